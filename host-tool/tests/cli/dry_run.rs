//! Whatever writes or sends has a dry run, which does neither.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::link::json;
use super::support::{SMALL, Simulated, Workshop};
use super::{firmware, ink};

/// What a command is told so that it writes or sends.
const DEEDS: [&[&str]; 33] = [
    &["demo", "exhibit.toml", "-o", "shown"],
    &["new", "mine"],
    &["new", "own", "--from", "photos"],
    &["check", "exhibit.toml", "--frontier", "frontier.svg"],
    &["design", "exhibit.toml", "-o", "designed"],
    &["design", "exhibit.toml", "-o", "by-strips", "--strips"],
    &["design", "exhibit.toml", "-o", "build"],
    &["slice", "points.txt", "-o", "sliced", "--pixels", "16", "--films", "4"],
    &["view", "build", "--horizontal", "30", "-o", "view.png"],
    &["turn", "build", "-o", "turn.png", "--steps", "3"],
    &["calibrate", "wedge.png", "-o", "curves.toml", "--overlay", "found.png"],
    &["experiment", "films", "-o", "films.png"],
    &["experiment", "films", "--fit", "circles.png", "--side", "lamp", "--overlay", "overlay.png"],
    &["print", "build", "-o", "sheets", "--dpi", "100"],
    &["print", "--wedge", "-o", "chart", "--dpi", "254"],
    &["print", "--circles", "-o", "circles", "--dpi", "254"],
    &["upload", "other", "--yes", "--to", "TO"],
    &["upload", "other", "--yes", "--allow-more", "--to", "TO"],
    &["clock", "--set", "--to", "TO"],
    &["new-stack", "--yes", "--to", "TO"],
    &["settings", "--set", "place=Hall 3", "--yes", "--to", "TO"],
    &["self-test", "-o", "sheet.txt", "--to", "TO"],
    &["controller", "--listen", "tcp:0", "--flash", "new.flash"],
    &["firmware", "build", "--source", "SOURCE", "-o", "built"],
    &["firmware", "keygen", "--secret", "secret.pem", "--public", "public.pem"],
    &["firmware", "sign", "new.elf", "-o", "signed.again"],
    &["firmware", "update", "new.signed", "--to", "TO"],
    &["man", "pages"],
    // The controller writes nothing into its flash while these let the lamps fade.
    &["hold", "cat", "--to", "TO"],
    &["release", "--to", "TO"],
    &["dark", "--to", "TO"],
    &["open", "--for", "2h", "--to", "TO"],
    &["rearm", "--to", "TO"],
];

/// What runs on or takes long, is done in a test of its own, or changes nothing in a controller to which nothing has happened.
const NOT_DONE: [&[&str]; 14] = [
    &["demo"],
    &["check"],
    &["design", "exhibit.toml", "-o", "by-strips"],
    &["slice"],
    &["print", "--wedge"],
    &["print", "--circles"],
    &["firmware", "update"],
    &["upload", "other", "--yes", "--allow-more"],
    &["rearm"],
    &["self-test"],
    &["controller"],
    &["firmware", "build"],
    &["calibrate"],
    &["experiment", "films", "--fit"],
];

/// Everything that a command could change: the files with what is in them, and the controller.
#[derive(PartialEq)]
struct State {
    files: BTreeMap<String, blake3::Hash>,
    controller: Vec<Value>,
}

fn state(workshop: &Workshop, to: &str) -> State {
    State { files: files(workshop), controller: controller(workshop, to) }
}

fn files(workshop: &Workshop) -> BTreeMap<String, blake3::Hash> {
    let mut found = BTreeMap::new();
    files_in(&workshop.path(""), &mut found);
    found
}

fn files_in(folder: &Path, found: &mut BTreeMap<String, blake3::Hash>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.display().to_string();
        if path.is_dir() {
            files_in(&path, found);
            found.insert(name, blake3::hash(b"a folder"));
        } else if !name.ends_with("board.flash") {
            found.insert(name, blake3::hash(&std::fs::read(&path).unwrap()));
        }
    }
}

/// What a person may have changed of it; the rest goes on by itself.
fn controller(workshop: &Workshop, to: &str) -> Vec<Value> {
    let ask = |command: &str| json(&workshop.succeed(&[command, "--to", to, "--json"]));
    let status = ask("status");
    let events = ask("log");
    let of_people = events.as_array().unwrap().iter().filter(|entry| {
        let event = entry["event"].as_str().unwrap();
        ["plan", "stack", "re-arm"].iter().any(|word| event.contains(word))
    });
    vec![
        status["plan_crc"].clone(),
        status["firmware"].clone(),
        (status["lease_s"].as_f64().unwrap() / 600.0).round().into(),
        ask("clock")["last_set"].clone(),
        ask("settings"),
        of_people.count().into(),
    ]
}

fn workshop() -> Workshop {
    let workshop = Workshop::built();
    workshop.write("exhibit.toml", SMALL.replace("\"Small\"", "\"Other\""));
    workshop.succeed(&["design", "exhibit.toml", "-o", "other"]);
    workshop.write("points.txt", "0 0 0\n1 1 1\n2 0 1\n");
    workshop.write("new.elf", firmware::elf("new firmware"));
    workshop.succeed(&["firmware", "sign", "new.elf", "--version", "9.0.0", "-o", "new.signed"]);
    ink::wedge_photograph(0.8).write_png(&workshop.path("wedge.png")).unwrap();
    ink::circles_photograph(0.88).write_png(&workshop.path("circles.png")).unwrap();
    std::fs::create_dir(workshop.path("pages")).unwrap();
    std::fs::create_dir(workshop.path("photos")).unwrap();
    std::fs::copy(workshop.path("cat.jpg"), workshop.path("photos/cat.jpg")).unwrap();
    workshop
}

/// The commands, which a test beside the command line holds to be all there are.
fn commands(workshop: &Workshop) -> Vec<String> {
    let schema = json(&workshop.succeed(&["schema", "--answers"]));
    let names = schema["$defs"].as_object().unwrap().keys().cloned();
    let is_one = |name: &String| {
        let words: Vec<&str> = name.split(' ').chain(["--help"]).collect();
        // The schema has parts of answers, too, which the command line takes for arguments.
        workshop.run(&words).stdout.contains(&format!("Usage: vitrine {name} "))
    };
    names.filter(is_one).collect()
}

#[test]
fn a_dry_run_of_every_command_writes_and_sends_nothing() {
    let workshop = workshop();
    let simulated = Simulated::start(&workshop, &["--flash", "board.flash"]);
    let to = simulated.address.as_str();
    workshop.succeed(&["upload", "build", "--to", to]);
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let given = |words: &[&'static str]| -> Vec<String> {
        words.iter().map(|word| word.replace("TO", to).replace("SOURCE", source)).collect()
    };

    let all = commands(&workshop);
    assert!(all.len() > 30, "{all:?}");
    for command in &all {
        let words: Vec<&str> = command.split(' ').collect();
        let help = workshop.succeed(&[&words[..], &["--help"]].concat());
        let tried = DEEDS.iter().any(|deed| deed.starts_with(&words));
        assert_eq!(help.contains("--dry-run"), tried, "{command}");
        // Options that write say so.
        let writes = help.lines().any(|line| line.trim_start().starts_with("-o") || line.contains("rite "));
        assert!(tried || !writes || command == "schema", "{command}: {help}");
    }

    let mut before = state(&workshop, to);
    let do_it = |words: &[&'static str]| {
        let arguments = given(words);
        workshop.succeed(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    };
    for deed in DEEDS {
        do_it(&[deed, &["--dry-run"]].concat());
        let files = files(&workshop);
        // Asking takes its time: a command that is told no controller is looked after with the next that is.
        let controller =
            if deed.contains(&"TO") { controller(&workshop, to) } else { before.controller.clone() };
        assert!(State { files, controller } == before, "{deed:?} has changed something");
    }

    // Without it they do.
    for deed in DEEDS.iter().filter(|deed| !NOT_DONE.iter().any(|not| deed.starts_with(not))) {
        do_it(deed);
        let after = match deed.contains(&"TO") {
            true => state(&workshop, to),
            false => State { files: files(&workshop), controller: before.controller.clone() },
        };
        assert!(after != before, "{deed:?} has changed nothing");
        before = after;
    }
}

#[test]
fn a_controllers_dry_run_says_what_stands_against_it() {
    let workshop = Workshop::new();
    let simulated = Simulated::start(&workshop, &["--flash", "board.flash"]);
    let dry = |arguments: &[&str]| workshop.run(&[&["controller", "--dry-run"], arguments].concat());
    workshop.write("text.flash", "no flash");
    for (arguments, code) in [
        (&["--listen", simulated.address.as_str()][..], "port_busy"),
        (&["--listen", "tcp:0", "--flash", "board.flash"], "flash_busy"),
        (&["--listen", "tcp:0", "--flash", "text.flash"], "flash_size"),
        (&["--listen", "tcp:0", "--flash", "none/board.flash"], "flash_file"),
    ] {
        let told = dry(arguments);
        assert_eq!(told.code, Some(1), "{arguments:?}");
        let code = format!("vitrine::controller::{code}");
        assert!(told.stderr.contains(&code), "{arguments:?}: {}", told.stderr);
    }
    drop(simulated);
    let told = dry(&["--listen", "tcp:0", "--flash", "board.flash"]);
    assert!(told.stdout.contains("go on with the flash memory in board.flash"), "{}", told.stdout);
    let told = dry(&["--listen", "tcp:0", "--flash", "new.flash"]);
    assert!(told.stdout.contains("new.flash, which is new"), "{}", told.stdout);
    assert!(!workshop.path("new.flash").exists());
}
