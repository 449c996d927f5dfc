//! The part of the loss that looks at structure: errors that vary within a few pixels, the more so where the
//! pattern is smooth and every speck shows. It stands for what SSIM sees and a squared error does not.
//!
//! With H the difference from the local mean and w a weight per pixel in 0..=1, it is
//! `strength * |sqrt(w) H e|^2` of the error e.

use rayon::prelude::*;

use crate::simd::vectorised;

/// Half the side of the window over which the local mean is taken.
const RADIUS: usize = 3;

/// Local variance of the pattern at which the weight is a half.
const HALF_VARIANCE: f32 = 0.003;

/// Rows of a picture that one task computes.
const ROWS_AT_ONCE: usize = 16;

/// The structure weights of one pattern.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    width: usize,
    strength: f32,
    /// Weight of each pixel's squared error itself, where it is not 1.
    mask: Option<Vec<f32>>,
    weights: Vec<f32>,
}

/// The memory in which errors of pictures of one size are looked at.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    rough: Vec<f32>,
    mean: LocalMean,
}

impl Scratch {
    /// Memory for pictures of `len` pixels in rows of `width`.
    pub(super) fn new(len: usize, width: usize) -> Self {
        Self { rough: vec![0.0; len], mean: LocalMean::new(len, width) }
    }
}

impl Structure {
    /// Weighs the structure of a pattern in the values in which errors are measured; where there is a mask,
    /// each pixel's errors count by it.
    pub(super) fn of(pattern: &[f32], width: usize, strength: f32, mask: Option<&[f32]>) -> Self {
        let mut local = LocalMean::new(pattern.len(), width);
        let squares: Vec<f32> = pattern.iter().map(|value| value * value).collect();
        let mean_square = local.of(&squares).to_vec();
        let mean = local.of(pattern);
        let weight =
            |(mean, square): (&f32, &f32)| HALF_VARIANCE / (HALF_VARIANCE + (square - mean * mean).max(0.0));
        let mut weights: Vec<f32> = mean.iter().zip(&mean_square).map(weight).collect();
        if let Some(mask) = mask {
            weights.iter_mut().zip(mask).for_each(|(weight, mask)| *weight *= mask);
        }
        let mask = mask.map(<[f32]>::to_vec);
        Self { width, strength, mask, weights }
    }

    /// As [`Structure::answer`], for the errors of row `row` and means along it alone, without a mask.
    #[inline(always)]
    pub(super) fn answer_row(&self, row: usize, errors: &mut [f32], scratch: &mut RowScratch) -> f64 {
        let RowScratch { rough, sums } = scratch;
        let share = 1.0 / (2 * RADIUS + 1) as f32;
        let weights = &self.weights[row * self.width..(row + 1) * self.width];
        sum_across(sums, errors);
        sums.iter_mut().for_each(|sum| *sum *= share);
        let loss = roughness(rough, sums, errors, weights);
        sum_across(sums, rough);
        for ((error, rough), sum) in errors.iter_mut().zip(rough).zip(sums) {
            *error += self.strength * (*rough - share * *sum);
        }
        f64::from(self.strength) * loss
    }

    /// Turns each error into its half slope in the squared error and the structure loss together, and adds to
    /// each curvature that of this loss in proportion; returns the structure loss.
    pub(super) fn answer(&self, errors: &mut [f32], curvatures: &mut [f32], scratch: &mut Scratch) -> f64 {
        let size = self.width * ROWS_AT_ONCE;
        let means = scratch.mean.of(errors);
        let rough = scratch.rough.par_chunks_mut(size).zip(means.par_chunks(size));
        let losses: Vec<f64> = rough
            .zip(errors.par_chunks(size).zip(self.weights.par_chunks(size)))
            .map(|((rough, means), (errors, weights))| {
                vectorised(
                    #[inline(always)]
                    || roughness(rough, means, errors, weights),
                )
            })
            .collect();
        if let Some(mask) = &self.mask {
            errors.iter_mut().zip(mask).for_each(|(error, mask)| *error *= mask);
        }
        let back = scratch.mean.of(&scratch.rough);
        let strength = self.strength;
        let pixels = errors.par_chunks_mut(size).zip(curvatures.par_chunks_mut(size));
        let rough = scratch.rough.par_chunks(size).zip(back.par_chunks(size));
        pixels.zip(rough).zip(self.weights.par_chunks(size)).for_each(
            |(((errors, curvatures), (rough, back)), weights)| {
                for ((error, &rough), &back) in errors.iter_mut().zip(rough).zip(back) {
                    *error += strength * (rough - back);
                }
                for (curvature, &weight) in curvatures.iter_mut().zip(weights) {
                    *curvature *= 1.0 + strength * weight;
                }
            },
        );
        f64::from(strength) * losses.iter().sum::<f64>()
    }
}

/// The memory in which errors of one row are looked at.
#[derive(Clone, Debug)]
pub(super) struct RowScratch {
    rough: Vec<f32>,
    sums: Vec<f32>,
}

impl RowScratch {
    /// Memory for rows of `width` pixels.
    pub(super) fn new(width: usize) -> Self {
        Self { rough: vec![0.0; width], sums: vec![0.0; width] }
    }
}

/// Writes the weighted differences from the local means; returns the sum of their weighted squares.
#[inline(always)]
fn roughness(rough: &mut [f32], means: &[f32], errors: &[f32], weights: &[f32]) -> f64 {
    let mut lanes = [0.0f32; 8];
    let groups = rough.chunks_mut(8).zip(means.chunks(8)).zip(errors.chunks(8)).zip(weights.chunks(8));
    for (((rough, means), errors), weights) in groups {
        let pixels = rough.iter_mut().zip(means).zip(errors).zip(weights).zip(&mut lanes);
        for ((((rough, mean), error), weight), lane) in pixels {
            let difference = error - mean;
            *rough = weight * difference;
            *lane += *rough * difference;
        }
    }
    f64::from(lanes.iter().sum::<f32>())
}

/// Means over a square window; what lies beyond the edge counts as 0, so that the map is its own transpose.
#[derive(Clone, Debug)]
struct LocalMean {
    width: usize,
    across: Vec<f32>,
    mean: Vec<f32>,
}

impl LocalMean {
    fn new(len: usize, width: usize) -> Self {
        Self { width, across: vec![0.0; len], mean: vec![0.0; len] }
    }

    fn of(&mut self, values: &[f32]) -> &[f32] {
        let (width, height) = (self.width, values.len() / self.width);
        let size = width * ROWS_AT_ONCE;
        self.across.par_chunks_mut(size).zip(values.par_chunks(size)).for_each(|(targets, sources)| {
            vectorised(
                #[inline(always)]
                || {
                    for (target, source) in targets.chunks_mut(width).zip(sources.chunks(width)) {
                        sum_across(target, source);
                    }
                },
            );
        });
        let across = &self.across;
        self.mean.par_chunks_mut(size).enumerate().for_each(|(chunk, targets)| {
            vectorised(
                #[inline(always)]
                || {
                    for (row, target) in targets.chunks_mut(width).enumerate() {
                        let row = chunk * ROWS_AT_ONCE + row;
                        let near = row.saturating_sub(RADIUS)..(row + RADIUS + 1).min(height);
                        mean_down(target, &across[near.start * width..near.end * width]);
                    }
                },
            );
        });
        &self.mean
    }
}

#[inline(always)]
fn sum_across(target: &mut [f32], source: &[f32]) {
    target.copy_from_slice(source);
    for shift in 1..=RADIUS.min(source.len() - 1) {
        target[shift..].iter_mut().zip(source).for_each(|(sum, value)| *sum += value);
        target.iter_mut().zip(&source[shift..]).for_each(|(sum, value)| *sum += value);
    }
}

#[inline(always)]
fn mean_down(target: &mut [f32], rows: &[f32]) {
    let share = 1.0 / ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as f32;
    target.fill(0.0);
    for row in rows.chunks_exact(target.len()) {
        target.iter_mut().zip(row).for_each(|(value, &sum)| *value += sum);
    }
    target.iter_mut().for_each(|value| *value *= share);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The structure loss by its definition.
    fn loss(structure: &Structure, errors: &[f32]) -> f64 {
        let mut local = LocalMean::new(errors.len(), structure.width);
        let mean = local.of(errors);
        let squares =
            errors.iter().zip(mean).zip(&structure.weights).map(|((e, m), w)| w * (e - m) * (e - m));
        f64::from(structure.strength * squares.sum::<f32>())
    }

    #[test]
    fn the_answer_is_the_slope_of_the_loss() {
        let value = |index: usize, factor: usize| (index * factor % 23) as f32 / 23.0;
        let pattern: Vec<f32> = (0..12 * 15).map(|index| value(index, 7)).collect();
        let structure = Structure::of(&pattern, 12, 2.0, None);
        let mut scratch = Scratch::new(pattern.len(), 12);
        let errors: Vec<f32> = (0..12 * 15).map(|index| value(index, 5) - 0.5).collect();
        let mut answer = errors.clone();
        let reported = structure.answer(&mut answer, &mut vec![1.0; errors.len()], &mut scratch);
        assert!((reported - loss(&structure, &errors)).abs() < 1e-4);
        for at in [0, 17, 100, 179] {
            let mut moved = [errors.clone(), errors.clone()];
            moved[0][at] -= 0.05;
            moved[1][at] += 0.05;
            let slope = (loss(&structure, &moved[1]) - loss(&structure, &moved[0])) / 0.1;
            let half = f64::from(answer[at] - errors[at]);
            assert!((slope / 2.0 - half).abs() < 1e-3, "{at}: {slope} {half}");
        }
    }
}
