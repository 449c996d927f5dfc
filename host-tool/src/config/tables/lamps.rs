//! `[lamps]` and `[limits]`: their keys, defaults and bounds.

use vitrine_exhibit::limits;
use vitrine_exhibit::plan::MAX_CURVE;
use vitrine_exhibit::units::{Dose, Irradiance, Milliseconds};

use super::bounds;
use crate::config::exhibit::{BelowFloorSetting, LampSettings, LimitSettings};
use crate::config::problem::Problems;
use crate::config::reader::{TableReader, as_number};

/// `[lamps]`.
pub(in crate::config) fn lamps(mut reader: TableReader<'_>, problems: &mut Problems) -> LampSettings {
    let (hardware, firmware) = (watts(limits::HARDWARE_CEILING), watts(limits::CEILING));
    let irradiance = bounds(0.01, hardware, "the sense resistors hold a lamp to 50 W/m2");
    let ceiling = bounds(0.01, firmware, "the firmware cuts above 20 W/m2");
    let below_floor = reader
        .choice("below_floor", &[("cut", BelowFloorSetting::Cut), ("dither", BelowFloorSetting::Dither)]);
    let settings = LampSettings {
        irradiance_w_m2: reader.number("irradiance_w_m2", 10.0, irradiance),
        ceiling_w_m2: reader.number("ceiling_w_m2", 10.0, ceiling),
        calibration: calibration(&mut reader),
        below_floor: below_floor.unwrap_or(BelowFloorSetting::Cut),
        ultraviolet_at_full_w_m2: ultraviolet_at_full(&mut reader),
    };
    reader.finish(problems);
    settings
}

/// `ultraviolet_at_full_w_m2 = [top, bottom]`, or `"not measured"`.
fn ultraviolet_at_full(reader: &mut TableReader<'_>) -> Option<[f64; 2]> {
    const KEY: &str = "ultraviolet_at_full_w_m2";
    const WANTED: &str = "what the sensor reads under each lamp alone, [top, bottom], or \"not measured\"";
    let value = reader.raw(KEY)?;
    if value.get_ref().as_str() == Some("not measured") {
        return None;
    }
    let readings: Option<Vec<f64>> = value
        .get_ref()
        .as_array()
        .and_then(|pair| pair.iter().map(|reading| as_number(reading.get_ref())).collect());
    let Some(Ok(pair)) = readings.map(<[f64; 2]>::try_from) else {
        reader.report_type(KEY, value, WANTED);
        return None;
    };
    // The plan keeps mW/m2, and a reading of nothing cannot be held against a lamp.
    let range =
        bounds(0.001, watts(limits::HARDWARE_CEILING), "read it at commissioning, one lamp at a time");
    let checked = pair.map(|reading| reader.check_number(KEY, reading, value.span(), range));
    checked.iter().all(Option::is_some).then_some(pair)
}

fn watts(irradiance: Irradiance) -> f64 {
    f64::from(irradiance.0) / 1000.0
}

fn joules(dose: Dose) -> f64 {
    dose.0 as f64 / 1e6
}

fn seconds(time: Milliseconds) -> f64 {
    f64::from(time.0) / 1000.0
}

/// `calibration = [[duty, level], ...]`, rising in both from nothing to full level.
fn calibration(reader: &mut TableReader<'_>) -> Vec<[f64; 2]> {
    const WANTED: &str = "pairs of duty and level: [[0.0, 0.0], [0.5, 0.46], [1.0, 1.0]]";
    let Some(items) = reader.array("calibration", WANTED) else { return Vec::new() };
    let mut points: Vec<[f64; 2]> = Vec::new();
    for item in items {
        let pair: Option<Vec<f64>> = item
            .get_ref()
            .as_array()
            .and_then(|pair| pair.iter().map(|value| as_number(value.get_ref())).collect());
        let Some(Ok(pair)) = pair.map(<[f64; 2]>::try_from) else {
            reader.report_type("calibration", item, WANTED);
            return Vec::new();
        };
        points.push(pair);
    }
    let from_nothing = points.first().is_none_or(|first| *first == [0.0, 0.0]);
    let to_full_level = points.last().is_none_or(|last| last[1] == 1.0 && last[0] <= 1.0);
    // A level is kept in 16 bits: nearer points would fall together.
    let rising = points.windows(2).all(|pair| (0..2).all(|axis| pair[1][axis] - pair[0][axis] > 1e-4));
    if points.len() == 1 || points.len() > MAX_CURVE || !(from_nothing && to_full_level && rising) {
        let message = "`calibration` in [lamps] does not rise from [0, 0] to level 1".to_owned();
        reader.report_value(reader.span(), message, format!("give 2 to {MAX_CURVE} {WANTED}"));
        return Vec::new();
    }
    points
}

/// `[limits]`: never more than the firmware's own.
pub(in crate::config) fn limits(mut reader: TableReader<'_>, problems: &mut Problems) -> LimitSettings {
    const KINDER: &str = "the firmware's own limit is the most; a plan may only ask for less";
    let (day, life) = (joules(limits::DAILY_DOSE), joules(limits::LIFE_DOSE));
    let (continuous, rest) = (seconds(limits::CONTINUOUS), seconds(limits::REST));
    let settings = LimitSettings {
        daily_dose_j_m2: reader.number("daily_dose_j_m2", day, bounds(1.0, day, KINDER)),
        life_dose_j_m2: reader.number("life_dose_j_m2", life, bounds(1.0, life, KINDER)),
        continuous_s: reader.number("continuous_s", continuous, bounds(1.0, continuous, KINDER)),
        rest_s: reader.number("rest_s", rest, bounds(rest, 86_400.0, "LEDs live longer with rests")),
    };
    if settings.daily_dose_j_m2 > settings.life_dose_j_m2 {
        let message = "the dose of a day is more than the dose of the stack's life".to_owned();
        reader.report_value(reader.span(), message, "lower `daily_dose_j_m2` or raise `life_dose_j_m2`");
    }
    reader.finish(problems);
    settings
}
