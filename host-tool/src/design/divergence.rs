//! What counts as an error between what is seen and what is wanted, and how strongly to answer it.

use super::request::Tone;
use crate::picture::srgb_encode;

/// Patterns at least this bright are white: light beyond it is no error, for it is seen as white.
const WHITE: f32 = 0.998;

/// Entries of the table of the sRGB curve.
const TABLE: usize = 4096;

/// Where the sRGB curve begins to be a power.
const NEARLY_BLACK: f32 = 0.003_130_8;

/// Light of the encoding table's last entry: brighter light counts as if the curve went on straight.
const TABLE_END: f32 = 1.0;

/// The error of one pixel: squared in the values in which it is measured, which for light are its sRGB codes.
#[derive(Clone, Debug)]
pub(super) struct Divergence {
    /// Code values at equal steps of the square root of light, or nothing when values are codes already.
    encoding: Option<Vec<f32>>,
}

/// The answer to one pixel's error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    /// The error in the values in which it is measured.
    pub(super) error: f32,
    /// How steeply the measured value rises with the pixel's.
    pub(super) slope: f32,
    /// A bound of its curvature, halved: how steeply the slope may change on the way to the wanted value.
    pub(super) curvature: f32,
}

impl Divergence {
    pub(super) fn new(tone: Tone) -> Self {
        let table = || {
            let light = |step: usize| {
                let root = step as f32 / TABLE as f32;
                root * root * TABLE_END
            };
            (0..TABLE + 2).map(|step| srgb_encode(light(step))).collect()
        };
        Self { encoding: matches!(tone, Tone::Linear).then(table) }
    }

    /// Whether the curvature differs from pixel to pixel.
    pub(super) fn varies(&self) -> bool {
        self.encoding.is_some()
    }

    /// Returns a wanted value as it is measured.
    pub(super) fn measured(&self, wanted: f32) -> f32 {
        self.encoding.as_deref().map_or(wanted, |table| encode(table, wanted))
    }

    /// Answers for a pixel that shows `seen` where `wanted` is to be seen; white is 1.
    pub(super) fn answer(&self, seen: f32, wanted: f32) -> Answer {
        let white = wanted >= WHITE && seen > wanted;
        match &self.encoding {
            _ if white => Answer { error: 0.0, slope: 0.0, curvature: 1.0 },
            None => {
                let error = seen - wanted;
                Answer { error, slope: 1.0, curvature: 1.0 }
            }
            Some(table) => {
                let (code, wanted_code) = (encode(table, seen), encode(table, wanted));
                let error = code - wanted_code;
                // The curve is concave: on the way from what is seen to what is wanted it is nowhere steeper
                // than at the darker of the two, and its error shrinks along the chord.
                let slope = steepness(seen, code);
                let steepest = steepness(seen.min(wanted), code.min(wanted_code));
                let distance = seen - wanted;
                let chord = if distance.abs() > 1e-4 { error / distance } else { slope };
                let curvature = (chord.clamp(0.4, 12.92) * steepest).max(slope * slope);
                Answer { error, slope, curvature }
            }
        }
    }
}

fn encode(table: &[f32], light: f32) -> f32 {
    if light >= TABLE_END {
        // The slope of the curve at white.
        return 1.0 + (light - TABLE_END) * (1.055 / 2.4);
    }
    let position = (light.max(0.0) / TABLE_END).sqrt() * TABLE as f32;
    let below = position as usize;
    table[below] + (position - below as f32) * (table[below + 1] - table[below])
}

/// Slope of the sRGB curve at `light`, whose code value is `code`. Where the curve is a power, its slope is
/// the power's exponent times its value over the light.
fn steepness(light: f32, code: f32) -> f32 {
    if light <= NEARLY_BLACK { 12.92 } else { (code.min(1.0) + 0.055) / (2.4 * light.min(1.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_slope_points_away_from_what_is_wanted(seen in 0.0f32..1.5, wanted in 0.0f32..1.0) {
            for tone in [Tone::Code, Tone::Linear] {
                let answer = Divergence::new(tone).answer(seen, wanted);
                prop_assert!(answer.curvature >= answer.slope * answer.slope);
                prop_assert!(answer.slope * answer.error * (seen - wanted) >= 0.0);
            }
        }

        #[test]
        fn light_is_judged_by_its_code(seen in 0.0f32..1.0, wanted in 0.0f32..0.99) {
            let answer = Divergence::new(Tone::Linear).answer(seen, wanted);
            let expected = srgb_encode(seen) - srgb_encode(wanted);
            prop_assert!((answer.error - expected).abs() < 1e-4, "{} {}", answer.error, expected);
        }
    }
}
