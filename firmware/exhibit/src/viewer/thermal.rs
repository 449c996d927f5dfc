//! Two Grid-EYE thermal sensors as one source of bearings.

use super::axis::{self, Strip};
use super::eye::Eye;
use super::{BearingSource, Sightings, ThermalFrame};
use crate::units::Milliseconds;

/// The two thermal sensors, yawed to either side, on one azimuth axis.
#[derive(Clone, Debug)]
pub struct ThermalPair {
    eyes: [Eye; 2],
    strips: [Strip; 2],
}

impl Default for ThermalPair {
    fn default() -> Self {
        Self::new()
    }
}

impl ThermalPair {
    /// A pair that has seen nothing yet.
    pub const fn new() -> Self {
        Self { eyes: [Eye::new(), Eye::new()], strips: [Strip::EMPTY; 2] }
    }

    /// Tells of each sensor, left and right, whether its frames are fresh, credible and alive.
    pub fn sound(&self) -> [bool; 2] {
        let [left, right] = &self.eyes;
        [left.is_sound(), right.is_sound()]
    }
}

impl BearingSource for ThermalPair {
    type Reading<'a> = [Option<&'a ThermalFrame>; 2];

    fn take(&mut self, reading: Self::Reading<'_>, elapsed: Milliseconds) -> Option<Sightings> {
        let mut fresh = false;
        for ((frame, eye), strip) in reading.iter().zip(&mut self.eyes).zip(&mut self.strips) {
            eye.pass(elapsed);
            if let Some(frame) = frame
                && let Some(warmth) = eye.take(frame)
            {
                *strip = Strip::new(frame, &warmth);
                fresh = true;
            }
            if !eye.is_sound() {
                *strip = Strip::EMPTY;
            }
        }
        fresh.then(|| axis::bodies(&self.strips))
    }

    fn is_sound(&self) -> bool {
        self.eyes.iter().all(|eye| eye.is_sound() && eye.is_seeded())
    }
}
