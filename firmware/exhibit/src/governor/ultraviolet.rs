//! Holds the ultraviolet sensor against what the lamps should give.
//!
//! At commissioning the sensor's reading under each lamp alone at full level goes into the plan; what it should read
//! follows linearly from the levels. A lamp's calibration without such a reading switches the check off.
//!
//! A sensor that the plan counts on and that falls silent is told, in the log, the status and by the status LED, and does
//! not cut: it proves nothing about the lamps, whose irradiance, dose and heat are bounded without it. What it read last is
//! forgotten, and readings in a row begin anew when it is back.

use crate::events::{Event, Events};
use crate::limits;
use crate::plan::{Emphasis, Plan};
use crate::units::{Irradiance, Level, Milliseconds};

/// The sensor integrates: what it reads may be this old.
const OLDEST: Milliseconds = Milliseconds(1_000);
/// So many readings in a row make a fault.
const FAULTY_READINGS: u8 = 3;
/// So many readings in a row make an aged lamp or sensor.
const AGED_READINGS: u8 = 100;

/// The extreme of the expected readings of the last second.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    value: u32,
    age: Milliseconds,
}

impl Held {
    /// Takes a new value where it is more extreme, or where the held one is too old.
    fn update(&mut self, value: u32, more_extreme: bool, elapsed: Milliseconds) {
        self.age = self.age.plus(elapsed);
        if more_extreme || self.age >= OLDEST {
            *self = Self { value, age: Milliseconds(0) };
        }
    }
}

/// Compares readings with the model.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UltravioletWatch {
    most: Held,
    least: Held,
    bright_readings: u8,
    dim_readings: u8,
    too_bright: bool,
    bright_while_dark: bool,
    last: Option<Irradiance>,
    silent_for: Milliseconds,
    lost: bool,
}

impl UltravioletWatch {
    pub(super) fn update(
        &mut self,
        plan: Option<&Plan>,
        levels: Emphasis,
        reading: Option<Irradiance>,
        elapsed: Milliseconds,
        events: &mut Events,
    ) {
        let full = plan.and_then(expected_at_full);
        self.listen(reading, full.is_some(), elapsed, events);
        let Some(full) = full else { return };
        let expected = part(full.0, levels.top) + part(full.1, levels.bottom);
        self.most.update(expected, expected >= self.most.value, elapsed);
        self.least.update(expected, expected <= self.least.value, elapsed);
        if let Some(reading) = reading {
            self.judge(reading.0, full.0 + full.1, events);
        }
    }

    /// Takes note of a reading, or of its absence.
    fn listen(
        &mut self,
        reading: Option<Irradiance>,
        counted_on: bool,
        elapsed: Milliseconds,
        events: &mut Events,
    ) {
        self.silent_for = if reading.is_some() { Milliseconds(0) } else { self.silent_for.plus(elapsed) };
        let silent = self.silent_for >= limits::ULTRAVIOLET_SILENT;
        self.last = reading.or(self.last).filter(|_| !silent);
        if silent {
            (self.bright_readings, self.dim_readings) = (0, 0);
        }
        let lost = silent && counted_on;
        if lost && !self.lost {
            events.push(Event::UltravioletSensorLost);
        } else if self.lost && !silent {
            events.push(Event::UltravioletSensorBack);
        }
        self.lost = lost;
    }

    fn judge(&mut self, reading: u32, scale: u32, events: &mut Events) {
        let margin = scale / 100 * limits::ULTRAVIOLET_MARGIN_PERCENT;
        let bound = (self.most.value / 10 * limits::ULTRAVIOLET_BRIGHT_TENTHS).max(margin);
        self.bright_readings = if reading > bound { self.bright_readings.saturating_add(1) } else { 0 };
        if self.bright_readings >= FAULTY_READINGS {
            let dark = self.most.value == 0;
            self.bright_while_dark |= dark;
            self.too_bright |= !dark;
        }
        let dim =
            self.least.value > scale / 5 && reading < self.least.value / 10 * limits::ULTRAVIOLET_DIM_TENTHS;
        self.dim_readings = if dim { self.dim_readings.saturating_add(1) } else { 0 };
        if self.dim_readings == AGED_READINGS {
            events.push(Event::UltravioletLow);
        }
    }

    /// The last reading, while it is not old.
    pub(super) const fn reading(&self) -> Option<Irradiance> {
        self.last
    }

    /// Tells whether the plan counts on the sensor and it is silent.
    pub(super) const fn is_lost(&self) -> bool {
        self.lost
    }

    pub(super) const fn is_too_bright(&self) -> bool {
        self.too_bright
    }

    pub(super) const fn is_bright_while_dark(&self) -> bool {
        self.bright_while_dark
    }

    pub(super) const fn rearm(&mut self) {
        self.bright_readings = 0;
        self.too_bright = false;
        self.bright_while_dark = false;
    }
}

/// What the sensor reads under each lamp alone at full level, in mW/m².
fn expected_at_full(plan: &Plan) -> Option<(u32, u32)> {
    let (top, bottom) = (plan.lamps.top.ultraviolet_at_full.0, plan.lamps.bottom.ultraviolet_at_full.0);
    (top > 0 && bottom > 0).then_some((top, bottom))
}

const fn part(full: u32, level: Level) -> u32 {
    level.of(Irradiance(full)).0
}
