//! Units as small integer newtypes: the controller has no floating-point unit, and integers do not drift.

use serde::{Deserialize, Serialize};

/// An angle in hundredths of a degree; positive horizontal is to the right, positive vertical is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CentiDegrees(pub i16);

/// A lamp's level as a part of its full irradiance, linear in irradiance: 0 is off, 65,535 is full.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Level(pub u16);

impl Level {
    /// Lamp off.
    pub const OFF: Self = Self(0);
    /// Lamp at its full irradiance.
    pub const FULL: Self = Self(u16::MAX);
}

/// Irradiance at 365 nm in mW/m².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Irradiance(pub u32);

/// Radiant exposure in µJ/m² (mW/m² times ms).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Dose(pub u64);

/// A point in time, whole seconds since 1970-01-01T00:00:00 UTC, without leap seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct UtcSeconds(pub i64);

/// A span of time in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Milliseconds(pub u32);

/// A temperature in hundredths of a degree Celsius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CentiCelsius(pub i16);

/// A voltage in mV.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Millivolts(pub u16);

/// One of the two ultraviolet lamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Lamp {
    /// The lamp on the viewer's side.
    Top,
    /// The lamp behind the stack.
    Bottom,
}

/// One value for each lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PerLamp<T> {
    /// The value of the lamp on the viewer's side.
    pub top: T,
    /// The value of the lamp behind the stack.
    pub bottom: T,
}

impl<T> PerLamp<T> {
    /// Pairs a value for each lamp.
    pub const fn new(top: T, bottom: T) -> Self {
        Self { top, bottom }
    }

    /// Gives the value of one lamp.
    pub const fn get(&self, lamp: Lamp) -> &T {
        match lamp {
            Lamp::Top => &self.top,
            Lamp::Bottom => &self.bottom,
        }
    }

    /// Applies a function to both values.
    pub fn map<U>(self, mut function: impl FnMut(T) -> U) -> PerLamp<U> {
        PerLamp { top: function(self.top), bottom: function(self.bottom) }
    }

    /// Joins the values of two pairs, lamp by lamp.
    pub fn zip<U>(self, other: PerLamp<U>) -> PerLamp<(T, U)> {
        PerLamp { top: (self.top, other.top), bottom: (self.bottom, other.bottom) }
    }
}

impl Level {
    /// Scales this level by another, rounded to the nearest: `FULL` changes nothing.
    pub const fn scaled(self, by: Self) -> Self {
        let product = self.0 as u32 * by.0 as u32;
        Self(((product + 32_767) / 65_535) as u16)
    }

    /// The irradiance of this level of a lamp that gives `full` at full level, rounded up.
    pub const fn of(self, full: Irradiance) -> Irradiance {
        match (self.0 as u32).checked_mul(full.0) {
            // The way of every valid plan: the processor has no 64-bit division.
            Some(product) => Irradiance(product.div_ceil(65_535)),
            None => Irradiance((self.0 as u64 * full.0 as u64).div_ceil(65_535) as u32),
        }
    }

    /// The highest level of a lamp that gives `full` at full level which does not exceed `irradiance`.
    pub const fn not_above(irradiance: Irradiance, full: Irradiance) -> Self {
        if irradiance.0 >= full.0 {
            return Self::FULL;
        }
        match irradiance.0.checked_mul(65_535) {
            Some(product) => Self((product / full.0) as u16),
            None => Self((irradiance.0 as u64 * 65_535 / full.0 as u64) as u16),
        }
    }
}

impl Irradiance {
    /// The dose that this irradiance gives in a time.
    pub const fn over(self, time: Milliseconds) -> Dose {
        Dose(self.0 as u64 * time.0 as u64)
    }
}

impl Dose {
    /// The sum of two doses; stays at the greatest value instead of overflowing.
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// The difference of two doses, not below zero.
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Milliseconds {
    /// A time of whole seconds; stays at the greatest value instead of overflowing.
    pub const fn from_seconds(seconds: u32) -> Self {
        Self(seconds.saturating_mul(1000))
    }

    /// The sum of two times; stays at the greatest value instead of overflowing.
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// The difference of two times, not below zero.
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}
