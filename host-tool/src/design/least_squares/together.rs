//! All rows at once, where views, smoothness or structure tie one to the next.

use rayon::prelude::*;

use super::kernel::{Answers, Momentum, RowSteps, add_smoothness, step_row};
use super::{Effort, LAPLACIAN, LEAST_CURVATURE, PATIENCE, Problem, SolverView};
use crate::design::structure::Structure;
use crate::simd::vectorised;

/// Iterations between two renewals of the voxels' steps, where they follow the pictures.
const STEP_RENEWAL: usize = 8;

/// Rows of a picture that one task computes.
const ROWS_AT_ONCE: usize = 16;

/// Lowers the loss; see [`Problem::solve`].
pub(super) fn solve(
    problem: &Problem,
    targets: &[&[f32]],
    volume: &mut [f32],
    effort: Effort,
    watch: &mut dyn FnMut(usize, f64) -> bool,
) {
    let mut ahead = volume.to_vec();
    let mut answers: Vec<ViewAnswer> = problem.views.iter().zip(targets).map(|(view, target)| ViewAnswer::new(problem, view, target)).collect();
    let mut steps = Steps::OfFilm(problem.film_steps());
    let mut momentum = Momentum::START;
    let mut last_loss = f64::INFINITY;
    for iteration in 0..effort.iterations {
        let mut loss = 0.0;
        for ((view, target), answer) in problem.views.iter().zip(targets).zip(&mut answers) {
            loss += answer.renew(problem, view, target, &ahead);
        }
        if problem.curvature_varies() && iteration % STEP_RENEWAL == 0 {
            steps = Steps::OfVoxel(problem.voxel_steps(&answers, steps));
        }
        if !watch(iteration, loss) {
            return;
        }
        if iteration % PATIENCE == 0 {
            if last_loss - loss < effort.tolerance * loss {
                return;
            }
            last_loss = loss;
        }
        let (pull, next) = momentum.next();
        let overshoot = problem.advance(&answers, &steps, pull, volume, &mut ahead);
        momentum = next.unless_turned_back(overshoot);
    }
}

/// How far to go along the gradient.
enum Steps {
    OfFilm(Vec<f32>),
    OfVoxel(Vec<f32>),
}

impl Problem {
    /// Takes one step from `ahead` and looks ahead again; returns how much the step turned back.
    fn advance(
        &self,
        answers: &[ViewAnswer],
        steps: &Steps,
        pull: f32,
        volume: &mut [f32],
        ahead: &mut [f32],
    ) -> f64 {
        let size = self.width * self.height;
        let films = volume.par_chunks_mut(size).zip(ahead.par_chunks_mut(size)).enumerate();
        let overshoots: Vec<f64> = films
            .map(|(film, (now, ahead))| {
                vectorised(
                    #[inline(always)]
                    || self.advance_film(film, answers, steps, pull, now, ahead),
                )
            })
            .collect();
        overshoots.iter().sum()
    }

    #[inline(always)]
    fn advance_film(
        &self,
        film: usize,
        answers: &[ViewAnswer],
        steps: &Steps,
        pull: f32,
        now: &mut [f32],
        ahead: &mut [f32],
    ) -> f64 {
        let width = self.width;
        let mut gradient = vec![0.0; width];
        let mut scratch = vec![0.0; width];
        // The row above as it was before this step, and this row likewise.
        let mut above = vec![0.0; width];
        let mut here = vec![0.0; width];
        let mut overshoot = 0.0;
        for row in 0..self.height {
            let line = row * width..(row + 1) * width;
            gradient.fill(0.0);
            for (view, answer) in self.views.iter().zip(answers) {
                let weight = view.film_weights[film];
                view.rays.back_project_row(film, row, &answer.slopes, weight, &mut gradient, &mut scratch);
            }
            if self.smoothness[film] > 0.0 {
                here.copy_from_slice(&ahead[line.clone()]);
                let below = (row + 1 < self.height).then(|| &ahead[line.end..line.end + width]);
                let above_row = (row > 0).then_some(&above[..]);
                add_smoothness(self.smoothness[film], above_row, &here, below, &mut gradient);
                std::mem::swap(&mut above, &mut here);
            }
            let row_steps = match steps {
                Steps::OfFilm(steps) => RowSteps::Even(steps[film]),
                Steps::OfVoxel(all) => {
                    let start = film * width * self.height;
                    RowSteps::Each(&all[start + line.start..start + line.end])
                }
            };
            overshoot += step_row(&mut now[line.clone()], &mut ahead[line], &mut gradient, row_steps, pull);
        }
        overshoot
    }

    /// Steps where the curvature differs from pixel to pixel; `old` gives its memory.
    fn voxel_steps(&self, answers: &[ViewAnswer], old: Steps) -> Vec<f32> {
        let size = self.width * self.height;
        let mut steps = match old {
            Steps::OfVoxel(steps) => steps,
            Steps::OfFilm(_) => vec![0.0; size * self.films()],
        };
        steps.par_chunks_mut(size).enumerate().for_each(|(film, plane)| {
            vectorised(
                #[inline(always)]
                || self.film_voxel_steps(film, answers, plane),
            );
        });
        steps
    }

    #[inline(always)]
    fn film_voxel_steps(&self, film: usize, answers: &[ViewAnswer], plane: &mut [f32]) {
        let mut scratch = vec![0.0; self.width];
        for (row, line) in plane.chunks_mut(self.width).enumerate() {
            line.fill(LAPLACIAN * self.smoothness[film]);
            for (view, answer) in self.views.iter().zip(answers) {
                let weight = view.film_weights[film] * view.row_sum();
                view.rays.back_project_row(film, row, &answer.curvatures, weight, line, &mut scratch);
            }
            line.iter_mut().for_each(|value| *value = 1.0 / value.max(LEAST_CURVATURE));
        }
    }
}

/// The answer to what one view shows, pixel by pixel.
struct ViewAnswer {
    /// Half the slope of the loss with what the pixel shows, times the view's weight.
    slopes: Vec<f32>,
    /// A bound of half the loss's curvature, times the view's weight.
    curvatures: Vec<f32>,
    /// The error in the values in which it is measured.
    errors: Vec<f32>,
    structure: Option<Structure>,
}

impl ViewAnswer {
    fn new(problem: &Problem, view: &SolverView, target: &[f32]) -> Self {
        let structure = (problem.structure > 0.0).then(|| {
            let measured: Vec<f32> = target.iter().map(|&value| problem.divergence.measured(value)).collect();
            Structure::of(&measured, problem.width, problem.structure, view.mask.as_deref())
        });
        let blank = vec![0.0; target.len()];
        Self { slopes: blank.clone(), curvatures: blank.clone(), errors: blank, structure }
    }

    /// Looks at the films and answers; returns the view's loss.
    fn renew(&mut self, problem: &Problem, view: &SolverView, target: &[f32], films: &[f32]) -> f64 {
        let size = problem.width * ROWS_AT_ONCE;
        let losses: Vec<f64> = self
            .slopes
            .par_chunks_mut(size)
            .zip(self.curvatures.par_chunks_mut(size))
            .zip(self.errors.par_chunks_mut(size))
            .zip(target.par_chunks(size))
            .enumerate()
            .map(|(chunk, (((slopes, curvatures), errors), target))| {
                let mut scratch = vec![0.0; problem.width];
                vectorised(
                    #[inline(always)]
                    || {
                        slopes.fill(0.0);
                        for (row, line) in slopes.chunks_mut(problem.width).enumerate() {
                            let row = chunk * ROWS_AT_ONCE + row;
                            view.rays.project_row(row, films, &view.film_weights, line, &mut scratch);
                        }
                        let mut answers = Answers { slopes, errors, curvatures };
                        answers.renew(view, problem, chunk * size, target)
                    },
                )
            })
            .collect();
        let mut loss: f64 = losses.iter().sum();
        if let Some(structure) = &mut self.structure {
            loss += structure.answer(&mut self.errors, &mut self.curvatures) * f64::from(view.weight);
        }
        self.slopes.par_chunks_mut(size).zip(self.errors.par_chunks(size)).for_each(|(slopes, errors)| {
            slopes.iter_mut().zip(errors).for_each(|(slope, error)| *slope *= error);
        });
        loss
    }
}
