//! What counts as an error between what is seen and what is wanted, and how strongly to answer it.

use super::request::Tone;
use crate::picture::{STEEPEST, srgb_encode, srgb_encode_with_slope};

/// Patterns at least this bright are white: light beyond it is no error, for it is seen as white.
const WHITE: f32 = 0.998;

/// Slope of the sRGB curve at white: brighter light counts as if the curve went on straight.
const SLOPE_AT_WHITE: f32 = 1.055 / 2.4;

/// The error of one pixel: squared in the values in which it is measured, which for light are its sRGB codes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Divergence {
    tone: Tone,
}

impl Divergence {
    pub(super) fn new(tone: Tone) -> Self {
        Self { tone }
    }

    /// Whether the curvature differs from pixel to pixel.
    pub(super) fn varies(&self) -> bool {
        self.tone == Tone::Linear
    }

    /// Returns a wanted value as it is measured.
    pub(super) fn measured(&self, wanted: f32) -> f32 {
        match self.tone {
            Tone::Linear => srgb_encode(wanted),
            Tone::Code => wanted,
        }
    }

    /// Turns code values that are shown into what they lack of `wanted`; see [`Divergence::answer`].
    #[inline(always)]
    pub(super) fn lack(&self, shown: &mut [f32], wanted: &[f32]) {
        for (shown, &wanted) in shown.iter_mut().zip(wanted) {
            let lack = wanted - *shown;
            *shown = if wanted >= WHITE { lack.max(0.0) } else { lack };
        }
    }

    /// Answers for pixels that show `seen` where `wanted` is to be seen; white is 1. `seen` becomes how
    /// steeply the measured values rise with it, `errors` the errors in measured values, and `curvatures`
    /// bounds of half the squared error's curvature: how steeply its slope may change on the way to what is
    /// wanted.
    #[inline(always)]
    pub(super) fn answer(
        &self,
        seen: &mut [f32],
        wanted: &[f32],
        errors: &mut [f32],
        curvatures: &mut [f32],
    ) {
        let pixels = seen.iter_mut().zip(wanted).zip(errors).zip(curvatures);
        match self.tone {
            Tone::Code => {
                for (((seen, &wanted), error), curvature) in pixels {
                    *error = if wanted >= WHITE { (*seen - wanted).min(0.0) } else { *seen - wanted };
                    *seen = 1.0;
                    *curvature = 1.0;
                }
            }
            Tone::Linear => {
                for (((seen, &wanted), error), curvature) in pixels {
                    let (code, slope) = encode(*seen);
                    let (wanted_code, wanted_slope) = encode(wanted);
                    let raw = code - wanted_code;
                    // The curve is concave: on the way from what is seen to what is wanted it is nowhere
                    // steeper than at the darker of the two, and its error shrinks along the chord.
                    let distance = *seen - wanted;
                    let far = distance.abs() > 1e-4;
                    let chord = if far { raw / if far { distance } else { 1.0 } } else { slope };
                    let bound = chord.clamp(SLOPE_AT_WHITE, STEEPEST) * slope.max(wanted_slope);
                    let white = wanted >= WHITE && distance > 0.0;
                    *error = if white { 0.0 } else { raw };
                    *seen = if white { 0.0 } else { slope };
                    *curvature = if white { 1.0 } else { bound.max(slope * slope) };
                }
            }
        }
    }
}

/// Returns the code value of `light` and the curve's slope there; beyond white the curve goes on straight.
#[inline(always)]
fn encode(light: f32) -> (f32, f32) {
    let (code, slope) = srgb_encode_with_slope(light);
    (code + (light - 1.0).max(0.0) * SLOPE_AT_WHITE, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Slope, error and curvature of one pixel.
    fn answer(tone: Tone, seen: f32, wanted: f32) -> (f32, f32, f32) {
        let (mut seen, mut error, mut curvature) = ([seen], [0.0], [0.0]);
        Divergence::new(tone).answer(&mut seen, &[wanted], &mut error, &mut curvature);
        (seen[0], error[0], curvature[0])
    }

    proptest! {
        #[test]
        fn the_slope_points_away_from_what_is_wanted(seen in 0.0f32..1.5, wanted in 0.0f32..1.0) {
            for tone in [Tone::Code, Tone::Linear] {
                let (slope, error, curvature) = answer(tone, seen, wanted);
                prop_assert!(curvature >= slope * slope);
                prop_assert!(slope * error * (seen - wanted) >= 0.0);
            }
        }

        #[test]
        fn light_is_judged_by_its_code(seen in 0.0f32..1.0, wanted in 0.0f32..0.99) {
            let (_, error, _) = answer(Tone::Linear, seen, wanted);
            let expected = srgb_encode(seen) - srgb_encode(wanted);
            prop_assert!((error - expected).abs() < 1e-5, "{error} {expected}");
        }
    }
}
