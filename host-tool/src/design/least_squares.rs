//! The bounded optimiser: the volume in 0..=1 whose views differ least from their patterns.
//!
//! It minimises, for each colour by itself,
//!
//! ```text
//! sum over views i of  weight_i * |d(P_i, T_i)|^2  +  sum over films k of  noise_k * (|B V_k|^2 - |G V_k|^2)
//! ```
//!
//! where `P_i` is the view's projection of the films' expected light `G V_k` divided by its white, `d` compares in
//! the values that are measured (see [`super::divergence`]), and the second sum is what films that lie astray
//! scatter about that (see [`blur`]). The method is the accelerated proximal gradient (Beck and Teboulle
//! 2009; see [`kernel::Pace`]) with a step of its own for every film or voxel:
//! the inverse of `B^T C B 1` (De Pierro 1995), which bounds the curvature of `|B V|^2` in the weights C
//! because all entries of the projection B are non-negative. No step size is searched.
//!
//! Where nothing ties one row of pixels to the next, every row is a problem of its own, small enough for the
//! processor's cache ([`apart`]); else all rows move together ([`together`]).

mod apart;
mod blur;
mod kernel;
mod lines;
mod together;

use std::borrow::Cow;
use std::sync::Arc;

pub(super) use blur::FilmBlur;

use super::divergence::Divergence;
use super::stop::Stop;
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
    /// How much the errors of each pixel (row, column) count beside that; nothing for all alike.
    pub(super) mask: Option<Vec<f32>>,
}

/// The problem of all colours: the views, and how the films' light spreads.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) views: Vec<SolverView>,
    /// Of each film: how its light spreads; nothing where no film's does.
    pub(super) blurs: Vec<FilmBlur>,
    pub(super) divergence: Divergence,
    /// The strength of the structure loss beside the squared error; along rows alone where they are apart.
    pub(super) structure: f32,
    /// Whether each voxel (film, row, column) stays as it is, where any does.
    pub(super) fixed: Option<Arc<[bool]>>,
    pub(super) films: usize,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Asks the solver to stop.
    pub(super) stop: Stop,
}

/// What is lost to errors of the expected light, to their structure, and to what scatters about that light.
struct Loss {
    errors: f64,
    structure: f64,
    scatter: f64,
}

impl Loss {
    fn sum(&self) -> f64 {
        self.errors + self.structure + self.scatter
    }
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
pub(super) const PATIENCE: usize = 10;

/// Voxels that no view sees have no curvature: this bounds their step, which nothing drives.
const LEAST_CURVATURE: f32 = 1e-3;

impl Problem {
    /// Lowers the loss of one colour from where `volume` (film, row, column) is; `targets` are the views'
    /// patterns (row, column). `watch` is told the iteration and the loss of the errors alone.
    pub(super) fn solve(
        &self,
        targets: &[&[f32]],
        volume: &mut [f32],
        effort: Effort,
        watch: &mut dyn FnMut(usize, f64),
    ) {
        if self.rows_are_apart() {
            apart::solve(self, targets, volume, effort, watch);
        } else {
            together::solve(self, targets, volume, effort, watch);
        }
    }

    /// Whether every row of pixels is a problem of its own.
    pub(super) fn rows_are_apart(&self) -> bool {
        !self.divergence.varies()
            && self.fixed.is_none()
            && self.blurs.is_empty()
            && self.views.iter().all(|view| view.mask.is_none())
            && self.views.iter().all(|view| view.rays.rows_are_apart())
    }

    /// Brings every voxel of one colour to one of `levels` of glow, which rise; as [`Problem::solve`].
    pub(super) fn settle(&self, targets: &[&[f32]], volume: &mut [f32], levels: &[f32]) {
        together::settle(self, targets, volume, levels);
    }

    /// The problem of an ink that gives the part `ink_yield` of the light.
    pub(super) fn of_yield(&self, ink_yield: f32) -> Cow<'_, Self> {
        if ink_yield == 1.0 {
            return Cow::Borrowed(self);
        }
        let mut problem = self.clone();
        for weight in problem.views.iter_mut().flat_map(|view| &mut view.film_weights) {
            *weight *= ink_yield;
        }
        problem.blurs.iter_mut().for_each(|blur| blur.noise *= ink_yield * ink_yield);
        Cow::Owned(problem)
    }

    /// What films that lie astray scatter counts this much.
    fn noise(&self, film: usize) -> f32 {
        self.blurs.get(film).map_or(0.0, |blur| blur.noise)
    }

    /// Whether some voxels' steps differ from others' of their film.
    fn steps_vary(&self) -> bool {
        self.divergence.varies()
            || self.structure > 0.0
            || self.fixed.is_some()
            || self.views.iter().any(|view| view.mask.is_some())
    }

    /// Turns the sums of a row's curvatures into its steps; what is fixed takes none.
    #[inline(always)]
    fn curvatures_to_steps(&self, film: usize, row: usize, line: &mut [f32]) {
        line.iter_mut().for_each(|value| *value = 1.0 / value.max(LEAST_CURVATURE));
        if let Some(fixed) = &self.fixed {
            let start = (film * self.height + row) * self.width;
            let held = &fixed[start..start + self.width];
            line.iter_mut().zip(held).filter(|(_, held)| **held).for_each(|(step, _)| *step = 0.0);
        }
    }

    /// Whether the voxel of a film at `pixel` (row, column) stays as it is.
    fn is_fixed(&self, film: usize, pixel: usize) -> bool {
        let at = film * self.height * self.width + pixel;
        self.fixed.as_ref().is_some_and(|fixed| fixed[at])
    }

    /// Steps of the films where every pixel's curvature is 1.
    fn film_steps(&self) -> Vec<f32> {
        let step = |film: usize| {
            let views = self.views.iter().map(|view| view.weight * view.film_weights[film] * view.row_sum());
            1.0 / (views.sum::<f32>() + self.noise(film)).max(f32::MIN_POSITIVE)
        };
        (0..self.films).map(step).collect()
    }
}

impl SolverView {
    /// What full ink on every film would show.
    fn row_sum(&self) -> f32 {
        self.film_weights.iter().sum()
    }

    /// How much the errors of the pixels from `start` on count beside the view's weight.
    fn mask_from(&self, start: usize) -> Option<&[f32]> {
        self.mask.as_deref().map(|mask| &mask[start..])
    }
}
