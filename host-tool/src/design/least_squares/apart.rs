//! Rows that are problems of their own: each is solved where it stands in the processor's cache.

use rayon::prelude::*;

use super::kernel::{Answers, Pace, RowSteps, step_row};
use super::lines::{by_film, by_row};
use super::{Effort, PATIENCE, Problem};
use crate::simd::vectorised;

/// A row costs so little that it goes on until it gains this part of what would stop rows that move together.
const TOLERANCE: f64 = 1.0 / 32.0;

/// Where the solution of one row is.
struct RowState {
    pace: Pace,
    /// Loss at the last look.
    loss: f64,
    /// Whether the row still gains.
    gains: bool,
}

/// Lowers the loss; see [`Problem::solve`].
pub(super) fn solve(
    problem: &Problem,
    targets: &[&[f32]],
    volume: &mut [f32],
    effort: Effort,
    watch: &mut dyn FnMut(usize, f64),
) {
    let line = problem.films * problem.width;
    let mut ahead = by_row(volume, problem);
    let start = || RowState { pace: Pace::START, loss: f64::INFINITY, gains: true };
    let mut states: Vec<RowState> = (0..problem.height).map(|_| start()).collect();
    let film_steps = problem.film_steps();
    let mut done = 0;
    while done < effort.iterations {
        let iterations = PATIENCE.min(effort.iterations - done);
        let rows = volume.par_chunks_mut(line).zip(ahead.par_chunks_mut(line)).zip(&mut states).enumerate();
        rows.with_min_len(4).for_each_init(
            || Row::new(problem, targets, &film_steps),
            |work, (row, ((now, ahead), state))| {
                if state.gains && !problem.stop.is_asked() {
                    vectorised(
                        #[inline(always)]
                        || work.improve(row, now, ahead, state, iterations, TOLERANCE * effort.tolerance),
                    );
                }
            },
        );
        let loss: f64 = states.iter().map(|state| state.loss).sum();
        if problem.stop.is_asked() {
            break;
        }
        watch(done, loss);
        if states.iter().all(|state| !state.gains) {
            break;
        }
        done += iterations;
    }
    by_film(volume, &mut ahead, problem);
}

/// The memory in which one row is worked on.
struct Row<'a> {
    problem: &'a Problem,
    targets: &'a [&'a [f32]],
    film_steps: &'a [f32],
    /// Per view, one picture row each.
    slopes: Vec<f32>,
    curvatures: Vec<f32>,
    errors: Vec<f32>,
    gradient: Vec<f32>,
    /// Steps of each voxel of the row (film, column), where they differ.
    steps: Vec<f32>,
}

impl<'a> Row<'a> {
    fn new(problem: &'a Problem, targets: &'a [&'a [f32]], film_steps: &'a [f32]) -> Self {
        let pictures = vec![0.0; problem.views.len() * problem.width];
        let voxels = if problem.steps_vary() { problem.films * problem.width } else { 0 };
        Self {
            problem,
            targets,
            film_steps,
            slopes: pictures.clone(),
            curvatures: pictures.clone(),
            errors: pictures,
            gradient: vec![0.0; problem.width],
            steps: vec![0.0; voxels],
        }
    }

    #[inline(always)]
    fn improve(
        &mut self,
        row: usize,
        now: &mut [f32],
        ahead: &mut [f32],
        state: &mut RowState,
        iterations: usize,
        tolerance: f64,
    ) {
        for iteration in 0..iterations {
            let loss = self.look(row, ahead);
            if iteration == 0 {
                state.gains = state.loss - loss >= tolerance * loss;
                state.loss = loss;
                if !state.gains {
                    return;
                }
                if self.problem.steps_vary() {
                    self.renew_steps(row);
                }
            }
            state.pace = state.pace.seeing(loss);
            let overshoot = self.advance(now, ahead, state.pace);
            state.pace = state.pace.after(overshoot);
        }
    }

    /// Looks at the row's films and answers; returns the loss.
    #[inline(always)]
    fn look(&mut self, row: usize, films: &[f32]) -> f64 {
        let width = self.problem.width;
        let start = row * width;
        let mut loss = 0.0;
        for (index, (view, target)) in self.problem.views.iter().zip(self.targets).enumerate() {
            let part = index * width..(index + 1) * width;
            let slopes = &mut self.slopes[part.clone()];
            slopes.fill(0.0);
            view.rays.project_line(films, &view.film_weights, slopes);
            let (errors, curvatures) = (&mut self.errors[part.clone()], &mut self.curvatures[part]);
            let mut answers = Answers { slopes, errors, curvatures };
            loss += answers.renew(view, self.problem, start, &target[start..start + width]);
        }
        self.slopes.iter_mut().zip(&self.errors).for_each(|(slope, error)| *slope *= error);
        loss
    }

    #[inline(always)]
    fn advance(&mut self, now: &mut [f32], ahead: &mut [f32], pace: Pace) -> f64 {
        let width = self.problem.width;
        let mut overshoot = 0.0;
        for film in 0..self.problem.films {
            let line = film * width..(film + 1) * width;
            self.gradient.fill(0.0);
            for (view, slopes) in self.problem.views.iter().zip(self.slopes.chunks_exact(width)) {
                let weight = view.film_weights[film];
                view.rays.back_project_line(film, slopes, weight, &mut self.gradient);
            }
            let steps = match self.steps.get(line.clone()) {
                Some(steps) => RowSteps::Each(steps),
                None => RowSteps::Even(self.film_steps[film]),
            };
            overshoot += step_row(&mut now[line.clone()], &mut ahead[line], &mut self.gradient, steps, pace);
        }
        overshoot
    }

    #[inline(always)]
    fn renew_steps(&mut self, row: usize) {
        let width = self.problem.width;
        for (film, line) in self.steps.chunks_exact_mut(width).enumerate() {
            line.fill(0.0);
            for (view, curvatures) in self.problem.views.iter().zip(self.curvatures.chunks_exact(width)) {
                let weight = view.film_weights[film] * view.row_sum();
                view.rays.back_project_line(film, curvatures, weight, line);
            }
            self.problem.curvatures_to_steps(film, row, line);
        }
    }
}
