//! `[visitors]` and `[presence]`: how viewers are followed, and what happens when nobody is there.

use vitrine_exhibit::limits;
use vitrine_exhibit::plan;
use vitrine_exhibit::units::{CentiDegrees, Milliseconds};

use super::exhibit::{
    BetweenSetting, PagingSetting, PolicySetting, PresenceSettings, SensorSetting, VisitorSettings,
};
use super::problem::Problems;
use super::reader::{Bounds, TableReader, as_number};

const ANGLE: Bounds = Bounds { least: 0.0, most: 20.0, reason: "views stand 20 degrees apart and more" };
const FADE: Bounds = Bounds {
    least: limits::FASTEST_FADE.0 as f64 / 1000.0,
    most: 60.0,
    reason: "faster changes flash, which some people must not see",
};

const fn time(least: f64, most: f64) -> Bounds {
    Bounds { least, most, reason: "" }
}

/// `[visitors]`.
pub(super) fn visitors(mut reader: TableReader<'_>, problems: &mut Problems) -> VisitorSettings {
    let defaults = plan::ViewerSettings::default();
    let sensor = reader.choice(
        "sensor",
        &[
            ("either", SensorSetting::Either),
            ("thermal", SensorSetting::Thermal),
            ("radar", SensorSetting::Radar),
        ],
    );
    let policy = reader.choice(
        "policy",
        &[
            ("first", PolicySetting::First),
            ("nearest", PolicySetting::Nearest),
            ("shared", PolicySetting::Shared),
            ("alternating", PolicySetting::Alternating),
        ],
    );
    let between =
        reader.choice("between", &[("nearest", BetweenSetting::Nearest), ("smooth", BetweenSetting::Smooth)]);
    let paging = reader.choice("paging", &[("time", PagingSetting::Time), ("step", PagingSetting::Step)]);
    let settings = VisitorSettings {
        sensor: sensor.unwrap_or(SensorSetting::Either),
        policy: policy.unwrap_or(PolicySetting::First),
        between: between.unwrap_or(BetweenSetting::Nearest),
        hysteresis_deg: reader.number("hysteresis_deg", degrees(defaults.hysteresis), ANGLE),
        dwell_s: reader.number("dwell_s", seconds(defaults.dwell), time(0.0, 10.0)),
        least_hold_s: reader.number("least_hold_s", seconds(defaults.least_hold), time(0.0, 60.0)),
        dead_zone_deg: reader.number("dead_zone_deg", degrees(defaults.dead_zone), ANGLE),
        turn_s: reader.number("turn_s", seconds(defaults.turn), time(1.0, 3600.0)),
        paging: paging.unwrap_or(PagingSetting::Time),
        page_s: reader.number("page_s", seconds(defaults.page), time(1.0, 3600.0)),
        step_deg: reader.number(
            "step_deg",
            degrees(defaults.step),
            Bounds {
                least: 1.0,
                most: 20.0,
                reason: "bearings waver by a degree or two, and a step at 1.5 m is about 15 degrees",
            },
        ),
        fade_s: reader.number("fade_s", seconds(defaults.fade), FADE),
    };
    reader.finish(problems);
    settings
}

/// `[presence]`.
pub(super) fn presence(mut reader: TableReader<'_>, problems: &mut Problems) -> PresenceSettings {
    let defaults = plan::PresenceSettings::default();
    let part = Bounds { least: 0.0, most: 1.0, reason: "it is a part of the neutral pair" };
    let idle_level = (f64::from(defaults.idle_level.0) / f64::from(u16::MAX) * 1000.0).round() / 1000.0;
    let settings = PresenceSettings {
        hold_s: reader.number("hold_s", seconds(defaults.hold), time(0.0, 86_400.0)),
        idle_s: reader.number("idle_s", seconds(defaults.idle), time(0.0, 86_400.0)),
        fade_s: reader.number("fade_s", seconds(defaults.fade), FADE),
        idle_level: reader.number("idle_level", idle_level, part),
        expected_h_a_day: expected_h_a_day(&mut reader),
    };
    reader.finish(problems);
    settings
}

/// `expected_h_a_day = 2.5` or `"unknown"`.
fn expected_h_a_day(reader: &mut TableReader<'_>) -> Option<f64> {
    const KEY: &str = "expected_h_a_day";
    let value = reader.raw(KEY)?;
    if value.get_ref().as_str() == Some("unknown") {
        return None;
    }
    let Some(hours) = as_number(value.get_ref()) else {
        reader.report_type(KEY, value, "a number of hours, or \"unknown\"");
        return None;
    };
    let day = Bounds { least: 0.0, most: 24.0, reason: "hours with somebody before the exhibit" };
    reader.check_number(KEY, hours, value.span(), day).map(|placed| placed.value)
}

fn seconds(time: Milliseconds) -> f64 {
    f64::from(time.0) / 1000.0
}

fn degrees(angle: CentiDegrees) -> f64 {
    f64::from(angle.0) / 100.0
}
