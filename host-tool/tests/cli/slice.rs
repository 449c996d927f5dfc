//! `vitrine slice` and `[object]`: from models to builds like any other.

use std::fs;

use serde_json::Value;

use super::support::{SMALL, Workshop};

#[path = "../../examples/flowers/meadow.rs"]
mod meadow;

/// A cloud of `count` points on a grid, 0.5 mm apart, red to the right and green above; every tenth lies far outside.
fn cloud(count: usize) -> String {
    let line = |index: usize| {
        let (column, row, layer) = (index % 20, index / 20 % 20, index / 400);
        let z = if index % 10 == 9 { 900.0 } else { layer as f64 * 0.6 - 2.0 };
        let (x, y) = (column as f64 * 0.5 - 4.75, row as f64 * 0.5 - 4.75);
        format!("{x} {y} {z} {} {} 200\n", 100 + column, 100 + row)
    };
    (0..count).map(line).collect()
}

const IN_MM: [&str; 4] = ["--unit-mm", "1", "--centre", "origin"];

#[test]
fn a_cloud_becomes_a_build_like_any_other_whose_points_are_all_accounted_for() {
    let workshop = Workshop::new();
    workshop.write("cloud.xyz", cloud(2000));
    let arguments = [
        "slice",
        "cloud.xyz",
        "-o",
        "build",
        "--json",
        "--pixels",
        "64x48",
        "--films",
        "8",
        "--width-mm",
        "20",
    ];
    let told: Value = serde_json::from_str(&workshop.succeed(&[&arguments[..], &IN_MM].concat())).unwrap();
    let report: Value =
        serde_json::from_slice(&fs::read(workshop.path("build/report.json")).unwrap()).unwrap();
    assert_eq!(told, report);
    let object = &told["object"];
    let count = |key: &str| object[key].as_u64().unwrap();
    assert_eq!((count("on_films"), count("outside"), count("not_finite")), (1800, 200, 0));
    let of_films: Vec<u64> = serde_json::from_value(object["points_of_films"].clone()).unwrap();
    assert_eq!(of_films.iter().sum::<u64>(), 1800);
    assert_eq!(object["model"], "cloud.xyz");
    // Every film's file has a pixel with ink for each of its points: none share a voxel.
    for (film, points) in of_films.iter().enumerate() {
        let film = image::open(workshop.path(&format!("build/films/film-{:02}.png", film + 1))).unwrap();
        let lit = film.to_rgb8().pixels().filter(|pixel| pixel.0 != [0; 3]).count();
        assert_eq!(lit as u64, *points);
    }
    assert_eq!(count("voxels"), 1800);
    let manifest: Value =
        serde_json::from_slice(&fs::read(workshop.path("build/manifest.json")).unwrap()).unwrap();
    let hash = blake3::hash(cloud(2000).as_bytes()).to_hex().to_string();
    assert_eq!(manifest["inputs"], serde_json::json!({ "cloud.xyz": hash }));
    let page = fs::read_to_string(workshop.path("build/report.html")).unwrap();
    assert!(page.contains("1800 voxels have ink") && !page.contains("NaN"));
    for id in ["left", "front", "right"] {
        assert!(workshop.path(&format!("build/views/{id}.png")).exists());
        workshop.succeed(&["view", "build", "--view", id, "-o", "view.png"]);
    }
    // Blue grows nowhere, red to the right: the right half of the front view is redder.
    workshop.succeed(&["view", "build", "--horizontal", "0", "--ideal", "-o", "front.png"]);
    let front = image::open(workshop.path("front.png")).unwrap().to_rgb8();
    let red = |columns: std::ops::Range<u32>| -> u64 {
        columns
            .flat_map(|x| (0..48).map(move |y| (x, y)))
            .map(|(x, y)| u64::from(front.get_pixel(x, y).0[0]))
            .sum()
    };
    assert!(red(32..64) > red(0..32));
}

#[test]
fn the_same_model_gives_the_same_bytes_on_any_number_of_threads() {
    let workshop = Workshop::new();
    workshop.write("cloud.xyz", cloud(20_000));
    let films = ["1", "4"].map(|threads| {
        let arguments = ["slice", "cloud.xyz", "-o", "build", "--pixels", "48", "--films", "6"];
        let output = workshop.command(&arguments).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success());
        fs::read(workshop.path("build/manifest.json")).unwrap()
    });
    assert_eq!(films[0], films[1]);
}

#[test]
fn a_dry_run_tells_and_writes_nothing() {
    let workshop = Workshop::new();
    workshop.write("cloud.xyz", cloud(100));
    let before = workshop.names();
    let arguments = ["slice", "cloud.xyz", "--dry-run", "--pixels", "64", "--json"];
    let told: Value = serde_json::from_str(&workshop.succeed(&[&arguments[..], &IN_MM].concat())).unwrap();
    assert_eq!(told["outside"], 10);
    assert_eq!(workshop.names(), before);
}

#[test]
fn an_object_stands_in_front_of_the_pictures_around_it() {
    let workshop = Workshop::new();
    // A red square of 6 x 6 mm on the middle of the stack.
    let line = |index: usize| {
        let (x, y) = ((index % 40) as f64 * 0.15 - 2.9, (index / 40) as f64 * 0.15 - 2.9);
        format!("{x} {y} 0.1 255 40 40\n")
    };
    workshop.write("square.xyz", (0..1600).map(line).collect::<String>());
    let exhibit = SMALL.replace("\"product\"", "\"least-squares\"\nbrightness = 0.15\niterations = 20");
    let object = "[object]\nmodel = \"square.xyz\"\nunit_mm = 1.0\ncentre = \"origin\"\n";
    workshop.write("exhibit.toml", format!("{exhibit}{object}"));
    let told: Value =
        serde_json::from_str(&workshop.succeed(&["design", "exhibit.toml", "-o", "build", "--json"]))
            .unwrap();
    assert_eq!(told["object"]["on_films"], 1600);
    // The object's own ink is there untouched.
    let film = image::open(workshop.path("build/films/film-04.png")).unwrap().to_rgb8();
    assert_eq!(film.get_pixel(32, 24).0, [255, 40, 40]);
    let red_of = |name: &str, x: u32, y: u32| {
        let picture = image::open(workshop.path(name)).unwrap().to_rgb8();
        let [r, g, b] = picture.get_pixel(x, y).0.map(i32::from);
        r - (g + b) / 2
    };
    for id in ["astronaut", "coffee", "cat"] {
        for name in [format!("build/views/{id}.png"), format!("build/views/{id}.target.png")] {
            assert!(red_of(&name, 32, 24) > 60, "{name}: {}", red_of(&name, 32, 24));
        }
    }
}

#[test]
fn wrong_models_are_told_and_leave_nothing() {
    let workshop = Workshop::new();
    workshop.write("bad.xyz", "1 2 3\n4 5 x\n");
    workshop.write("far.xyz", "1 2 3\n");
    workshop.write("nothing.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
    let before = workshop.names();
    for (arguments, wanted) in [
        (&["bad.xyz"][..], &["vitrine::model::damaged", "line 2", "is no number", "help:"][..]),
        (&["far.xyz", "--unit-mm", "1000", "--centre", "origin"], &["vitrine::model::empty", "1 outside"]),
        (&["nothing.ply"], &["vitrine::model::empty", "no point"]),
        (&["none.ply"], &["vitrine::model::unreadable", "none.ply"]),
        (&["far.xyz", "--films", "200", "--pixels", "65536"], &["vitrine::slice::too_many_voxels"]),
    ] {
        let finished = workshop.run(&[&["slice", "-o", "build"], arguments].concat());
        assert_eq!(finished.code, Some(1), "{arguments:?}: {}", finished.stderr);
        for text in wanted {
            assert!(finished.stderr.contains(text), "no \"{text}\" in:\n{}", finished.stderr);
        }
        assert_eq!(workshop.names(), before);
    }
    for arguments in [
        &["far.xyz"][..],
        &["far.xyz", "-o", "build", "--turn-deg", "1,2"],
        &["far.xyz", "-o", "build", "--colour", "red"],
        &["far.xyz", "-o", "build", "--unit-mm", "0"],
    ] {
        assert_eq!(workshop.run(&[&["slice"], arguments].concat()).code, Some(2), "{arguments:?}");
    }
}

/// The paper's 3D prototype: 51,767 points on 20 films of 300 x 300, in 35 x 35 x 12.5 mm.
#[test]
fn the_films_of_the_meadow_show_exactly_its_points() {
    let workshop = Workshop::new();
    workshop.write("flowers.ply", meadow::ply());
    let prototype = ["--pixels", "300", "--spacer-mm", "0.525"];
    let arguments = [&["slice", "flowers.ply", "-o", "build", "--json"][..], &IN_MM, &prototype].concat();
    let told: Value = serde_json::from_str(&workshop.succeed(&arguments)).unwrap();
    let count = |key: &str| told["object"][key].as_u64().unwrap();
    assert_eq!((count("on_films"), count("outside"), count("not_finite")), (meadow::POINTS as u64, 0, 0));
    let lit: usize = (1..=20)
        .map(|film| {
            let film =
                image::open(workshop.path(&format!("build/films/film-{film:02}.png"))).unwrap().to_rgb8();
            film.pixels().filter(|pixel| pixel.0 != [0; 3]).count()
        })
        .sum();
    assert_eq!(lit, meadow::POINTS);
    for angle in ["-30", "0", "30"] {
        workshop.succeed(&["view", "build", "--horizontal", angle, "--ideal", "--encode", "-o", "view.png"]);
        let view = image::open(workshop.path("view.png")).unwrap().to_rgb8();
        let lit = view.pixels().filter(|pixel| pixel.0.iter().any(|value| *value > 60)).count();
        assert!((20_000..60_000).contains(&lit), "{angle}: {lit}");
    }
}

#[test]
fn an_objects_films_are_printed_with_as_much_ink_as_was_said() {
    let workshop = Workshop::new();
    workshop.write("cloud.xyz", cloud(2000));
    let stack = ["--pixels", "64x48", "--films", "8", "--width-mm", "20"];
    workshop.succeed(&[&["slice", "cloud.xyz", "-o", "build"], &stack[..], &IN_MM].concat());
    for way in ["blue-noise", "error-diffusion"] {
        let coarse = ["print", "build", "-o", "sheets", "--json", "--dpi", "720x360", "--halftone", way];
        let told = workshop.succeed(&coarse);
        let told: Value = serde_json::from_str(&told).unwrap();
        let sheet = image::open(workshop.path("sheets/sheet-01.tif")).unwrap().into_rgb16();
        let number = |value: &Value| value.as_u64().unwrap() as u32;
        let [width, height] = [0, 1].map(|axis| number(&told["film_dots"][axis]));
        let mut dots = [0_u64; 3];
        for place in told["sheets"][0]["films"].as_array().unwrap() {
            let (x, y) = (number(&place["x_dots"]), number(&place["y_dots"]));
            for pixel in image::imageops::crop_imm(&sheet, x, y, width, height).to_image().pixels() {
                (0..3).for_each(|ink| dots[ink] += u64::from(pixel.0[ink] == 0));
            }
        }
        for (ink, dots) in dots.into_iter().enumerate() {
            let covered = dots as f64 / f64::from(8 * width * height);
            let said = told["estimate"]["coverage"][ink].as_f64().unwrap();
            assert!(said > 0.001 && (covered / said - 1.0).abs() < 0.05, "{way}: {covered} for {said}");
        }
    }
}

#[test]
fn an_objects_films_hold_the_printers_levels_alone_and_with_pictures_around_it() {
    let workshop = Workshop::new();
    workshop.write("cloud.xyz", cloud(2000));
    let object = "[object]\nmodel = \"cloud.xyz\"\nunit_mm = 1.0\ncentre = \"origin\"\n[print]\nlevels = 2\n";
    let (head, views) = SMALL.split_once("[[view]]").unwrap();
    workshop.write("alone.toml", format!("{head}{object}"));
    workshop.write("around.toml", format!("{head}{object}[[view]]{views}"));
    let films = |exhibit: &str| -> Vec<image::RgbImage> {
        workshop.succeed(&["design", exhibit, "-o", "build"]);
        let film = |film: usize| workshop.path(&format!("build/films/film-{film:02}.png"));
        (1..=8).map(|number| image::open(film(number)).unwrap().to_rgb8()).collect()
    };
    let (alone, around) = (films("alone.toml"), films("around.toml"));
    let full = |films: &[image::RgbImage]| -> usize {
        let values = films.iter().flat_map(|film| film.as_raw());
        assert!(values.clone().all(|value| [0, 255].contains(value)));
        values.filter(|value| **value == 255).count()
    };
    // 1,800 points, of 100 to 119 of 255 in red and green and of 200 in blue.
    let wanted = 1800.0 * (2.0 * 109.0 + 200.0) / 255.0;
    let ratio = full(&alone) as f64 / wanted;
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    assert!(full(&around) > 2 * full(&alone));
    // What the object has stays.
    for (alone, around) in alone.iter().zip(&around) {
        for (own, other) in alone.pixels().zip(around.pixels()).filter(|(own, _)| own.0 != [0; 3]) {
            assert_eq!(own, other);
        }
    }
}
