//! What exhibit.toml takes and refuses.

use std::path::Path;

use miette::Diagnostic;

use super::*;

const VIEW: &str = "[[view]]\nid = \"front\"\npattern = \"photos/coffee.jpg\"\n";

/// Any path in the crate's folder: patterns are relative to it.
fn here() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("exhibit.toml")
}

fn read(text: &str) -> Result<Exhibit, ConfigError> {
    parse(&here(), text)
}

/// Codes, and the text that each label covers, of all problems in `text`.
fn problems(text: &str) -> Vec<(&'static str, String, String)> {
    let Err(ConfigError::Invalid { problems, .. }) = read(text) else { return Vec::new() };
    problems
        .iter()
        .map(|problem| {
            let label = problem.labels().unwrap().next().unwrap();
            let covered = &text[label.offset()..label.offset() + label.len()];
            let help = problem.help().map(|help| help.to_string()).unwrap_or_default();
            (problem.code_name(), covered.to_owned(), format!("{problem}; {help}"))
        })
        .collect()
}

/// The one problem of `text` with `VIEW` behind it.
fn problem(text: &str) -> (&'static str, String, String) {
    let mut found = problems(&format!("{text}\n{VIEW}"));
    assert_eq!(found.len(), 1, "{text}: {found:?}");
    found.remove(0)
}

#[test]
fn a_view_is_all_that_is_needed() {
    let exhibit = read(VIEW).unwrap();
    assert_eq!(exhibit.stack.films, 20);
    assert_eq!(exhibit.stack.pixels, [512, 512]);
    assert_eq!(exhibit.stack.film_pitch_mm(), 0.6);
    assert_eq!(exhibit.viewer.distance_mm, None);
    assert_eq!(exhibit.design.misplacement_um, 68.0);
    assert_eq!(exhibit.views[0].horizontal_deg, 0.0);
    assert_eq!(exhibit.limits.daily_dose_j_m2, 30_000.0);
}

#[test]
fn the_starter_shows_the_defaults() {
    let text = crate::starter::EXHIBIT_TOML.replace("pattern = \"", "pattern = \"photos/");
    let shown = read(&text).unwrap();
    let defaults = read(VIEW).unwrap();
    assert_eq!(shown.views.len(), 3);
    let with_views_of = |exhibit: &Exhibit| Exhibit {
        views: exhibit.views.clone(),
        name: exhibit.name.clone(),
        ..defaults.clone()
    };
    assert_eq!(shown, with_views_of(&shown));
}

#[test]
fn the_starter_schedule_is_valid_once_uncommented() {
    let text: String = crate::starter::EXHIBIT_TOML
        .replace("pattern = \"", "pattern = \"photos/")
        .lines()
        .skip_while(|line| !line.starts_with("# [[schedule]]"))
        .take_while(|line| line.starts_with("# "))
        .map(|line| format!("{}\n", &line[2..]))
        .collect();
    let exhibit = read(&format!("{text}{VIEW}")).unwrap();
    assert_eq!(exhibit.schedule[0].days, [false, true, true, true, true, true, true]);
    assert_eq!((exhibit.schedule[0].from_minute, exhibit.schedule[0].to_minute), (600, 1080));
}

#[test]
fn ideal_optics_expect_no_misplacement_unless_it_is_said() {
    let ideal = |more: &str| read(&format!("[design]\noptics = \"ideal\"\n{more}\n{VIEW}")).unwrap().design;
    assert_eq!(ideal("").misplacement_um, 0.0);
    assert_eq!(ideal("misplacement_um = 20").misplacement_um, 20.0);
}

#[test]
fn unknown_keys_are_named_with_a_suggestion() {
    let (code, covered, text) =
        problem("[stack]\nfilm = 20\nwith_mm = 3.0\n".replace("film = 20\n", "").as_str());
    assert_eq!((code, covered.as_str()), ("vitrine::config::unknown_key", "with_mm"));
    assert!(text.contains("did you mean `width_mm`?"), "{text}");
    let (code, covered, text) = problem("[desing]\nmethod = \"product\"\n");
    assert_eq!((code, covered.as_str()), ("vitrine::config::unknown_key", "desing"));
    assert!(text.contains("did you mean `design`?"), "{text}");
}

#[test]
fn wrong_values_are_shown_where_they_stand() {
    for (text, code, covered) in [
        ("[stack]\nfilms = 0", "vitrine::config::bad_value", "0"),
        ("[stack]\nfilms = 20.5", "vitrine::config::wrong_type", "20.5"),
        ("[stack]\nfilms = 99999999999999999999", "vitrine::config::wrong_type", "99999999999999999999"),
        ("[stack]\nwidth_mm = nan", "vitrine::config::bad_value", "nan"),
        ("[stack]\nwidth_mm = inf", "vitrine::config::bad_value", "inf"),
        ("[stack]\npixels = [512]", "vitrine::config::wrong_type", "[512]"),
        ("[stack]\npixels = 1000000", "vitrine::config::bad_value", "1000000"),
        ("[stack]\npixels = \"many\"", "vitrine::config::wrong_type", "\"many\""),
        ("[viewer]\ndistance_mm = \"near\"", "vitrine::config::wrong_type", "\"near\""),
        ("[viewer]\ndistance_mm = 2", "vitrine::config::bad_value", "2"),
        ("[design]\nmethod = \"least_squares\"", "vitrine::config::bad_value", "\"least_squares\""),
        ("[design]\nbrightness = 0.0", "vitrine::config::bad_value", "0.0"),
        ("[visitors]\npaging = \"page\"", "vitrine::config::bad_value", "\"page\""),
        ("[visitors]\npage_s = 0.5", "vitrine::config::bad_value", "0.5"),
        ("[visitors]\nstep_deg = 0", "vitrine::config::bad_value", "0"),
        ("[design]\npedestal = -0.1", "vitrine::config::bad_value", "-0.1"),
        ("[design]\nwhite_ratio = 0.5", "vitrine::config::bad_value", "0.5"),
        ("[design]\nstructure = 101", "vitrine::config::bad_value", "101"),
        ("[design]\nbalance = 1.5", "vitrine::config::bad_value", "1.5"),
        ("[design]\niterations = 0", "vitrine::config::bad_value", "0"),
        ("[design]\niterations = 2.5", "vitrine::config::wrong_type", "2.5"),
        ("[design]\ntolerance_db = 0", "vitrine::config::bad_value", "0"),
        ("[design]\nmemory_mib = 1", "vitrine::config::bad_value", "1"),
        ("[design]\nmemory_mib = \"much\"", "vitrine::config::wrong_type", "\"much\""),
        ("[calendar]\ntime_zone = \"Europe/Berlim\"", "vitrine::config::bad_value", "\"Europe/Berlim\""),
        ("[calendar]\nclosed = [\"2026-02-30\"]", "vitrine::config::bad_value", "\"2026-02-30\""),
        ("[[schedule]]\ndays = \"someday\"", "vitrine::config::bad_value", "\"someday\""),
        (
            "[[schedule]]\ndays = \"sun\"\nfirst = \"2026-06-01\"\nlast = \"2026-06-06\"",
            "vitrine::config::bad_value",
            "[[schedule]]",
        ),
        ("[[schedule]]\nfrom = \"25:00\"", "vitrine::config::bad_value", "\"25:00\""),
        ("[lamps]\ncalibration = [1]", "vitrine::config::wrong_type", "1"),
        ("[lamps]\nbelow_floor = \"fade\"", "vitrine::config::bad_value", "\"fade\""),
        ("[lamps]\nultraviolet_at_full_w_m2 = 0.2", "vitrine::config::wrong_type", "0.2"),
        ("[lamps]\nultraviolet_at_full_w_m2 = [0.2, 60]", "vitrine::config::bad_value", "[0.2, 60]"),
        ("[visitors]\npolicy = \"last\"", "vitrine::config::bad_value", "\"last\""),
        ("[visitors]\nfade_s = 0.1", "vitrine::config::bad_value", "0.1"),
        ("[presence]\nidle_level = 2", "vitrine::config::bad_value", "2"),
        ("[print]\npaper = \"A9\"", "vitrine::config::bad_value", "\"A9\""),
        ("stack = 3", "vitrine::config::wrong_type", "3"),
        ("[exhibit]\nname = \"\"", "vitrine::config::bad_value", "\"\""),
    ] {
        let found = problem(text);
        assert_eq!((found.0, found.1.as_str()), (code, covered), "{found:?}");
    }
}

#[test]
fn a_calibration_rises_from_nothing_to_full_level() {
    let exhibit = |points: &str| read(&format!("[lamps]\ncalibration = {points}\n{VIEW}"));
    assert_eq!(exhibit("[[0, 0], [0.5, 0.46], [0.9, 1]]").unwrap().lamps.calibration.len(), 3);
    for wrong in
        ["[[0, 0]]", "[[0, 0], [0, 1]]", "[[0.1, 0], [1, 1]]", "[[0, 0], [1, 0.9]]", "[[0, 0], [nan, 1]]"]
    {
        assert!(exhibit(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn absurd_volumes_are_refused_before_they_are_made() {
    let (code, _, text) = problem("[stack]\nfilms = 200\npixels = 65536");
    assert_eq!(code, "vitrine::config::bad_value");
    assert!(text.contains("voxels"), "{text}");
}

#[test]
fn views_are_checked() {
    let view = |lines: &str| problems(&format!("[[view]]\n{lines}"));
    let picture = "pattern = \"photos/coffee.jpg\"";
    let found = view(&format!("id = \"a\"\n{picture}\nhorizontal_deg = 95"));
    assert_eq!((found[0].0, found[0].1.as_str()), ("vitrine::config::bad_value", "95"));
    let found = view("id = \"a\"\npattern = \"photos/none.jpg\"");
    assert_eq!((found[0].0, found[0].1.as_str()), ("vitrine::config::bad_picture", "\"photos/none.jpg\""));
    for (line, code, covered) in [
        ("distance_mm = 3", "vitrine::config::bad_value", "3"),
        ("distance_mm = \"far\"", "vitrine::config::wrong_type", "\"far\""),
        ("mask = \"photos/none.png\"", "vitrine::config::bad_picture", "\"photos/none.png\""),
        ("mask = 1", "vitrine::config::wrong_type", "1"),
        ("lamp = \"side\"", "vitrine::config::bad_value", "\"side\""),
    ] {
        let found = view(&format!("id = \"a\"\n{picture}\n{line}"));
        assert_eq!((found[0].0, found[0].1.as_str()), (code, covered), "{found:?}");
    }
    for id in ["", "a b", "../up", "a/b", "-rf", "ümlaut", "a_very_long_name_of_25_chr"] {
        assert_eq!(view(&format!("id = \"{id}\"\n{picture}"))[0].0, "vitrine::config::bad_id", "{id}");
    }
    let found = problems(&format!("{VIEW}{}", VIEW.replace("front", "Front")));
    assert_eq!((found[0].0, found[0].1.as_str()), ("vitrine::config::duplicate_id", "\"Front\""));
    assert_eq!(view(picture)[0].0, "vitrine::config::missing_key");
    assert_eq!(problems("")[0].0, "vitrine::config::no_view");
    let many: String = (0..17)
        .map(|index| format!("{}horizontal_deg = {index}\n", VIEW.replace("front", &format!("v{index}"))))
        .collect();
    assert_eq!(problems(&many)[0].0, "vitrine::config::too_many_views");
}

#[test]
fn two_views_in_one_direction_need_a_lamp_each() {
    let text = |lamps: [&str; 3]| {
        let views = lamps.iter().enumerate().filter(|(_, lamp)| **lamp != "none");
        let views = views.map(|(index, lamp)| {
            let lamp = if lamp.is_empty() { String::new() } else { format!("lamp = \"{lamp}\"\n") };
            format!("{}{lamp}", VIEW.replace("front", &format!("v{index}")))
        });
        views.collect::<String>()
    };
    let pages = read(&text(["top", "bottom", "none"])).unwrap();
    assert_eq!(pages.views[1].lamp, Some(LampSetting::Bottom));
    for lamps in [["", "", "none"], ["top", "", "none"], ["top", "top", "none"], ["top", "bottom", "top"]] {
        let found = problems(&text(lamps));
        assert_eq!(found[0].0, "vitrine::config::same_direction", "{lamps:?}");
        assert!(found[0].2.contains("lamp = \"top\""), "{found:?}");
    }
    let ideal = problems(&format!("[design]\noptics = \"ideal\"\n{}", text(["top", "none", "none"])));
    assert_eq!((ideal[0].0, ideal[0].1.as_str()), ("vitrine::config::bad_value", "\"top\""));
}

#[test]
fn a_view_has_the_viewers_distance_unless_it_has_its_own() {
    let exhibit = |own: &str| read(&format!("[viewer]\ndistance_mm = 600\n{VIEW}{own}\n")).unwrap();
    assert_eq!(exhibit("").views[0].distance_mm, Some(600.0));
    assert_eq!(exhibit("distance_mm = 900").views[0].distance_mm, Some(900.0));
    assert_eq!(exhibit("distance_mm = \"parallel\"").views[0].distance_mm, None);
}

#[test]
fn all_problems_are_reported_at_once_in_the_order_of_the_file() {
    let found = problems("[stack]\nfilms = -1\ncolour = 3\n[[view]]\nid = \"a\"\nhorizontal_deg = 95\n");
    let codes: Vec<_> = found.iter().map(|problem| problem.0).collect();
    assert_eq!(
        codes,
        [
            "vitrine::config::bad_value",
            "vitrine::config::unknown_key",
            "vitrine::config::missing_key",
            "vitrine::config::bad_value"
        ]
    );
}

#[test]
fn broken_syntax_is_an_error_with_its_place() {
    let found = problems("[stack\nfilms = 20\n");
    assert_eq!(found[0].0, "vitrine::config::syntax");
}

#[test]
fn the_resolved_exhibit_survives_json() {
    let exhibit = read(VIEW).unwrap();
    let json = serde_json::to_string(&exhibit).unwrap();
    assert_eq!(serde_json::from_str::<Exhibit>(&json).unwrap(), exhibit);
}

#[test]
fn materials_give_what_is_left_out_and_numbers_go_before_them() {
    let stack = |lines: &str| read(&format!("[stack]\n{lines}{VIEW}")).unwrap().stack;
    let plain = stack("");
    assert_eq!((plain.index, plain.tau_uv, plain.tau_visible, plain.spacer_tau_uv), (1.0, 0.82, 0.90, 1.0));
    let bonded = stack("spacer = \"bonded-acrylic\"\ntau_uv = 0.5\n");
    assert_eq!((bonded.index, bonded.tau_uv), (1.49, 0.5));
    assert!(bonded.tau_visible > 0.99 && bonded.spacer_tau_visible > 0.999, "{bonded:?}");
    assert_eq!(stack("film = \"pdms\"\n").tau_visible, 0.99);
}

#[test]
fn ink_keys_are_held_to_what_can_be_printed() {
    let print = |lines: &str| read(&format!("[print]\n{lines}{VIEW}")).map(|exhibit| exhibit.print.ink);
    assert_eq!(print("").unwrap().yields, crate::ink::YIELDS);
    assert_eq!(print("ink_limit = 2.5\n").unwrap().ink_limit, 2.5);
    let (code, covered, told) = problem("[print]\nhalftone = \"blue-noise\"\nink_limit = 2.5\n");
    assert_eq!((code, covered.as_str()), ("vitrine::config::bad_value", "2.5"));
    assert!(told.contains("side by side"), "{told}");
    assert_eq!(problem("[print]\nyields = [0.4, 0.8]\n").0, "vitrine::config::wrong_type");
    assert_eq!(problem("[print]\nquench = [0, 0, -1]\n").0, "vitrine::config::bad_value");
    assert!(problem("[print]\ngamut = \"clap\"\n").2.contains("did you mean \"clip\"?"));
    let halftone = print("halftone = \"blue-noise\"\ndot_levels = 4\n").unwrap();
    let inks = halftone.inks().unwrap();
    assert_eq!(inks.dots, crate::ink::Dots::Levels(4));
    let (code, covered, _) = problem("[print]\ncurves = \"none.toml\"\n");
    assert_eq!((code, covered.as_str()), ("vitrine::ink::unreadable_curves", "\"none.toml\""));
    assert_eq!(problem("[print]\ncurves = \"Cargo.toml\"\n").0, "vitrine::ink::bad_curves");
}

#[test]
fn an_object_needs_no_view_and_is_shown_from_three_sides() {
    let exhibit = read("[object]\nmodel = \"Cargo.toml\"\n").unwrap();
    assert_eq!(exhibit.views.iter().map(|view| view.horizontal_deg).collect::<Vec<_>>(), [-30.0, 0.0, 30.0]);
    assert!(exhibit.is_object_alone());
    let defaults = ObjectSettings { model: "Cargo.toml".into(), ..ObjectSettings::default() };
    assert_eq!(exhibit.object, Some(defaults));
    let both = read(&format!(
        "[object]\nmodel = \"Cargo.toml\"\n{VIEW}[[view]]\nid = \"side\"\nhorizontal_deg = 40\n"
    ));
    let both = both.unwrap();
    assert!(!both.is_object_alone());
    assert_eq!(both.views[1].pattern, None);
}

#[test]
fn the_starters_object_is_the_default_once_uncommented() {
    let text: String = crate::starter::EXHIBIT_TOML
        .lines()
        .skip_while(|line| !line.starts_with("# [object]"))
        .take_while(|line| line.starts_with("# "))
        .map(|line| format!("{}\n", &line[2..]))
        .collect();
    let exhibit = read(&text.replace("flowers.ply", "Cargo.toml")).unwrap();
    let defaults = ObjectSettings { model: "Cargo.toml".into(), ..ObjectSettings::default() };
    assert_eq!(exhibit.object, Some(defaults));
    let text = "[object]\nmodel = \"Cargo.toml\"\nunit_mm = 10\nturn_deg = [-90, 0, 12.5]\ncentre = \"origin\"\n\
        colour = \"#ff8000\"\nfilled = true\nhidden = \"remove\"\ndepth_dither = true\npoint_mm = 0.5\n";
    let object = read(text).unwrap().object.unwrap();
    assert_eq!(
        (object.unit_mm, object.turn_deg, object.colour),
        (Some(10.0), [-90.0, 0.0, 12.5], Some([255, 128, 0]))
    );
    assert_eq!((object.centre, object.hidden), (CentreSetting::Origin, HiddenSetting::Remove));
    assert!(object.filled && object.depth_dither && object.point_mm == 0.5);
}

#[test]
fn a_wrong_object_is_told_with_its_place() {
    let object = |line: &str| {
        let found = problems(&format!("[object]\nmodel = \"Cargo.toml\"\n{line}\n"));
        assert_eq!(found.len(), 1, "{line}: {found:?}");
        (found[0].0, found[0].1.clone())
    };
    for (line, code, covered) in [
        ("unit_mm = 0", "bad_value", "0"),
        ("unit_mm = \"cm\"", "wrong_type", "\"cm\""),
        ("turn_deg = [1, 2]", "wrong_type", "[1, 2]"),
        ("turn_deg = [1, 2, 700]", "bad_value", "[1, 2, 700]"),
        ("centre = \"top\"", "bad_value", "\"top\""),
        ("colour = \"#ff80\"", "bad_value", "\"#ff80\""),
        ("colour = \"#+f8000\"", "bad_value", "\"#+f8000\""),
        ("points = 3", "unknown_key", "points"),
        ("[design]\nadapt = true", "contradiction", "true"),
    ] {
        let (found, place) = object(line);
        assert_eq!((found, place.as_str()), (format!("vitrine::config::{code}").as_str(), covered), "{line}");
    }
    assert_eq!(problems("[object]\nmodel = \"none.ply\"\n")[0].0, "vitrine::config::bad_model");
    assert_eq!(problems("[object]\n")[0].0, "vitrine::config::missing_key");
}
