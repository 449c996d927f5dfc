//! Two Grid-EYE thermal sensors as one source of bearings.

use super::{Bearing, BearingSource, COLUMNS, PIXELS, ROWS, Sighting, Sightings, ThermalFrame};
use crate::units::Milliseconds;

/// Width of a pixel, and of a row, in hundredths of a degree.
const PIXEL: i32 = 750;
/// Width of a bin of the common azimuth axis.
const BIN: i32 = 250;
/// Half the width of the common azimuth axis.
const HALF_AXIS: i32 = 5_500;
/// Bins of the common azimuth axis.
const BINS: usize = 44;
/// Frames over which a background is seeded.
const SEED_FRAMES: u8 = 32;
/// Fractional bits of the background.
const FRACTION: u32 = 8;
/// Foreground is this much above the background, in quarters of a degree.
const THRESHOLD: i32 = 4;
/// A sensor without a new frame for this long is lost.
const STALE: Milliseconds = Milliseconds(1_000);

/// One sensor's background and freshness.
#[derive(Clone, Debug)]
struct Eye {
    background: [i32; PIXELS],
    seeded: u8,
    age: Milliseconds,
}

impl Eye {
    const fn new() -> Self {
        Self { background: [0; PIXELS], seeded: 0, age: STALE }
    }

    /// Takes a frame; gives the foreground in quarters of a degree above the background.
    fn foreground(&mut self, frame: &ThermalFrame) -> [i32; PIXELS] {
        let mut foreground = [0; PIXELS];
        let seeding = self.seeded < SEED_FRAMES;
        let shift = if seeding { 3 } else { 10 };
        for ((pixel, background), above) in frame.pixels.iter().zip(&mut self.background).zip(&mut foreground)
        {
            let value = i32::from(*pixel) << FRACTION;
            if self.seeded == 0 {
                *background = value;
            }
            let excess = (value - *background) >> FRACTION;
            if seeding || excess < THRESHOLD {
                *background += (value - *background) >> shift;
            }
            if !seeding && excess >= THRESHOLD {
                *above = excess;
            }
        }
        self.seeded = self.seeded.saturating_add(1).min(SEED_FRAMES);
        foreground
    }
}

/// The two thermal sensors, yawed to either side, on one azimuth axis.
#[derive(Clone, Debug)]
pub struct ThermalPair {
    eyes: [Eye; 2],
    /// Warmth over the azimuth axis, by sensor.
    profiles: [[u16; BINS]; 2],
    /// Highest warm row over the azimuth axis as elevation; the least value where nothing is warm.
    tops: [[i16; BINS]; 2],
}

impl Default for ThermalPair {
    fn default() -> Self {
        Self::new()
    }
}

impl ThermalPair {
    /// A pair that has seen nothing yet.
    pub const fn new() -> Self {
        Self { eyes: [Eye::new(), Eye::new()], profiles: [[0; BINS]; 2], tops: [[i16::MIN; BINS]; 2] }
    }

    fn lay_out(
        frame: &ThermalFrame,
        foreground: &[i32; PIXELS],
        profile: &mut [u16; BINS],
        tops: &mut [i16; BINS],
    ) {
        profile.fill(0);
        tops.fill(i16::MIN);
        for column in 0..COLUMNS {
            let rows = foreground.iter().skip(column).step_by(COLUMNS);
            let warmth: i32 = rows.clone().sum();
            let top = rows.zip(0_i32..).find(|(above, _)| **above > 0).map_or(i16::MIN, |(_, row)| {
                let half_rows = ROWS as i32 - 1 - 2 * row;
                (i32::from(frame.pitch.0) + half_rows * PIXEL / 2) as i16
            });
            let left = i32::from(frame.yaw.0) + (column as i32 - COLUMNS as i32 / 2) * PIXEL;
            for part in 0..PIXEL / BIN {
                let bin = (left + part * BIN + HALF_AXIS).div_euclid(BIN);
                let Ok(bin) = usize::try_from(bin) else { continue };
                if let (Some(sum), Some(highest)) = (profile.get_mut(bin), tops.get_mut(bin)) {
                    *sum = warmth.clamp(0, i32::from(u16::MAX)) as u16;
                    *highest = top;
                }
            }
        }
    }

    fn sightings(&self) -> Sightings {
        let [left, right] = &self.profiles;
        let [left_tops, right_tops] = &self.tops;
        let mut sightings = Sightings::new();
        let (mut warmth, mut moment, mut top) = (0_i32, 0_i32, i16::MIN);
        let bins = left.iter().zip(right).zip(left_tops.iter().zip(right_tops)).zip(0_i32..);
        for (((left, right), (left_top, right_top)), bin) in bins {
            let here = i32::from(*left.max(right));
            if here > 0 {
                warmth += here;
                moment += here * (bin * BIN + BIN / 2 - HALF_AXIS) / 16;
                top = top.max(*left_top).max(*right_top);
            }
            if warmth > 0 && (here == 0 || bin + 1 == BINS as i32) {
                let bearing = Bearing::new((moment / (warmth / 16).max(1)) as i16, top);
                let strength = warmth.min(i32::from(u16::MAX)) as u16;
                if sightings.push(Sighting { bearing, strength }).is_err() {
                    break;
                }
                (warmth, moment, top) = (0, 0, i16::MIN);
            }
        }
        sightings
    }
}

impl BearingSource for ThermalPair {
    type Reading<'a> = [Option<&'a ThermalFrame>; 2];

    fn take(&mut self, reading: Self::Reading<'_>, elapsed: Milliseconds) -> Option<Sightings> {
        let mut fresh = false;
        for (((frame, eye), profile), tops) in
            reading.iter().zip(&mut self.eyes).zip(&mut self.profiles).zip(&mut self.tops)
        {
            eye.age = eye.age.plus(elapsed);
            if let Some(frame) = frame {
                let foreground = eye.foreground(frame);
                Self::lay_out(frame, &foreground, profile, tops);
                eye.age = Milliseconds(0);
                fresh = true;
            }
        }
        fresh.then(|| self.sightings())
    }

    fn is_sound(&self) -> bool {
        self.eyes.iter().all(|eye| eye.age < STALE)
    }
}
