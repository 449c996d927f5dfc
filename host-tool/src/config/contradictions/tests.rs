use std::fmt::Write as _;
use std::sync::LazyLock;

use miette::Diagnostic;
use proptest::prelude::*;
use vitrine_exhibit::plan::ValidPlan;
use vitrine_protocol::plan_file;

use crate::config::{ConfigError, Exhibit, PlanPairs, parse};
use crate::optics::LampPair;

const VIEW: &str = "[[view]]\nid = \"front\"\npattern = \"photos/cat.png\"\n";

/// A folder with a picture that is quickly read.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("photos")).expect("a folder in it");
    image::RgbImage::new(8, 8).save(folder.path().join("photos/cat.png")).expect("a picture");
    folder
});

fn read(text: &str) -> Result<Exhibit, ConfigError> {
    parse(&FOLDER.path().join("exhibit.toml"), &format!("{text}\n{VIEW}"))
}

/// The lines that problems stand on, from 1, with their texts.
fn problems(text: &str) -> Vec<(usize, String)> {
    let Err(error) = read(text) else { return Vec::new() };
    let ConfigError::Invalid { problems, .. } = &error else { panic!("{error}") };
    let line = |offset: usize| 1 + text.as_bytes().iter().take(offset).filter(|byte| **byte == b'\n').count();
    let place = |problem: &dyn Diagnostic| problem.labels().unwrap().next().unwrap().offset();
    problems
        .iter()
        .map(|problem| {
            (
                line(place(problem)),
                format!("{}: {problem}; {}", problem.code().unwrap(), problem.help().unwrap()),
            )
        })
        .collect()
}

/// The contradiction of `text` stands on this line and says this.
#[track_caller]
fn contradicts(text: &str, line: usize, said: &str) {
    let found = problems(text);
    assert_eq!(found.len(), 1, "{text}: {found:?}");
    assert_eq!(found[0].0, line, "{text}: {found:?}");
    assert!(found[0].1.starts_with("vitrine::config::contradiction"), "{found:?}");
    assert!(found[0].1.contains(said), "{text}: {found:?}");
}

#[track_caller]
fn agrees(text: &str) {
    let found = problems(text);
    assert!(found.is_empty(), "{text}: {found:?}");
}

#[test]
fn inks_that_are_balanced_by_the_design_and_on_the_sheets_are_refused() {
    let text = "[stack]\nink_yields = [0.43, 0.85, 0.89]\n";
    contradicts(text, 2, "the inks are balanced twice");
    agrees(&format!("{text}[print]\nyields = [1.0, 1.0, 1.0]\n"));
    agrees("[stack]\nink_yields = [0.5, 0.5, 0.5]\n");
}

#[test]
fn a_schedule_that_never_lights_is_refused() {
    contradicts("[[schedule]]\nlevel = 0.0", 1, "never lights");
    contradicts(
        "[[schedule]]\nfirst = \"2026-12-24\"\nlast = \"2026-12-25\"\n\
         [calendar]\nclosed = [\"2026-12-24\", \"2026-12-25\"]",
        1,
        "never lights",
    );
}

#[test]
fn a_rule_that_never_begins_or_never_decides_is_refused() {
    let ordinary = "[[schedule]]\ndays = \"tue-sun\"\nfrom = \"10:00\"\nto = \"18:00\"\n";
    contradicts(
        &format!(
            "{ordinary}[[schedule]]\nfirst = \"2026-12-24\"\nlast = \"2026-12-24\"\nlevel = 0.5\n\
                  [calendar]\nclosed = [\"2026-12-24\"]"
        ),
        5,
        "never begins",
    );
    contradicts(
        &format!("[[schedule]]\nfrom = \"12:00\"\nto = \"13:00\"\nlevel = 0.5\n{ordinary}days = \"daily\"")
            .replace("days = \"tue-sun\"\n", ""),
        1,
        "never decides",
    );
    contradicts(&format!("{ordinary}{ordinary}"), 1, "never decides");
    agrees(&format!(
        "{ordinary}[[schedule]]\ndays = \"tue-sun\"\nfrom = \"12:00\"\nto = \"13:00\"\nlevel = 0.5"
    ));
    // Of three, the second is an exception that the third takes back in part.
    agrees(&format!(
        "{ordinary}[[schedule]]\ndays = \"tue-sun\"\nfrom = \"12:00\"\nto = \"14:00\"\nlevel = 0.5\n\
         [[schedule]]\ndays = \"sun\"\nfrom = \"13:00\"\nto = \"14:00\"\nlevel = 0.7"
    ));
}

#[test]
fn a_dark_rule_must_darken_something() {
    let ordinary = "[[schedule]]\nfrom = \"10:00\"\nto = \"18:00\"\n";
    contradicts(
        &format!("{ordinary}[[schedule]]\nfrom = \"20:00\"\nto = \"22:00\"\nlevel = 0"),
        4,
        "level 0",
    );
    agrees(&format!("{ordinary}[[schedule]]\nfrom = \"12:00\"\nto = \"13:00\"\nlevel = 0"));
    // Over midnight into another rule's morning.
    agrees(&format!("{ordinary}[[schedule]]\ndays = \"sat\"\nfrom = \"22:00\"\nto = \"11:00\"\nlevel = 0"));
}

#[test]
fn rules_that_overlap_by_halves_with_different_levels_are_refused() {
    let two = |second: &str| {
        format!("[[schedule]]\ndays = \"mon-fri\"\nfrom = \"10:00\"\nto = \"18:00\"\n[[schedule]]\n{second}")
    };
    contradicts(&two("days = \"mon-fri\"\nfrom = \"16:00\"\nto = \"20:00\"\nlevel = 0.5"), 5, "overlap");
    contradicts(&two("days = \"fri-sat\"\nfrom = \"16:00\"\nto = \"20:00\"\nlevel = 0.5"), 5, "overlap");
    agrees(&two("days = \"mon-fri\"\nfrom = \"18:00\"\nto = \"20:00\"\nlevel = 0.5"));
    agrees(&two("days = \"mon-fri\"\nfrom = \"16:00\"\nto = \"20:00\""));
    agrees(&two("days = \"thu\"\nfrom = \"16:00\"\nto = \"20:00\"\nlevel = 0.5"));
    agrees(&two("from = \"16:00\"\nto = \"20:00\"\nfirst = \"2026-12-01\"\nlevel = 0.5"));
}

#[test]
fn a_rule_within_the_hour_left_out_in_spring_is_refused() {
    let rule = |from: &str, to: &str, zone: &str| {
        format!(
            "[calendar]\ntime_zone = \"{zone}\"\n[[schedule]]\n[[schedule]]\nfrom = \"{from}\"\nto = \"{to}\"\n\
                 first = \"2026-03-29\"\nlast = \"2026-03-29\"\nlevel = 0.5"
        )
    };
    contradicts(&rule("02:00", "03:00", "Europe/Berlin"), 4, "clocks go forward");
    agrees(&rule("02:00", "03:01", "Europe/Berlin"));
    agrees(&rule("01:59", "03:00", "Europe/Berlin"));
    agrees(&rule("02:00", "03:00", "UTC"));
}

#[test]
fn closed_days_without_a_rule_around_them_are_refused() {
    let summer = "[[schedule]]\nfirst = \"2026-06-01\"\nlast = \"2026-08-31\"\n[calendar]\n";
    contradicts(&format!("{summer}closed = [\n  \"2026-07-14\",\n  \"2027-07-14\",\n]"), 7, "2027-07-14");
    agrees(&format!("{summer}closed = [\"2026-07-14\", \"2026-08-31\"]"));
}

#[test]
fn times_and_dates_that_cannot_be_are_refused() {
    for (text, line) in [
        ("[[schedule]]\nfrom = \"10:00\"\nto = \"10:00\"", 3),
        ("[[schedule]]\nfrom = \"24:00\"", 2),
        ("[[schedule]]\nfirst = \"2026-05-02\"\nlast = \"2026-05-01\"", 1),
        ("[[schedule]]\ndays = []", 2),
        ("[[schedule]]\ndays = \"sun\"\nfirst = \"2026-05-04\"\nlast = \"2026-05-09\"", 1),
        ("[[schedule]]\nlevel = 1.5", 2),
        ("[calendar]\ntime_zone = \"Europe/Atlantis\"", 2),
        ("[calendar]\nclosed = [\"2026-02-29\"]", 2),
    ] {
        let found = problems(text);
        assert_eq!(found.iter().map(|problem| problem.0).collect::<Vec<_>>(), [line], "{text}: {found:?}");
    }
}

#[test]
fn levels_below_the_drivers_floor_are_refused_where_it_is_cut() {
    let rule = |level: &str, floor: &str| {
        format!("[lamps]\nbelow_floor = \"{floor}\"\n[[schedule]]\nlevel = {level}")
    };
    contradicts(&rule("0.009", "cut"), 4, "floor");
    agrees(&rule("0.0101", "cut"));
    agrees(&rule("0.009", "dither"));
    contradicts(&rule("0.00001", "dither"), 4, "floor");
}

#[test]
fn times_at_a_stretch_rests_and_openings_go_together() {
    contradicts("[limits]\ncontinuous_s = 1.2", 1, "least_hold_s");
    contradicts("[visitors]\nfade_s = 20\n[limits]\ncontinuous_s = 15", 2, "fade_s");
    let opening =
        |rest_s: u32| format!("[[schedule]]\nfrom = \"10:00\"\nto = \"11:00\"\n[limits]\nrest_s = {rest_s}");
    contradicts(&opening(3_600), 5, "rest");
    agrees(&opening(3_599));
    agrees("[limits]\nrest_s = 80000");
}

#[test]
fn doses_last_for_what_is_planned() {
    contradicts("[limits]\ndaily_dose_j_m2 = 5000", 1, "lit at a stretch");
    agrees("[limits]\ndaily_dose_j_m2 = 6000");
    let expected = |hours: &str, ceiling: &str| {
        format!(
            "[presence]\nexpected_h_a_day = {hours}\n[lamps]\nceiling_w_m2 = {ceiling}\n\
                 [[schedule]]\nfrom = \"10:00\"\nto = \"14:00\""
        )
    };
    contradicts(&expected("1", "10"), 2, "the dose lasts for 0.92 h");
    agrees(&expected("0.9", "10"));
    agrees(&expected("4", "2"));
    contradicts(&expected("4.5", "1"), 2, "open for 4 h at most");
    agrees(&expected("\"unknown\"", "10"));
}

#[test]
fn views_that_are_never_chosen_are_refused() {
    let other = |degrees: &str| {
        format!("[[view]]\nid = \"other\"\npattern = \"photos/cat.png\"\nhorizontal_deg = {degrees}")
    };
    let found = problems(&other("3"));
    assert!(found.len() == 1 && found[0].1.contains("hysteresis"), "{found:?}");
    agrees(&other("4.5"));
    let sides = format!("{}\n{}", other("-4.5"), other("4.5").replace("other", "another"));
    let found = problems(&sides);
    assert!(found.len() == 1 && found[0].1.contains("dead zone"), "{found:?}");
}

/// A file of one or more views with any schedule, calendar, limits, lamps and visitors, most of them within bounds.
fn any_exhibit() -> impl Strategy<Value = String> {
    let date =
        || (2025_i32..2030, 1_u8..=12, 1_u8..=28).prop_map(|(y, m, d)| format!("\"{y}-{m:02}-{d:02}\""));
    let time = || (0_u16..=1440).prop_map(|minute| format!("\"{:02}:{:02}\"", minute / 60, minute % 60));
    let part = || prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0_f64];
    let days = prop::sample::select(vec!["daily", "mon-fri", "sat", "tue-sun", "sun", "fri-mon"]);
    let rule = (days, time(), time(), prop::option::of(date()), prop::option::of(date()), part()).prop_map(
        |(days, from, to, first, last, level)| {
            let mut text =
                format!("[[schedule]]\ndays = \"{days}\"\nfrom = {from}\nto = {to}\nlevel = {level}\n");
            first.iter().for_each(|first| writeln!(text, "first = {first}").unwrap());
            last.iter().for_each(|last| writeln!(text, "last = {last}").unwrap());
            text
        },
    );
    let zone = prop::sample::select(vec![
        "UTC",
        "Europe/Berlin",
        "America/New_York",
        "Pacific/Auckland",
        "Asia/Kolkata",
    ]);
    let calendar = (zone, prop::collection::vec(date(), 0..70)).prop_map(|(zone, closed)| {
        format!("[calendar]\ntime_zone = \"{zone}\"\nclosed = [{}]\n", closed.join(", "))
    });
    let limits = (1.0..40_000.0_f64, 1.0..1.1e7_f64, 0.5..700.0_f64, 30.0..90_000.0_f64).prop_map(
        |(day, life, continuous, rest)| {
            format!("[limits]\ndaily_dose_j_m2 = {day:.6}\nlife_dose_j_m2 = {life:.6}\ncontinuous_s = {continuous:.6}\nrest_s = {rest:.6}\n")
        },
    );
    let lamps = (0.01..55.0_f64, 0.01..22.0_f64, prop::option::of((0.0005..60.0_f64, 0.0005..60.0_f64)), any::<bool>(), 0.0002..0.9999_f64)
        .prop_map(|(full, ceiling, ultraviolet, dither, middle)| {
            let floor = if dither { "dither" } else { "cut" };
            let mut text = format!("[lamps]\nirradiance_w_m2 = {full:.6}\nceiling_w_m2 = {ceiling:.6}\nbelow_floor = \"{floor}\"\ncalibration = [[0, 0], [{middle:.6}, {middle:.6}], [1, 1]]\n");
            if let Some((top, bottom)) = ultraviolet {
                writeln!(text, "ultraviolet_at_full_w_m2 = [{top:.6}, {bottom:.6}]").unwrap();
            }
            text
        });
    let visitors = (0.0..21.0_f64, 0.0..11.0_f64, 0.25..70.0_f64, 0.9..4000.0_f64).prop_map(|(angle, dwell, fade, turn)| {
        format!("[visitors]\npolicy = \"alternating\"\nhysteresis_deg = {angle:.6}\ndwell_s = {dwell:.6}\nfade_s = {fade:.6}\nturn_s = {turn:.6}\n")
    });
    let presence = (0.0..90_000.0_f64, 0.25..70.0_f64, part(), prop::option::of(0.0..24.0_f64)).prop_map(|(idle, fade, level, hours)| {
        let hours = hours.map_or("\"unknown\"".to_owned(), |hours| format!("{hours:.6}"));
        format!("[presence]\nidle_s = {idle:.6}\nfade_s = {fade:.6}\nidle_level = {level:.6}\nexpected_h_a_day = {hours}\n")
    });
    let views = prop::collection::vec((-82.0..82.0_f64, -82.0..82.0_f64), 0..15).prop_map(|views| {
        let view = |(index, (h, v)): (usize, &(f64, f64))| {
            format!("[[view]]\nid = \"v{index}\"\npattern = \"photos/cat.png\"\nhorizontal_deg = {h:.6}\nvertical_deg = {v:.6}\n")
        };
        views.iter().enumerate().map(view).collect::<String>()
    });
    let tables = prop::sample::subsequence((0..7).collect::<Vec<usize>>(), 0..=4);
    (prop::collection::vec(rule, 0..4), calendar, limits, lamps, visitors, presence, views, tables).prop_map(
        |(rules, calendar, limits, lamps, visitors, presence, views, tables)| {
            let all = [rules.concat(), calendar, limits, lamps, visitors, presence, views];
            tables.into_iter().map(|table| all[table].as_str()).collect::<String>()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    /// What check accepts the controller accepts, and it fits into its flash.
    #[test]
    fn what_is_accepted_here_is_accepted_by_the_controller(text in any_exhibit()) {
        if let Ok(exhibit) = read(&text) {
            let views = exhibit.views.len();
            let pairs = PlanPairs {
                views: vec![LampPair::new(1.0, 0.3); views],
                neutral: LampPair::new(0.4, 0.4),
                shared: vec![LampPair::new(0.7, 1.0); views * (views - 1) / 2],
            };
            let plan = exhibit.plan(&pairs, [7; 32]).expect("a known zone");
            let valid = ValidPlan::new(plan.clone());
            prop_assert!(valid.is_ok(), "{:?} of\n{text}", valid.err());
            let mut bytes = [0; plan_file::MAX_PLAN_BYTES];
            prop_assert!(plan_file::encode(&plan, &mut bytes).is_some(), "too long a plan of\n{text}");
        }
    }
}
