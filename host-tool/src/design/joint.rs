//! Volume, lamp pairs and whites solved together.
//!
//! Each view is seen under its own pair only, so pairs weight the films differently and part the views.
//! Volume and pairs are improved in turn: the volume for given pairs, then each view's pair in closed form.
//! Where that ends depends on where it starts, so several starts are tried on small films and the best is
//! carried on to large ones.

use rayon::prelude::*;

use super::emphasis::LampSums;
use super::fixed::FixedInk;
use super::least_squares::Effort;
use super::optimise::{Lighting, design_weights, improve, set_up};
use super::request::{DesignRequest, DesignSettings, OpticsModel, Progress, ViewRequest};
use super::scale::{enlarged_volume, reduced};
use crate::measure::{fit, percentiles, psnr_db};
use crate::optics::{LampPair, film_weights};
use crate::picture::Picture;
use crate::projection::{Rays, project_along};
use crate::volume::Volume;

/// Pixels along the longer side of the films on which starts are compared, and of the next larger ones.
const SEARCH_PIXELS: usize = 64;
const SETTLE_PIXELS: usize = 128;

/// Starts that are carried on after a first look.
const FINALISTS: usize = 4;

/// Iterations between two looks at the lamps in the search.
const SEARCH_ITERATIONS: usize = 10;

/// Rounds of volume and lamps on films of each size, and the iterations in each.
const SETTLE_ROUNDS: usize = 3;
const SETTLE_ITERATIONS: usize = 16;

/// The most starts that are tried.
const MOST_STARTS: usize = 16;

/// Solves the request: on small films for the lamps, then on larger and larger ones.
/// Around the `fixed` ink, where there is some.
pub(super) fn solve(
    request: &DesignRequest,
    fixed: Option<&FixedInk>,
    report: &mut dyn FnMut(Progress),
) -> Volume {
    let (volume, lighting) = settle(request, fixed, report);
    let mut volume = enlarged_volume(&volume, request.stack.width_px, request.stack.height_px);
    if let Some(fixed) = fixed {
        fixed.put_into(&mut volume);
    }
    let effort = effort(&request.settings);
    improve(request, &set_up(request, &lighting, fixed), &request.targets(), &mut volume, effort, report);
    volume
}

/// Finds the lamps on small films, and a volume to begin from, smaller than the request's.
pub(super) fn settle(
    request: &DesignRequest,
    fixed: Option<&FixedInk>,
    report: &mut dyn FnMut(Progress),
) -> (Volume, Lighting) {
    let search = Stage::new(reduced(request, SEARCH_PIXELS), fixed);
    let mut state = search.best(starts(request), report);
    let longer = request.stack.width_px.max(request.stack.height_px);
    let mut pixels = SETTLE_PIXELS;
    while pixels < longer {
        let stage = Stage::new(reduced(request, pixels), fixed);
        state.volume =
            enlarged_volume(&state.volume, stage.request.stack.width_px, stage.request.stack.height_px);
        stage.alternate(&mut state, SETTLE_ROUNDS, SETTLE_ITERATIONS);
        report(Progress::at("settling lamps on small films", pixels, longer).reaching(state.quality_db));
        pixels *= 2;
    }
    (state.volume, state.lighting)
}

/// When the optimiser stops.
pub(super) fn effort(settings: &DesignSettings) -> Effort {
    // A gain of x dB lowers the loss by the part 1 - 10^(-x / 10).
    let tolerance = 1.0 - 10f64.powf(-settings.tolerance_db / 10.0);
    Effort { iterations: settings.iterations, tolerance }
}

/// Lightings to begin from: under ideal optics lamps do not matter; else each view under either lamp.
fn starts(request: &DesignRequest) -> Vec<Lighting> {
    let views = request.views.len();
    if request.settings.optics == OpticsModel::Ideal {
        return vec![Lighting::even(views, LampPair::FULL)];
    }
    let held: Vec<Option<LampPair>> = request.views.iter().map(ViewRequest::held_pair).collect();
    let lit = |pair: &dyn Fn(usize) -> LampPair| {
        let pairs = held.iter().enumerate().map(|(view, held)| held.unwrap_or_else(|| pair(view)));
        Lighting { pairs: pairs.collect(), ..Lighting::even(views, LampPair::FULL) }
    };
    let free: Vec<usize> = (0..views).filter(|&view| held[view].is_none()).collect();
    let mut starts = vec![lit(&|_| LampPair::FULL)];
    if free.is_empty() {
        return starts;
    }
    let all = 1usize << free.len().min(16);
    let stride = (all / MOST_STARTS).max(1);
    for choice in (0..all).step_by(stride) {
        let bit = |view: usize| free.iter().position(|&other| other == view).unwrap_or(0);
        starts.push(lit(&|view| if choice >> bit(view) & 1 == 0 { LampPair::TOP } else { LampPair::BOTTOM }));
    }
    starts
}

/// The problem at one size of films.
struct Stage {
    request: DesignRequest,
    fixed: Option<FixedInk>,
    targets: Vec<Picture>,
    rays: Vec<Rays>,
}

/// Where the search is.
struct State {
    volume: Volume,
    lighting: Lighting,
    /// Mean quality of the views in dB, each with its best gain.
    quality_db: f64,
}

impl Stage {
    fn new(request: DesignRequest, fixed: Option<&FixedInk>) -> Self {
        let fixed = fixed.map(|fixed| fixed.reduced(request.stack.width_px, request.stack.height_px));
        let targets = request.targets();
        let rays = (0..request.views.len()).map(|view| request.rays(view)).collect();
        Self { request, fixed, targets, rays }
    }

    fn begin(&self, lighting: Lighting) -> State {
        let stack = &self.request.stack;
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        volume.values_mut().fill(self.request.settings.brightness as f32 * 0.5);
        State { volume, lighting, quality_db: f64::NEG_INFINITY }
    }

    /// Tries all starts a little, goes on with the best of them, and returns the best of those.
    fn best(&self, starts: Vec<Lighting>, report: &mut dyn FnMut(Progress)) -> State {
        let total = starts.len();
        let mut states: Vec<State> = starts.into_iter().map(|start| self.begin(start)).collect();
        for (kept, rounds) in [(FINALISTS, 2), (1, 3)] {
            states.par_iter_mut().for_each(|state| self.alternate(state, rounds, SEARCH_ITERATIONS));
            states.sort_by(|a, b| b.quality_db.total_cmp(&a.quality_db));
            states.truncate(kept);
            report(Progress::at("searching lamp pairs", total, total).reaching(states[0].quality_db));
        }
        states.swap_remove(0)
    }

    /// Improves volume and lighting in turn.
    fn alternate(&self, state: &mut State, rounds: usize, iterations: usize) {
        let effort = Effort { iterations, tolerance: 0.0 };
        if let Some(fixed) = &self.fixed {
            fixed.put_into(&mut state.volume);
        }
        for _ in 0..rounds {
            if self.request.stop.is_asked() {
                return;
            }
            let problem = set_up(&self.request, &state.lighting, self.fixed.as_ref());
            improve(&self.request, &problem, &self.targets, &mut state.volume, effort, &mut |_| ());
            self.light(state);
        }
    }

    /// Finds the best pair and white of each view for the volume as it is.
    fn light(&self, state: &mut State) {
        let settings = &self.request.settings;
        let mut qualities = Vec::new();
        let mut whites = Vec::new();
        let mut efficiencies = Vec::new();
        for (index, view) in self.request.views.iter().enumerate() {
            let (rays, target) = (&self.rays[index], &self.targets[index]);
            if settings.optics == OpticsModel::Stack {
                let under = |lamps| {
                    project_along(
                        &state.volume,
                        rays,
                        &film_weights(&self.request.stack, view.direction, lamps),
                    )
                };
                let (top, bottom) = (under(LampPair::TOP), under(LampPair::BOTTOM));
                let sums = LampSums::of(top.values(), bottom.values(), target.values(), settings.tone);
                state.lighting.pairs[index] = view.held_pair().unwrap_or_else(|| sums.best_pair());
            }
            let weights = design_weights(&self.request, index, state.lighting.pairs[index]);
            let shown = project_along(&state.volume, rays, &weights);
            let fitted = fit(&shown, &view.pattern, settings.tone);
            let [bright] = percentiles(shown.values(), [99.5]);
            efficiencies.push(bright / weights.iter().sum::<f64>().max(1e-9));
            qualities.push(psnr_db(&fitted.picture, &view.pattern));
            whites.push(1.0 / (fitted.gain * weights.iter().sum::<f64>()).max(1e-9));
        }
        // Highlights fall short of what is wanted; ask for more until half of that, by ratio, is made good: what
        // is left is cheaper in brightness than in quality.
        let reached = efficiencies.iter().sum::<f64>() / efficiencies.len() as f64 / settings.brightness;
        state.lighting.level = (state.lighting.level / reached.max(1e-3)).sqrt().clamp(0.5, 3.0);
        state.lighting.whites = relative(whites.into_iter());
        // The mean square error is 10^(-dB / 10).
        let shares = qualities.iter().map(|quality| 10f64.powf(-quality / 10.0 * settings.balance));
        state.lighting.shares = relative(shares);
        state.quality_db = qualities.iter().sum::<f64>() / qualities.len() as f64;
    }
}

/// Scales the numbers so that their geometric mean is 1.
fn relative(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let numbers: Vec<f64> = numbers.collect();
    let mean = geometric_mean(&numbers);
    numbers.iter().map(|number| number / mean).collect()
}

fn geometric_mean(numbers: &[f64]) -> f64 {
    (numbers.iter().map(|number| number.ln()).sum::<f64>() / numbers.len() as f64).exp()
}
