//! Wrong input ends in an error that names the place and the remedy, and leaves nothing half-written.

use std::fs;

use super::support::{Finished, SMALL, Workshop, names};

/// Designs `exhibit`, which must fail with exit code 1 and leave the folder as it was.
fn refused(workshop: &Workshop, exhibit: &str) -> String {
    workshop.write("exhibit.toml", exhibit);
    let before = workshop.names();
    let finished = workshop.run(&["design", "exhibit.toml", "-o", "build"]);
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    assert_eq!(finished.stdout, "");
    assert_eq!(workshop.names(), before);
    finished.stderr
}

fn assert_tells(stderr: &str, wanted: &[&str]) {
    for text in wanted {
        assert!(stderr.contains(text), "no \"{text}\" in:\n{stderr}");
    }
}

#[test]
fn a_missing_picture_is_named_with_its_line() {
    let stderr = refused(&Workshop::new(), &SMALL.replace("coffee.jpg", "tea.jpg"));
    assert_tells(&stderr, &["vitrine::config::bad_picture", "tea.jpg", "exhibit.toml:17:11", "help:"]);
}

#[test]
fn a_misspelt_picture_is_suggested_whatever_the_case() {
    for wrong in ["Coffe.jpg", "COFFEE.JPG"] {
        let stderr = refused(&Workshop::new(), &SMALL.replace("coffee.jpg", wrong));
        assert_tells(&stderr, &["vitrine::config::bad_picture", wrong, "did you mean \"coffee.jpg\"?"]);
    }
}

#[test]
fn what_is_mostly_meant_by_wrong_toml_is_said() {
    for (right, wrong, line, help) in [
        ("= 30.0", "= 30,0", 14, "as 13.3"),
        ("\"coffee\"", "\u{201c}coffee\u{201d}", 16, "straight quotes"),
        ("\"coffee.jpg\"", "\"C:\\Users\\coffee.jpg\"", 17, "write paths with /"),
        ("[[view]]\nid = \"coffee\"", "[view]\nid = \"coffee\"", 15, "begin each with two brackets"),
        ("\"Small\"", "Small", 2, "texts in quotes"),
    ] {
        let stderr = refused(&Workshop::new(), &SMALL.replace(right, wrong));
        assert_tells(&stderr, &["vitrine::config::syntax", &format!("exhibit.toml:{line}:"), help]);
    }
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_a_suggestion() {
    let stderr = refused(&Workshop::new(), &SMALL.replace("width_mm", "widht_mm"));
    assert_tells(
        &stderr,
        &["vitrine::config::unknown_key", "widht_mm", "exhibit.toml:6:1", "did you mean `width_mm`?"],
    );
}

#[test]
fn an_impossible_angle_is_named_with_its_line() {
    let stderr = refused(&Workshop::new(), &SMALL.replace("= 30.0", "= 95"));
    assert_tells(&stderr, &["vitrine::config::bad_value", "95", "exhibit.toml:14:18", "-80 to 80"]);
}

#[test]
fn a_truncated_photograph_is_refused_rather_than_filled_with_grey() {
    let workshop = Workshop::new();
    let photograph = fs::read(workshop.path("cat.jpg")).unwrap();
    workshop.write("cat.jpg", &photograph[..photograph.len() / 2]);
    let stderr = refused(&workshop, SMALL);
    assert_tells(&stderr, &["vitrine::config::bad_picture", "cat.jpg", "exhibit.toml:20:11", "help:"]);
}

#[test]
fn an_exhibit_that_is_not_there_is_named() {
    let workshop = Workshop::new();
    let finished = workshop.run(&["check", "none.toml"]);
    assert_eq!(finished.code, Some(1));
    assert_tells(&finished.stderr, &["vitrine::config::unreadable", "none.toml", "vitrine new"]);
}

#[test]
fn the_next_command_is_told_as_a_shell_takes_it() {
    let workshop = Workshop::new();
    let told = workshop.run(&["new", "mein Exponat 🦋"]).stderr;
    assert_tells(
        &told,
        &["vitrine check 'mein Exponat 🦋/exhibit.toml', then", "-o 'mein Exponat 🦋/build'"],
    );
}

#[test]
fn a_page_that_cannot_be_served_says_why() {
    let workshop = Workshop::new();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let place = taken.local_addr().unwrap().to_string();
    // TEST-NET-1 (RFC 5737) is no computer's.
    for (place, why) in
        [(place.as_str(), "another program has the port"), ("192.0.2.1:8080", "no such address")]
    {
        let told = workshop.run(&["serve", "--listen", place]);
        assert_eq!(told.code, Some(1));
        assert_tells(&told.stderr, &["vitrine::serve::listen", place, why]);
    }
}

#[test]
fn wrong_usage_ends_with_2() {
    let workshop = Workshop::small();
    for arguments in [
        &["design", "exhibit.toml"][..],
        &["design", "exhibit.toml", "-o", "build", "--bits", "12"],
        &["view", "build", "--horizontal", "95", "-o", "view.png"],
        &["view", "build", "--horizontal", "nan", "-o", "view.png"],
        &["polish"],
    ] {
        let finished = workshop.run(arguments);
        assert_eq!(finished.code, Some(2), "{arguments:?}");
        assert_eq!(finished.stdout, "");
    }
    assert!(!workshop.path("build").exists());
}

#[test]
fn a_folder_that_is_no_build_is_never_replaced() {
    let workshop = Workshop::small();
    fs::create_dir(workshop.path("holiday")).unwrap();
    workshop.write("holiday/beach.jpg", "sand");
    for place in ["holiday", "cat.jpg", "."] {
        let finished = workshop.run(&["design", "exhibit.toml", "-o", place]);
        assert_eq!(finished.code, Some(1), "{place}");
        assert_tells(&finished.stderr, &["vitrine::build::not_a_build", place]);
    }
    assert_eq!(fs::read(workshop.path("holiday/beach.jpg")).unwrap(), b"sand");
}

#[test]
fn errors_are_json_on_request() {
    let workshop = Workshop::new();
    workshop.write("exhibit.toml", SMALL.replace("films", "filmz"));
    let finished = workshop.run(&["check", "exhibit.toml", "--json"]);
    assert_eq!(finished.code, Some(1));
    let error: serde_json::Value = serde_json::from_str(&finished.stderr).unwrap();
    assert_eq!(error["related"][0]["code"], "vitrine::config::unknown_key");
}

#[test]
fn what_is_no_build_is_said_to_be_none() {
    let workshop = Workshop::small();
    let finished = workshop.run(&["view", ".", "--horizontal", "0", "-o", "view.png"]);
    assert_eq!(finished.code, Some(1));
    assert_tells(&finished.stderr, &["vitrine::build::no_manifest", "vitrine design"]);
    workshop.write("manifest.json", "{\"format\": \"recipe\", \"layout\": 1}");
    let finished = workshop.run(&["view", ".", "--horizontal", "0", "-o", "view.png"]);
    assert_tells(&finished.stderr, &["vitrine::build::bad_manifest", "recipe"]);
    assert!(!workshop.path("view.png").exists());
}

/// A limit on the size of files stands for a full disk: both make a write fail half-way.
#[cfg(unix)]
fn with_file_limit(workshop: &Workshop, blocks: u32, arguments: &str) -> Finished {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {arguments}");
    let output = std::process::Command::new("bash")
        .args(["-c", &script, env!("CARGO_BIN_EXE_vitrine")])
        .current_dir(workshop.path(""))
        .output()
        .unwrap();
    Finished::from(output)
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_new_and_the_old_build_whole() {
    let workshop = Workshop::small();
    let before = workshop.names();
    let finished = with_file_limit(&workshop, 4, "design exhibit.toml -o build");
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    assert_tells(&finished.stderr, &["vitrine::build::write", "build/", "free space"]);
    assert_eq!(workshop.names(), before);

    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let old = fs::read(workshop.path("build/manifest.json")).unwrap();
    let finished = with_file_limit(&workshop, 4, "design exhibit.toml -o build");
    assert_eq!(finished.code, Some(1));
    assert_eq!(fs::read(workshop.path("build/manifest.json")).unwrap(), old);
    assert_eq!(names(&workshop.path("build/films")).len(), 8);

    let finished = with_file_limit(&workshop, 1, "view build --horizontal 0 -o view.png");
    assert_eq!(finished.code, Some(1));
    assert_tells(&finished.stderr, &["vitrine::view::write", "view.png", "free space"]);
    assert!(!workshop.path("view.png").exists());
    // Half a flash would be refused for ever; an empty file is new flash.
    let finished = with_file_limit(&workshop, 1000, "controller --listen tcp:0 --flash board.flash");
    assert_eq!(finished.code, Some(1));
    assert_tells(&finished.stderr, &["vitrine::controller::flash_file", "board.flash", "free space"]);
    assert_eq!(fs::metadata(workshop.path("board.flash")).unwrap().len(), 0);
    let unfinished = workshop.names().into_iter().find(|name| name.starts_with('.'));
    assert_eq!(unfinished, None);
}

/// Whenever the interrupt comes, there is a whole build or none.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_a_whole_build_or_none() {
    let workshop = Workshop::small();
    workshop.write("exhibit.toml", SMALL.replace("[64, 48]", "256").replace("films = 8", "films = 20"));
    let before = workshop.names();
    let mut child = workshop.command(&["design", "exhibit.toml", "-o", "build", "--json"]).spawn().unwrap();
    while workshop.names() == before && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let _ = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let code = child.wait().unwrap().code();
    let mut after = workshop.names();
    match code {
        Some(130) => assert_eq!(after, before),
        Some(0) => {
            after.retain(|name| name != "build");
            assert_eq!(after, before);
            workshop.succeed(&["view", "build", "--horizontal", "0", "-o", "view.png"]);
        }
        other => panic!("ended with {other:?}"),
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_stops_a_design_that_is_under_way() {
    use std::io::{BufRead, BufReader};
    let workshop = Workshop::new();
    // It would go on for hours.
    let endless = SMALL.replace("[64, 48]", "256").replace("films = 8", "films = 20");
    let endless =
        endless.replace("\"product\"", "\"least-squares\"\niterations = 100000\ntolerance_db = 1e-6");
    workshop.write("exhibit.toml", endless);
    let before = workshop.names();
    let mut command = workshop.command(&["design", "exhibit.toml", "-o", "build"]);
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("solving")));
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said:?}");
    assert!(said.concat().contains("vitrine::design::stopped"), "{said:?}");
    assert_eq!(workshop.names(), before);
}
