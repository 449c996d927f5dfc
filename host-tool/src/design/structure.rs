//! The part of the loss that looks at structure: errors that vary within a few pixels, the more so where the
//! pattern is smooth and every speck shows. It stands for what SSIM sees and a squared error does not.
//!
//! With H the difference from the local mean and w a weight per pixel in 0..=1, it is
//! `strength * |sqrt(w) H e|^2` of the error e.

use rayon::prelude::*;

/// Half the side of the window over which the local mean is taken.
const RADIUS: usize = 3;

/// Local variance of the pattern at which the weight is a half.
const HALF_VARIANCE: f32 = 0.003;

/// The structure weights of one pattern.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    width: usize,
    strength: f32,
    weights: Vec<f32>,
}

impl Structure {
    /// Weighs the structure of a pattern in the values in which errors are measured.
    pub(super) fn of(pattern: &[f32], width: usize, strength: f32) -> Self {
        let squares: Vec<f32> = pattern.iter().map(|value| value * value).collect();
        let (mean, mean_square) = (local_mean(pattern, width), local_mean(&squares, width));
        let weight =
            |(mean, square): (&f32, &f32)| HALF_VARIANCE / (HALF_VARIANCE + (square - mean * mean).max(0.0));
        Self { width, strength, weights: mean.iter().zip(&mean_square).map(weight).collect() }
    }

    /// Adds to each error its half slope in the structure loss, and to each curvature that of this loss in
    /// proportion; returns the loss.
    pub(super) fn answer(&self, errors: &mut [f32], curvatures: &mut [f32]) -> f64 {
        let mut rough = local_mean(errors, self.width);
        let rows = rough.par_chunks_mut(self.width).zip(errors.par_chunks(self.width));
        let losses: Vec<f64> = rows
            .zip(self.weights.par_chunks(self.width))
            .map(|((rough, errors), weights)| {
                let mut loss = 0.0;
                for ((rough, &error), &weight) in rough.iter_mut().zip(errors).zip(weights) {
                    let difference = error - *rough;
                    *rough = weight * difference;
                    loss += *rough * difference;
                }
                f64::from(loss)
            })
            .collect();
        let back = local_mean(&rough, self.width);
        for ((error, &rough), &back) in errors.iter_mut().zip(&rough).zip(&back) {
            *error += self.strength * (rough - back);
        }
        for (curvature, &weight) in curvatures.iter_mut().zip(&self.weights) {
            *curvature *= 1.0 + self.strength * weight;
        }
        f64::from(self.strength) * losses.iter().sum::<f64>()
    }
}

/// Means over a square window; what lies beyond the edge counts as 0, so that the map is its own transpose.
fn local_mean(values: &[f32], width: usize) -> Vec<f32> {
    let mut across = vec![0.0; values.len()];
    across.par_chunks_mut(width).zip(values.par_chunks(width)).for_each(|(target, source)| {
        target.copy_from_slice(source);
        for shift in 1..=RADIUS.min(width - 1) {
            target[shift..].iter_mut().zip(source).for_each(|(sum, value)| *sum += value);
            target.iter_mut().zip(&source[shift..]).for_each(|(sum, value)| *sum += value);
        }
    });
    let height = values.len() / width;
    let share = 1.0 / ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as f32;
    let mut mean = vec![0.0; values.len()];
    mean.par_chunks_mut(width).enumerate().for_each(|(row, target)| {
        for near in row.saturating_sub(RADIUS)..(row + RADIUS + 1).min(height) {
            for (value, &sum) in target.iter_mut().zip(&across[near * width..(near + 1) * width]) {
                *value += sum;
            }
        }
        target.iter_mut().for_each(|value| *value *= share);
    });
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The structure loss by its definition.
    fn loss(structure: &Structure, errors: &[f32]) -> f64 {
        let mean = local_mean(errors, structure.width);
        let squares =
            errors.iter().zip(&mean).zip(&structure.weights).map(|((e, m), w)| w * (e - m) * (e - m));
        f64::from(structure.strength * squares.sum::<f32>())
    }

    #[test]
    fn the_answer_is_the_slope_of_the_loss() {
        let value = |index: usize, factor: usize| (index * factor % 23) as f32 / 23.0;
        let pattern: Vec<f32> = (0..12 * 15).map(|index| value(index, 7)).collect();
        let structure = Structure::of(&pattern, 12, 2.0);
        let errors: Vec<f32> = (0..12 * 15).map(|index| value(index, 5) - 0.5).collect();
        let mut answer = errors.clone();
        let reported = structure.answer(&mut answer, &mut vec![1.0; errors.len()]);
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
