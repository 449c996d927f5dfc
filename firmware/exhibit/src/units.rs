//! Units as small integer newtypes: the controller has no floating-point unit, and integers do not drift.

use serde::{Deserialize, Serialize};

/// An angle in hundredths of a degree; positive horizontal is to the right, positive vertical is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CentiDegrees(pub i16);

/// A lamp's level as a part of its full irradiance, linear in irradiance: 0 is off, 65,535 is full.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Level(pub u16);

impl Level {
    /// Lamp off.
    pub const OFF: Self = Self(0);
    /// Lamp at its full irradiance.
    pub const FULL: Self = Self(u16::MAX);
}

/// Irradiance at 365 nm in mW/m².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Irradiance(pub u32);

/// Radiant exposure in µJ/m² (mW/m² times ms).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Dose(pub u64);

/// A point in time, whole seconds since 1970-01-01T00:00:00 UTC, without leap seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct UtcSeconds(pub i64);

/// A span of time in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Milliseconds(pub u32);
