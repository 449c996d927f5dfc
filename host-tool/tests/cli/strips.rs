//! `vitrine design` by strips: films too large for memory, and interruptions.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::support::{SMALL, Workshop, names};

/// An exhibit of which 16 MiB hold a few rows at a time.
fn large(workshop: &Workshop, design: &str) {
    let more = format!("[design]\nmemory_mib = 16\n{design}");
    workshop.write("exhibit.toml", SMALL.replace("[64, 48]", "[256, 320]").replace("[design]\n", &more));
}

/// The pixels of all films of a build.
fn films(workshop: &Workshop, build: &str) -> Vec<Vec<u8>> {
    let film = |number| workshop.path(&format!("{build}/films/film-{number:02}.png"));
    (1..=8).map(|number| image::open(film(number)).unwrap().to_rgb8().into_raw()).collect()
}

fn json(workshop: &Workshop, file: &str) -> Value {
    serde_json::from_slice(&fs::read(workshop.path(file)).unwrap()).unwrap()
}

/// All files of a build by their names.
fn bytes(workshop: &Workshop, build: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for folder in ["", "films/", "views/"] {
        let place = workshop.path(&format!("{build}/{folder}"));
        for name in names(&place) {
            if place.join(&name).is_file() {
                files.insert(format!("{folder}{name}"), fs::read(place.join(&name)).unwrap());
            }
        }
    }
    files
}

#[test]
fn the_product_by_strips_is_the_whole_product_and_the_plan_names_it() {
    let workshop = Workshop::new();
    large(&workshop, "");
    let finished = workshop.run(&["design", "exhibit.toml", "-o", "strips"]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    assert!(finished.stderr.contains("strips of"), "{}", finished.stderr);
    let whole = fs::read_to_string(workshop.path("exhibit.toml")).unwrap().replace("memory_mib = 16\n", "");
    workshop.write("exhibit.toml", whole);
    workshop.succeed(&["design", "exhibit.toml", "-o", "whole"]);
    assert!(films(&workshop, "strips") == films(&workshop, "whole"));
    let volume = |build: &str| json(&workshop, &format!("{build}/plan.json"))["volume"].clone();
    assert_eq!(volume("strips"), volume("whole"));
    assert_eq!(names(&workshop.path("strips")), names(&workshop.path("whole")));
}

#[test]
fn a_report_of_an_exhibit_in_small_says_so() {
    let workshop = Workshop::new();
    large(&workshop, "");
    let text = fs::read_to_string(workshop.path("exhibit.toml")).unwrap().replace("[256, 320]", "[20, 640]");
    workshop.write("exhibit.toml", text);
    let told = workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let report = json(&workshop, "build/report.json");
    assert_eq!(report["in_small"], serde_json::json!({ "pixels": [16, 512], "film_pixels": [20, 640] }));
    let page = fs::read_to_string(workshop.path("build/report.html")).unwrap();
    for text in [told, page] {
        assert!(
            text.contains("in small, with films of 16 x 512 pixels; the films in the folder have 20 x 640"),
            "{text}"
        );
    }
}

#[test]
fn what_it_takes_is_foretold_and_what_needs_whole_films_refused() {
    let workshop = Workshop::new();
    large(&workshop, "");
    let before = workshop.names();
    let told = workshop.succeed(&["design", "exhibit.toml", "-o", "build", "--dry-run", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert!(told["strips"].as_u64().unwrap() > 2 && told["minutes"].as_f64().unwrap() > 0.0, "{told}");
    assert_eq!(workshop.names(), before);
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let written: usize = bytes(&workshop, "build")
        .iter()
        .filter(|file| file.0.starts_with("films/"))
        .map(|file| file.1.len())
        .sum();
    let ratio = told["bytes"].as_f64().unwrap() / written as f64;
    assert!((0.4..2.5).contains(&ratio), "{ratio}");
    large(&workshop, "adapt = true\n");
    let refused = workshop.run(&["design", "exhibit.toml", "-o", "build"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("vitrine::design::not_by_strips"), "{}", refused.stderr);
}

/// Waits until some strips are on the disk.
fn wait_for_strips(workshop: &Workshop, child: &mut Child) {
    let journal = workshop.path("build.unfinished/strips.jsonl");
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(120) && child.try_wait().unwrap().is_none() {
        let lines = fs::read_to_string(&journal).unwrap_or_default().lines().count();
        if lines > 3 {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_design_goes_on_and_ends_as_if_nothing_had_happened() {
    let workshop = Workshop::new();
    large(&workshop, "");
    // Strips lean with the rays of a viewer so near.
    let near = fs::read_to_string(workshop.path("exhibit.toml")).unwrap() + "[viewer]\ndistance_mm = 60\n";
    workshop.write("exhibit.toml", near);
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let wanted = bytes(&workshop, "build");
    for signal in ["-INT", "-KILL"] {
        fs::remove_dir_all(workshop.path("build")).unwrap();
        let mut command = workshop.command(&["design", "exhibit.toml", "-o", "build"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        wait_for_strips(&workshop, &mut child);
        let kill = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(kill.is_ok());
        let code = child.wait().unwrap().code();
        assert!(code != Some(1) && code != Some(2), "{signal}: {code:?}");
        workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
        assert!(bytes(&workshop, "build") == wanted, "{signal}");
        assert!(!workshop.path("build.unfinished").exists());
    }
}

#[test]
fn an_object_alone_is_laid_by_strips_and_told_of_as_it_is() {
    let workshop = Workshop::new();
    let at = |index: usize, factor: usize| (index * factor % 997) as f64 / 997.0 - 0.5;
    let point = |index: usize| {
        let [x, y, z] = [at(index, 331), at(index, 577), at(index, 89)];
        format!("{x} {y} {z} {} {} {}\n", index % 256, index * 7 % 256, index * 31 % 256)
    };
    workshop.write("cloud.xyz", (0..3000).map(point).collect::<String>());
    let exhibit = |memory: &str| {
        format!(
            "[stack]\nfilms = 8\npixels = [300, 420]\nwidth_mm = 20.0\n[object]\nmodel = \"cloud.xyz\"\nhidden = \"remove\"\n\
             point_mm = 0.2\n[design]\n{memory}"
        )
    };
    workshop.write("whole.toml", exhibit(""));
    workshop.succeed(&["design", "whole.toml", "-o", "whole"]);
    workshop.write("exhibit.toml", exhibit("memory_mib = 16\n"));
    let told = workshop.succeed(&["design", "exhibit.toml", "-o", "strips", "--dry-run", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert!(told["strips"].as_u64().unwrap() > 2 && told["bytes"].as_u64().unwrap() > 0, "{told}");
    workshop.succeed(&["slice", "cloud.xyz", "-o", "strips", "--exhibit", "exhibit.toml"]);
    assert!(films(&workshop, "strips") == films(&workshop, "whole"));
    let object = |build: &str| json(&workshop, &format!("{build}/report.json"))["object"].clone();
    for key in ["on_films", "outside", "points_of_films", "unit_mm", "size_mm"] {
        assert_eq!(object("strips")[key], object("whole")[key], "{key}");
    }
    // Pictures around it look at whole films.
    let around = format!("{}[[view]]\nid = \"a\"\npattern = \"cat.jpg\"\n", exhibit("memory_mib = 16\n"));
    workshop.write("exhibit.toml", around);
    let refused = workshop.run(&["design", "exhibit.toml", "-o", "around"]);
    assert_eq!(refused.code, Some(1), "{}", refused.stderr);
    assert!(refused.stderr.contains("[object] with pictures around it"), "{}", refused.stderr);
}
