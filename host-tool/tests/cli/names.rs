//! Names that come from files, folders and boards: nothing of them reaches a terminal as what it obeys.

use std::io::{Read, Write};
use std::net::TcpStream;

use serde_json::Value;
use vitrine_protocol::frame::{self, Deframer};
use vitrine_protocol::{Hello, Reply, Request, Response, Status};

use super::ports::{announce, serve};
use super::support::{Finished, SMALL, Workshop};

/// Clears the screen, sets a title, moves up and writes over what stands there, and is a line of its own.
const WICKED: &str = "a\u{1b}[2J\u{1b}]0;b\u{7}\u{9b}A\u{202e}c\nforg";

/// Nothing but line ends and tabs is a control character.
fn assert_plain(told: &Finished) {
    for text in [&told.stdout, &told.stderr] {
        let wicked = |letter: char| (letter.is_control() && !"\n\t".contains(letter)) || letter == '\u{202e}';
        assert!(!text.contains(wicked), "{text:?}");
        assert!(!text.lines().any(|line| line.starts_with("forg")), "{text:?}");
    }
}

#[cfg(unix)]
#[test]
fn file_names_are_told_with_what_a_terminal_obeys_written_out() {
    let workshop = Workshop::small();
    let photograph = std::fs::read(workshop.path("cat.jpg")).unwrap();
    let folder = format!("photos {WICKED}");
    std::fs::create_dir(workshop.path(&folder)).unwrap();
    workshop.write(&format!("{folder}/{WICKED}.txt"), "no picture");
    workshop.write(&format!("{WICKED}.toml"), SMALL.replace("width_mm", "widht_mm"));
    workshop.write(&format!("{WICKED}.right.toml"), SMALL);
    let model = format!("{WICKED}.xyz");
    workshop.write(&model, "1 2 three\n");
    for arguments in [
        vec!["check", &format!("{WICKED}.toml")],
        vec!["check", &format!("{WICKED}.right.toml"), "--quick"],
        vec!["check", &format!("{WICKED}.none.toml")],
        vec!["new", WICKED, "--from", &folder],
        vec!["new", WICKED, "--dry-run"],
        vec!["new", WICKED],
        vec!["view", WICKED, "--horizontal", "0", "-o", "view.png"],
        vec!["design", "exhibit.toml", "-o", &folder],
        vec!["slice", &model, "--dry-run"],
        vec!["polish", WICKED],
        vec!["upload", WICKED, "--to", "tcp:127.0.0.1:1"],
    ] {
        assert_plain(&workshop.run(&arguments));
        let in_json = workshop.run(&[&arguments[..], &["--json"]].concat());
        assert_plain(&in_json);
    }
    // Names that would come into exhibit.toml are refused, with what is wrong about them.
    workshop.write(&format!("{folder}/{WICKED}.jpg"), photograph);
    let told = workshop.run(&["new", "mine", "--from", &folder]);
    assert_plain(&told);
    assert!(told.stderr.contains("vitrine::new::name"), "{}", told.stderr);
    assert!(told.stderr.contains("a\\u001b[2J"), "{}", told.stderr);
    assert!(!workshop.path("mine").exists());
}

#[test]
fn exhibit_toml_names_nothing_with_a_control_character() {
    let workshop = Workshop::new();
    let wicked = toml::Value::from(WICKED).to_string();
    for (plain, line) in [("\"Small\"", 2), ("\"cat.jpg\"", 20), ("\"cat\"", 19)] {
        workshop.write("exhibit.toml", SMALL.replace(plain, &wicked));
        let told = workshop.run(&["check", "exhibit.toml", "--quick"]);
        assert_plain(&told);
        assert_eq!(told.code, Some(1));
        assert!(told.stderr.contains("holds a control character"), "{}", told.stderr);
        assert!(told.stderr.contains(&format!("exhibit.toml:{line}:")), "{}", told.stderr);
    }
    // Nor does the file itself speak to the terminal, where it is shown.
    workshop
        .write("exhibit.toml", SMALL.replace("[stack]", "[stack] # \u{1b}[2J\u{9b}1A\u{202e}\nwidht_mm = 1"));
    let told = workshop.run(&["check", "exhibit.toml", "--quick"]);
    assert_plain(&told);
    assert!(told.stderr.contains("exhibit.toml:3:11"), "{}", told.stderr);
}

/// Answers as a controller that calls itself, its exhibit and its view what a terminal obeys.
fn as_a_wicked_controller(mut stream: TcpStream) {
    let mut deframer = Deframer::new();
    let mut bytes = [0; 512];
    while let Ok(count @ 1..) = stream.read(&mut bytes) {
        for byte in &bytes[..count] {
            let Some(Ok(body)) = deframer.push(*byte) else { continue };
            let Some((sequence, request)) = frame::decode(body) else { continue };
            let response = match request {
                Request::Hello { .. } => Response::Hello(Hello {
                    version: vitrine_protocol::VERSION,
                    fingerprint: vitrine_protocol::FINGERPRINT,
                    serial_number: WICKED.try_into().unwrap(),
                    firmware: WICKED.try_into().unwrap(),
                    name: WICKED.try_into().unwrap(),
                }),
                Request::Status => {
                    let mut status = Status { plan: Some(Default::default()), ..Status::default() };
                    let plan = status.plan.as_mut().unwrap();
                    plan.name = WICKED.try_into().unwrap();
                    plan.view_id = WICKED.try_into().unwrap();
                    Response::Status(status)
                }
                Request::ReadSettings => {
                    let place = WICKED.try_into().unwrap();
                    Response::Settings(vitrine_exhibit::settings::Settings { place, ..Default::default() })
                }
                Request::ReadPlan { offset } => {
                    let mut plan = vitrine_exhibit::testing::plan();
                    plan.name = WICKED.try_into().unwrap();
                    plan.views[0].id = WICKED.try_into().unwrap();
                    let mut room = vec![0; vitrine_protocol::plan_file::MAX_PLAN_BYTES];
                    let whole = vitrine_protocol::plan_file::encode(&plan, &mut room).unwrap();
                    let part = &whole[(offset as usize).min(whole.len())..];
                    let part = &part[..part.len().min(vitrine_protocol::MAX_CHUNK)];
                    Response::PlanPart { length: whole.len() as u32, offset, bytes: part.try_into().unwrap() }
                }
                _ => Response::Done,
            };
            let reply = frame::encode(sequence, &Reply::Ok(response)).unwrap();
            let _gone = stream.write_all(&reply);
        }
    }
}

#[test]
fn what_a_board_calls_itself_is_told_plainly() {
    let workshop = Workshop::built();
    let place = serve(as_a_wicked_controller);
    announce(&workshop, &place);
    announce(&workshop, "127.0.0.1:1\u{1b}[2J");
    let to = format!("tcp:{place}");
    for arguments in [
        &["devices"][..],
        &["status", "--to", &to],
        &["watch", "--count", "1", "--to", &to],
        &["settings", "--to", &to],
        &["settings", "--set", "place=a\u{1b}b", "--yes", "--to", &to],
        &["hold", "none", "--to", &to],
        &["upload", "build", "--dry-run", "--to", &to],
        &["status", "--to", "no-such-number"],
    ] {
        let told = workshop.run(arguments);
        assert!(!told.stdout.is_empty() || !told.stderr.is_empty());
        assert_plain(&told);
        assert_plain(&workshop.run(&[arguments, &["--json"]].concat()));
    }
    let status: Value = serde_json::from_str(&workshop.succeed(&["status", "--to", &to, "--json"])).unwrap();
    assert_eq!(status["exhibit"], "a?[2J?]0;b??A?c?forg");
}

#[test]
fn a_build_that_names_itself_wickedly_is_none() {
    let workshop = Workshop::built();
    let manifest = std::fs::read_to_string(workshop.path("build/manifest.json")).unwrap();
    workshop.write("build/manifest.json", manifest.replace("\"Small\"", "\"a\\u001b[2J\\nforged\""));
    let told = workshop.run(&["view", "build", "--horizontal", "0", "-o", "view.png"]);
    assert_plain(&told);
    assert!(told.stderr.contains("vitrine::build::bad_manifest"), "{}", told.stderr);
}
