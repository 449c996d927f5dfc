//! One Grid-EYE: is it sound, what is its background, what stands out from it.
//!
//! Values inside are sums of two frames, that is, in eighths of a degree.

use super::{COLUMNS, PIXELS, ThermalFrame};
use crate::units::Milliseconds;

/// Frames over which a background is seeded.
pub(super) const SEED_FRAMES: u16 = 32;
/// A sensor without a new frame for this long is lost.
pub(super) const STALE: Milliseconds = Milliseconds(1_000);
/// Frames without the change of a single pixel that make a frozen sensor: its noise alone changes some in each.
const FROZEN_FRAMES: u16 = 20;
/// Foreground stands at least this far above the background, with `FRACTION` fractional bits: 0.8 degrees.
const LEAST_THRESHOLD: i32 = (8 << FRACTION) * 8 / 10;
/// The part of each frame in the background's mean, over 65,536: the mean follows within 120 s at 10 frames a second.
const SLOW: i32 = 65_536 / 1_200;
/// The background's noise is learnt within this many frames, as a power of two: 26 s.
const NOISE_SLOW: u32 = 8;
/// A pixel that stays foreground for this many frames is background after all: 15 minutes without life in its
/// column.
const FORCED_FRAMES: u16 = 9_000;
/// A pixel that is this many frames colder than its background never had a background there.
const COLD_FRAMES: u8 = 10;
/// Fractional bits of the background's mean and noise.
const FRACTION: u32 = 10;
/// Fractional bits of a pixel's mean of the last seconds, and its length: 32 frames, as a power of two.
const RECENT: u32 = 5;
/// A pixel is restless where it differs this much from its last seconds, half a degree, ...
const RESTLESS: i32 = 4;
/// ... for this many frames on end. Noise alone does so less than once a day.
const RESTLESS_FRAMES: u8 = 4;
/// Readings that no room has, in quarters of a degree: below -20 or above 100 degrees.
const CREDIBLE: core::ops::RangeInclusive<i16> = -80..=400;

/// What one pixel remembers.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    last: i16,
    mean: i32,
    /// Mean distance from the mean.
    noise: u16,
    warm_frames: u16,
    cold_frames: u8,
    /// Mean of the last seconds, with `RECENT` fractional bits.
    recent: i16,
    restless_frames: u8,
}

/// What one frame shows above the background.
#[derive(Clone, Copy, Debug)]
pub(super) struct Warmth {
    /// Eighths of a degree above the background, where that is foreground.
    pub(super) above: [u16; PIXELS],
    /// Columns, by their bit, with a pixel that differs from its own last seconds for longer than noise does:
    /// something lives.
    pub(super) moved: u8,
}

/// One sensor.
#[derive(Clone, Debug)]
pub(super) struct Eye {
    pixels: [Pixel; PIXELS],
    frames: u16,
    same_frames: u16,
    age: Milliseconds,
}

impl Eye {
    pub(super) const fn new() -> Self {
        let pixel = Pixel {
            last: 0,
            mean: 0,
            noise: 0,
            warm_frames: 0,
            cold_frames: 0,
            recent: 0,
            restless_frames: 0,
        };
        Self { pixels: [pixel; PIXELS], frames: 0, same_frames: 0, age: STALE }
    }

    pub(super) const fn pass(&mut self, elapsed: Milliseconds) {
        self.age = self.age.plus(elapsed);
    }

    /// Tells whether the sensor's frames are fresh, credible and alive.
    pub(super) fn is_sound(&self) -> bool {
        self.age < STALE && self.same_frames < FROZEN_FRAMES
    }

    /// Tells whether the background is known.
    pub(super) const fn is_seeded(&self) -> bool {
        self.frames >= SEED_FRAMES
    }

    /// Takes a frame; gives none where it is not credible, or while the background is being seeded.
    pub(super) fn take(&mut self, frame: &ThermalFrame) -> Option<Warmth> {
        if !frame.pixels.iter().all(|reading| CREDIBLE.contains(reading)) {
            return None;
        }
        self.age = Milliseconds(0);
        let same = self.pixels.iter().zip(&frame.pixels).all(|(pixel, reading)| pixel.last == *reading);
        self.same_frames = if same && self.frames > 0 { self.same_frames.saturating_add(1) } else { 0 };
        let mut warmth = Warmth { above: [0; PIXELS], moved: 0 };
        let first = self.frames == 0;
        let seeded = self.is_seeded();
        let pixels = self.pixels.iter_mut().zip(&frame.pixels).zip(&mut warmth.above).zip(0_u32..);
        for (((pixel, reading), above), index) in pixels {
            let before = if first { *reading } else { pixel.last };
            let sum = i32::from(before) + i32::from(*reading);
            pixel.last = *reading;
            if seeded {
                *above = pixel.rise(sum);
                warmth.moved |= u8::from(pixel.is_restless(sum)) << (index % COLUMNS as u32);
            } else {
                pixel.seed(sum, first);
            }
        }
        if warmth.moved != 0 {
            self.keep_foreground(warmth.moved);
        }
        self.frames = self.frames.saturating_add(1);
        seeded.then_some(warmth)
    }

    /// Begins the time anew after which foreground is background, in columns where something lives.
    fn keep_foreground(&mut self, lives: u8) {
        for row in self.pixels.chunks_exact_mut(COLUMNS) {
            for (pixel, column) in row.iter_mut().zip(0..) {
                if lives >> column & 1 == 1 {
                    pixel.warm_frames = 0;
                }
            }
        }
    }
}

impl Pixel {
    fn seed(&mut self, sum: i32, first: bool) {
        let value = sum << FRACTION;
        if first {
            self.mean = value;
        }
        self.recent = (sum << RECENT) as i16;
        self.mean += (value - self.mean) >> 3;
        self.learn_noise((value - self.mean).abs(), 3);
    }

    /// Foreground stands this far above the mean: 0.8 degrees or four standard deviations, of which the mean
    /// distance is 0.8.
    fn threshold(&self) -> i32 {
        (i32::from(self.noise) * 5).max(LEAST_THRESHOLD)
    }

    /// Gives how far a value stands above the background, or zero; the background learns from what is no foreground.
    fn rise(&mut self, sum: i32) -> u16 {
        let value = sum << FRACTION;
        let difference = value - self.mean;
        let threshold = self.threshold();
        if difference >= threshold {
            self.warm_frames = self.warm_frames.saturating_add(1);
            self.cold_frames = 0;
            if self.warm_frames < FORCED_FRAMES {
                return (difference >> FRACTION) as u16;
            }
            self.mean = value;
            self.warm_frames = 0;
            return 0;
        }
        self.warm_frames = 0;
        self.cold_frames = if difference <= -threshold { self.cold_frames.saturating_add(1) } else { 0 };
        if self.cold_frames >= COLD_FRAMES {
            // Whoever stood here while the background was seeded has gone.
            self.mean = value;
            self.cold_frames = 0;
            return 0;
        }
        self.mean += (difference * SLOW) >> 16;
        self.learn_noise(difference.abs(), NOISE_SLOW);
        0
    }

    /// Takes a value into the mean of the last seconds; tells whether it has differed from it for a while.
    fn is_restless(&mut self, sum: i32) -> bool {
        let difference = (sum << RECENT) - i32::from(self.recent);
        let restless = difference.abs() >= RESTLESS << RECENT;
        self.restless_frames = if restless { self.restless_frames.saturating_add(1) } else { 0 };
        self.recent = (i32::from(self.recent) + (difference >> RECENT)) as i16;
        self.restless_frames >= RESTLESS_FRAMES
    }

    fn learn_noise(&mut self, distance: i32, shift: u32) {
        let noise = i32::from(self.noise);
        let learnt = noise + ((distance.min(i32::from(u16::MAX)) - noise) >> shift);
        self.noise = learnt.clamp(0, i32::from(u16::MAX)) as u16;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames for which a patch two degrees above the room is foreground; `lives` has a pixel of its column waver.
    fn foreground_frames(lives: bool, most: u32) -> u32 {
        let mut eye = Eye::new();
        let mut frame = ThermalFrame::left([88; PIXELS]);
        for number in 0..u32::from(SEED_FRAMES) {
            frame.pixels[63] = 88 + (number % 2) as i16;
            eye.take(&frame);
        }
        frame.pixels[18] = 96;
        frame.pixels[26] = 96;
        let above = |number: u32, frame: &mut ThermalFrame, eye: &mut Eye| {
            frame.pixels[63] = 88 + (number % 2) as i16;
            // A second warmer, a second colder.
            frame.pixels[26] = if lives && (number / 10).is_multiple_of(2) { 102 } else { 96 };
            eye.take(frame).is_some_and(|warmth| warmth.above[18] > 0)
        };
        (0..most).take_while(|number| above(*number, &mut frame, &mut eye)).count() as u32
    }

    #[test]
    fn what_is_dead_still_is_background_after_fifteen_minutes_and_not_sooner() {
        // That it comes is taken for life for some seconds.
        let least = u32::from(FORCED_FRAMES);
        assert!((least..least + 100).contains(&foreground_frames(false, 20_000)));
    }

    #[test]
    fn who_lives_never_becomes_background() {
        assert_eq!(foreground_frames(true, 20_000), 20_000);
    }
}
