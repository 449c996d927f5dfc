//! The bounded optimiser: the volume in 0..=1 whose views differ least from their patterns.
//!
//! It minimises, for each colour by itself,
//!
//! ```text
//! sum over views i of  weight_i * |d(P_i, T_i)|^2  +  sum over films k of  smoothness_k * |grad V_k|^2
//! ```
//!
//! where `P_i` is the view's projection divided by its white and `d` compares in the values that are
//! measured (see [`super::divergence`]). The method is the accelerated proximal gradient (Beck and Teboulle
//! 2009) with adaptive restart (O'Donoghue and Candes 2015) and a step of its own for every film or voxel:
//! the inverse of `B^T C B 1` (De Pierro 1995), which bounds the curvature of `|B V|^2` in the weights C
//! because all entries of the projection B are non-negative. No step size is searched.

use rayon::prelude::*;

use super::divergence::Divergence;
use super::structure::Structure;
use crate::projection::Rays;

/// One view as the solver sees it.
#[derive(Clone, Debug)]
pub(super) struct SolverView {
    /// The rays from the films to the picture.
    pub(super) rays: Rays,
    /// The weight of each film divided by the view's white.
    pub(super) film_weights: Vec<f32>,
    /// How much the view's errors count.
    pub(super) weight: f32,
    /// How much each pixel's errors count beside that (row, column), 1 in the mean; `None` where all count alike.
    pub(super) mask: Option<Vec<f32>>,
}

/// The problem of all colours: the views and how smooth each film must be.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) views: Vec<SolverView>,
    /// Of each film: the weight of its squared gradient.
    pub(super) smoothness: Vec<f32>,
    pub(super) divergence: Divergence,
    /// The strength of the structure loss beside the squared error.
    pub(super) structure: f32,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// The most iterations.
    pub(super) iterations: usize,
    /// Stop when ten iterations lower the loss by less than this part of it.
    pub(super) tolerance: f64,
}

/// Iterations between two looks at whether anything is still gained.
const PATIENCE: usize = 10;

/// Iterations between two renewals of the voxels' steps, where they follow the pictures.
const STEP_RENEWAL: usize = 8;

/// Rows of a picture that one task computes.
const ROWS_AT_ONCE: usize = 16;

impl Problem {
    /// Lowers the loss of one colour from where `volume` (film, row, column) is; `targets` are the views'
    /// patterns (row, column). `watch` is told the iteration and the loss, and returns whether to go on.
    pub(super) fn solve(
        &self,
        targets: &[&[f32]],
        volume: &mut [f32],
        effort: Effort,
        watch: &mut dyn FnMut(usize, f64) -> bool,
    ) {
        let mut ahead = volume.to_vec();
        let mut answers: Vec<ViewAnswer> =
            targets.iter().map(|target| ViewAnswer::new(self, target)).collect();
        let mut steps = Steps::OfFilm(self.film_steps());
        let mut momentum = 1.0f64;
        let mut last_loss = f64::INFINITY;
        for iteration in 0..effort.iterations {
            let mut loss = 0.0;
            for ((view, target), answer) in self.views.iter().zip(targets).zip(&mut answers) {
                loss += answer.renew(self, view, target, &ahead);
            }
            if self.curvature_varies() && iteration % STEP_RENEWAL == 0 {
                steps = Steps::OfVoxel(self.voxel_steps(&answers, steps));
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
            let next = (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt()) / 2.0;
            let pull = ((momentum - 1.0) / next) as f32;
            let overshoot = self.advance(&answers, &steps, pull, volume, &mut ahead);
            momentum = if overshoot > 0.0 { 1.0 } else { next };
        }
    }

    fn curvature_varies(&self) -> bool {
        self.divergence.varies() || self.structure > 0.0
    }

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
            .map(|(film, (now, ahead))| self.advance_film(film, answers, steps, pull, now, ahead))
            .collect();
        overshoots.iter().sum()
    }

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
        let mut row_steps = match steps {
            Steps::OfFilm(steps) => vec![steps[film]; width],
            Steps::OfVoxel(_) => vec![0.0; width],
        };
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
            if let Steps::OfVoxel(all) = steps {
                let start = film * width * self.height;
                row_steps.copy_from_slice(&all[start + line.start..start + line.end]);
            }
            overshoot += step_row(&mut now[line.clone()], &mut ahead[line], &mut gradient, &row_steps, pull);
        }
        overshoot
    }

    /// Steps of the films where every pixel's curvature is 1.
    fn film_steps(&self) -> Vec<f32> {
        let step = |film: usize| {
            let views = self.views.iter().map(|view| view.weight * view.film_weights[film] * view.row_sum());
            1.0 / (views.sum::<f32>() + LAPLACIAN * self.smoothness[film]).max(f32::MIN_POSITIVE)
        };
        (0..self.smoothness.len()).map(step).collect()
    }

    /// Steps where the curvature differs from pixel to pixel; `old` gives its memory.
    fn voxel_steps(&self, answers: &[ViewAnswer], old: Steps) -> Vec<f32> {
        let size = self.width * self.height;
        let mut steps = match old {
            Steps::OfVoxel(steps) => steps,
            Steps::OfFilm(_) => vec![0.0; size * self.smoothness.len()],
        };
        steps.par_chunks_mut(size).enumerate().for_each(|(film, plane)| {
            let mut scratch = vec![0.0; self.width];
            for (row, line) in plane.chunks_mut(self.width).enumerate() {
                line.fill(LAPLACIAN * self.smoothness[film]);
                for (view, answer) in self.views.iter().zip(answers) {
                    let weight = view.film_weights[film] * view.row_sum();
                    view.rays.back_project_row(film, row, &answer.curvatures, weight, line, &mut scratch);
                }
                line.iter_mut().for_each(|value| *value = 1.0 / value.max(LEAST_CURVATURE));
            }
        });
        steps
    }
}

/// The largest eigenvalue of the five-point Laplacian, by which the squared gradient bends.
const LAPLACIAN: f32 = 8.0;

/// Voxels that no view sees have no curvature: this bounds their step, which nothing drives.
const LEAST_CURVATURE: f32 = 1e-3;

/// How far to go along the gradient.
enum Steps {
    OfFilm(Vec<f32>),
    OfVoxel(Vec<f32>),
}

impl SolverView {
    /// What full ink on every film would show.
    fn row_sum(&self) -> f32 {
        self.film_weights.iter().sum()
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
    fn new(problem: &Problem, target: &[f32]) -> Self {
        let structure = (problem.structure > 0.0).then(|| {
            let measured: Vec<f32> = target.iter().map(|&value| problem.divergence.measured(value)).collect();
            Structure::of(&measured, problem.width, problem.structure)
        });
        let blank = vec![0.0; target.len()];
        Self { slopes: blank.clone(), curvatures: blank.clone(), errors: blank, structure }
    }

    /// Looks at the films and answers; returns the view's loss.
    fn renew(&mut self, problem: &Problem, view: &SolverView, target: &[f32], films: &[f32]) -> f64 {
        let rows = problem.width * ROWS_AT_ONCE;
        let losses: Vec<f64> = self
            .slopes
            .par_chunks_mut(rows)
            .zip(self.curvatures.par_chunks_mut(rows))
            .zip(self.errors.par_chunks_mut(rows))
            .zip(target.par_chunks(rows))
            .enumerate()
            .map(|(chunk, (((slopes, curvatures), errors), target))| {
                let mut scratch = vec![0.0; problem.width];
                slopes.fill(0.0);
                for (row, line) in slopes.chunks_mut(problem.width).enumerate() {
                    let row = chunk * ROWS_AT_ONCE + row;
                    view.rays.project_row(row, films, &view.film_weights, line, &mut scratch);
                }
                let loss = answer_rows(problem, view.weight, slopes, target, errors, curvatures);
                match &view.mask {
                    Some(mask) => loss_masked(&mask[chunk * rows..], view.weight, slopes, errors, curvatures),
                    None => loss,
                }
            })
            .collect();
        let mut loss: f64 = losses.iter().sum();
        if let Some(structure) = &self.structure {
            loss += structure.answer(&mut self.errors, &mut self.curvatures) * f64::from(view.weight);
        }
        self.slopes.par_iter_mut().zip(&self.errors).for_each(|(slope, error)| *slope *= error);
        loss
    }
}

/// Turns what pixels show, in `shown`, into how steeply the measured value rises with it.
fn answer_rows(
    problem: &Problem,
    weight: f32,
    shown: &mut [f32],
    target: &[f32],
    errors: &mut [f32],
    curvatures: &mut [f32],
) -> f64 {
    let mut loss = 0.0;
    for (((shown, &wanted), error), curvature) in shown.iter_mut().zip(target).zip(errors).zip(curvatures) {
        let answer = problem.divergence.answer(*shown, wanted);
        loss += answer.error * answer.error;
        *error = answer.error;
        *shown = weight * answer.slope;
        *curvature = weight * answer.curvature;
    }
    f64::from(weight * loss)
}

/// Weighs each pixel's answer by the view's mask; returns the loss.
fn loss_masked(mask: &[f32], weight: f32, slopes: &mut [f32], errors: &[f32], curvatures: &mut [f32]) -> f64 {
    let mut loss = 0.0;
    for (((slope, curvature), &error), &mask) in slopes.iter_mut().zip(curvatures).zip(errors).zip(mask) {
        *slope *= mask;
        *curvature *= mask;
        loss += mask * error * error;
    }
    f64::from(weight * loss)
}

/// Adds the half slope of `smoothness * |grad|^2` in one row; beyond the film's edge nothing changes.
fn add_smoothness(
    smoothness: f32,
    above: Option<&[f32]>,
    here: &[f32],
    below: Option<&[f32]>,
    gradient: &mut [f32],
) {
    for neighbours in [above, below].into_iter().flatten() {
        for ((gradient, &value), &neighbour) in gradient.iter_mut().zip(here).zip(neighbours) {
            *gradient += smoothness * (value - neighbour);
        }
    }
    let last = here.len() - 1;
    for ((gradient, &value), &right) in gradient[..last].iter_mut().zip(here).zip(&here[1..]) {
        *gradient += smoothness * (value - right);
    }
    for ((gradient, &value), &left) in gradient[1..].iter_mut().zip(&here[1..]).zip(here) {
        *gradient += smoothness * (value - left);
    }
}

/// Steps from `ahead` against the gradient into 0..=1 and looks ahead again; returns how much the step turned
/// back. Leaves in `gradient` each voxel's part of that.
fn step_row(now: &mut [f32], ahead: &mut [f32], gradient: &mut [f32], steps: &[f32], pull: f32) -> f64 {
    for (((now, ahead), gradient), &step) in now.iter_mut().zip(&mut *ahead).zip(&mut *gradient).zip(steps) {
        let reached = (*ahead - step * *gradient).clamp(0.0, 1.0);
        let moved = reached - *now;
        *gradient = (*ahead - reached) * moved;
        *ahead = reached + pull * moved;
        *now = reached;
    }
    sum(gradient)
}

/// Sums in eight lanes, which processors add at once.
fn sum(values: &[f32]) -> f64 {
    let mut lanes = [0.0f32; 8];
    let mut chunks = values.chunks_exact(lanes.len());
    for chunk in &mut chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, value)| *lane += value);
    }
    let rest: f32 = chunks.remainder().iter().sum();
    f64::from(lanes.iter().sum::<f32>() + rest)
}
