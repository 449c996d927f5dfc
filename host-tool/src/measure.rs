//! Measures of quality: how well a projection shows its pattern, and at what cost in light.

mod percentiles;
mod similarity;
mod sums;

use rayon::prelude::*;

use crate::design::Tone;
use crate::picture::{Picture, srgb_encode};
use crate::volume::Volume;

pub use percentiles::percentiles;
pub use similarity::structural_similarity;
use sums::sums;

/// How well one projection shows its pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// The gain that fits the projection to the pattern.
    pub gain: f64,
    /// Peak signal-to-noise ratio over all pixels and channels, in dB.
    pub psnr_db: f64,
    /// Structural similarity, mean over channels.
    pub ssim: f64,
    /// Brightness: the 99.5th percentile of the projection, as a part of what the volume's brightest ink
    /// (99.9th percentile) on every film would give.
    pub efficiency: f64,
    /// 99th percentile of the projection's values over its 1st, at most 1000.
    pub contrast: f64,
    /// The largest correlation of what is wrong in this view with another view's pattern, -1..=1.
    pub cross_talk: f64,
}

/// A projection brought to its pattern by one gain.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The gain.
    pub gain: f64,
    /// The projection times the gain, as code values in 0..=1.
    pub picture: Picture,
}

/// Brings a projection to its pattern (code values) by one gain over all channels.
///
/// With code values the gain is the least-squares one, `<P,T>/<P,P>`. In linear light it is the one that
/// makes the encoded pictures agree best, searched around the linear fit.
pub fn fit(projection: &Picture, pattern: &Picture, tone: Tone) -> Fitted {
    match tone {
        Tone::Code => {
            let gain = least_squares_gain(projection.values(), pattern.values());
            Fitted { gain, picture: projection.map(|value| (gain as f32 * value).clamp(0.0, 1.0)) }
        }
        Tone::Linear => {
            let start = least_squares_gain(projection.values(), pattern.decoded().values());
            let gain = best_encoded_gain(projection, pattern, start);
            Fitted { gain, picture: projection.map(|value| srgb_encode(gain as f32 * value)) }
        }
    }
}

/// Returns the gain g that makes `g * values` nearest to `wanted`; 0 when all values are 0.
pub fn least_squares_gain(values: &[f32], wanted: &[f32]) -> f64 {
    let [product, square] = sums(
        values,
        wanted,
        #[inline(always)]
        |value, wanted| {
            let (value, wanted) = (f64::from(value), f64::from(wanted));
            [value * wanted, value * value]
        },
    );
    if square > 0.0 { (product / square).max(0.0) } else { 0.0 }
}

/// Returns the peak signal-to-noise ratio in dB of two pictures in 0..=1, at most 120.
pub fn psnr_db(picture: &Picture, pattern: &Picture) -> f64 {
    let mean = mean_square_error(picture.values(), pattern.values());
    -10.0 * mean.max(1e-12).log10()
}

/// Returns the mean of the squared differences.
pub fn mean_square_error(values: &[f32], wanted: &[f32]) -> f64 {
    let [sum] = sums(
        values,
        wanted,
        #[inline(always)]
        |value, wanted| {
            let error = f64::from(value - wanted);
            [error * error]
        },
    );
    sum / values.len().max(1) as f64
}

/// Measures one view's projection against the patterns (code values) of all views, its own being `own`.
///
/// `full_light` is what the volume's brightest ink on every film would give: see [`brightest_ink`].
pub fn measure(
    projection: &Picture,
    patterns: &[&Picture],
    own: usize,
    tone: Tone,
    full_light: f64,
) -> (Quality, Picture) {
    let pattern = patterns[own];
    let Fitted { gain, picture } = fit(projection, pattern, tone);
    let [bright, light, shade] = percentiles(projection.values(), [99.5, 99.0, 1.0]);
    let contrast = light / shade.max(1e-9);
    let error: Vec<f32> = picture.values().iter().zip(pattern.values()).map(|(a, b)| a - b).collect();
    let others = patterns.iter().enumerate().filter(|(index, _)| *index != own);
    let cross_talk = others
        .map(|(_, other)| correlation(&error, other.values()))
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(0.0);
    let quality = Quality {
        gain,
        psnr_db: psnr_db(&picture, pattern),
        ssim: structural_similarity(&picture, pattern),
        efficiency: if full_light > 0.0 { bright / full_light } else { 0.0 },
        contrast: contrast.min(1000.0),
        cross_talk,
    };
    (quality, picture)
}

/// Returns the 99.9th percentile of a volume's ink, to 1 part in 65,535: its brightest ink, outliers aside.
pub fn brightest_ink(volume: &Volume) -> f64 {
    const FULL: f32 = 65_535.0;
    let none = || vec![0u64; FULL as usize + 1];
    let counts = volume
        .values()
        .par_chunks(1 << 20)
        .fold(none, |mut counts, values| {
            for value in values {
                counts[(value.clamp(0.0, 1.0) * FULL + 0.5) as usize] += 1;
            }
            counts
        })
        .reduce(none, |mut sum, counts| {
            sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            sum
        });
    let wanted = ((volume.values().len() as f64 - 1.0) * 0.999).floor() as u64;
    let mut seen = 0;
    let position = counts.iter().position(|&count| {
        seen += count;
        seen > wanted
    });
    position.unwrap_or(0) as f64 / f64::from(FULL)
}

/// Returns Pearson's correlation of two rows of numbers; 0 when either does not vary.
pub fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let count = a.len().max(1) as f64;
    let [sum_a, sum_b, ab, aa, bb] = sums(
        a,
        b,
        #[inline(always)]
        |x, y| {
            let (x, y) = (f64::from(x), f64::from(y));
            [x, y, x * y, x * x, y * y]
        },
    );
    let (ab, aa, bb) = (ab - sum_a * sum_b / count, aa - sum_a * sum_a / count, bb - sum_b * sum_b / count);
    // What is left of numbers that do not vary is the arithmetic's rounding.
    if aa > 1e-12 * count && bb > 1e-12 * count { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// Values of a picture that tell its gain to four digits.
const GAIN_SAMPLE: usize = 8192;

/// How near the golden section comes to the logarithm of the gain, before a parabola finds the rest of the way.
const GAIN_STEP: f64 = 0.02;

/// Searches the gain on its logarithm, between a fifth and five times the start: by golden section, and then by the
/// parabola through the last three points.
fn best_encoded_gain(projection: &Picture, pattern: &Picture, start: f64) -> f64 {
    if start <= 0.0 {
        return 0.0;
    }
    // An odd stride meets all columns of pictures whose width is even.
    let stride = (projection.values().len() / GAIN_SAMPLE) | 1;
    let sample = |picture: &Picture| picture.values().iter().copied().step_by(stride).collect::<Vec<f32>>();
    let (seen, wanted) = (sample(projection), sample(pattern));
    let error = |logarithm: f64| {
        let gain = logarithm.exp() as f32;
        let [sum] = sums(
            &seen,
            &wanted,
            #[inline(always)]
            |seen, wanted| {
                let error = srgb_encode(gain * seen) - wanted;
                [f64::from(error * error)]
            },
        );
        sum
    };
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = ((start / 5.0).ln(), (start * 5.0).ln());
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut error_left, mut error_right) = (error(left), error(right));
    while high - low > GAIN_STEP {
        if error_left < error_right {
            (high, right, error_right) = (right, left, error_left);
            left = high - golden * (high - low);
            error_left = error(left);
        } else {
            (low, left, error_left) = (left, right, error_right);
            right = low + golden * (high - low);
            error_right = error(right);
        }
    }
    let (middle, half) = (f64::midpoint(low, high), 0.5 * (high - low));
    let [before, here, after] = [middle - half, middle, middle + half].map(error);
    let bend = before - 2.0 * here + after;
    let step = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    (middle + half * step.clamp(-1.0, 1.0)).exp()
}

#[cfg(test)]
mod tests;
