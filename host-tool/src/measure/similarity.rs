//! Structural similarity (Wang et al. 2004) with the settings of scikit-image's
//! `structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)`.

use rayon::prelude::*;

use crate::picture::Picture;
use crate::simd::vectorised;
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
            || Moments::new(width),
            |moments, index| {
                let (channel, row) = (index / inner_rows, index % inner_rows);
                let lines = row * width..(row + kernel.len()) * width;
                let (a, b) = (&picture.channel(channel)[lines.clone()], &pattern.channel(channel)[lines]);
                vectorised(
                    #[inline(always)]
                    || moments.row_similarity(a, b, &kernel),
                )
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

/// Weighted sums of two rows of pixels a and b: of a, b, a², b² and ab.
struct Moments {
    down: [Vec<f64>; 5],
    whole: [Vec<f64>; 5],
}

impl Moments {
    fn new(width: usize) -> Self {
        let down = [(); 5].map(|()| vec![0.0; width]);
        let whole = [(); 5].map(|()| vec![0.0; width - 2 * RADIUS]);
        Self { down, whole }
    }

    /// Returns the sum of the similarities along one row, of which `a` and `b` are the lines within the window.
    #[inline(always)]
    fn row_similarity(&mut self, a: &[f32], b: &[f32], kernel: &[f64]) -> f64 {
        let width = self.down[0].len();
        self.down.iter_mut().for_each(|moment| moment.fill(0.0));
        for ((a, b), &weight) in a.chunks_exact(width).zip(b.chunks_exact(width)).zip(kernel) {
            self.add(a, b, weight);
        }
        for (whole, down) in self.whole.iter_mut().zip(&self.down) {
            whole.fill(0.0);
            for (tap, weight) in kernel.iter().enumerate() {
                whole.iter_mut().zip(&down[tap..]).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        let [first, second, aa, bb, ab] = &self.whole;
        let mut lanes = [0.0; 4];
        let groups =
            first.chunks(4).zip(second.chunks(4)).zip(aa.chunks(4)).zip(bb.chunks(4)).zip(ab.chunks(4));
        for ((((first, second), aa), bb), ab) in groups {
            let pixels = lanes.iter_mut().zip(first).zip(second).zip(aa).zip(bb).zip(ab);
            for (((((lane, ux), uy), uxx), uyy), uxy) in pixels {
                let (vx, vy, vxy) = (uxx - ux * ux, uyy - uy * uy, uxy - ux * uy);
                *lane +=
                    ((2.0 * ux * uy + C1) * (2.0 * vxy + C2)) / ((ux * ux + uy * uy + C1) * (vx + vy + C2));
            }
        }
        lanes.iter().sum()
    }

    #[inline(always)]
    fn add(&mut self, a: &[f32], b: &[f32], weight: f64) {
        let [first, second, aa, bb, ab] = &mut self.down;
        let sums = first.iter_mut().zip(second).zip(aa).zip(bb).zip(ab);
        for (((((first, second), aa), bb), ab), (&x, &y)) in sums.zip(a.iter().zip(b)) {
            let (x, y) = (f64::from(x), f64::from(y));
            let (wx, wy) = (weight * x, weight * y);
            *first += wx;
            *second += wy;
            *aa += wx * x;
            *bb += wy * y;
            *ab += wx * y;
        }
    }
}
