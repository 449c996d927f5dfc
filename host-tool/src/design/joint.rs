//! Volume, lamp pairs and whites solved together.
//!
//! Each view is seen under its own pair only, so pairs weight the films differently and part the views.
//! Volume and pairs are improved in turn: the volume for given pairs, then each view's pair in closed form.
//! Where that ends depends on where it starts, so several starts are tried on small films and the best is
//! carried on to large ones.

use std::borrow::Cow;

use rayon::prelude::*;

use super::emphasis::LampSums;
use super::fixed::FixedInk;
use super::least_squares::{Effort, Problem};
use super::optimise::{Colours, Lighting, design_weights, improve, set_up};
use super::request::{DesignRequest, DesignSettings, OpticsModel, Progress};
use super::scale::{enlarge_planes, enlarged_volume, reduced};
use super::sixteen::{from_sixteen_bits, to_sixteen_bits};
use crate::measure::{fit, percentiles, psnr_db};
use crate::optics::{LampPair, film_weights};
use crate::picture::Picture;
use crate::projection::{Rays, project_along};
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

/// Pixels along the longer side of the films on which starts are compared, and of the next larger ones.
const SEARCH_PIXELS: usize = 64;
const SETTLE_PIXELS: usize = 128;

/// Starts that are carried on after a first look.
const FINALISTS: usize = 4;

/// Iterations between two looks at the lamps in the search.
const SEARCH_ITERATIONS: usize = 10;

/// Rounds of volume and lamps on films of each size, and the iterations in each.
const SETTLE_ROUNDS: usize = 3;
const SETTLE_ITERATIONS: usize = 10;

/// The most free views for which every choice of a lamp for each is tried.
const MOST_FREE: usize = 4;

/// Of each free view: the bits of a start's number whose parity chooses its lamp.
const COLUMNS: [usize; 15] = [1, 2, 4, 8, 3, 5, 6, 9, 10, 12, 7, 11, 13, 14, 15];

/// Solves the request: on small films for the lamps, then on larger and larger ones; around the `fixed` ink, where
/// there is some. Where lightings near the best are known, the search starts there and nowhere else.
pub(super) fn solve(
    request: &DesignRequest,
    fixed: Option<&FixedInk>,
    known: &[Lighting],
    report: &mut dyn FnMut(Progress),
) -> (Volume, Lighting) {
    let fixed = fixed.map(|fixed| fixed.glowing(&request.emission()));
    let fixed = fixed.as_ref();
    let (settled, lighting) = settle(request, fixed, known, report);
    let problem = set_up(request, &request.targets(), &lighting, fixed);
    (solve_each_colour(request, &problem, settled, fixed, report), lighting)
}

/// Solves one colour after the other from where the smaller films `start` are. The solver takes several times the memory
/// of the colour that it is at; the others wait in 16 bits, or have not been enlarged.
pub(super) fn solve_each_colour(
    request: &DesignRequest,
    problem: &Problem,
    start: Volume,
    fixed: Option<&FixedInk>,
    report: &mut dyn FnMut(Progress),
) -> Volume {
    /// Where all colours are solved: the memory of the others is not there until they are put into it.
    const LAST: usize = CHANNELS - 1;
    let stack = &request.stack;
    let size = (stack.width_px, stack.height_px);
    let mut colours = Colours::new(request, problem, effort(&request.settings));
    let from = (start.width(), start.height());
    let starts: [Vec<f32>; CHANNELS] = std::array::from_fn(|channel| start.channel(channel).to_vec());
    drop(start);
    let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
    let mut solved: Vec<Vec<u16>> = Vec::new();
    for (channel, start) in starts.into_iter().enumerate() {
        let films = volume.channel_mut(LAST);
        enlarge_planes(&start, from, films, size);
        drop(start);
        if let Some(fixed) = fixed {
            fixed.put_into_channel(channel, films);
        }
        colours.improve(channel, films, report);
        request.emission().turn_into_ink(films);
        if channel != LAST {
            solved.push(films.par_iter().map(|ink| to_sixteen_bits(*ink)).collect());
        }
    }
    for (channel, solved) in solved.into_iter().enumerate() {
        let inks = volume.channel_mut(channel).par_iter_mut().zip(solved);
        inks.for_each(|(ink, bits)| *ink = from_sixteen_bits(bits));
    }
    volume
}

/// Finds the lamps on small films, and a volume of glow to begin from, smaller than the request's. What is fixed glows too.
pub(super) fn settle(
    request: &DesignRequest,
    fixed: Option<&FixedInk>,
    known: &[Lighting],
    report: &mut dyn FnMut(Progress),
) -> (Volume, Lighting) {
    let search = Stage::new(reduced(request, SEARCH_PIXELS), fixed);
    let mut state = match known {
        [] => search.best(starts(request), &[(FINALISTS, 2), (1, 3)], report),
        known => search.best(known.to_vec(), &[(1, 2)], report),
    };
    if known.is_empty() && free_views(request).len() > MOST_FREE {
        state = search.try_other_lamps(state);
    }
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

/// The voxels of the films from which the last ones begin, as a part of the stack's.
pub(super) fn start_part(stack: &Stack) -> f64 {
    let longer = stack.width_px.max(stack.height_px);
    let sizes = std::iter::successors(Some(SETTLE_PIXELS), |pixels| Some(2 * pixels));
    let settled = sizes.take_while(|pixels| *pixels < longer).last().unwrap_or(SEARCH_PIXELS);
    (settled as f64 / longer as f64).min(1.0).powi(2)
}

/// When the optimiser stops.
pub(super) fn effort(settings: &DesignSettings) -> Effort {
    // A gain of x dB lowers the loss by the part 1 - 10^(-x / 10).
    let tolerance = 1.0 - 10f64.powf(-settings.tolerance_db / 10.0);
    Effort { iterations: settings.iterations, tolerance }
}

/// Lightings to begin from: under ideal optics lamps do not matter; else both lamps full, and each view under either
/// lamp. All choices are tried for up to four free views. For more views there are as many starts as for four, in which
/// any two of fifteen views take each of their four choices equally often (the columns of a Hadamard matrix), and
/// [`Stage::try_other_lamps`] goes on from the best.
fn starts(request: &DesignRequest) -> Vec<Lighting> {
    let views = request.views.len();
    let even = Lighting::even(views, LampPair::FULL);
    if request.settings.optics == OpticsModel::Ideal {
        return vec![even];
    }
    let free = free_views(request);
    let choices = 1usize << free.len().min(MOST_FREE);
    let held: Vec<_> = request.views.iter().map(|view| view.held_pair().unwrap_or(LampPair::FULL)).collect();
    let chosen = |choice: usize| {
        let mut pairs = held.clone();
        for (&view, column) in free.iter().zip(COLUMNS.iter().cycle()) {
            let top = (choice & column).count_ones().is_multiple_of(2);
            pairs[view] = if top { LampPair::TOP } else { LampPair::BOTTOM };
        }
        Lighting { pairs, ..even.clone() }
    };
    let full = Lighting { pairs: held.clone(), ..even.clone() };
    let each = (0..choices).filter(|_| !free.is_empty()).map(chosen);
    std::iter::once(full).chain(each).collect()
}

/// The views whose lamps are not held.
fn free_views(request: &DesignRequest) -> Vec<usize> {
    (0..request.views.len()).filter(|&view| request.views[view].held_pair().is_none()).collect()
}

/// The problem at one size of films.
struct Stage {
    request: DesignRequest,
    fixed: Option<FixedInk>,
    targets: Vec<Picture>,
    rays: Vec<Rays>,
}

/// Where the search is.
#[derive(Clone)]
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

    /// Tries all starts for the rounds of the first look, goes on with as many of the best as it keeps, and so on;
    /// returns the best of the last.
    fn best(
        &self,
        starts: Vec<Lighting>,
        looks: &[(usize, usize)],
        report: &mut dyn FnMut(Progress),
    ) -> State {
        let total = starts.len();
        let mut states: Vec<State> = starts.into_iter().map(|start| self.begin(start)).collect();
        for &(kept, rounds) in looks {
            states.par_iter_mut().for_each(|state| self.alternate(state, rounds, SEARCH_ITERATIONS));
            states.sort_by(|a, b| b.quality_db.total_cmp(&a.quality_db));
            states.truncate(kept);
            report(Progress::at("searching lamp pairs", total, total).reaching(states[0].quality_db));
        }
        states.swap_remove(0)
    }

    /// Lets each free view in turn go on from the other lamp, and keeps what is better.
    fn try_other_lamps(&self, mut state: State) -> State {
        for view in free_views(&self.request) {
            let mut turned = state.clone();
            let pair = &mut turned.lighting.pairs[view];
            *pair = LampPair::new(pair.bottom, pair.top);
            let mut tried = [state, turned];
            tried.par_iter_mut().for_each(|state| self.alternate(state, 2, SEARCH_ITERATIONS));
            let [same, turned] = tried;
            state = if turned.quality_db > same.quality_db { turned } else { same };
        }
        state
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
            let problem = set_up(&self.request, &self.targets, &state.lighting, self.fixed.as_ref());
            improve(&self.request, &problem, &mut state.volume, effort, &mut |_| ());
            self.light(state);
        }
    }

    /// Finds the best pair and white of each view for the volume as it is.
    fn light(&self, state: &mut State) {
        let settings = &self.request.settings;
        let emission = self.request.emission();
        let light = emission.light_of_glow(Cow::Borrowed(&state.volume));
        let mut qualities = Vec::new();
        let mut whites = Vec::new();
        let mut efficiencies = Vec::new();
        for (index, view) in self.request.views.iter().enumerate() {
            let (rays, target) = (&self.rays[index], &self.targets[index]);
            if settings.optics == OpticsModel::Stack {
                let under = |lamps| {
                    project_along(&light, rays, &film_weights(&self.request.stack, view.direction, lamps))
                };
                let (top, bottom) = (under(LampPair::TOP), under(LampPair::BOTTOM));
                let sums = LampSums::of(top.values(), bottom.values(), target.values(), settings.tone);
                state.lighting.pairs[index] = view.held_pair().unwrap_or_else(|| sums.best_pair());
            }
            let weights = design_weights(&self.request, index, state.lighting.pairs[index]);
            let shown = project_along(&light, rays, &weights);
            let fitted = fit(&shown, &view.pattern, settings.tone);
            let [bright] = percentiles(shown.values(), [99.5]);
            let full = emission.white() * weights.iter().sum::<f64>();
            efficiencies.push(bright / full.max(1e-9));
            qualities.push(psnr_db(&fitted.picture, &view.pattern));
            whites.push(1.0 / (fitted.gain * full).max(1e-9));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, ViewRequest};
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;
    use vitrine_exhibit::units::Lamp;

    fn request(views: usize) -> DesignRequest {
        let view =
            |index: usize| ViewRequest::new(index.to_string(), Picture::new(4, 4), Direction::default());
        DesignRequest {
            stack: Stack { width_px: 4, height_px: 4, ..Stack::default() },
            distance: ViewerDistance::Parallel,
            views: (0..views).map(view).collect(),
            settings: DesignSettings::default(),
            stop: Default::default(),
        }
    }

    #[test]
    fn up_to_four_free_views_begin_from_every_choice_of_lamps() {
        let mut request = request(5);
        request.views[1].lamp = Some(Lamp::Bottom);
        let starts = starts(&request);
        assert_eq!(starts.len(), 17);
        assert!(starts.iter().all(|start| start.pairs[1] == LampPair::BOTTOM));
        let mut choices: Vec<Vec<bool>> = starts[1..]
            .iter()
            .map(|start| [0, 2, 3, 4].map(|view| start.pairs[view] == LampPair::TOP).to_vec())
            .collect();
        choices.sort();
        choices.dedup();
        assert_eq!(choices.len(), 16);
    }

    #[test]
    fn of_many_free_views_any_two_begin_from_all_four_choices() {
        let starts = starts(&request(15));
        assert_eq!(starts.len(), 17);
        for (one, other) in (0..15).flat_map(|one| (0..one).map(move |other| (one, other))) {
            let both = starts[1..]
                .iter()
                .filter(|start| [one, other].map(|view| start.pairs[view]) == [LampPair::TOP; 2]);
            assert_eq!(both.count(), 4, "{one} {other}");
        }
    }
}
