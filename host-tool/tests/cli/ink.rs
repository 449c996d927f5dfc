//! Inks and materials: measuring a photographed wedge, listing what films are made of.

use serde_json::Value;
use vitrine::ink::{CurveFile, wedge};
use vitrine::picture::{Picture, srgb_encode};

use super::support::Workshop;

/// Pixels of a mm, and the picture's dark rim in mm.
const FINE: f64 = 5.0;
const RIM: f64 = 8.0;

/// The wedge as a camera sees it that looks straight at it: each ink glows `most` of its coverage to the power 0.8.
fn photograph(most: f64) -> Picture {
    let wedge = wedge();
    let pixels = |mm: f64| ((mm + 2.0 * RIM) * FINE) as usize;
    let (width, height) = (pixels(wedge.width_mm), pixels(wedge.height_mm));
    let mut picture = Picture::new(width, height);
    for at in 0..width * height {
        let mm = |index: usize| (index as f64 + 0.5) / FINE - RIM;
        let coverages = wedge.coverages_at(mm(at % width), mm(at / width));
        for (channel, coverage) in coverages.into_iter().enumerate() {
            let light = most * f64::from(coverage).powf(0.8) + 0.004;
            picture.channel_mut(channel)[at] = srgb_encode(light.min(1.0) as f32);
        }
    }
    picture
}

#[test]
fn a_photographed_wedge_becomes_curves_that_an_exhibit_takes() {
    let workshop = Workshop::small();
    photograph(0.8).write_png(&workshop.path("photo.png")).unwrap();
    let told = workshop.succeed(&[
        "calibrate",
        "photo.png",
        "-o",
        "curves.toml",
        "--overlay",
        "found.png",
        "--json",
    ]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert!((told["pixels_per_mm"].as_f64().unwrap() - FINE).abs() < 0.1, "{told}");
    for curve in CurveFile::read(&workshop.path("curves.toml")).unwrap() {
        for coverage in [0.1_f32, 0.5, 0.9] {
            let wanted = coverage.powf(0.8);
            assert!((curve.light(coverage) - wanted).abs() < 0.01, "{coverage}: {}", curve.light(coverage));
        }
    }
    let (found, photo) = (
        Picture::read(&workshop.path("found.png")).unwrap(),
        Picture::read(&workshop.path("photo.png")).unwrap(),
    );
    assert_eq!((found.width(), found.height()), (photo.width(), photo.height()));
    workshop.write("exhibit.toml", format!("{}[print]\ncurves = \"curves.toml\"\n", super::support::SMALL));
    workshop.succeed(&["check", "exhibit.toml", "--quick"]);
    let text = workshop.succeed(&["calibrate", "photo.png", "-o", "none.toml", "--dry-run"]);
    assert!(text.contains("nothing written") && text.contains("green"), "{text}");
    assert!(!workshop.path("none.toml").exists());
}

#[test]
fn photographs_that_cannot_be_measured_are_refused_and_leave_nothing() {
    let workshop = Workshop::new();
    let before = workshop.names();
    let refused = |photo: &str, code: &str| {
        let finished = workshop.run(&["calibrate", photo, "-o", "curves.toml"]);
        assert_eq!(finished.code, Some(1), "{photo}");
        assert!(finished.stderr.contains(code), "{photo}: {}", finished.stderr);
    };
    refused("rocket.jpg", "vitrine::chart::");
    refused("nothing.jpg", "vitrine::ink::bad_photograph");
    assert_eq!(workshop.names(), before);
    photograph(1.3).write_png(&workshop.path("bright.png")).unwrap();
    refused("bright.png", "vitrine::ink::overexposed");
    photograph(0.002).map(|_| 0.01).write_png(&workshop.path("dark.png")).unwrap();
    refused("dark.png", "vitrine::chart::too_dark");
}

#[test]
fn materials_are_listed_with_their_sources() {
    let workshop = Workshop::new();
    let listed: Value = serde_json::from_str(&workshop.succeed(&["materials", "--json"])).unwrap();
    let polyester = &listed["films"][0];
    assert_eq!((polyester["tau_uv"].as_f64(), polyester["tau_visible"].as_f64()), (Some(0.82), Some(0.90)));
    for material in listed["films"].as_array().unwrap().iter().chain(listed["spacers"].as_array().unwrap()) {
        assert!(material["source"].as_str().unwrap().len() > 10, "{material}");
    }
    assert!(workshop.succeed(&["materials"]).contains("bonded-acrylic"));
}
