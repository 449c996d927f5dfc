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
    /// A frame of the right sensor that came together with one of the left.
    waits: Option<ThermalFrame>,
    /// Frames taken since bodies were looked for.
    unseen: u8,
}

/// After so many frames bodies are looked for even where there was no quiet step between them.
const MOST_UNSEEN: u8 = 4;

impl Default for ThermalPair {
    fn default() -> Self {
        Self::new()
    }
}

impl ThermalPair {
    /// A pair that has seen nothing yet.
    pub const fn new() -> Self {
        Self { eyes: [Eye::new(), Eye::new()], strips: [Strip::EMPTY; 2], waits: None, unseen: 0 }
    }

    /// Tells whether what has come is still being worked on.
    pub const fn is_busy(&self) -> bool {
        self.waits.is_some() || self.unseen > 0
    }

    /// Tells of each sensor, left and right, whether its frames are fresh, credible and alive.
    pub fn sound(&self) -> [bool; 2] {
        let [left, right] = &self.eyes;
        [left.is_sound(), right.is_sound()]
    }
}

impl ThermalPair {
    fn look(&mut self, sensor: usize, frame: &ThermalFrame) {
        let (Some(eye), Some(strip)) = (self.eyes.get_mut(sensor), self.strips.get_mut(sensor)) else {
            return;
        };
        if let Some(warmth) = eye.take(frame) {
            *strip = if eye.is_sound() { Strip::new(frame, &warmth) } else { Strip::EMPTY };
            self.unseen = self.unseen.saturating_add(1);
        }
    }
}

impl BearingSource for ThermalPair {
    type Reading<'a> = [Option<&'a ThermalFrame>; 2];

    /// Spreads its work over steps, so that none is long: a frame in each, and the bodies in the next quiet one.
    fn take(&mut self, reading: Self::Reading<'_>, elapsed: Milliseconds) -> Option<Sightings> {
        for (eye, strip) in self.eyes.iter_mut().zip(&mut self.strips) {
            eye.pass(elapsed);
            if !eye.is_sound() {
                *strip = Strip::EMPTY;
            }
        }
        let [left, right] = reading;
        let is_quiet = match (left, right) {
            (Some(left), right) => {
                self.waits = right.copied().or(self.waits);
                self.look(0, left);
                false
            }
            (None, Some(right)) => {
                self.waits = None;
                self.look(1, right);
                false
            }
            (None, None) => match self.waits.take() {
                Some(right) => {
                    self.look(1, &right);
                    false
                }
                None => true,
            },
        };
        let is_due = self.unseen > 0 && (is_quiet || self.unseen >= MOST_UNSEEN);
        is_due.then(|| {
            self.unseen = 0;
            axis::bodies(&self.strips)
        })
    }

    fn is_sound(&self) -> bool {
        self.eyes.iter().all(|eye| eye.is_sound() && eye.is_seeded())
    }
}
