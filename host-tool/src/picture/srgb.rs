//! The sRGB curve (IEC 61966-2-1).

/// Light up to which the curve is straight, and how steep it is there.
const NEARLY_BLACK: f32 = 0.003_130_8;
pub(crate) const STEEPEST: f32 = 12.92;

/// Returns the light, 0..=1, that an sRGB code value stands for (IEC 61966-2-1).
pub fn srgb_decode(code: f32) -> f32 {
    let code = code.clamp(0.0, 1.0);
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Returns the sRGB code value that stands for light in 0..=1 (IEC 61966-2-1), to within 1e-6.
#[inline(always)]
pub fn srgb_encode(light: f32) -> f32 {
    srgb_encode_with_slope(light).0
}

/// Returns the sRGB code value of light in 0..=1 and the curve's slope there, in arithmetic that processors do
/// for many pixels at once.
#[inline(always)]
pub(crate) fn srgb_encode_with_slope(light: f32) -> (f32, f32) {
    // Light to the power 1 / 2.4 is its fourth root q to the power 5/3, here by Chebyshev's polynomial over
    // the curved part.
    const POWER: [f32; 8] = [
        -0.003_330_25,
        0.118_044_58,
        1.379_970_4,
        -1.078_870_2,
        1.115_958_5,
        -0.820_274_65,
        0.356_715_5,
        -0.068_214_07,
    ];
    let inside = light.clamp(0.0, 1.0);
    let curved_light = inside.max(NEARLY_BLACK);
    let root = curved_light.sqrt().sqrt();
    let power = POWER.iter().rev().fold(0.0, |sum, coefficient| sum * root + coefficient);
    let curved = (1.055 * power - 0.055, (1.055 / 2.4) * power / curved_light);
    if inside <= NEARLY_BLACK { (STEEPEST * inside, STEEPEST) } else { curved }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_curve_is_the_standards(light in 0.0f32..=1.0) {
            let exact = match f64::from(light) {
                dark if dark <= 0.003_130_8 => 12.92 * dark,
                light => 1.055 * light.powf(1.0 / 2.4) - 0.055,
            };
            prop_assert!((f64::from(srgb_encode(light)) - exact).abs() < 1e-6);
            let (_, slope) = srgb_encode_with_slope(light);
            let difference = (srgb_encode((light + 1e-3).min(1.0)) - srgb_encode(light - 1e-3)) / 2e-3;
            prop_assert!(!(0.01..=0.99).contains(&light) || (slope / difference - 1.0).abs() < 0.02);
        }

        #[test]
        fn encoding_undoes_decoding(code in 0.0f32..=1.0) {
            prop_assert!((srgb_encode(srgb_decode(code)) - code).abs() < 1e-5);
        }
    }
}
