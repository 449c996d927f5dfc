//! Structural similarity (Wang et al. 2004) with the settings of scikit-image's
//! `structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)`.

use rayon::prelude::*;

use crate::picture::Picture;
use crate::simd::vectorised;
use crate::volume::CHANNELS;

const SIGMA: f64 = 1.5;
/// The window is cut at 3.5 sigma: 11 x 11 pixels.
const RADIUS: usize = 5;
const WINDOW: usize = 2 * RADIUS + 1;
const C1: f32 = 0.01 * 0.01;
const C2: f32 = 0.03 * 0.03;

/// Rows that one task of the thread pool computes: enough to outweigh the rows around them.
const ROWS_AT_ONCE: usize = 32;

/// Returns the structural similarity of two pictures in 0..=1, mean over channels; pictures smaller than
/// the window of 11 x 11 pixels have none, 0.
pub fn structural_similarity(picture: &Picture, pattern: &Picture) -> f64 {
    let (width, height) = (picture.width(), picture.height());
    if width < WINDOW || height < WINDOW {
        return 0.0;
    }
    let kernel = kernel();
    let (inner_rows, inner_columns) = (height - 2 * RADIUS, width - 2 * RADIUS);
    let tasks = inner_rows.div_ceil(ROWS_AT_ONCE);
    let sums: Vec<f64> = (0..CHANNELS * tasks)
        .into_par_iter()
        .map_init(
            || Moments::new(width),
            |moments, index| {
                let (channel, first) = (index / tasks, index % tasks * ROWS_AT_ONCE);
                let rows = ROWS_AT_ONCE.min(inner_rows - first) + 2 * RADIUS;
                let lines = first * width..(first + rows) * width;
                let (a, b) = (&picture.channel(channel)[lines.clone()], &pattern.channel(channel)[lines]);
                vectorised(
                    #[inline(always)]
                    || moments.similarity(a, b, &kernel),
                )
            },
        )
        .collect();
    sums.iter().sum::<f64>() / (CHANNELS * inner_rows * inner_columns) as f64
}

/// The Gaussian's middle weight and those to either side.
fn kernel() -> [f32; RADIUS + 1] {
    let weight = |distance: usize| (-0.5 * (distance as f64 / SIGMA).powi(2)).exp();
    let sum: f64 = 1.0 + (1..=RADIUS).map(|distance| 2.0 * weight(distance)).sum::<f64>();
    std::array::from_fn(|distance| (weight(distance) / sum) as f32)
}

/// Local means of four numbers of two pictures a and b: of a + b - 1, of a - b, and of their squares. They tell all
/// that similarity asks for: `4 ab = (a + b)^2 - (a - b)^2`.
struct Moments {
    /// One row of the numbers.
    row: [Vec<f32>; 4],
    /// Their means along the last rows; row i of the pictures is at i modulo the window.
    across: [[Vec<f32>; 4]; WINDOW],
    /// Their means over the window.
    whole: [Vec<f32>; 4],
}

impl Moments {
    fn new(width: usize) -> Self {
        let four = |len: usize| std::array::from_fn(|_| vec![0.0; len]);
        let inner = width - 2 * RADIUS;
        Self { row: four(width), across: std::array::from_fn(|_| four(inner)), whole: four(inner) }
    }

    /// Returns the sum of the similarities over all windows in these rows of a and b.
    #[inline(always)]
    fn similarity(&mut self, a: &[f32], b: &[f32], kernel: &[f32; RADIUS + 1]) -> f64 {
        let width = self.row[0].len();
        let mut sum = 0.0;
        for (row, (a, b)) in a.chunks_exact(width).zip(b.chunks_exact(width)).enumerate() {
            self.take(row, a, b, kernel);
            if row >= 2 * RADIUS {
                let place = |offset: usize| (row - RADIUS + offset) % WINDOW;
                for (moment, whole) in self.whole.iter_mut().enumerate() {
                    let line = |offset: usize| &*self.across[place(offset)][moment];
                    weigh(whole, kernel, |distance| (line(WINDOW - distance), line(distance)));
                }
                sum += row_similarity(&self.whole);
            }
        }
        sum
    }

    /// Takes the means along one row.
    #[inline(always)]
    fn take(&mut self, row: usize, a: &[f32], b: &[f32], kernel: &[f32; RADIUS + 1]) {
        let [sums, differences, sum_squares, difference_squares] = &mut self.row;
        let squares = sum_squares.iter_mut().zip(difference_squares);
        for (((sum, difference), squares), (a, b)) in
            sums.iter_mut().zip(differences).zip(squares).zip(a.iter().zip(b))
        {
            *sum = a + b - 1.0;
            *difference = a - b;
            *squares.0 = *sum * *sum;
            *squares.1 = *difference * *difference;
        }
        for (across, row) in self.across[row % WINDOW].iter_mut().zip(&self.row) {
            weigh(across, kernel, |distance| (&row[RADIUS - distance..], &row[RADIUS + distance..]));
        }
    }
}

/// Adds up the lines to either side, which `lines` gives by their distance from the middle, by their weights.
#[inline(always)]
fn weigh<'a>(
    target: &mut [f32],
    kernel: &[f32; RADIUS + 1],
    lines: impl Fn(usize) -> (&'a [f32], &'a [f32]),
) {
    target.iter_mut().zip(lines(0).1).for_each(|(sum, value)| *sum = kernel[0] * value);
    for (distance, weight) in kernel.iter().enumerate().skip(1) {
        let (before, after) = lines(distance);
        for ((sum, before), after) in target.iter_mut().zip(before).zip(after) {
            *sum += weight * (before + after);
        }
    }
}

/// Sums the similarities along one row.
#[inline(always)]
fn row_similarity(moments: &[Vec<f32>; 4]) -> f64 {
    let [sums, differences, sum_squares, difference_squares] = moments;
    let mut lanes = [0.0f32; 8];
    let means = sums.chunks(8).zip(differences.chunks(8));
    for ((sums, differences), (sum_squares, difference_squares)) in
        means.zip(sum_squares.chunks(8).zip(difference_squares.chunks(8)))
    {
        let pixels = sums.iter().zip(differences).zip(sum_squares.iter().zip(difference_squares));
        for (lane, ((sum, difference), (sum_square, difference_square))) in lanes.iter_mut().zip(pixels) {
            let sum_variance = sum_square - sum * sum;
            let difference_variance = difference_square - difference * difference;
            let (sum, difference) = ((sum + 1.0) * (sum + 1.0), difference * difference);
            let alike = (sum - difference + 2.0 * C1) * (sum_variance - difference_variance + 2.0 * C2);
            *lane +=
                alike / ((sum + difference + 2.0 * C1) * (sum_variance + difference_variance + 2.0 * C2));
        }
    }
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}
