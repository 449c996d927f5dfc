//! `vitrine demo`: the whole chain, from pictures to lamps that follow a viewer.

use serde_json::Value;

use super::support::{Finished, SMALL, Workshop, names};

#[test]
fn the_lamps_follow_the_viewer_through_all_views_and_a_contact_sheet_is_left() {
    let workshop = Workshop::small();
    // Deep enough for each view to have a lamp pair of its own.
    workshop.write("exhibit.toml", SMALL.replace("films = 8", "films = 20"));
    let finished = workshop.run(&["demo", "exhibit.toml", "-o", "shown", "--json"]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    let told: Value = serde_json::from_str(&finished.stdout).unwrap();
    let walk = told["walk"].as_array().unwrap();
    let place = |moment: &Value| moment["viewer_deg"].as_f64().unwrap();
    assert_eq!((place(&walk[0]), place(&walk[walk.len() - 1])), (-45.0, 45.0));

    let mut views: Vec<&str> = walk.iter().filter_map(|moment| moment["view"].as_str()).collect();
    views.dedup();
    assert_eq!(views, ["cat", "coffee", "astronaut"]);
    for (degrees, id) in [(-30.0, "cat"), (0.0, "coffee"), (30.0, "astronaut")] {
        let moment = walk.iter().find(|moment| place(moment) == degrees).unwrap();
        assert_eq!(moment["view"], id, "{moment}");
        let seen = moment["seen_deg"].as_f64().unwrap();
        assert!((seen - degrees).abs() < 5.0, "{moment}");
        let views = told["report"]["views"].as_array().unwrap();
        let wanted = &views.iter().find(|view| view["id"] == id).unwrap()["emphasis"];
        for lamp in ["top", "bottom"] {
            let (level, wanted) = (moment[lamp].as_f64().unwrap(), wanted[lamp].as_f64().unwrap());
            assert!((level - wanted).abs() < 0.02, "{lamp} of {moment}: wanted {wanted}");
        }
    }

    let sheet = image::open(workshop.path("shown/contact-sheet.png")).unwrap();
    assert!(sheet.width() > 900 && sheet.height() > 600);
    assert_eq!(names(&workshop.path("shown/films")).len(), 20);
    assert_eq!(names(&workshop.path("shown/views")).len(), 6);
}

#[test]
fn a_reader_of_plain_text_sees_one_line_for_each_step() {
    let workshop = Workshop::small();
    let finished = workshop.run(&["demo", "exhibit.toml", "-o", "shown"]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    assert_eq!(finished.stdout.trim(), "shown/contact-sheet.png");
    let steps = finished.stderr.lines().filter(|line| line.starts_with("viewer at ")).count();
    assert_eq!(steps, 31);
    assert!(!finished.stderr.contains('\u{1b}'), "{}", finished.stderr);
    assert!(
        finished.stderr.trim_end().ends_with("Now look at shown/report.html: `vitrine demo --open` opens it")
    );
}

#[test]
#[cfg(target_os = "linux")]
fn the_page_is_opened_on_request_and_where_nothing_opens_it_that_is_said() {
    use std::os::unix::fs::PermissionsExt;

    let workshop = Workshop::small();
    let opener = workshop.path("xdg-open");
    workshop.write("xdg-open", "#!/bin/sh\necho \"$1\" > opened.partly && mv opened.partly opened\n");
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).unwrap();
    let demo = |path: &str| {
        let mut command = workshop.command(&["demo", "exhibit.toml", "-o", "shown", "--open"]);
        Finished::from(command.env("PATH", path).output().unwrap())
    };
    let path = format!("{}:/usr/bin:/bin", workshop.path("").display());
    let finished = demo(&path);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    // The opener goes on by itself.
    let mut looks = 0..1000;
    while !workshop.path("opened").exists() && looks.next().is_some() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert_eq!(std::fs::read_to_string(workshop.path("opened")).unwrap().trim(), "shown/report.html");
    let finished = demo("/nowhere");
    assert_eq!(finished.code, Some(1));
    assert!(finished.stderr.contains("vitrine::demo::open"), "{}", finished.stderr);
}
