//! What both ways of solving do to a line of pixels.

use super::{Problem, SolverView};

/// The answer to a part of what one view shows, pixel by pixel.
pub(super) struct Answers<'a> {
    /// In: what the pixels show. Out: how steeply their measured values rise with it, times the weight.
    pub(super) slopes: &'a mut [f32],
    /// Out: the error in the values in which it is measured; where pixels count differently and structure does
    /// not look at the errors itself, times how much the pixel counts.
    pub(super) errors: &'a mut [f32],
    /// Out: a bound of half the loss's curvature, times the weight.
    pub(super) curvatures: &'a mut [f32],
}

impl Answers<'_> {
    /// Answers to what is shown beside `target`, from pixel `start` of the view on; returns the loss.
    #[inline(always)]
    pub(super) fn renew(
        &mut self,
        view: &SolverView,
        problem: &Problem,
        start: usize,
        target: &[f32],
    ) -> f64 {
        problem.divergence.answer(self.slopes, target, self.errors, self.curvatures);
        match view.mask_from(start) {
            None => {
                for (slope, curvature) in self.slopes.iter_mut().zip(&mut *self.curvatures) {
                    *slope *= view.weight;
                    *curvature *= view.weight;
                }
                f64::from(view.weight) * sum_of_products(self.errors, self.errors)
            }
            Some(mask) => {
                let mut loss = 0.0;
                let structure_looks = problem.structure > 0.0;
                let pixels = self.slopes.iter_mut().zip(&mut *self.curvatures).zip(&mut *self.errors);
                for (((slope, curvature), error), mask) in pixels.zip(mask) {
                    *slope *= view.weight;
                    *curvature *= view.weight * mask;
                    loss += view.weight * mask * *error * *error;
                    *error *= if structure_looks { 1.0 } else { *mask };
                }
                f64::from(loss)
            }
        }
    }
}

/// Adds the half slope of `smoothness * |grad|^2` in one row; beyond the film's edge nothing changes.
#[inline(always)]
pub(super) fn add_smoothness(
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

/// How far to go along the gradient in one row.
#[derive(Clone, Copy)]
pub(super) enum RowSteps<'a> {
    /// Everywhere as far.
    Even(f32),
    /// At each pixel as far as this.
    Each(&'a [f32]),
}

/// Steps from `ahead` against the gradient into 0..=1 and looks ahead again; returns how much the step turned
/// back. Leaves in `gradient` each voxel's part of that.
#[inline(always)]
pub(super) fn step_row(
    now: &mut [f32],
    ahead: &mut [f32],
    gradient: &mut [f32],
    steps: RowSteps,
    pull: f32,
) -> f64 {
    let voxels = now.iter_mut().zip(&mut *ahead).zip(&mut *gradient);
    match steps {
        RowSteps::Even(step) => voxels.for_each(
            #[inline(always)]
            |((now, ahead), gradient)| step_voxel(now, ahead, gradient, step, pull),
        ),
        RowSteps::Each(steps) => voxels.zip(steps).for_each(
            #[inline(always)]
            |(((now, ahead), gradient), &step)| step_voxel(now, ahead, gradient, step, pull),
        ),
    }
    sum(gradient)
}

#[inline(always)]
fn step_voxel(now: &mut f32, ahead: &mut f32, gradient: &mut f32, step: f32, pull: f32) {
    let reached = (*ahead - step * *gradient).clamp(0.0, 1.0);
    let moved = reached - *now;
    *gradient = (*ahead - reached) * moved;
    *ahead = reached + pull * moved;
    *now = reached;
}

/// Sums in eight lanes, which processors add at once.
#[inline(always)]
fn sum(values: &[f32]) -> f64 {
    let mut lanes = [0.0f32; 8];
    let mut chunks = values.chunks_exact(lanes.len());
    for chunk in &mut chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, value)| *lane += value);
    }
    let rest: f32 = chunks.remainder().iter().sum();
    f64::from(lanes.iter().sum::<f32>() + rest)
}

/// Sums products in eight lanes.
#[inline(always)]
fn sum_of_products(a: &[f32], b: &[f32]) -> f64 {
    let mut lanes = [0.0f32; 8];
    let (mut left, mut right) = (a.chunks_exact(8), b.chunks_exact(8));
    for (a, b) in (&mut left).zip(&mut right) {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane += a * b;
        }
    }
    let rest: f32 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    f64::from(lanes.iter().sum::<f32>() + rest)
}

/// How far the next look ahead goes along the last move, and what to remember for the one after it (Beck and
/// Teboulle 2009): starts from 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Momentum(f64);

impl Momentum {
    pub(super) const START: Self = Self(1.0);

    /// Returns the part of the last move that is added, and the momentum after it.
    pub(super) fn next(self) -> (f32, Self) {
        let next = (1.0 + (1.0 + 4.0 * self.0 * self.0).sqrt()) / 2.0;
        (((self.0 - 1.0) / next) as f32, Self(next))
    }

    /// Begins anew when the step turned back (O'Donoghue and Candes 2015).
    pub(super) fn unless_turned_back(self, overshoot: f64) -> Self {
        if overshoot > 0.0 { Self::START } else { self }
    }
}
