//! `vitrine design` writes a build that holds together.

use std::fs;

use serde_json::Value;
use vitrine::build_folder::BuildFolder;
use vitrine_exhibit::plan::ValidPlan;

use super::support::{SMALL, Workshop, names};

fn json(workshop: &Workshop, name: &str) -> Value {
    serde_json::from_slice(&fs::read(workshop.path(name)).unwrap()).unwrap()
}

#[test]
fn a_build_has_all_its_files_and_the_manifest_names_them() {
    let workshop = Workshop::small();
    let stdout = workshop.succeed(&["design", "exhibit.toml", "-o", "build", "--json"]);
    let told: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(told, json(&workshop, "build/report.json"));
    assert!(told["in_small"].is_null(), "the pictures are of the films themselves: {told}");
    assert_eq!(
        names(&workshop.path("build")),
        ["films", "manifest.json", "plan.bin", "plan.json", "report.html", "report.json", "views"]
    );
    assert_eq!(names(&workshop.path("build/films")).len(), 8);
    assert_eq!(names(&workshop.path("build/views")).len(), 6);

    let manifest = json(&workshop, "build/manifest.json");
    let outputs = manifest["outputs"].as_object().unwrap();
    assert_eq!(outputs.len(), 8 + 6 + 4);
    for (name, hash) in outputs {
        let bytes = fs::read(workshop.path("build").join(name)).unwrap();
        assert_eq!(*hash, blake3::hash(&bytes).to_hex().to_string(), "{name}");
    }
    let exhibit = fs::read(workshop.path("exhibit.toml")).unwrap();
    assert_eq!(manifest["inputs"]["exhibit.toml"], blake3::hash(&exhibit).to_hex().to_string());
    assert_eq!(manifest["inputs"].as_object().unwrap().len(), 4);
}

#[test]
fn the_same_exhibit_gives_the_same_bytes_wherever_it_lies() {
    let builds = [Workshop::small(), Workshop::small()].map(|workshop| {
        let absolute = workshop.path("cat.jpg").display().to_string();
        workshop.write("exhibit.toml", SMALL.replace("cat.jpg", &absolute).replace('\\', "/"));
        workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
        let text = fs::read_to_string(workshop.path("build/manifest.json")).unwrap();
        assert!(!text.contains(&workshop.path("").display().to_string()));
        let mut manifest: Value = serde_json::from_str(&text).unwrap();
        // The file itself names the folder here, so only its own hash may differ, which the page tells.
        manifest["inputs"]["exhibit.toml"].take();
        manifest["outputs"]["report.html"].take();
        manifest
    });
    assert_eq!(builds[0], builds[1]);
}

#[test]
fn the_plan_is_one_that_the_controller_takes_and_names_the_films() {
    let workshop = Workshop::small();
    for bits in ["8", "16"] {
        workshop.succeed(&["design", "exhibit.toml", "-o", "build", "--bits", bits]);
        let build = BuildFolder::open(&workshop.path("build")).unwrap();
        let plan = vitrine_protocol::plan_file::decode(&build.plan_file().unwrap()).unwrap();
        let films = build.films().unwrap();
        assert!(films.changed.is_empty());
        let depth =
            if bits == "8" { vitrine::volume::InkDepth::Eight } else { vitrine::volume::InkDepth::Sixteen };
        assert_eq!(plan.volume.blake3, films.volume.blake3(depth));
        assert_eq!(serde_json::to_value(&plan).unwrap(), json(&workshop, "build/plan.json"));
        assert_eq!(plan.views.iter().map(|view| view.horizontal.0).collect::<Vec<_>>(), [3000, 0, -3000]);
        ValidPlan::new(plan).unwrap();
    }
}

#[test]
fn a_design_that_needs_more_memory_than_allowed_is_refused_beforehand() {
    let workshop = Workshop::small();
    let limited = |mib: u32| SMALL.replace("[design]\n", &format!("[design]\nmemory_mib = {mib}\n"));
    // Not even a row of these does.
    let wide = limited(16).replace("films = 8", "films = 200").replace("[64, 48]", "[4096, 64]");
    workshop.write("exhibit.toml", wide);
    let finished = workshop.run(&["design", "exhibit.toml", "-o", "build"]);
    assert_eq!(finished.code, Some(1));
    for text in ["vitrine::design::memory", "`memory_mib` in [design] allows 16", "fewer `pixels`"] {
        assert!(finished.stderr.contains(text), "{}", finished.stderr);
    }
    assert!(!workshop.path("build").exists());
    workshop.write("exhibit.toml", limited(1000));
    let finished = workshop.run(&["design", "exhibit.toml", "-o", "build"]);
    assert_eq!(finished.code, Some(0));
    assert!(finished.stderr.contains("needs at most about"), "{}", finished.stderr);
}

/// Two pictures in each of two directions, one under each lamp.
const PAGES: &str = "\
[stack]
films = 10
pixels = 48
[design]
tone = \"code\"
iterations = 10
[visitors]
paging = \"step\"
[lamps]
irradiance_w_m2 = 20
[[schedule]]
days = \"daily\"
from = \"10:00\"
to = \"18:00\"
[[view]]
id = \"astronaut\"
pattern = \"astronaut.jpg\"
horizontal_deg = 25.0
lamp = \"top\"
[[view]]
id = \"coffee\"
pattern = \"coffee.jpg\"
horizontal_deg = 25.0
lamp = \"bottom\"
[[view]]
id = \"cat\"
pattern = \"cat.jpg\"
horizontal_deg = -25.0
distance_mm = 700.0
";

#[test]
fn pages_pairs_and_what_they_are_worth_are_in_the_plan_and_in_the_report() {
    let workshop = Workshop::new();
    workshop.write("exhibit.toml", PAGES);
    let text = workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    for wanted in
        ["what lamps do", "own pair", "neutral pair", "both lamps full", "can be held for 0.8 h a day"]
    {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
    let (plan, report) = (json(&workshop, "build/plan.json"), json(&workshop, "build/report.json"));
    assert_eq!(plan["viewer"]["paging"], "Step");
    let level = |view: usize, lamp: &str| plan["views"][view]["emphasis"][lamp].as_f64().unwrap();
    assert!(level(0, "top") > 0.0 && level(0, "bottom") == 0.0);
    assert!(level(1, "bottom") > 0.0 && level(1, "top") == 0.0);
    // Lamps of 20 W/m2 under a ceiling of 10.
    let brightest =
        (0..3).flat_map(|view| ["top", "bottom"].map(|lamp| level(view, lamp))).fold(0.0, f64::max);
    assert_eq!(brightest, 32_768.0);
    assert_eq!(plan["shared"].as_array().unwrap().len(), 3);
    assert_eq!(report["shared"][1]["views"], serde_json::json!(["astronaut", "cat"]));
    assert_eq!(report["views"][1]["lamp"], "bottom");
    assert_eq!(report["views"][2]["distance_mm"], 700.0);
    let page = fs::read_to_string(workshop.path("build/report.html")).unwrap();
    for wanted in ["astronaut and cat", "under the bottom lamp alone", "can be held for"] {
        assert!(page.contains(wanted), "{wanted}");
    }

    let seen = |arguments: &[&str]| -> Value {
        let all = [&["view", "build", "-o", "seen.png", "--json"], arguments].concat();
        serde_json::from_str(&workshop.succeed(&all)).unwrap()
    };
    let coffee = seen(&["--view", "coffee"]);
    assert_eq!((coffee["horizontal_deg"].as_f64(), coffee["top"].as_f64()), (Some(25.0), Some(0.0)));
    assert!(coffee["bottom"].as_f64().unwrap() > 0.0);
    assert_eq!(seen(&["--view", "coffee", "--top", "1"])["top"], 1.0);
    assert_eq!(seen(&["--horizontal", "25"])["bottom"], 1.0);
    let finished = workshop.run(&["view", "build", "--view", "tea", "-o", "seen.png"]);
    assert_eq!(finished.code, Some(1));
    assert!(finished.stderr.contains("astronaut, coffee, cat"), "{}", finished.stderr);
    assert_eq!(workshop.run(&["view", "build", "-o", "seen.png"]).code, Some(2));
}

#[test]
fn what_becomes_of_a_design_in_human_hands_is_told_and_always_the_same() {
    let workshop = Workshop::small();
    // Ideal optics expect no errors of hands.
    workshop.write("exhibit.toml", SMALL.replace("\"ideal\"", "\"stack\""));
    let built = || -> Value {
        let told = workshop.succeed(&["design", "exhibit.toml", "-o", "build", "--as-built", "--json"]);
        serde_json::from_str::<Value>(&told).unwrap()["as_built"].clone()
    };
    let first = built();
    assert_eq!(first, built());
    assert_eq!((first["stacks"].as_u64(), first["errors"]["spacing_um"].as_f64()), (Some(16), Some(25.0)));
    for view in first["views"].as_array().unwrap() {
        let of = |name: &str| view[name].as_f64().unwrap();
        assert!(of("worst_psnr_db") < of("mean_psnr_db") && of("worst_ssim") < of("mean_ssim"), "{view}");
        assert!((0.0..of("mean_psnr_db") - of("worst_psnr_db")).contains(&of("spread_psnr_db")), "{view}");
    }
    let page = fs::read_to_string(workshop.path("build/report.html")).unwrap();
    assert!(page.contains("16 random stacks") && page.contains("gaps 25 µm"));
    let text = workshop.succeed(&["design", "exhibit.toml", "-o", "build", "--as-built"]);
    assert!(text.contains("mean of 16 stacks   worst stack"), "{text}");
    let text = workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    assert!(text.contains("mean of 6 stacks"), "{text}");
}

/// The most memory that a child has had in RAM, in MiB.
#[cfg(target_os = "linux")]
fn peak_mib(mut child: std::process::Child) -> f64 {
    let mut peak = 0.0f64;
    while child.try_wait().unwrap().is_none() {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
        peak = peak.max(kib.unwrap_or_default() / 1024.0);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(child.wait().unwrap().success());
    peak
}

#[cfg(target_os = "linux")]
#[test]
fn no_more_memory_is_used_than_was_said() {
    let workshop = Workshop::small();
    let product = SMALL.replace("[64, 48]", "[400, 320]").replace("films = 8", "films = 24");
    let ideal = product.replace("\"product\"", "\"least-squares\"\niterations = 2");
    let robust = ideal.replace("optics = \"ideal\"\ntone = \"code\"\n", "");
    assert_ne!(robust, ideal);
    for (method, text) in [("product", product), ("ideal", ideal), ("robust", robust)] {
        workshop.write("exhibit.toml", text);
        let mut command = workshop.command(&["design", "exhibit.toml", "-o", "build"]);
        let child = command.stderr(std::fs::File::create(workshop.path("told")).unwrap()).spawn().unwrap();
        let peak = peak_mib(child);
        let told = fs::read_to_string(workshop.path("told")).unwrap();
        let said = told.lines().find_map(|line| line.strip_prefix("needs at most about ")).unwrap();
        let said: f64 = said.split(' ').next().unwrap().parse().unwrap();
        assert!(peak <= said && peak > 0.7 * said, "{method}: {said} MiB said, {peak} MiB used");
    }
}

#[test]
fn a_mask_and_a_pedestal_change_the_design_and_the_mask_is_an_input() {
    let workshop = Workshop::new();
    let slow = SMALL.replace("\"product\"", "\"least-squares\"\niterations = 5");
    let films = |exhibit: String| {
        workshop.write("exhibit.toml", exhibit);
        workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
        json(&workshop, "build/plan.json")["volume"]["blake3"].clone()
    };
    let plain = films(slow.clone());
    let masked = films(slow.replace("\"coffee.jpg\"", "\"coffee.jpg\"\nmask = \"rocket.jpg\""));
    assert!(json(&workshop, "build/manifest.json")["inputs"]["rocket.jpg"].is_string());
    let lifted = films(slow.replace("[design]\n", "[design]\npedestal = 0.5\n"));
    let contrast = json(&workshop, "build/report.json")["views"][0]["quality"]["contrast"].as_f64().unwrap();
    assert!((1.5..4.0).contains(&contrast), "{contrast}");
    assert!(plain != masked && plain != lifted);
}

#[test]
fn the_columns_of_the_summary_stand_below_each_other_whatever_the_views_names() {
    let workshop = Workshop::new();
    workshop.write("exhibit.toml", SMALL.replace("id = \"coffee\"", "id = \"coffee_in_the_afternoon\""));
    let summary = workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let columns = |table: &str| -> Vec<Option<usize>> {
        let lines = summary.lines().skip_while(|line| !line.starts_with(table)).skip(1).take(3);
        lines.map(|line| line.find(" dB")).collect()
    };
    for table in ["what lamps do", "as built"] {
        let found = columns(table);
        assert_eq!(found.len(), 3, "{summary}");
        assert!(found.iter().all(|column| column.is_some() && *column == found[0]), "{summary}");
    }
}

#[test]
fn a_build_is_replaced_by_the_next_one() {
    let workshop = Workshop::built();
    workshop.write("exhibit.toml", SMALL.replace("films = 8", "films = 5"));
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    assert_eq!(names(&workshop.path("build/films")).len(), 5);
    assert_eq!(
        workshop.names(),
        ["astronaut.jpg", "build", "cat.jpg", "coffee.jpg", "exhibit.toml", "rocket.jpg"]
    );
}

#[test]
fn a_new_exhibit_is_valid_as_it_is() {
    let workshop = Workshop::new();
    let stdout = workshop.succeed(&["new", "mine"]);
    assert_eq!(stdout.trim(), "mine/exhibit.toml");
    workshop.succeed(&["check", "mine/exhibit.toml", "--quick"]);
    assert_eq!(workshop.run(&["new", "mine"]).code, Some(1));
}

#[test]
fn every_command_has_help_with_examples() {
    let workshop = Workshop::new();
    let help = workshop.succeed(&["--help"]);
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty()))
        .filter(|name| *name != "help")
        .collect();
    assert!(commands.len() >= 4, "{help}");
    for command in commands {
        let help = workshop.succeed(&[command, "--help"]);
        assert!(help.contains(&format!("Examples:\n  vitrine {command}")), "{command}: {help}");
        assert!(help.contains("--json"), "{command}");
        assert!(!help.contains('\u{1b}'), "{command}");
    }
}
