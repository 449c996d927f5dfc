//! Inks and materials: measuring a photographed wedge, listing what films are made of.

use image::ImageEncoder;
use serde_json::Value;
use vitrine::chart::Chart;
use vitrine::experiment::films;
use vitrine::ink::{CurveFile, wedge};
use vitrine::picture::{Picture, srgb_encode};

use super::support::Workshop;

/// Pixels of a mm, and the picture's dark rim in mm.
const FINE: f64 = 4.0;
const RIM: f64 = 8.0;

/// `chart` as a camera sees it that looks straight at it: `glow` is an ink's light by its coverage and place.
fn photograph(chart: &Chart, glow: impl Fn(f64, [f64; 2]) -> f64) -> Picture {
    let pixels = |mm: f64| ((mm + 2.0 * RIM) * FINE) as usize;
    let (width, height) = (pixels(chart.width_mm), pixels(chart.height_mm));
    let mut picture = Picture::new(width, height);
    let mut crossed = chart.clone();
    for at in 0..width * height {
        let mm = |index: usize| (index as f64 + 0.5) / FINE - RIM;
        let place = [mm(at % width), mm(at / width)];
        if at % width == 0 {
            crossed = chart.at_height(place[1]);
        }
        let coverages = crossed.coverages_at(place[0], place[1]);
        for (channel, coverage) in coverages.into_iter().enumerate() {
            let light = glow(f64::from(coverage), place) + 0.004;
            picture.channel_mut(channel)[at] = srgb_encode(light.min(1.0) as f32);
        }
    }
    picture
}

/// The wedge in inks that glow `most` of their coverage to the power 0.8.
pub(super) fn wedge_photograph(most: f64) -> Picture {
    photograph(&wedge(), |coverage, _| most * coverage.powf(0.8))
}

/// The circles with strips of a film that lets so much of the light through.
pub(super) fn circles_photograph(tau: f64) -> Picture {
    let strips = |[x, y]: [f64; 2]| {
        let over = |strip: &usize| {
            let [left, top, width, height] = films::strip_mm(*strip);
            (left..left + width).contains(&x) && (top..top + height).contains(&y)
        };
        (1..=films::MOST_FILMS).filter(over).count() as i32
    };
    photograph(&films::chart(), |coverage, place| 0.7 * coverage * tau.powi(strips(place)))
}

#[test]
fn a_photographed_wedge_becomes_curves_that_an_exhibit_takes() {
    let workshop = Workshop::small();
    wedge_photograph(0.8).write_png(&workshop.path("photo.png")).unwrap();
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
    for curve in CurveFile::read(&workshop.path("curves.toml")).unwrap().curves().unwrap() {
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

/// Writes a photograph, of sRGB code values, in those of a gamma of 1.8, and with a profile that says so where `tells`.
fn write_with_gamma(photograph: &Picture, path: &std::path::Path, tells: bool) {
    let bent = photograph.decoded().map(|light| light.powf(1.0 / 1.8));
    let mut encoder = image::codecs::png::PngEncoder::new(std::fs::File::create(path).unwrap());
    if tells {
        let mut profile = moxcms::ColorProfile::new_display_p3();
        let curve = moxcms::curve_from_gamma(1.8);
        (profile.red_trc, profile.green_trc, profile.blue_trc) =
            (Some(curve.clone()), Some(curve.clone()), Some(curve));
        profile.cicp = None;
        encoder.set_icc_profile(profile.encode().unwrap()).unwrap();
    }
    let (width, height) = (bent.width() as u32, bent.height() as u32);
    encoder.write_image(&bent.rgb8(), width, height, image::ExtendedColorType::Rgb8).unwrap();
}

#[test]
fn photographs_of_another_gamma_are_decoded_by_their_profile_or_by_what_is_given() {
    let workshop = Workshop::new();
    for (name, tells) in [("plain.png", false), ("tells.png", true)] {
        write_with_gamma(&wedge_photograph(0.8), &workshop.path(name), tells);
    }
    let off = |arguments: &[&str], way: &str| {
        let finished = workshop.run(&[&["calibrate", "-o", "curves.toml"], arguments].concat());
        assert!(finished.stderr.contains(way), "{arguments:?}: {}", finished.stderr);
        let [red, ..] = CurveFile::read(&workshop.path("curves.toml")).unwrap().curves().unwrap();
        (red.light(0.4) - 0.4_f32.powf(0.8)).abs()
    };
    assert!(off(&["plain.png"], "sRGB, which is assumed") > 0.03);
    assert!(off(&["plain.png", "--gamma", "1.8"], "gamma of 1.8") < 0.01);
    assert!(off(&["tells.png"], "Display P3") < 0.01);
    write_with_gamma(&circles_photograph(0.9), &workshop.path("circles.png"), true);
    let fit = ["experiment", "films", "--fit", "circles.png", "--side", "lamp", "--json"];
    let told: Value = serde_json::from_str(&workshop.succeed(&fit)).unwrap();
    assert!((told["tau"].as_f64().unwrap() - 0.9).abs() < 0.005, "{told}");
    assert!(told["photographs"][0]["decoded_by"].as_str().unwrap().contains("Display P3"), "{told}");
    assert_eq!(workshop.run(&["calibrate", "plain.png", "-o", "x.toml", "--gamma", "0"]).code, Some(2));
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
    wedge_photograph(1.3).write_png(&workshop.path("bright.png")).unwrap();
    refused("bright.png", "vitrine::ink::overexposed");
    wedge_photograph(0.002).map(|_| 0.01).write_png(&workshop.path("dark.png")).unwrap();
    refused("dark.png", "vitrine::chart::too_dark");
}

#[test]
fn a_photograph_of_the_other_chart_is_sent_to_the_command_that_measures_it() {
    let workshop = Workshop::new();
    wedge_photograph(0.8).write_png(&workshop.path("wedge.png")).unwrap();
    photograph(&films::chart(), |coverage, _| 0.8 * coverage)
        .write_png(&workshop.path("circles.png"))
        .unwrap();
    for (arguments, advice) in [
        (&["experiment", "films", "--fit", "wedge.png", "--side", "lamp"][..], "vitrine calibrate"),
        (&["calibrate", "circles.png", "-o", "curves.toml"], "vitrine experiment films --fit"),
    ] {
        let finished = workshop.run(arguments);
        assert_eq!(finished.code, Some(1), "{}", finished.stderr);
        for text in ["vitrine::chart::exchanged", advice] {
            assert!(finished.stderr.contains(text), "{text}: {}", finished.stderr);
        }
    }
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

#[test]
fn circles_fade_behind_films_as_in_the_paper() {
    let workshop = Workshop::new();
    let told: Value =
        serde_json::from_str(&workshop.succeed(&["experiment", "films", "-o", "films.png", "--json"]))
            .unwrap();
    let lamp = |films: usize| told["light"][films]["lamp"].as_f64().unwrap();
    assert_eq!(told["light"].as_array().unwrap().len(), 26);
    assert!((lamp(1) - 0.82).abs() < 1e-9 && (lamp(20) - 0.02).abs() < 0.002 && lamp(25) < 0.01, "{told}");
    assert!(Picture::read(&workshop.path("films.png")).unwrap().width() > 1000);
    assert!(
        workshop.succeed(&["experiment", "films", "-o", "films.png"]).contains("20                1.9 %")
    );
    assert_eq!(workshop.run(&["experiment", "films"]).code, Some(2));
    assert_eq!(workshop.run(&["experiment", "films", "-o", "x.png", "--tau-uv", "1.5"]).code, Some(2));
}

#[test]
fn photographed_circles_tell_what_a_film_lets_through() {
    let workshop = Workshop::new();
    for (name, tau) in [("one.png", 0.88), ("two.png", 0.9)] {
        circles_photograph(tau).write_png(&workshop.path(name)).unwrap();
    }
    let fit = ["experiment", "films", "--fit", "one.png", "two.png", "--side", "lamp"];
    let told: Value = serde_json::from_str(&workshop.succeed(&[&fit[..], &["--json"]].concat())).unwrap();
    assert_eq!(told["key"], "tau_uv");
    assert!((told["tau"].as_f64().unwrap() / 0.89 - 1.0).abs() < 0.01, "{told}");
    assert!((told["photographs"][1]["tau"].as_f64().unwrap() / 0.9 - 1.0).abs() < 0.01, "{told}");
    let text = workshop.succeed(&[&fit[..], &["--overlay", "found.png"]].concat());
    assert!(text.starts_with("tau_uv = 0.8") && workshop.path("found.png").exists(), "{text}");
    let finished = workshop.run(&["experiment", "films", "--fit", "cat.jpg", "--side", "both"]);
    assert_eq!(finished.code, Some(1));
    assert!(
        finished.stderr.contains("vitrine::chart::") && finished.stderr.contains("cat.jpg"),
        "{}",
        finished.stderr
    );
}

/// The ink of a sheet's dots, 65,535 for full.
fn sheet_ink(workshop: &Workshop, name: &str) -> image::ImageBuffer<image::Rgb<u16>, Vec<u16>> {
    let mut sheet = image::open(workshop.path(name)).unwrap().into_rgb16();
    sheet.iter_mut().for_each(|sample| *sample = u16::MAX - *sample);
    sheet
}

#[test]
fn a_printed_wedge_is_measured_as_what_was_printed() {
    let workshop = Workshop::new();
    workshop.succeed(&["print", "--wedge", "-o", "wedge", "--each", "--format", "tiff", "--dpi", "260"]);
    let sheet = sheet_ink(&workshop, "wedge/sheet-01.tif");
    let mut glowing = Picture::new(sheet.width() as usize, sheet.height() as usize);
    for channel in 0..3 {
        let plane = glowing.channel_mut(channel);
        for (value, dot) in plane.iter_mut().zip(sheet.pixels()) {
            *value = srgb_encode(0.7 * f32::from(dot.0[channel]) / 65_535.0);
        }
    }
    glowing.write_png(&workshop.path("photo.png")).unwrap();
    let told = workshop.succeed(&["calibrate", "photo.png", "-o", "curves.toml", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert!((told["pixels_per_mm"].as_f64().unwrap() - 260.0 / 25.4).abs() < 0.1, "true to size: {told}");
    for curve in CurveFile::read(&workshop.path("curves.toml")).unwrap().curves().unwrap() {
        assert!([0.1, 0.5, 0.9].into_iter().all(|coverage| (curve.light(coverage) - coverage).abs() < 0.01));
    }
    let circles =
        workshop.run(&["print", "--circles", "-o", "circles", "--each", "--dpi", "260", "--dry-run"]);
    assert_eq!(circles.code, Some(0), "{}", circles.stderr);
    assert!(!workshop.path("circles").exists());
}

#[test]
fn printed_films_are_parted_into_inks_side_by_side() {
    let workshop = Workshop::small();
    workshop.write("exhibit.toml", format!("{}[print]\nmarks = false\n", super::support::SMALL));
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let print = |more: &[&str]| {
        let plain = ["print", "build", "-o", "sheets", "--dpi", "720x360", "--format", "tiff", "--json"];
        let told: Value = serde_json::from_str(&workshop.succeed(&[&plain[..], more].concat())).unwrap();
        let sheet = sheet_ink(&workshop, "sheets/sheet-01.tif");
        let mean = |ink: usize| {
            sheet.pixels().map(|dot| f64::from(dot.0[ink])).sum::<f64>()
                / f64::from(sheet.width() * sheet.height())
        };
        ([mean(0), mean(1), mean(2)], sheet, told)
    };
    let (designed, _, _) = print(&["--as-designed"]);
    let (parted, _, told) = print(&[]);
    // What the limit dims apart, green and blue are thinned to the red ink's yield.
    for (ink, share) in [(0, 1.0), (1, 0.43 / 0.85), (2, 0.43 / 0.89)] {
        let ratio = parted[ink] / designed[ink] / share;
        assert!(ratio > 0.85 && ratio < 1.0 + 1e-3, "ink {ink}: {ratio}; {}", told["dimmed"]);
    }
    for way in ["blue-noise", "error-diffusion"] {
        let (dots, sheet, _) = print(&["--halftone", way]);
        for dot in sheet.pixels() {
            assert!(dot.0.iter().all(|&ink| ink == 0 || ink == u16::MAX), "{dot:?}");
            assert!(dot.0.iter().filter(|&&ink| ink > 0).count() <= 1, "{dot:?}");
        }
        for ink in 0..3 {
            assert!((dots[ink] / parted[ink] - 1.0).abs() < 0.02, "{way}: {dots:?} against {parted:?}");
        }
    }
}
