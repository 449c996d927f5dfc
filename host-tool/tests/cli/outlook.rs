//! `vitrine check` foretells a design, and `adapt` and `levels` change it as exhibit.toml asks.

use std::fs;

use serde_json::Value;

use super::support::{SMALL, Workshop};

#[test]
fn a_check_predicts_the_design_and_draws_the_frontier() {
    let workshop = Workshop::small();
    let stdout = workshop.succeed(&["check", "exhibit.toml", "--json", "--frontier", "frontier.svg"]);
    let told: Value = serde_json::from_str(&stdout).unwrap();
    let predicted = told["outlook"]["prediction"]["mean_psnr_db"].as_f64().unwrap();
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let report: Value =
        serde_json::from_slice(&fs::read(workshop.path("build/report.json")).unwrap()).unwrap();
    let reached = report["mean_psnr_db"].as_f64().unwrap();
    assert!((predicted - reached).abs() < 0.1, "{predicted} dB predicted, {reached} dB reached");
    assert!(fs::read_to_string(workshop.path("frontier.svg")).unwrap().starts_with("<svg"));
    let points: Value = serde_json::from_slice(&fs::read(workshop.path("frontier.json")).unwrap()).unwrap();
    assert_eq!(points, told["outlook"]["frontier"]);
    assert!(points.as_array().unwrap().len() > 10);
    let quick: Value =
        serde_json::from_str(&workshop.succeed(&["check", "exhibit.toml", "--json", "--quick"])).unwrap();
    assert!(quick["outlook"].is_null());
}

#[test]
fn a_frontier_that_cannot_be_written_is_refused_before_it_is_computed() {
    let workshop = Workshop::small();
    fs::create_dir(workshop.path("taken.svg")).unwrap();
    for (place, code, why) in [
        ("taken.svg", "vitrine::frontier::write", "a folder is there"),
        ("missing/frontier.svg", "vitrine::frontier::write", "no folder missing"),
        ("frontier.json", "vitrine::frontier::name", ".svg"),
    ] {
        let told = workshop.run(&["check", "exhibit.toml", "--frontier", place, "--dry-run"]);
        assert_eq!(told.code, Some(1));
        assert!(told.stderr.contains(code) && told.stderr.contains(why), "{}", told.stderr);
        assert!(!told.stderr.contains("predicting"), "{}", told.stderr);
    }
}

#[test]
fn adapted_pictures_lie_beside_the_given_ones_and_films_hold_the_printers_levels() {
    let workshop = Workshop::new();
    let adapting =
        SMALL.replace("[design]\nmethod = \"product\"", "[print]\nlevels = 4\n[design]\nadapt = true");
    workshop.write("exhibit.toml", adapting);
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let report: Value =
        serde_json::from_slice(&fs::read(workshop.path("build/report.json")).unwrap()).unwrap();
    for view in report["views"].as_array().unwrap() {
        assert!(view["similarity_to_given"].as_f64().unwrap() >= 0.9, "{view}");
        let id = view["id"].as_str().unwrap();
        let picture = |kind: &str| fs::read(workshop.path(&format!("build/views/{id}.{kind}.png"))).unwrap();
        assert_ne!(picture("given"), picture("target"));
    }
    let film = image::open(workshop.path("build/films/film-03.png")).unwrap().to_rgb8();
    assert!(film.as_raw().iter().all(|value| value % 85 == 0));
    assert!(film.as_raw().iter().any(|value| *value != 0));
}
