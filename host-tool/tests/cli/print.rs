//! `vitrine print`: what it says, refuses and leaves behind. Other programs read its files in `tests/print_tools.rs`.

use serde_json::Value;

use super::support::{Finished, SMALL, Workshop, names};

/// A build of 8 films, 20 x 15 mm, 64 x 48 pixels.
const PRINT: [&str; 7] = ["print", "build", "-o", "sheets", "--as-designed", "--dpi", "360x180"];

fn print(workshop: &Workshop, more: &[&str]) -> Finished {
    workshop.run(&[&PRINT, more].concat())
}

#[test]
fn sheets_are_written_whole_with_their_description() {
    let workshop = Workshop::built();
    let finished = print(&workshop, &["--json"]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    let told: Value = serde_json::from_str(&finished.stdout).unwrap();
    assert_eq!(
        names(&workshop.path("sheets")),
        ["assembly.pdf", "sheet-01.pdf", "sheet-01.tif", "sheets.json"]
    );
    let kept = std::fs::read_to_string(workshop.path("sheets/sheets.json")).unwrap();
    let kept: Value = serde_json::from_str(&kept).unwrap();
    assert_eq!(told["sheets"], kept["sheets"]);
    assert_eq!(kept["sheets"][0]["films"].as_array().unwrap().len(), 8);
    // 20 mm at 360 and 15 mm at 180 dots per inch.
    assert_eq!(kept["film_dots"], serde_json::json!([283, 106]));
    let estimate = &told["estimate"];
    assert_eq!(estimate["films_read"], 8);
    let written: u64 = ["sheet-01.pdf", "sheet-01.tif"]
        .map(|name| workshop.path(&format!("sheets/{name}")).metadata().unwrap().len())
        .iter()
        .sum();
    let ratio = estimate["bytes"].as_f64().unwrap() / written as f64;
    assert!((0.5..1.5).contains(&ratio), "{ratio}");
}

#[test]
fn films_that_lie_on_their_side_to_save_paper_come_back_pixel_by_pixel() {
    let workshop = Workshop::built();
    // Of 34 x 29 mm two go beside each other, of 29 x 34 mm three: three rows of 34 mm are less than four of 29 mm.
    for (way, mirrored) in [("--format=tiff", false), ("--mirrored", true)] {
        let finished = print(&workshop, &["--paper", "roll 102", "--json", way]);
        let told: Value = serde_json::from_str(&finished.stdout).unwrap();
        assert_eq!(told["turned"], true, "{told}");
        assert!(
            (told["sheets"][0]["mm"][1].as_f64().unwrap() - (3.0 * 34.0 + 40.0 + 10.0)).abs() < 0.1,
            "{told}"
        );
        let sheet = image::open(workshop.path("sheets/sheet-01.tif")).unwrap().into_rgb16();
        let [wide, high] = [0, 1].map(|axis| told["film_dots"][axis].as_u64().unwrap() as u32);
        for place in told["sheets"][0]["films"].as_array().unwrap() {
            let [number, left, top] =
                ["film", "x_dots", "y_dots"].map(|key| place[key].as_u64().unwrap() as u32);
            let film = workshop.path(&format!("build/films/film-{number:02}.png"));
            for (column, row, pixel) in image::open(film).unwrap().to_rgb8().enumerate_pixels() {
                // Up is to the right.
                let across = (2 * (47 - row) + 1) * wide / (2 * 48);
                let across = if mirrored { wide - 1 - across } else { across };
                let down = (2 * column + 1) * high / (2 * 64);
                let ink = sheet.get_pixel(left + across, top + down).0.map(|sample| u16::MAX - sample);
                assert_eq!(
                    ink,
                    pixel.0.map(|value| u16::from(value) * 257),
                    "film {number}: {column}, {row}"
                );
            }
        }
    }
}

#[test]
fn the_ink_is_the_films_mean_on_their_area() {
    let workshop = Workshop::built();
    let told: Value = serde_json::from_str(&print(&workshop, &["--dry-run", "--json"]).stdout).unwrap();
    assert!(!workshop.path("sheets").exists());
    for channel in 0..3 {
        let mut sum = 0.0;
        for film in 1..=8 {
            let film =
                image::open(workshop.path(&format!("build/films/film-{film:02}.png"))).unwrap().to_rgb8();
            sum += film.pixels().map(|pixel| f64::from(pixel.0[channel])).sum::<f64>();
        }
        let coverage = sum / 255.0 / (8.0 * 64.0 * 48.0);
        let estimate = &told["estimate"];
        assert!((estimate["coverage"][channel].as_f64().unwrap() - coverage).abs() < 1e-4);
        // 8 films of 20 x 15 mm, 10 ml/m2 where one is full.
        let millilitres = coverage * 8.0 * 0.020 * 0.015 * 10.0;
        assert!((estimate["ink_ml"][channel].as_f64().unwrap() - millilitres).abs() < 1e-6);
    }
}

#[test]
fn what_cannot_be_printed_is_refused_with_a_way_out_and_leaves_nothing() {
    let workshop = Workshop::built();
    let before = workshop.names();
    for (more, code, advice) in [
        (["--paper", "A9"], "vitrine::print::unknown_paper", "A4 landscape"),
        (["--dpi", "72"], "vitrine::print::too_coarse", "82"),
    ] {
        let arguments = [&["print", "build", "-o", "sheets"], &more[..]].concat();
        let finished = workshop.run(&arguments);
        assert_eq!(finished.code, Some(1), "{more:?}: {}", finished.stderr);
        assert!(finished.stderr.contains(code), "{more:?}: {}", finished.stderr);
        assert!(finished.stderr.contains(advice), "{more:?}: {}", finished.stderr);
    }
    workshop.write("exhibit.toml", SMALL.replace("width_mm = 20.0", "width_mm = 320.0"));
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let finished = workshop.run(&["print", "build", "-o", "sheets"]);
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    for text in ["vitrine::print::paper_too_small", "334.0 x 254.0 mm", "paper = \"A3\""] {
        assert!(finished.stderr.contains(text), "{text}: {}", finished.stderr);
    }
    let usage = workshop.run(&["print", "build", "-o", "sheets", "--dpi", "10x720"]);
    assert_eq!(usage.code, Some(2), "{}", usage.stderr);
    assert_eq!(workshop.names(), before);
}

#[test]
fn only_sheets_are_replaced_and_a_damaged_film_leaves_the_old_ones() {
    let workshop = Workshop::built();
    std::fs::create_dir(workshop.path("sheets")).unwrap();
    workshop.write("sheets/holiday.txt", "precious");
    let finished = print(&workshop, &[]);
    assert!(finished.stderr.contains("vitrine::print::not_sheets"), "{}", finished.stderr);
    std::fs::remove_file(workshop.path("sheets/holiday.txt")).unwrap();
    assert_eq!(print(&workshop, &[]).code, Some(0));
    let sheet = std::fs::read(workshop.path("sheets/sheet-01.tif")).unwrap();
    let film = workshop.path("build/films/film-05.png");
    let bytes = std::fs::read(&film).unwrap();
    std::fs::write(&film, &bytes[..bytes.len() / 2]).unwrap();
    let before = workshop.names();
    let finished = print(&workshop, &[]);
    assert_eq!(finished.code, Some(1));
    assert!(finished.stderr.contains("film-05.png"), "{}", finished.stderr);
    assert_eq!(std::fs::read(workshop.path("sheets/sheet-01.tif")).unwrap(), sheet);
    assert_eq!(workshop.names(), before);
}

#[test]
fn a_place_where_nothing_can_be_written_is_refused_before_the_work() {
    let workshop = Workshop::built();
    workshop.write("file", "no folder");
    for place in ["file/sheets", "file/deep/sheets"] {
        let finished = workshop.run(&["print", "build", "-o", place]);
        assert_eq!(finished.code, Some(1), "{}", finished.stderr);
        assert!(finished.stderr.contains("vitrine::print::write"), "{}", finished.stderr);
        assert!(finished.stderr.contains("permissions"), "{}", finished.stderr);
        assert!(!finished.stderr.contains("waste"), "worked before it was refused: {}", finished.stderr);
    }
}

#[test]
fn what_a_halftone_takes_is_said_beforehand() {
    let workshop = Workshop::built();
    for way in ["blue-noise", "error-diffusion"] {
        let arguments = ["print", "build", "-o", "sheets", "--dpi", "720x360", "--json", "--halftone", way];
        let told: Value = serde_json::from_str(&workshop.succeed(&arguments)).unwrap();
        let written: u64 = ["sheet-01.pdf", "sheet-01.tif"]
            .map(|name| workshop.path(&format!("sheets/{name}")).metadata().unwrap().len())
            .iter()
            .sum();
        let ratio = told["estimate"]["bytes"].as_f64().unwrap() / written as f64;
        assert!((0.8..1.2).contains(&ratio), "{way}: {ratio}");
    }
}

#[test]
fn spoilt_films_are_printed_anew() {
    let workshop = Workshop::built();
    let told: Value =
        serde_json::from_str(&print(&workshop, &["--films", "7,3,7", "--json"]).stdout).unwrap();
    let films = told["sheets"][0]["films"].as_array().unwrap();
    let numbers: Vec<&Value> = films.iter().map(|film| &film["film"]).collect();
    assert_eq!((numbers, told["sheets"].as_array().unwrap().len()), (vec![&3.into(), &7.into()], 1));
    assert_eq!(told["estimate"]["films_read"], 2);
    assert_eq!(names(&workshop.path("sheets")), ["sheet-01.pdf", "sheet-01.tif", "sheets.json"]);
    for wrong in ["0", "9"] {
        let finished = print(&workshop, &["--films", wrong]);
        assert_eq!(finished.code, Some(1), "{}", finished.stderr);
        assert!(finished.stderr.contains("vitrine::print::no_film"), "{}", finished.stderr);
        assert!(finished.stderr.contains("films 1 to 8"), "{}", finished.stderr);
    }
}
