//! All rows at once, where views, spreading light or structure tie one to the next.

mod settle;

use rayon::prelude::*;

use super::blur::Blurred;
use super::kernel::{Answers, Pace, RowSteps, narrow, step_row};
use super::lines::{by_film, by_row};
use super::{Effort, Loss, PATIENCE, Problem, SolverView};
use crate::design::sixteen::to_sixteen_bits;
use crate::design::structure::{Scratch, Structure};
use crate::simd::vectorised;

pub(super) use settle::settle;

/// Iterations between two renewals of the voxels' steps, where they follow the pictures.
const STEP_RENEWAL: usize = 8;

/// Rows that one task computes.
const ROWS_AT_ONCE: usize = 16;

/// Lowers the loss; see [`Problem::solve`].
pub(super) fn solve(
    problem: &Problem,
    targets: &[&[f32]],
    volume: &mut [f32],
    effort: Effort,
    watch: &mut dyn FnMut(usize, f64),
) {
    let mut work = Work::new(problem, targets, volume);
    let mut pace = Pace::START;
    let mut last_loss = f64::INFINITY;
    for iteration in 0..effort.iterations {
        let seen = work.look();
        let loss = seen.sum();
        if problem.stop.is_asked() {
            break;
        }
        watch(iteration, seen.errors);
        if iteration % PATIENCE == 0 {
            if last_loss - loss < effort.tolerance * loss {
                break;
            }
            last_loss = loss;
        }
        pace = pace.seeing(loss);
        let overshoot = work.advance(pace, iteration % STEP_RENEWAL == 0);
        pace = pace.after(overshoot);
    }
    by_film(&work.now, work.ahead, problem);
}

/// One colour as it is worked on; films are row, film, column.
struct Work<'a> {
    problem: &'a Problem,
    targets: &'a [&'a [f32]],
    /// Where the films are, in 16 bits, and where they look ahead.
    now: Vec<u16>,
    ahead: &'a mut [f32],
    /// The light of `ahead`, where it spreads.
    blurred: Option<Blurred>,
    /// 0 for a film that stays as it is.
    film_steps: Vec<f32>,
    /// Of each voxel, where they differ; see [`narrow`].
    steps: Vec<u16>,
    answers: Vec<ViewAnswer>,
    /// Where structure looks at errors.
    scratch: Option<Scratch>,
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

impl<'a> Work<'a> {
    /// Works on `films` (film, row, column) where they are: they hold the look ahead until the end.
    fn new(problem: &'a Problem, targets: &'a [&'a [f32]], films: &'a mut [f32]) -> Self {
        let ahead = films;
        by_row(ahead, problem);
        let views = problem.views.iter().zip(targets);
        Self {
            problem,
            targets,
            now: ahead.iter().map(|ink| to_sixteen_bits(*ink)).collect(),
            blurred: Blurred::new(problem),
            film_steps: problem.film_steps(),
            steps: vec![0; if problem.steps_vary() { ahead.len() } else { 0 }],
            answers: views.map(|(view, target)| ViewAnswer::new(problem, view, target)).collect(),
            scratch: (problem.structure > 0.0)
                .then(|| Scratch::new(problem.width * problem.height, problem.width)),
            ahead,
        }
    }

    /// Looks at the films from all views and answers.
    fn look(&mut self) -> Loss {
        let (problem, targets) = (self.problem, self.targets);
        let scatter = self.blurred.as_mut().map_or(0.0, |blurred| blurred.renew(problem, self.ahead));
        let films = self.blurred.as_ref().map_or(&*self.ahead, Blurred::light);
        let chunk_count = problem.height.div_ceil(ROWS_AT_ONCE);
        let mut chunks: Vec<Vec<Answers>> = (0..chunk_count).map(|_| Vec::new()).collect();
        for answer in &mut self.answers {
            for (chunk, answers) in chunks.iter_mut().zip(answer.chunks(problem.width * ROWS_AT_ONCE)) {
                chunk.push(answers);
            }
        }
        let losses: Vec<f64> = chunks
            .par_iter_mut()
            .enumerate()
            .map(|(chunk, answers)| {
                let mut scratch = vec![0.0; problem.width];
                vectorised(
                    #[inline(always)]
                    || look_at_rows(problem, targets, films, chunk * ROWS_AT_ONCE, answers, &mut scratch),
                )
            })
            .collect();
        let (views, scratch) = (self.answers.iter_mut().zip(&problem.views), &mut self.scratch);
        let structure: f64 = views
            .map(|(answer, view)| f64::from(view.weight) * answer.finish(problem.width, scratch.as_mut()))
            .sum();
        Loss { errors: losses.iter().sum(), structure, scatter }
    }

    /// Takes one step from `ahead`, so that `now` is there, and looks ahead again; returns how much the step turned back.
    fn advance(&mut self, pace: Pace, renew_steps: bool) -> f64 {
        let size = self.problem.films * self.problem.width * ROWS_AT_ONCE;
        if let Some(blurred) = &mut self.blurred {
            if renew_steps && !self.steps.is_empty() {
                self.answers
                    .iter_mut()
                    .for_each(|answer| blurred.spread(self.problem, &mut answer.curvatures));
            }
            blurred.turn(self.problem, self.answers.iter().map(|answer| &*answer.slopes).collect());
        }
        let mut steps: Vec<&mut [u16]> = self.steps.chunks_mut(size).collect();
        steps.resize_with(self.ahead.len().div_ceil(size), Default::default);
        let (problem, answers, film_steps) = (self.problem, &self.answers, &self.film_steps);
        let blurred = self.blurred.as_ref();
        let tasks = self.now.par_chunks_mut(size).zip(self.ahead.par_chunks_mut(size)).zip(steps);
        let overshoots: Vec<f64> = tasks
            .enumerate()
            .map(|(chunk, ((now, ahead), steps))| {
                let mut rows = Rows {
                    problem,
                    answers,
                    blurred,
                    film_steps,
                    first: chunk * ROWS_AT_ONCE,
                    gradient: vec![0.0; problem.width],
                    scratch: vec![0.0; problem.width],
                    wide_steps: vec![0.0; problem.width],
                };
                vectorised(
                    #[inline(always)]
                    || rows.advance(now, ahead, steps, pace, renew_steps),
                )
            })
            .collect();
        overshoots.iter().sum()
    }
}

#[inline(always)]
fn look_at_rows(
    problem: &Problem,
    targets: &[&[f32]],
    films: &[f32],
    first: usize,
    answers: &mut [Answers],
    scratch: &mut [f32],
) -> f64 {
    if problem.stop.is_asked() {
        return 0.0;
    }
    let width = problem.width;
    let rows = answers.first().map_or(0, |answers| answers.slopes.len() / width);
    // Row by row, so that the films' row is looked at from all views while it is at hand.
    for row in 0..rows {
        for (view, answers) in problem.views.iter().zip(&mut *answers) {
            let line = &mut answers.slopes[row * width..(row + 1) * width];
            line.fill(0.0);
            view.rays.project_row_of_lines(first + row, films, &view.film_weights, line, scratch);
        }
    }
    let start = first * width;
    let views = problem.views.iter().zip(targets).zip(answers);
    views
        .map(
            #[inline(always)]
            |((view, target), answers)| {
                answers.renew(view, problem, start, &target[start..start + rows * width])
            },
        )
        .sum()
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

    /// The answer in pieces of `size` pixels.
    fn chunks(&mut self, size: usize) -> impl Iterator<Item = Answers<'_>> {
        let errors = self.errors.chunks_mut(size);
        let pieces = self.slopes.chunks_mut(size).zip(errors).zip(self.curvatures.chunks_mut(size));
        pieces.map(|((slopes, errors), curvatures)| Answers { slopes, errors, curvatures })
    }

    /// Brings errors and slopes together; returns the structure loss.
    fn finish(&mut self, width: usize, scratch: Option<&mut Scratch>) -> f64 {
        let loss = match (&self.structure, scratch) {
            (Some(structure), Some(scratch)) => {
                structure.answer(&mut self.errors, &mut self.curvatures, scratch)
            }
            _ => 0.0,
        };
        let size = width * ROWS_AT_ONCE;
        self.slopes.par_chunks_mut(size).zip(self.errors.par_chunks(size)).for_each(|(slopes, errors)| {
            slopes.iter_mut().zip(errors).for_each(|(slope, error)| *slope *= error);
        });
        loss
    }
}

/// Some rows of all films, to be advanced by one task.
struct Rows<'a> {
    problem: &'a Problem,
    answers: &'a [ViewAnswer],
    blurred: Option<&'a Blurred>,
    film_steps: &'a [f32],
    first: usize,
    gradient: Vec<f32>,
    scratch: Vec<f32>,
    /// Steps of one line before they are made narrow.
    wide_steps: Vec<f32>,
}

impl Rows<'_> {
    #[inline(always)]
    fn advance(
        &mut self,
        now: &mut [u16],
        ahead: &mut [f32],
        steps: &mut [u16],
        pace: Pace,
        renew_steps: bool,
    ) -> f64 {
        let (width, films) = (self.problem.width, self.problem.films);
        let mut overshoot = 0.0;
        if self.problem.stop.is_asked() {
            return overshoot;
        }
        for row in 0..now.len() / (films * width) {
            for film in 0..films {
                let start = (row * films + film) * width;
                let line = start..start + width;
                self.pull_back(film, self.first + row, &ahead[line.clone()]);
                if renew_steps && !steps.is_empty() {
                    self.renew_steps(film, self.first + row, &mut steps[line.clone()]);
                }
                let row_steps = match steps.get(line.clone()) {
                    Some(steps) => RowSteps::Each(steps),
                    None => RowSteps::Even(self.film_steps[film]),
                };
                overshoot +=
                    step_row(&mut now[line.clone()], &mut ahead[line], &mut self.gradient, row_steps, pace);
            }
        }
        overshoot
    }

    /// Leaves in `gradient` half the slope of the loss along one line of one film, which is `ahead`.
    #[inline(always)]
    fn pull_back(&mut self, film: usize, row: usize, ahead: &[f32]) {
        let (gradient, scratch) = (&mut self.gradient, &mut self.scratch);
        if let Some(blurred) = self.blurred {
            blurred.pull_back(self.problem, film, row, ahead, gradient, scratch);
            return;
        }
        gradient.fill(0.0);
        for (view, answer) in self.problem.views.iter().zip(self.answers) {
            view.rays.back_project_row(film, row, &answer.slopes, view.film_weights[film], gradient, scratch);
        }
    }

    #[inline(always)]
    fn renew_steps(&mut self, film: usize, row: usize, narrow_steps: &mut [u16]) {
        if self.film_steps[film] == 0.0 {
            narrow_steps.fill(0);
            return;
        }
        let steps = &mut self.wide_steps;
        steps.fill(self.problem.noise(film));
        for (view, answer) in self.problem.views.iter().zip(self.answers) {
            let weight = view.film_weights[film] * view.row_sum();
            view.rays.back_project_row(film, row, &answer.curvatures, weight, steps, &mut self.scratch);
        }
        self.problem.curvatures_to_steps(film, row, steps);
        narrow_steps.iter_mut().zip(steps).for_each(|(narrowed, step)| *narrowed = narrow(*step));
    }
}

#[cfg(test)]
mod tests;
