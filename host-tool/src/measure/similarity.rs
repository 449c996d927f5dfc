//! Structural similarity (Wang et al. 2004) with the settings of scikit-image's
//! `structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)`.

use rayon::prelude::*;

use crate::picture::Picture;
use crate::volume::CHANNELS;

const SIGMA: f64 = 1.5;
/// The window is cut at 3.5 sigma: 11 x 11 pixels.
const RADIUS: usize = 5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Returns the structural similarity of two pictures in 0..=1, mean over channels; pictures smaller than
/// the window of 11 x 11 pixels have none, 0.
pub fn structural_similarity(picture: &Picture, pattern: &Picture) -> f64 {
    let (width, height) = (picture.width(), picture.height());
    if width <= 2 * RADIUS || height <= 2 * RADIUS {
        return 0.0;
    }
    let kernel = window();
    let inner_rows = height - 2 * RADIUS;
    let inner_columns = width - 2 * RADIUS;
    let rows: Vec<f64> = (0..CHANNELS * inner_rows)
        .into_par_iter()
        .map_init(
            || [(); 5].map(|()| vec![0.0f64; width]),
            |moments, index| {
                let (channel, row) = (index / inner_rows, index % inner_rows);
                let (a, b) = (picture.channel(channel), pattern.channel(channel));
                for moment in moments.iter_mut() {
                    moment.fill(0.0);
                }
                for (tap, weight) in kernel.iter().enumerate() {
                    let line = (row + tap) * width..(row + tap + 1) * width;
                    add_moments(moments, &a[line.clone()], &b[line], *weight);
                }
                row_similarity(moments, &kernel)
            },
        )
        .collect();
    rows.iter().sum::<f64>() / (CHANNELS * inner_rows * inner_columns) as f64
}

fn window() -> [f64; 2 * RADIUS + 1] {
    let mut kernel = [0.0; 2 * RADIUS + 1];
    for (tap, weight) in kernel.iter_mut().enumerate() {
        let distance = tap as f64 - RADIUS as f64;
        *weight = (-0.5 * distance * distance / (SIGMA * SIGMA)).exp();
    }
    let sum: f64 = kernel.iter().sum();
    kernel.map(|weight| weight / sum)
}

fn add_moments(moments: &mut [Vec<f64>; 5], a: &[f32], b: &[f32], weight: f64) {
    let [first, second, aa, bb, ab] = moments;
    for (i, (&x, &y)) in a.iter().zip(b).enumerate() {
        let (x, y) = (f64::from(x), f64::from(y));
        first[i] += weight * x;
        second[i] += weight * y;
        aa[i] += weight * x * x;
        bb[i] += weight * y * y;
        ab[i] += weight * x * y;
    }
}

fn row_similarity(moments: &[Vec<f64>; 5], kernel: &[f64]) -> f64 {
    let inner = moments[0].len() - 2 * RADIUS;
    (0..inner)
        .map(|column| {
            let smooth = |moment: &Vec<f64>| -> f64 {
                moment[column..column + kernel.len()]
                    .iter()
                    .zip(kernel)
                    .map(|(value, weight)| value * weight)
                    .sum()
            };
            let [ux, uy, uxx, uyy, uxy] = [0, 1, 2, 3, 4].map(|index| smooth(&moments[index]));
            let (vx, vy, vxy) = (uxx - ux * ux, uyy - uy * uy, uxy - ux * uy);
            ((2.0 * ux * uy + C1) * (2.0 * vxy + C2)) / ((ux * ux + uy * uy + C1) * (vx + vy + C2))
        })
        .sum()
}
