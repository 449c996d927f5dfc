//! What helps a user: explanations, completions, man pages, the README's commands.

use std::path::Path;

use serde_json::Value;

use super::book::shrink;
use super::support::{Workshop, names};

#[test]
fn an_error_is_explained_by_the_code_it_shows() {
    let workshop = Workshop::new();
    workshop.write("exhibit.toml", "[[view]]\nid = \"a\"\npattern = \"none.jpg\"\n");
    let finished = workshop.run(&["check", "exhibit.toml"]);
    let code = "vitrine::config::bad_picture";
    assert!(finished.stderr.contains(code), "{}", finished.stderr);
    let explanation = workshop.succeed(&["explain", code]);
    assert!(explanation.contains("relative to exhibit.toml"), "{explanation}");
    assert_eq!(explanation, workshop.succeed(&["explain", "config::bad_picture"]));
    let finished = workshop.run(&["explain", "config::bad_pictures"]);
    assert_eq!(finished.code, Some(1));
    assert!(finished.stderr.contains("did you mean vitrine::config::bad_picture?"), "{}", finished.stderr);
}

#[test]
fn completions_and_man_pages_name_every_command() {
    let workshop = Workshop::new();
    for shell in ["bash", "zsh", "fish", "powershell"] {
        assert!(workshop.succeed(&["completions", shell]).contains("new-stack"), "{shell}");
    }
    std::fs::create_dir(workshop.path("man1")).unwrap();
    workshop.succeed(&["man", "man1"]);
    let pages = names(&workshop.path("man1"));
    assert!(
        ["vitrine.1", "vitrine-design.1", "vitrine-firmware-update.1"]
            .iter()
            .all(|page| pages.contains(&(*page).to_owned())),
        "{pages:?}"
    );
    assert!(!pages.iter().any(|page| page.contains("-help")), "{pages:?}");
    let page = std::fs::read_to_string(workshop.path("man1/vitrine-design.1")).unwrap();
    assert!(page.contains(".TH VITRINE-DESIGN 1"), "{page}");
    assert_eq!(workshop.run(&["man", "nowhere"]).code, Some(1));
}

/// A text that is wrapped in the source is wrapped once more where lines are shorter, in the middle of its lines.
#[test]
fn help_is_wrapped_once() {
    const WIDTH: usize = 100;
    let workshop = Workshop::new();
    let text = workshop.succeed(&["schema", "--answers"]);
    let answers: Value = serde_json::from_str(&text).unwrap();
    let commands = answers["$defs"].as_object().unwrap().keys().filter(|name| *name != "error");
    let mut looked_at = 0;
    for command in commands.chain([&String::new()]) {
        let words: Vec<&str> = command.split_whitespace().chain(["--help"]).collect();
        let Some(help) = Some(workshop.run(&words)).filter(|told| told.code == Some(0)) else { continue };
        looked_at += 1;
        let lines: Vec<&str> = help.stdout.lines().collect();
        for pair in lines.windows(2) {
            let is_prose = |line: &str| line.starts_with(char::is_alphanumeric) && !line.ends_with(':');
            let first = pair[1].split(' ').next().unwrap_or_default();
            let fits = pair[0].chars().count() + 1 + first.chars().count() <= WIDTH;
            assert!(
                !(is_prose(pair[0]) && is_prose(pair[1]) && fits),
                "{command}:\n{}\n{}",
                pair[0],
                pair[1]
            );
        }
        let examples = lines.iter().skip_while(|line| **line != "Examples:").skip(1);
        for line in examples.take_while(|line| !line.is_empty()) {
            let begins = ["  vitrine ", "  curl ", "  cargo "];
            assert!(begins.iter().any(|begin| line.starts_with(begin)), "{command}: {line}");
        }
    }
    assert!(looked_at > 30, "{looked_at}");
}

#[test]
fn the_doctor_tells_versions_and_ports() {
    let told: Value = serde_json::from_str(&Workshop::new().succeed(&["doctor"])).unwrap();
    assert_eq!(told["vitrine"], env!("CARGO_PKG_VERSION"));
    assert!(told["ports"].is_array());
}

#[test]
fn check_shows_the_year_and_what_it_costs() {
    let workshop = Workshop::small();
    let schedule = "[[schedule]]\ndays = \"sat-sun\"\nfrom = \"10:00\"\nto = \"18:00\"\n";
    workshop.write("exhibit.toml", format!("{}{schedule}", super::support::SMALL));
    let text = workshop.succeed(&["check", "exhibit.toml", "--year", "2026", "--quick"]);
    assert!(text.contains("832 h on 104 days of 2026, UTC"), "{text}");
    assert!(text.contains("Jan       ..##.....##.....##.....##.....#"), "{text}");
    assert!(text.contains("30 kJ/m2 in 50 minutes"), "{text}");
    assert!(text.contains("with somebody there in all of these hours the stack's 10.0 MJ/m2 last"), "{text}");
    workshop.write(
        "exhibit.toml",
        format!("{}{schedule}[presence]\nexpected_h_a_day = 0.25\n", super::support::SMALL),
    );
    let text = workshop.succeed(&["check", "exhibit.toml", "--year", "2026", "--quick"]);
    assert!(
        text.contains("with somebody there for 0.25 h of each open day the stack's 10.0 MJ/m2 last"),
        "{text}"
    );
}

#[test]
fn check_tells_what_is_not_measured_and_refuses_what_cannot_be_kept() {
    let workshop = Workshop::small();
    let told = |more: &str| {
        workshop.write("exhibit.toml", format!("{}{more}", super::support::SMALL));
        workshop.run(&["check", "exhibit.toml", "--quick"])
    };
    assert!(told("").stderr.contains("`ultraviolet_at_full_w_m2` in [lamps] is not measured"));
    let measured =
        told("[lamps]\nultraviolet_at_full_w_m2 = [0.2, 0.1]\n[presence]\nexpected_h_a_day = 0.5\n");
    assert!(!measured.stderr.contains("not measured"), "{}", measured.stderr);
    assert!(measured.stdout.contains("expected 16.4 kJ/m2 a day"), "{}", measured.stdout);
    vitrine::picture::write_png_rgb8(&workshop.path("cat.jpg"), &[9; 12], 2, 2).unwrap();
    let soft = told("").stderr;
    assert!(soft.contains("cat.jpg has 2 x 2 pixels, the films 64 x 48: it will look soft"), "{soft}");
    let lines = super::support::SMALL.lines().count();
    let refused = told("[[schedule]]\nlevel = 0\n");
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("vitrine::config::contradiction"), "{}", refused.stderr);
    assert!(refused.stderr.contains(&format!("exhibit.toml:{}:1", lines + 1)), "{}", refused.stderr);
}

/// The README's own commands, with a design small enough for a test.
#[test]
fn the_commands_of_the_readme_work() {
    let readme = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md")).unwrap();
    let lines = readme.lines().filter_map(|line| line.strip_prefix("    vitrine "));
    let commands: Vec<Vec<&str>> =
        lines.map(|line| line.split('#').next().unwrap_or_default().split_whitespace().collect()).collect();
    assert!(commands.len() >= 7, "{commands:?}");
    let workshop = Workshop::new();
    for command in commands {
        match command.as_slice() {
            // These need a controller: their own tests run them.
            ["controller" | "upload" | "status" | "watch", ..] => {
                workshop.succeed(&[command[0], "--help"]);
            }
            ["new", folder, "--from", photos] => {
                std::fs::create_dir(workshop.path(photos)).unwrap();
                for name in ["cat.jpg", "coffee.jpg", "rocket.jpg"] {
                    std::fs::copy(workshop.path(name), workshop.path(photos).join(name)).unwrap();
                }
                workshop.succeed(&command);
                shrink(&workshop, folder);
            }
            _ => {
                workshop.succeed(&command);
            }
        }
    }
    assert!(workshop.path("right.png").exists());
    for (number, line) in readme.lines().enumerate() {
        let words = line.split(['(', ')', '`', ' ']);
        for path in words.filter(|word| word.starts_with("host-tool/") || word.starts_with("hardware/")) {
            let path = path.trim_end_matches(['.', ',', ';']);
            let there = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path).exists();
            assert!(there, "README.md:{}: {path}", number + 1);
        }
    }
}

#[test]
fn an_exhibit_starts_from_a_folder_of_pictures() {
    let workshop = Workshop::new();
    std::fs::create_dir(workshop.path("photos")).unwrap();
    let none = workshop.run(&["new", "mine", "--from", "photos"]);
    assert!(none.stderr.contains("vitrine::new::picture_count"), "{}", none.stderr);
    for name in ["cat.jpg", "coffee.jpg", "rocket.jpg"] {
        std::fs::rename(workshop.path(name), workshop.path("photos").join(name)).unwrap();
    }
    let dry: Value =
        serde_json::from_str(&workshop.succeed(&["new", "mine", "--from", "photos", "--dry-run", "--json"]))
            .unwrap();
    assert_eq!(dry["files"].as_array().unwrap().len(), 5);
    assert!(!workshop.path("mine").exists());
    workshop.succeed(&["new", "mine", "--from", "photos"]);
    let expected = ["cat.jpg", "coffee.jpg", "exhibit.schema.json", "exhibit.toml", "rocket.jpg"];
    assert_eq!(names(&workshop.path("mine")), expected);
    let text = std::fs::read_to_string(workshop.path("mine/exhibit.toml")).unwrap();
    assert!(text.starts_with("#:schema ./exhibit.schema.json\n"), "{text}");
    workshop.succeed(&["check", "mine/exhibit.toml", "--quick"]);
    let schema: Value = serde_json::from_str(&workshop.succeed(&["schema"])).unwrap();
    assert!(schema["properties"]["view"]["items"]["properties"]["horizontal_deg"].is_object());
    workshop.write("photos/cut.png", b"\x89PNG");
    let cut = workshop.run(&["new", "other", "--from", "photos"]);
    assert!(cut.stderr.contains("cut.png") && !workshop.path("other").exists(), "{}", cut.stderr);
}
