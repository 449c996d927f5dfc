//! Rows that are problems of their own: each is solved where it stands in the processor's cache.
//!
//! No film is kept while they are solved. With V the films where they began, the films of a row are always
//! `clip(V + S A^T m)`: the steps S of the films, the transpose A^T of the projection, and a picture m for every view,
//! which moves by what the view lacks. That is dual averaging (Nesterov, "Primal-dual subgradient methods for convex
//! problems", Mathematical Programming 2009), at the pace of [`Pace`]; it ends where the projected gradient does, and
//! an iteration costs a projection and its transpose, on one line of one film at a time.

use rayon::prelude::*;

use super::kernel::{Pace, sum, sum_of_products};
use super::{Effort, Loss, PATIENCE, Problem};
use crate::design::structure::{RowScratch, Structure};
use crate::simd::vectorised;

/// A row costs so little that it goes on until it gains this part of what would stop rows that move together.
const TOLERANCE: f64 = 1.0 / 32.0;

/// Rows that gain go on until they are as few as this part of all: the last ones change no picture.
const LAST_ROWS: usize = 50;

/// How much of its strength structure bends the loss by where that bends most, at detail that all views share.
const STRUCTURE_BENDS: f32 = 0.5;

/// Where the solution of one row is.
struct RowState<'a> {
    /// The row of every film.
    films: Vec<&'a mut [f32]>,
    /// The picture rows of all views by which the films have moved from where they began, and where they look ahead.
    moved: Vec<f32>,
    ahead: Vec<f32>,
    pace: Pace,
    /// Loss at the last look.
    loss: f64,
    /// The part of it that errors have themselves.
    errors: f64,
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
    let mut rows = rows_of(problem, volume);
    let structures = structures(problem, targets);
    let most = 1.0 + STRUCTURE_BENDS * problem.structure;
    let film_steps: Vec<f32> = problem.film_steps().iter().map(|step| step / most).collect();
    let mut done = 0;
    while done < effort.iterations {
        let iterations = PATIENCE.min(effort.iterations - done);
        rows.par_iter_mut().enumerate().with_min_len(4).for_each_init(
            || Work::new(problem, targets, &structures, &film_steps),
            |work, (row, state)| {
                if state.gains && !problem.stop.is_asked() {
                    vectorised(
                        #[inline(always)]
                        || work.improve(row, state, iterations, TOLERANCE * effort.tolerance),
                    );
                }
            },
        );
        if problem.stop.is_asked() {
            break;
        }
        done += iterations;
        watch(done, rows.iter().map(|state| state.errors).sum());
        if rows.iter().filter(|state| state.gains).count() <= problem.height / LAST_ROWS {
            break;
        }
    }
    rows.par_iter_mut().for_each_init(
        || Work::new(problem, targets, &structures, &film_steps),
        |work, state| {
            vectorised(
                #[inline(always)]
                || work.settle(state),
            );
        },
    );
}

/// The rows of a volume (film, row, column), each where it begins.
fn rows_of<'a>(problem: &Problem, volume: &'a mut [f32]) -> Vec<RowState<'a>> {
    let pictures = problem.views.len() * problem.width;
    let start = || RowState {
        films: Vec::with_capacity(problem.films),
        moved: vec![0.0; pictures],
        ahead: vec![0.0; pictures],
        pace: Pace::START,
        loss: f64::INFINITY,
        errors: 0.0,
        gains: true,
    };
    let mut rows: Vec<RowState> = (0..problem.height).map(|_| start()).collect();
    for plane in volume.chunks_exact_mut(problem.height * problem.width) {
        for (row, line) in rows.iter_mut().zip(plane.chunks_exact_mut(problem.width)) {
            row.films.push(line);
        }
    }
    rows
}

/// What the structure of every view counts, where it does.
fn structures(problem: &Problem, targets: &[&[f32]]) -> Vec<Structure> {
    if problem.structure == 0.0 {
        return Vec::new();
    }
    targets.iter().map(|target| Structure::of(target, problem.width, problem.structure, None)).collect()
}

/// The memory in which one row is worked on.
struct Work<'a> {
    problem: &'a Problem,
    targets: &'a [&'a [f32]],
    structures: &'a [Structure],
    film_steps: &'a [f32],
    /// One line of one film.
    line: Vec<f32>,
    /// Per view, the picture row that is shown, and then what it lacks.
    shown: Vec<f32>,
    scratch: RowScratch,
}

impl<'a> Work<'a> {
    fn new(
        problem: &'a Problem,
        targets: &'a [&'a [f32]],
        structures: &'a [Structure],
        film_steps: &'a [f32],
    ) -> Self {
        let scratch = RowScratch::new(problem.width);
        let pictures = vec![0.0; problem.views.len() * problem.width];
        Self {
            problem,
            targets,
            film_steps,
            structures,
            line: vec![0.0; problem.width],
            shown: pictures,
            scratch,
        }
    }

    #[inline(always)]
    fn improve(&mut self, row: usize, state: &mut RowState, iterations: usize, tolerance: f64) {
        for iteration in 0..iterations {
            self.show(&state.films, &state.ahead);
            let found = self.find_lacks(row);
            let loss = found.sum();
            if iteration == 0 {
                // The loss of a row that looks ahead rises now and then: it has come to rest when it does neither.
                state.gains = (state.loss - loss).abs() >= tolerance * loss;
                (state.loss, state.errors) = (loss, found.errors);
                if !state.gains {
                    return;
                }
            }
            state.pace = state.pace.seeing(loss);
            let overshoot = move_on(&mut state.moved, &mut state.ahead, &mut self.shown, state.pace);
            state.pace = state.pace.after(overshoot);
        }
    }

    /// Projects the films moved by `pictures`.
    #[inline(always)]
    fn show(&mut self, films: &[&mut [f32]], pictures: &[f32]) {
        self.shown.fill(0.0);
        for (film, start) in films.iter().enumerate() {
            self.find_line(film, start, pictures);
            let shown = self.shown.chunks_exact_mut(self.problem.width);
            for (view, shown) in self.problem.views.iter().zip(shown) {
                view.rays.project_film_line(film, &self.line, view.film_weights[film], shown);
            }
        }
    }

    /// Leaves the line of film `film` that begins at `start` and is moved by `pictures` in `line`.
    #[inline(always)]
    fn find_line(&mut self, film: usize, start: &[f32], pictures: &[f32]) {
        self.line.copy_from_slice(start);
        let pictures = pictures.chunks_exact(self.problem.width);
        for (view, picture) in self.problem.views.iter().zip(pictures) {
            let weight = self.film_steps[film] * view.film_weights[film];
            view.rays.back_project_line(film, picture, weight, &mut self.line);
        }
        self.line.iter_mut().for_each(|ink| *ink = ink.clamp(0.0, 1.0));
    }

    /// Turns what is shown into what it lacks, times the views' weights; returns the loss.
    #[inline(always)]
    fn find_lacks(&mut self, row: usize) -> Loss {
        let width = self.problem.width;
        let mut loss = Loss { errors: 0.0, structure: 0.0, scatter: 0.0 };
        let mut structures = self.structures.iter();
        let shown = self.shown.chunks_exact_mut(width);
        for ((view, target), shown) in self.problem.views.iter().zip(self.targets).zip(shown) {
            let wanted = &target[row * width..(row + 1) * width];
            self.problem.divergence.lack(shown, wanted);
            let weight = f64::from(view.weight);
            loss.errors += weight * sum_of_products(shown, shown);
            if let Some(structure) = structures.next() {
                loss.structure += weight * structure.answer_row(row, shown, &mut self.scratch);
            }
            shown.iter_mut().for_each(|lack| *lack *= view.weight);
        }
        loss
    }

    /// Writes the films where they have come to.
    #[inline(always)]
    fn settle(&mut self, state: &mut RowState) {
        for film in 0..state.films.len() {
            self.find_line(film, state.films[film], &state.moved);
            state.films[film].copy_from_slice(&self.line);
        }
    }
}

/// Moves by what the views lack and looks ahead; returns how much the move turned back. `lacks` is used up.
#[inline(always)]
fn move_on(moved: &mut [f32], ahead: &mut [f32], lacks: &mut [f32], pace: Pace) -> f64 {
    let (stride, pull) = (pace.stride(), pace.pull());
    for ((moved, ahead), lack) in moved.iter_mut().zip(ahead).zip(&mut *lacks) {
        let reached = *ahead + stride * *lack;
        let step = reached - *moved;
        *lack *= -step;
        *ahead = reached + pull * step;
        *moved = reached;
    }
    sum(lacks)
}

#[cfg(test)]
mod tests;
