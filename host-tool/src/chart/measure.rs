//! What patches give in a photograph.

use super::{Chart, Found, Patch};
use crate::picture::Picture;
use crate::volume::CHANNELS;

/// The inner part of a patch that is measured, along each side: its rim is blurred.
const INNER: f64 = 0.6;
/// Points along each side at which a patch is measured.
const POINTS: std::ops::RangeInclusive<f64> = 5.0..=40.0;
/// Light above which the camera may have had more than it could hold.
const CLIPPED: f32 = 0.985;

/// What a patch gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The patch, as the chart has it.
    pub patch: Patch,
    /// Mean light in each channel of the photograph, 0..=1.
    pub light: [f64; CHANNELS],
    /// The part of the patch where a channel is at its end.
    pub clipped: [f64; CHANNELS],
}

/// Measures all patches of `chart` where it was `found` in `light`, a photograph in linear light.
pub fn read_patches(light: &Picture, chart: &Chart, found: &Found) -> Vec<Reading> {
    chart.patches.iter().map(|patch| read(light, patch, found)).collect()
}

fn read(light: &Picture, patch: &Patch, found: &Found) -> Reading {
    let points = (found.pixels_per_mm * patch.size_mm * INNER).ceil().clamp(*POINTS.start(), *POINTS.end());
    let count = points as usize;
    let place = |index: usize| ((index as f64 + 0.5) / points - 0.5) * INNER * patch.size_mm;
    let (mut sum, mut clipped) = ([0.0; CHANNELS], [0.0; CHANNELS]);
    for row in 0..count {
        for column in 0..count {
            let at = found.perspective.apply([patch.x_mm + place(column), patch.y_mm + place(row)]);
            for channel in 0..CHANNELS {
                let value = sample(light, channel, at);
                sum[channel] += f64::from(value);
                clipped[channel] += f64::from(u8::from(value > CLIPPED));
            }
        }
    }
    let mean = |sum: [f64; CHANNELS]| sum.map(|sum| sum / (count * count) as f64);
    Reading { patch: *patch, light: mean(sum), clipped: mean(clipped) }
}

/// The value at (x, y), where (0, 0) is the middle of the first pixel, interpolated linearly; at the rim, the nearest.
pub(super) fn sample(picture: &Picture, channel: usize, [x, y]: [f64; 2]) -> f32 {
    let along = |at: f64, count: usize| {
        let at = at.clamp(0.0, count as f64 - 1.0);
        (at as usize, (at as usize + 1).min(count - 1), at.fract() as f32)
    };
    let (left, right, beside) = along(x, picture.width());
    let (top, bottom, below) = along(y, picture.height());
    let values = picture.channel(channel);
    let row = |row: usize| {
        let line = row * picture.width();
        values[line + left] * (1.0 - beside) + values[line + right] * beside
    };
    row(top) * (1.0 - below) + row(bottom) * below
}
