//! `vitrine view` against a projector of its own, written from the geometry alone.
//!
//! Film k of N lies at z_k = ((N-1)/2 - k) pitch. A point (x, y, z) appears at (x - z tan h, y - z tan v), x to the
//! right and y up, so that the view's point (x, y) shows each film at (x + z tan h, y + z tan v). Between the centres
//! of a film's pixels light is interpolated linearly; beyond the outermost centres there is none.

use std::fs;

use image::RgbImage;
use serde_json::Value;

use super::support::{SMALL, Workshop};

const FILMS: usize = 8;
const WIDTH_MM: f64 = 20.0;
const PITCH_MM: f64 = 0.6;

fn films(workshop: &Workshop) -> Vec<RgbImage> {
    (1..=FILMS)
        .map(|number| {
            image::open(workshop.path(&format!("build/films/film-{number:02}.png"))).unwrap().to_rgb8()
        })
        .collect()
}

/// One film's light at a column and row that need not be whole.
fn sample(film: &RgbImage, column: f64, row: f64, channel: usize) -> f64 {
    let (last_column, last_row) = (f64::from(film.width() - 1), f64::from(film.height() - 1));
    if !(0.0..=last_column).contains(&column) || !(0.0..=last_row).contains(&row) {
        return 0.0;
    }
    let (left, upper) = (column.floor(), row.floor());
    let (right_part, lower_part) = (column - left, row - upper);
    let at = |column: f64, row: f64| {
        let (column, row) = (column.min(last_column) as u32, row.min(last_row) as u32);
        f64::from(film.get_pixel(column, row).0[channel]) / 255.0
    };
    let upper_light = at(left, upper) * (1.0 - right_part) + at(left + 1.0, upper) * right_part;
    let lower_light = at(left, upper + 1.0) * (1.0 - right_part) + at(left + 1.0, upper + 1.0) * right_part;
    upper_light * (1.0 - lower_part) + lower_light * lower_part
}

/// What the films show, divided by their number; row by row, interleaved.
fn project(films: &[RgbImage], horizontal_deg: f64, vertical_deg: f64) -> Vec<f64> {
    let (width, height) = (films[0].width(), films[0].height());
    let pixel_mm = WIDTH_MM / f64::from(width);
    let (slope_x, slope_y) = (horizontal_deg.to_radians().tan(), vertical_deg.to_radians().tan());
    let mut light = Vec::new();
    for row in 0..height {
        for column in 0..width {
            for channel in 0..3 {
                let sum: f64 = films
                    .iter()
                    .enumerate()
                    .map(|(k, film)| {
                        let z = ((FILMS as f64 - 1.0) / 2.0 - k as f64) * PITCH_MM;
                        let film_column = f64::from(column) + z * slope_x / pixel_mm;
                        // Rows count downward, y upward.
                        let film_row = f64::from(row) - z * slope_y / pixel_mm;
                        sample(film, film_column, film_row, channel)
                    })
                    .sum();
                light.push(sum / FILMS as f64);
            }
        }
    }
    light
}

fn view(workshop: &Workshop, horizontal: f64, vertical: f64, more: &[&str]) -> (RgbImage, Value) {
    let (horizontal, vertical) = (horizontal.to_string(), vertical.to_string());
    let mut arguments = vec![
        "view",
        "build",
        "--horizontal",
        &horizontal,
        "--vertical",
        &vertical,
        "-o",
        "view.png",
        "--json",
    ];
    arguments.extend(more);
    let told = serde_json::from_str(&workshop.succeed(&arguments)).unwrap();
    (image::open(workshop.path("view.png")).unwrap().to_rgb8(), told)
}

fn designed(exhibit: &str) -> Workshop {
    let workshop = Workshop::new();
    workshop.write("exhibit.toml", exhibit);
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    workshop
}

#[test]
fn the_ideal_view_equals_an_independent_projection_within_one_code_value() {
    let workshop = designed(&SMALL.replace("\"code\"", "\"linear\""));
    let films = films(&workshop);
    for (horizontal, vertical) in
        [(0.0, 0.0), (30.0, 0.0), (-30.0, 0.0), (17.5, -12.0), (-44.0, 33.0), (3.0, 60.0)]
    {
        let light = project(&films, horizontal, vertical);
        for gain in ["1", "2.5"] {
            let (seen, told) = view(&workshop, horizontal, vertical, &["--ideal", "--gain", gain]);
            let factor: f64 = gain.parse().unwrap();
            assert_eq!(told["gain"], factor);
            let worst = seen
                .as_raw()
                .iter()
                .zip(&light)
                .map(|(code, light)| (f64::from(*code) - 255.0 * (light * factor).min(1.0)).abs())
                .fold(0.0, f64::max);
            assert!(worst <= 1.0, "{horizontal} {vertical}: {worst}");
        }
    }
}

#[test]
fn without_a_gain_the_brightest_half_percent_is_white() {
    let workshop = designed(SMALL);
    let mut light = project(&films(&workshop), 12.0, 0.0);
    light.sort_by(f64::total_cmp);
    let rank = 0.995 * (light.len() - 1) as f64;
    let white = light[rank as usize] + rank.fract() * (light[rank as usize + 1] - light[rank as usize]);
    let (_, told) = view(&workshop, 12.0, 0.0, &["--ideal"]);
    let gain = told["gain"].as_f64().unwrap();
    assert!((gain * white - 1.0).abs() < 1e-4, "{gain} {white}");
}

#[test]
fn a_viewer_to_the_right_sees_the_view_of_30_degrees() {
    // Deep enough for the views to part: the paper's stack with fewer pixels.
    let paper =
        SMALL.replace("films = 8", "films = 20").replace("[64, 48]", "96").replace("20.0\n", "35.0\n");
    let workshop = designed(&paper);
    let likeness = |horizontal: f64, id: &str| {
        let (seen, _) = view(&workshop, horizontal, 0.0, &["--ideal"]);
        let pattern = image::open(workshop.path(&format!("build/views/{id}.target.png"))).unwrap().to_rgb8();
        correlation(seen.as_raw(), pattern.as_raw())
    };
    for (right, left, id) in [(30.0, -30.0, "astronaut"), (-30.0, 30.0, "cat")] {
        let (own, mirrored) = (likeness(right, id), likeness(left, id));
        assert!(own > mirrored + 0.1, "{id}: {own} in its own direction, {mirrored} in the mirrored one");
    }
}

fn correlation(a: &[u8], b: &[u8]) -> f64 {
    let mean = |values: &[u8]| values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (f64::from(*a) - mean_a, f64::from(*b) - mean_b);
        (ab, aa, bb) = (ab + a * b, aa + a * a, bb + b * b);
    }
    ab / (aa * bb).sqrt()
}

#[test]
fn a_picture_of_light_says_so_and_can_be_encoded_instead() {
    let gamma = |workshop: &Workshop| {
        let file = fs::File::open(workshop.path("view.png")).unwrap();
        let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        (reader.info().gama_chunk.map(png::ScaledFloat::into_value), reader.info().srgb.is_some())
    };
    let light = designed(&SMALL.replace("\"code\"", "\"linear\""));
    let (values, told) = view(&light, 0.0, 0.0, &[]);
    assert_eq!((gamma(&light), &told["values"]), ((Some(1.0), false), &Value::from("light")));
    let (encoded, _) = view(&light, 0.0, 0.0, &["--encode"]);
    assert!(gamma(&light).1);
    let encode = |code: u8| 255.0 * vitrine::picture::srgb_encode(f32::from(code) / 255.0);
    let pairs = values.as_raw().iter().zip(encoded.as_raw()).filter(|(value, _)| **value > 60);
    assert!(pairs.clone().count() > 100);
    for (value, encoded) in pairs {
        assert!((f32::from(*encoded) - encode(*value)).abs() < 2.0);
    }
    let code = designed(SMALL);
    view(&code, 0.0, 0.0, &[]);
    assert!(gamma(&code).1);
}

#[test]
fn lamps_distance_and_absorption_change_what_is_seen() {
    let workshop = designed(SMALL);
    let seen = |more: &[&str]| view(&workshop, 20.0, 0.0, more).0;
    let full = seen(&["--gain", "1"]);
    assert_ne!(full, seen(&["--gain", "1", "--top", "0"]));
    assert_ne!(full, seen(&["--gain", "1", "--distance", "300"]));
    assert_ne!(full, seen(&["--gain", "1", "--ideal"]));
    // Two lamps of the same level give weights of the same proportions.
    assert_eq!(full, seen(&["--gain", "1", "--top", "0.5", "--bottom", "0.5"]));
    let dark = seen(&["--top", "0", "--bottom", "0"]);
    assert!(dark.as_raw().iter().all(|value| *value == 0));
    assert_eq!(
        workshop.run(&["view", "build", "--horizontal", "0", "--distance", "2", "-o", "v.png"]).code,
        Some(1)
    );
}

#[test]
fn a_film_changed_by_hand_is_noticed_and_a_broken_one_refused() {
    let workshop = designed(SMALL);
    let film = workshop.path("build/films/film-03.png");
    fs::copy(workshop.path("build/films/film-04.png"), &film).unwrap();
    let (_, told) = view(&workshop, 0.0, 0.0, &[]);
    assert_eq!(told["changed_films"][0], "films/film-03.png");
    let bytes = fs::read(&film).unwrap();
    fs::write(&film, &bytes[..bytes.len() / 2]).unwrap();
    let finished = workshop.run(&["view", "build", "--horizontal", "0", "-o", "broken.png"]);
    assert_eq!(finished.code, Some(1));
    assert!(finished.stderr.contains("film-03.png"), "{}", finished.stderr);
    assert!(!workshop.path("broken.png").exists());
}
