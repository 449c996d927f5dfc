//! `vitrine turn`: an animation of the views, frame by frame what `vitrine view` shows.

use std::fs::File;
use std::io::BufReader;

use serde_json::Value;

use super::support::Workshop;

/// The frames of an animation, and the time of each in seconds.
fn frames(workshop: &Workshop, name: &str) -> (Vec<Vec<u8>>, f64) {
    let decoder = png::Decoder::new(BufReader::new(File::open(workshop.path(name)).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let count = reader.info().animation_control().unwrap().num_frames;
    let mut frames = Vec::new();
    let mut seconds = 0.0;
    for _ in 0..count {
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let control = reader.info().frame_control().unwrap();
        seconds = f64::from(control.delay_num) / f64::from(control.delay_den);
        frames.push(pixels);
    }
    (frames, seconds)
}

#[test]
fn each_frame_is_what_view_shows_from_there() {
    let workshop = Workshop::built();
    let arguments = [
        "turn", "build", "-o", "turn.png", "--from", "-20", "--to", "20", "--steps", "5", "--fps", "12",
        "--json",
    ];
    let told: Value = serde_json::from_str(&workshop.succeed(&arguments)).unwrap();
    assert_eq!(told["frames"], 8);
    let (found, seconds) = frames(&workshop, "turn.png");
    assert!((seconds - 1.0 / 12.0).abs() < 1e-9);
    let gain = told["gain"].to_string();
    let angles = ["-20", "-10", "0", "10", "20", "10", "0", "-10"];
    assert_eq!(found.len(), angles.len());
    for (frame, angle) in found.iter().zip(angles) {
        let arguments =
            ["view", "build", "--horizontal", angle, "-o", "view.png", "--encode", "--gain", &gain];
        workshop.succeed(&arguments);
        let view = image::open(workshop.path("view.png")).unwrap().to_rgb8();
        assert!(view.as_raw() == frame, "{angle}");
    }
    workshop.succeed(&["turn", "build", "-o", "once.png", "--steps", "3", "--once"]);
    assert_eq!(frames(&workshop, "once.png").0.len(), 3);
}

#[test]
fn a_dry_run_writes_nothing_and_wrong_input_is_told() {
    let workshop = Workshop::built();
    let before = workshop.names();
    workshop.succeed(&["turn", "build", "-o", "turn.png", "--dry-run"]);
    let finished = workshop.run(&["turn", "build", "-o", "turn.png", "--distance", "2"]);
    assert_eq!(finished.code, Some(1));
    assert!(finished.stderr.contains("vitrine::turn::too_near"), "{}", finished.stderr);
    let finished = workshop.run(&["turn", "build", "-o", "nowhere/turn.png"]);
    assert!(finished.stderr.contains("vitrine::turn::write"), "{}", finished.stderr);
    assert_eq!(workshop.run(&["turn", "build", "-o", "turn.png", "--steps", "1"]).code, Some(2));
    for (command, name) in [("turn", "turn.webp"), ("view", "view.jpg"), ("view", "view")] {
        let finished = workshop.run(&[command, "build", "-o", name]);
        assert_eq!(finished.code, Some(2), "{command} {name}");
        assert!(finished.stderr.contains("a name that ends in .png"), "{}", finished.stderr);
    }
    assert_eq!(workshop.names(), before);
}
