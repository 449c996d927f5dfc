//! What happens in a scenario.

use serde::Deserialize;
use vitrine_exhibit::inputs::{Contact, Request, TemperatureReading};
use vitrine_exhibit::plan::ValidPlan;
use vitrine_exhibit::units::{CentiCelsius, Irradiance, Milliseconds, Millivolts, UtcSeconds};
use vitrine_exhibit::viewer::{RadarFrame, RadarTarget};

use crate::bench::{Bench, EyeHealth, standard_plan};

/// Something that happens at a moment; what is left out stays.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// When.
    pub at_s: f64,
    loop_a: Option<Position>,
    loop_b: Option<Position>,
    top_board: Option<Board>,
    bottom_board: Option<Board>,
    enclosure_c: Option<f64>,
    /// 0 for a supply that is not measured.
    supply_v: Option<f64>,
    ultraviolet_percent: Option<u32>,
    /// The ultraviolet sensor says nothing any more.
    ultraviolet_silent: Option<bool>,
    stray_w_m2: Option<f64>,
    /// A moment in UTC, or "none".
    clock: Option<String>,
    /// A host sets the clock to this moment.
    set_clock: Option<String>,
    /// "none" or "standard".
    plan: Option<String>,
    left_eye: Option<EyeHealth>,
    right_eye: Option<EyeHealth>,
    /// Targets' x and y in mm; an empty list is an empty report.
    radar: Option<Vec<(i16, i16)>>,
    /// A radar is fitted that sees the room.
    radar_sees_room: Option<bool>,
    flash_works: Option<bool>,
    staff_key: Option<bool>,
    /// The flash's owner asks the lamps to stand still, so that it may erase.
    stand_still: Option<bool>,
    /// Such as "rearm", "release", "new-stack", "dark 10", "open 10", "hold 2 10": view and lease in seconds.
    request: Option<String>,
    /// "power" or "fault".
    restart: Option<String>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Position {
    Open,
    Closed,
}

/// A temperature in °C, or "open", "shorted" or "silent".
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum Board {
    Celsius(f64),
    Fault(String),
}

impl Change {
    /// Makes it happen.
    ///
    /// # Errors
    /// A value that is not understood.
    pub fn apply(&self, bench: &mut Bench) -> Result<(), String> {
        self.apply_interlock(bench);
        self.apply_readings(bench)?;
        self.apply_viewer_sensors(bench);
        if let Some(clock) = &self.clock {
            bench.clock = read_clock(clock, bench.time_s())?;
        }
        if let Some(clock) = &self.set_clock {
            let clock = read_clock(clock, bench.time_s())?.ok_or("a host sets no invalid clock")?;
            bench.set_clock(clock);
        }
        match self.plan.as_deref() {
            None => {}
            Some("none") => bench.plan = None,
            Some("standard") => {
                bench.plan = Some(ValidPlan::new(standard_plan()).map_err(|error| error.to_string())?);
            }
            Some(other) => return Err(format!("no such plan: {other}")),
        }
        bench.flash_works = self.flash_works.unwrap_or(bench.flash_works);
        bench.staff_key = self.staff_key.unwrap_or(bench.staff_key);
        bench.stand_still = self.stand_still.unwrap_or(bench.stand_still);
        if let Some(request) = &self.request {
            bench.requests.push(read_request(request)?);
        }
        match self.restart.as_deref() {
            None => {}
            Some("power") => bench.restart(false),
            Some("fault") => bench.restart(true),
            Some(other) => return Err(format!("no such restart: {other}")),
        }
        Ok(())
    }

    fn apply_interlock(&self, bench: &mut Bench) {
        let contact = |position| match position {
            Position::Open => Contact::Open,
            Position::Closed => Contact::Closed,
        };
        bench.loops.a = self.loop_a.map_or(bench.loops.a, contact);
        bench.loops.b = self.loop_b.map_or(bench.loops.b, contact);
    }

    fn apply_readings(&self, bench: &mut Bench) -> Result<(), String> {
        if let Some(board) = &self.top_board {
            bench.boards.top = board.read()?;
        }
        if let Some(board) = &self.bottom_board {
            bench.boards.bottom = board.read()?;
        }
        if let Some(air) = self.enclosure_c {
            bench.enclosure = Some(CentiCelsius((air * 100.0) as i16));
        }
        if let Some(volts) = self.supply_v {
            bench.supply = (volts > 0.0).then_some(Millivolts((volts * 1_000.0) as u16));
        }
        bench.ultraviolet_percent = self.ultraviolet_percent.or(bench.ultraviolet_percent);
        if self.ultraviolet_silent == Some(true) {
            bench.ultraviolet_percent = None;
        }
        if let Some(stray) = self.stray_w_m2 {
            bench.stray = Irradiance((stray * 1_000.0) as u32);
        }
        Ok(())
    }

    fn apply_viewer_sensors(&self, bench: &mut Bench) {
        bench.eyes[0] = self.left_eye.unwrap_or(bench.eyes[0]);
        bench.eyes[1] = self.right_eye.unwrap_or(bench.eyes[1]);
        bench.radar_sees_room = self.radar_sees_room.unwrap_or(bench.radar_sees_room);
        if let Some(targets) = &self.radar {
            let target = |(x_mm, y_mm): &(i16, i16)| RadarTarget { x_mm: *x_mm, y_mm: *y_mm };
            bench.radar = Some(targets.iter().map(target).collect::<RadarFrame>());
        }
    }
}

impl Board {
    fn read(&self) -> Result<Option<TemperatureReading>, String> {
        match self {
            Self::Celsius(celsius) => {
                Ok(Some(TemperatureReading::Celsius(CentiCelsius((celsius * 100.0) as i16))))
            }
            Self::Fault(fault) => match fault.as_str() {
                "open" => Ok(Some(TemperatureReading::OpenCircuit)),
                "shorted" => Ok(Some(TemperatureReading::Shorted)),
                "silent" => Ok(None),
                other => Err(format!("no such sensor fault: {other}")),
            },
        }
    }
}

/// Reads a moment, as what the clock would have shown at the scenario's beginning.
fn read_clock(text: &str, time_s: f64) -> Result<Option<UtcSeconds>, String> {
    if text == "none" {
        return Ok(None);
    }
    let now: jiff::Timestamp = text.parse().map_err(|error| format!("{text}: {error}"))?;
    Ok(Some(UtcSeconds(now.as_second() - time_s as i64)))
}

fn read_request(text: &str) -> Result<Request, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let wrong = || format!("no such request: {text}");
    let lease = |seconds: &str| seconds.parse().map(Milliseconds::from_seconds).map_err(|_| wrong());
    match words.as_slice() {
        ["rearm"] => Ok(Request::Rearm),
        ["release"] => Ok(Request::Release),
        ["new-stack"] => Ok(Request::NewStack),
        ["dark", seconds] => Ok(Request::Dark { lease: lease(seconds)? }),
        ["open", seconds] => Ok(Request::Open { lease: lease(seconds)? }),
        ["hold", view, seconds] => {
            Ok(Request::Hold { view: view.parse().map_err(|_| wrong())?, lease: lease(seconds)? })
        }
        _ => Err(wrong()),
    }
}
