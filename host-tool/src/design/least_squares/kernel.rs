//! What both ways of solving do to a line of pixels.

use super::{Problem, SolverView};
use crate::design::sixteen::{from_sixteen_bits, to_sixteen_bits};

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

/// How far to go along the gradient in one row.
#[derive(Clone, Copy)]
pub(super) enum RowSteps<'a> {
    /// Everywhere as far.
    Even(f32),
    /// At each pixel as far as this; see [`narrow`].
    Each(&'a [u16]),
}

/// Steps from `ahead` against the gradient into 0..=1 and looks ahead again; returns how much the step turned
/// back. Leaves in `gradient` each voxel's part of that. `now` is in 16 bits: what they leave out moves the look ahead by
/// less than a step of what is written.
#[inline(always)]
pub(super) fn step_row(
    now: &mut [u16],
    ahead: &mut [f32],
    gradient: &mut [f32],
    steps: RowSteps,
    pace: Pace,
) -> f64 {
    let voxels = now.iter_mut().zip(&mut *ahead).zip(&mut *gradient);
    match steps {
        RowSteps::Even(step) => {
            for ((now, ahead), gradient) in voxels {
                step_voxel(now, ahead, gradient, pace.stride * step, pace.pull);
            }
        }
        RowSteps::Each(steps) => {
            for (((now, ahead), gradient), &step) in voxels.zip(steps) {
                step_voxel(now, ahead, gradient, pace.stride * wide(step), pace.pull);
            }
        }
    }
    sum(gradient)
}

/// The upper half of a step, which falls short of it by less than a hundredth: half the memory for all voxels' steps.
#[inline(always)]
pub(super) fn narrow(step: f32) -> u16 {
    (step.to_bits() >> 16) as u16
}

#[inline(always)]
fn wide(narrowed: u16) -> f32 {
    f32::from_bits(u32::from(narrowed) << 16)
}

#[inline(always)]
fn step_voxel(now: &mut u16, ahead: &mut f32, gradient: &mut f32, step: f32, pull: f32) {
    let reached = (*ahead - step * *gradient).clamp(0.0, 1.0);
    let moved = reached - from_sixteen_bits(*now);
    *gradient = (*ahead - reached) * moved;
    *ahead = reached + pull * moved;
    *now = to_sixteen_bits(reached);
}

/// Sums in eight lanes, which processors add at once.
#[inline(always)]
pub(super) fn sum(values: &[f32]) -> f64 {
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
pub(super) fn sum_of_products(a: &[f32], b: &[f32]) -> f64 {
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

/// How far steps go, and how far the next look ahead goes along the last move.
///
/// Steps longer than what bounds the curvature, and looks ahead that do not begin small, are Liang, Luo and
/// Schoenlieb's greedy FISTA ("Improving FISTA", SIAM Journal on Scientific Computing 2022): far from the
/// solution it needs a third of FISTA's iterations. It begins anew when a step turns back (O'Donoghue and Candes
/// 2015), and where longer steps raise the loss they become shorter until they are bounded again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// The step as a part of the one that the curvature's bound allows.
    stride: f32,
    /// The part of the last move that is added.
    pull: f32,
    least_loss: f64,
}

const LONGEST_STRIDE: f32 = 1.3;
const SHORTER: f32 = 0.9;
const PULL: f32 = 0.95;
/// Looking ahead lets the loss rise a little now and then; more than this comes of steps that are too long.
const RISE: f64 = 1.02;

impl Pace {
    pub(super) const START: Self = Self { stride: LONGEST_STRIDE, pull: PULL, least_loss: f64::INFINITY };

    /// Looks at the loss before a step.
    #[inline(always)]
    pub(super) fn seeing(self, loss: f64) -> Self {
        let least_loss = self.least_loss.min(loss);
        if loss > RISE * self.least_loss {
            Self { stride: (self.stride * SHORTER).max(1.0), pull: 0.0, least_loss: loss }
        } else {
            Self { least_loss, ..self }
        }
    }

    /// Adds nothing of the next move, so that the look ahead is where the step ends.
    pub(super) fn resting(self) -> Self {
        Self { pull: 0.0, ..self }
    }

    /// The step as a part of the one that the curvature's bound allows.
    pub(super) fn stride(self) -> f32 {
        self.stride
    }

    /// The part of the last move that is added.
    pub(super) fn pull(self) -> f32 {
        self.pull
    }

    /// Adds nothing of the next move when the step turned back.
    #[inline(always)]
    pub(super) fn after(self, overshoot: f64) -> Self {
        Self { pull: if overshoot > 0.0 { 0.0 } else { PULL }, ..self }
    }
}
