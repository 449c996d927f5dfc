//! All rows at once, where views, smoothness or structure tie one to the next.

use rayon::prelude::*;

use super::kernel::{Answers, Pace, RowSteps, add_smoothness, step_row};
use super::lines::{by_film, by_row};
use super::{Effort, LAPLACIAN, PATIENCE, Problem, SolverView};
use crate::design::structure::{Scratch, Structure};
use crate::simd::vectorised;

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
        let Loss { errors, structure } = work.look();
        let loss = errors + structure;
        if problem.stop.is_asked() {
            break;
        }
        watch(iteration, errors);
        if iteration % PATIENCE == 0 {
            if last_loss - loss < effort.tolerance * loss {
                break;
            }
            last_loss = loss;
        }
        pace = pace.seeing(loss);
        let overshoot = work.advance(volume, pace, iteration % STEP_RENEWAL == 0);
        pace = pace.after(overshoot);
    }
    let mut ahead = work.ahead;
    by_film(volume, &mut ahead, problem);
}

/// What is lost to errors themselves, and to their structure.
struct Loss {
    errors: f64,
    structure: f64,
}

/// One colour as it is worked on; films are row, film, column.
struct Work<'a> {
    problem: &'a Problem,
    targets: &'a [&'a [f32]],
    ahead: Vec<f32>,
    film_steps: Vec<f32>,
    /// Of each voxel, where they differ.
    steps: Vec<f32>,
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
    fn new(problem: &'a Problem, targets: &'a [&'a [f32]], volume: &mut [f32]) -> Self {
        let ahead = by_row(volume, problem);
        let views = problem.views.iter().zip(targets);
        Self {
            problem,
            targets,
            film_steps: problem.film_steps(),
            steps: vec![0.0; if problem.steps_vary() { ahead.len() } else { 0 }],
            answers: views.map(|(view, target)| ViewAnswer::new(problem, view, target)).collect(),
            scratch: (problem.structure > 0.0)
                .then(|| Scratch::new(problem.width * problem.height, problem.width)),
            ahead,
        }
    }

    /// Looks at the films from all views and answers.
    fn look(&mut self) -> Loss {
        let (problem, targets, films) = (self.problem, self.targets, &self.ahead);
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
        Loss { errors: losses.iter().sum(), structure }
    }

    /// Takes one step from `ahead`, so that `now` is there, and looks ahead again; returns how much the step turned back.
    fn advance(&mut self, now: &mut [f32], pace: Pace, renew_steps: bool) -> f64 {
        let line = self.problem.films() * self.problem.width;
        let size = line * ROWS_AT_ONCE;
        let edges = self.edges(size);
        let mut steps: Vec<&mut [f32]> = self.steps.chunks_mut(size).collect();
        steps.resize_with(edges.len(), Default::default);
        let (problem, answers, film_steps) = (self.problem, &self.answers, &self.film_steps);
        let tasks = now.par_chunks_mut(size).zip(self.ahead.par_chunks_mut(size)).zip(steps).zip(edges);
        let overshoots: Vec<f64> = tasks
            .enumerate()
            .map(|(chunk, (((now, ahead), steps), edges))| {
                let mut rows = Rows {
                    problem,
                    answers,
                    film_steps,
                    first: chunk * ROWS_AT_ONCE,
                    edges,
                    gradient: vec![0.0; problem.width],
                    scratch: vec![0.0; problem.width],
                    here: vec![0.0; problem.width],
                };
                vectorised(
                    #[inline(always)]
                    || rows.advance(now, ahead, steps, pace, renew_steps),
                )
            })
            .collect();
        overshoots.iter().sum()
    }

    /// The rows beyond both ends of every task's rows, as they are before the step.
    fn edges(&self, size: usize) -> Vec<Edges> {
        let line = self.problem.films() * self.problem.width;
        let smooth = self.problem.smoothness.iter().any(|&smoothness| smoothness > 0.0);
        let row = |start: usize| self.ahead.get(start..start + line).filter(|_| smooth).map(<[f32]>::to_vec);
        let starts = (0..self.ahead.len()).step_by(size);
        starts
            .map(|start| Edges {
                has_above: start > 0,
                above: row(start.saturating_sub(line)).unwrap_or_default(),
                below: row(start + size).unwrap_or_default(),
            })
            .collect()
    }
}

/// What lies beyond the rows of one task (film, column), where smoothness looks at it.
struct Edges {
    has_above: bool,
    /// The row above as it was before this step.
    above: Vec<f32>,
    /// The row below the last; empty at the bottom.
    below: Vec<f32>,
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
    film_steps: &'a [f32],
    first: usize,
    edges: Edges,
    gradient: Vec<f32>,
    scratch: Vec<f32>,
    here: Vec<f32>,
}

impl Rows<'_> {
    #[inline(always)]
    fn advance(
        &mut self,
        now: &mut [f32],
        ahead: &mut [f32],
        steps: &mut [f32],
        pace: Pace,
        renew_steps: bool,
    ) -> f64 {
        let (width, films) = (self.problem.width, self.problem.films());
        let last = now.len() / (films * width) - 1;
        let mut overshoot = 0.0;
        if self.problem.stop.is_asked() {
            return overshoot;
        }
        for row in 0..=last {
            for film in 0..films {
                let start = (row * films + film) * width;
                let line = start..start + width;
                self.pull_back(film, self.first + row, ahead, start, row == last);
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
            self.edges.has_above = true;
        }
        overshoot
    }

    /// Leaves in `gradient` half the slope of the loss along one line of one film.
    #[inline(always)]
    fn pull_back(&mut self, film: usize, row: usize, ahead: &[f32], start: usize, is_last: bool) {
        let (width, line) = (self.problem.width, self.problem.films() * self.problem.width);
        self.gradient.fill(0.0);
        for (view, answer) in self.problem.views.iter().zip(self.answers) {
            let weight = view.film_weights[film];
            let (gradient, scratch) = (&mut self.gradient, &mut self.scratch);
            view.rays.back_project_row(film, row, &answer.slopes, weight, gradient, scratch);
        }
        let smoothness = self.problem.smoothness[film];
        if smoothness > 0.0 {
            let place = film * width..(film + 1) * width;
            let below = start + line..start + line + width;
            let below = if is_last { self.edges.below.get(place.clone()) } else { ahead.get(below) };
            let above = &mut self.edges.above[place];
            self.here.copy_from_slice(&ahead[start..start + width]);
            let above_line = self.edges.has_above.then_some(&*above);
            add_smoothness(smoothness, above_line, &self.here, below, &mut self.gradient);
            above.copy_from_slice(&self.here);
        }
    }

    #[inline(always)]
    fn renew_steps(&mut self, film: usize, row: usize, steps: &mut [f32]) {
        steps.fill(LAPLACIAN * self.problem.smoothness[film]);
        for (view, answer) in self.problem.views.iter().zip(self.answers) {
            let weight = view.film_weights[film] * view.row_sum();
            view.rays.back_project_row(film, row, &answer.curvatures, weight, steps, &mut self.scratch);
        }
        self.problem.curvatures_to_steps(film, row, steps);
    }
}
