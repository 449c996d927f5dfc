//! Sets up the optimiser for a request: which films weigh how much, how bright white is, how smooth each
//! film has to be.

use std::borrow::Cow;

use super::divergence::Divergence;
use super::fixed::FixedInk;
use super::least_squares::{Effort, PATIENCE, Problem, SolverView};
use super::request::{DesignRequest, OpticsModel, Progress, Tone};
use super::robust;
use crate::optics::{LampPair, film_weights, ideal_weights};
use crate::picture::Picture;
use crate::projection::single;
use crate::volume::{CHANNELS, Volume};

/// Returns the weights of the films in a view under these lamps, in the optics of the design.
pub(super) fn design_weights(request: &DesignRequest, view: usize, lamps: LampPair) -> Vec<f64> {
    match request.settings.optics {
        OpticsModel::Stack => film_weights(&request.stack, request.views[view].direction, lamps),
        OpticsModel::Ideal => ideal_weights(&request.stack),
    }
}

/// How the views are lit, and how bright each is wanted beside the others.
#[derive(Clone, Debug)]
pub(super) struct Lighting {
    /// The lamp pair of each view.
    pub(super) pairs: Vec<LampPair>,
    /// The white of each view as a multiple of the wanted brightness; their geometric mean is 1.
    pub(super) whites: Vec<f64>,
    /// How much brighter than wanted the views are aimed at, for highlights fall short.
    pub(super) level: f64,
    /// How much each view's errors count beside its own weight; their geometric mean is 1.
    pub(super) shares: Vec<f64>,
}

impl Lighting {
    /// Every view under the same pair and equally bright.
    pub(super) fn even(views: usize, pair: LampPair) -> Self {
        Self { pairs: vec![pair; views], whites: vec![1.0; views], level: 1.0, shares: vec![1.0; views] }
    }

    /// The lighting of these views alone, in this order.
    pub(super) fn of_views(&self, order: &[usize]) -> Self {
        fn taken<T: Copy>(of: &[T], order: &[usize]) -> Vec<T> {
            order.iter().map(|&view| of[view]).collect()
        }
        Self {
            pairs: taken(&self.pairs, order),
            whites: taken(&self.whites, order),
            level: self.level,
            shares: taken(&self.shares, order),
        }
    }
}

/// Sets up the problem of all colours for views lit like this.
///
/// Every view's white is `brightness` of what full ink on every film gives under its own pair, times its
/// share in [`Lighting::whites`]. `targets` are the patterns in the values in which films add up; the volume is one
/// of glow (see [`crate::emission`]).
pub(super) fn set_up(
    request: &DesignRequest,
    targets: &[Picture],
    lighting: &Lighting,
    fixed: Option<&FixedInk>,
) -> Problem {
    set_up_counting(request, &robust::counts(request, targets), lighting, fixed)
}

/// As [`set_up`], where it is known how much scattered light counts in each view ([`robust::counts`]).
pub(super) fn set_up_counting(
    request: &DesignRequest,
    counts: &[f32],
    lighting: &Lighting,
    fixed: Option<&FixedInk>,
) -> Problem {
    let settings = &request.settings;
    let stack = &request.stack;
    let emission_white = request.emission().white();
    let views: Vec<SolverView> = request
        .views
        .iter()
        .enumerate()
        .map(|(index, view)| {
            let weights = design_weights(request, index, lighting.pairs[index]);
            let white = settings.brightness
                * lighting.level
                * lighting.whites[index]
                * emission_white
                * weights.iter().sum::<f64>();
            let film_weights = single(&weights.iter().map(|weight| weight / white).collect::<Vec<_>>());
            SolverView {
                rays: request.rays(index),
                film_weights,
                weight: (view.weight * lighting.shares[index]) as f32,
                mask: view.pixel_weights(),
            }
        })
        .collect();
    let blurs = robust::blurs(request, &views, counts);
    let divergence = Divergence::new(settings.tone);
    let mut problem = Problem {
        views,
        blurs,
        films: stack.films,
        divergence,
        structure: 0.0,
        fixed: fixed.map(FixedInk::voxels),
        width: stack.width_px,
        height: stack.height_px,
        stop: request.stop.clone(),
    };
    let suits = if problem.rows_are_apart() { Tone::ROW_STRUCTURE } else { settings.tone.structure() };
    problem.structure = settings.structure.unwrap_or(suits) as f32;
    problem
}

/// What is being done to each colour, in words.
const STAGES: [&str; CHANNELS] = ["solving red", "solving green", "solving blue"];

/// Lowers the loss of all colours from where `volume` is.
pub(super) fn improve(
    request: &DesignRequest,
    problem: &Problem,
    volume: &mut Volume,
    effort: Effort,
    report: &mut dyn FnMut(Progress),
) {
    let mut colours = Colours::new(request, problem, effort);
    for channel in 0..CHANNELS {
        colours.improve(channel, volume.channel_mut(channel), report);
    }
}

/// The colours of a design, improved one after the other.
pub(super) struct Colours<'a> {
    request: &'a DesignRequest,
    problem: &'a Problem,
    effort: Effort,
    /// Mean squared errors of the colours so far.
    losses: Vec<f64>,
}

impl<'a> Colours<'a> {
    pub(super) fn new(request: &'a DesignRequest, problem: &'a Problem, effort: Effort) -> Self {
        Self { request, problem, effort, losses: Vec::new() }
    }

    /// Lowers the loss of the next colour, `channel`, from where `films` (film, row, column) are.
    pub(super) fn improve(&mut self, channel: usize, films: &mut [f32], report: &mut dyn FnMut(Progress)) {
        let Self { request, effort, losses, .. } = self;
        let weight: f32 = self.problem.views.iter().map(|view| view.weight).sum();
        let full = f64::from(weight) * request.stack.film_len() as f64;
        let decibels = |loss: f64| -10.0 * loss.max(1e-12).log10();
        let problem = self.problem.of_yield(request.emission().yields()[channel]);
        let targets = request.channel_targets(channel);
        let targets: Vec<&[f32]> = targets.iter().map(Cow::as_ref).collect();
        losses.push(0.0);
        let mut seen: Vec<(usize, f64)> = Vec::new();
        problem.solve(&targets, films, *effort, &mut |iteration, loss| {
            losses[channel] = loss / full;
            seen.push((iteration, loss));
            let earlier = seen.iter().rev().find(|(before, _)| iteration >= before + PATIENCE);
            let mean = losses.iter().sum::<f64>() / losses.len() as f64;
            report(Progress {
                gained_db: earlier.map(|(_, earlier)| decibels(loss) - decibels(*earlier)),
                ..Progress::at(STAGES[channel], iteration, effort.iterations).reaching(decibels(mean))
            });
        });
    }
}
