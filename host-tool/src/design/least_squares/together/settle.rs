//! Films that hold only the printer's levels, settled one by one while the others take up what they leave over.
//!
//! Within one film the loss is a parabola in the values of its voxels: what a change of one voxel does to the slope at
//! its neighbours is known ([`Bend`]). So voxels choose their levels one after the other, each where the voxels before
//! it have left the parabola's lowest point (error diffusion by the loss itself). What the film leaves over, the
//! films that are still open take up, by a few steps of the solver, before the next one is settled. In the end
//! all films choose again, as long as that lowers the loss (direct binary search, Analoui and Allebach 1992, over all
//! films and views at once).

use super::*;
use crate::spread::Spread;

/// Steps in which the open films take up what a settled one has left over.
const REST_ITERATIONS: usize = 4;

/// Sweeps over all films in which voxels choose again.
const LAST_SWEEPS: usize = 3;

/// The farthest neighbour in pixels whose slope a change is followed to.
const LONGEST_REACH: usize = 12;

/// Brings every voxel of `volume` (film, row, column) to one of `levels`, which rise, so that the loss stays low.
pub(in crate::design::least_squares) fn settle(
    problem: &Problem,
    targets: &[&[f32]],
    volume: &mut [f32],
    levels: &[f32],
) {
    let mut work = Work::new(problem, targets, volume);
    let order = outside_in(problem.films);
    for &film in &order {
        work.settle_film(film, levels);
        work.film_steps[film] = 0.0;
        work.take_up();
    }
    let mut least = work.look().sum();
    for _ in 0..LAST_SWEEPS {
        let before = work.ahead.to_vec();
        order.iter().for_each(|&film| work.settle_film(film, levels));
        let loss = work.look().sum();
        if loss >= least || problem.stop.is_asked() {
            work.ahead.copy_from_slice(&before);
            break;
        }
        least = loss;
    }
    work.arrive();
    by_film(&work.now, work.ahead, problem);
}

/// 0, last, 1, last but one, ... : the outer films first, for they part the views most.
fn outside_in(films: usize) -> Vec<usize> {
    (0..films).map(|index| if index % 2 == 0 { index / 2 } else { films - 1 - index / 2 }).collect()
}

impl Work<'_> {
    /// Lets the films be where they look ahead.
    fn arrive(&mut self) {
        let inks = self.now.iter_mut().zip(&*self.ahead);
        inks.for_each(|(now, ahead)| *now = to_sixteen_bits(*ahead));
    }

    /// Lets the open films take some steps from the look ahead, which does not run before them in the end.
    fn take_up(&mut self) {
        self.arrive();
        let mut pace = Pace::START;
        for iteration in 0..REST_ITERATIONS {
            if self.problem.stop.is_asked() {
                return;
            }
            pace = pace.seeing(self.look().sum());
            if iteration + 1 == REST_ITERATIONS {
                pace = pace.resting();
            }
            let overshoot = self.advance(pace, iteration == 0);
            pace = pace.after(overshoot);
        }
    }

    /// Lets every voxel of a film choose its level; row by row, there and back.
    fn settle_film(&mut self, film: usize, levels: &[f32]) {
        let (width, height) = (self.problem.width, self.problem.height);
        self.look();
        let (mut slopes, curvatures) = self.slopes_of(film);
        let bend = Bend::of(self.problem, film);
        for row in 0..height {
            for step in 0..width {
                let column = if row % 2 == 0 { step } else { width - 1 - step };
                let at = row * width + column;
                if self.problem.is_fixed(film, at) {
                    continue;
                }
                let value = &mut self.ahead[(row * self.problem.films + film) * width + column];
                let stiffness = bend.own(curvatures[at]);
                let best = if stiffness > 0.0 { *value - slopes[at] / stiffness } else { *value };
                let level = nearest(levels, best);
                let change = level - *value;
                *value = level;
                if change != 0.0 {
                    bend.turn_slopes(&mut slopes, width, (row, column), change, curvatures[at]);
                }
            }
        }
    }

    /// Half the loss's slope along one film, and a bound of its curvature there (row, column).
    fn slopes_of(&mut self, film: usize) -> (Vec<f32>, Vec<f32>) {
        let problem = self.problem;
        let width = problem.width;
        if let Some(blurred) = &mut self.blurred {
            blurred.turn(problem, self.answers.iter().map(|answer| &*answer.slopes).collect());
        }
        let mut rows = Rows {
            problem,
            answers: &self.answers,
            blurred: self.blurred.as_ref(),
            film_steps: &self.film_steps,
            first: 0,
            gradient: vec![0.0; width],
            scratch: vec![0.0; width],
            wide_steps: vec![0.0; width],
        };
        let mut slopes = Vec::with_capacity(width * problem.height);
        let mut curvatures = vec![0.0; width * problem.height];
        for (row, curvatures) in curvatures.chunks_exact_mut(width).enumerate() {
            let start = (row * problem.films + film) * width;
            rows.pull_back(film, row, &self.ahead[start..start + width]);
            slopes.extend_from_slice(&rows.gradient);
            for (view, answer) in problem.views.iter().zip(&self.answers) {
                let square = view.film_weights[film].powi(2);
                view.rays.back_project_row(
                    film,
                    row,
                    &answer.curvatures,
                    square,
                    curvatures,
                    &mut rows.scratch,
                );
            }
        }
        (slopes, curvatures)
    }
}

/// The level next to `value`.
fn nearest(levels: &[f32], value: f32) -> f32 {
    let above = levels.partition_point(|level| *level < value).min(levels.len() - 1);
    let below = above.saturating_sub(1);
    if value - levels[below] < levels[above] - value { levels[below] } else { levels[above] }
}

/// How the slope changes around a voxel that changes: squares of 2 `reach` + 1 pixels a side.
struct Bend {
    reach: usize,
    /// By what the views see of the film: parts of the curvature.
    seen: Vec<f32>,
    /// By what the film's errors scatter.
    scattered: Vec<f32>,
}

impl Bend {
    fn of(problem: &Problem, film: usize) -> Self {
        let blur = problem.blurs.get(film);
        let reach = blur.map_or(1, |blur| (2 * blur.expected.reach() + 1).min(LONGEST_REACH));
        let side = 2 * reach + 1;
        let twice = |spread: &Spread, plane: &[f32]| spread.of_film(&spread.of_film(plane, side), side);
        let mut one = vec![0.0; side * side];
        one[reach * side + reach] = 1.0;
        let expected = blur.map_or(one.clone(), |blur| twice(&blur.expected, &one));
        let mut seen = vec![0.0; side * side];
        let squares = || problem.views.iter().map(|view| view.weight * view.film_weights[film].powi(2));
        let sum = squares().sum::<f32>().max(f32::MIN_POSITIVE);
        for (view, square) in problem.views.iter().zip(squares()) {
            // A ray between two pixels sees both.
            let shared =
                Spread::to_neighbours(view.rays.shared_with_neighbours(film)).of_film(&expected, side);
            seen.iter_mut().zip(shared).for_each(|(seen, shared)| *seen += square / sum * shared);
        }
        let scattered = blur.map_or(vec![0.0; side * side], |blur| {
            let crisp = blur.print_twice.of_film(&one, side);
            crisp.iter().zip(&expected).map(|(crisp, expected)| blur.noise * (crisp - expected)).collect()
        });
        Self { reach, seen, scattered }
    }

    /// The curvature along the voxel itself.
    fn own(&self, curvature: f32) -> f32 {
        let middle = self.seen.len() / 2;
        curvature * self.seen[middle] + self.scattered[middle]
    }

    /// Turns the slopes (row, column) in the voxel's row and below, where voxels have yet to choose.
    fn turn_slopes(
        &self,
        slopes: &mut [f32],
        width: usize,
        (row, column): (usize, usize),
        change: f32,
        curvature: f32,
    ) {
        let (reach, side) = (self.reach, 2 * self.reach + 1);
        let first = column.saturating_sub(reach);
        let last = (column + reach).min(width - 1);
        let offset = first + reach - column;
        for (below, slopes) in slopes.chunks_exact_mut(width).skip(row).take(reach + 1).enumerate() {
            let start = (reach + below) * side + offset;
            let parts = start..start + last + 1 - first;
            let bends = self.seen[parts.clone()].iter().zip(&self.scattered[parts]);
            for (slope, (seen, scattered)) in slopes[first..=last].iter_mut().zip(bends) {
                *slope += change * (curvature * seen + scattered);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_are_settled_from_the_outside_in() {
        assert_eq!(outside_in(5), [0, 4, 1, 3, 2]);
        assert_eq!(outside_in(4), [0, 3, 1, 2]);
    }

    #[test]
    fn the_nearest_level_is_chosen() {
        let levels = [0.0, 0.4, 1.0];
        for (value, level) in [(-3.0, 0.0), (0.19, 0.0), (0.21, 0.4), (0.69, 0.4), (0.71, 1.0), (7.0, 1.0)] {
            assert_eq!(nearest(&levels, value), level, "{value}");
        }
    }
}
