//! Halftone-aware design: films that hold only the printer's levels, chosen jointly.
//!
//! A printer that knows few levels leaves an error at every voxel. Rounded film by film, these errors are
//! strangers to each other and add up in every view. Here they are fed back through the operator. With U the
//! volume before and V the one of levels, the loss
//!
//! ```text
//! sum over views i, pixels p of  q_ip ((A_i (V - U))_p)^2
//! ```
//!
//! is quadratic in every voxel, so the best level of one voxel, all others given, is the level nearest to
//! the parabola's lowest point. Films are settled from the outside in, voxel by voxel, each looking at the
//! views as the voxels before it have left them; what a film leaves over, the films that are not settled
//! yet take up before the next one is. In the end all voxels choose again, as long as that lowers the loss
//! (direct binary search, Analoui and Allebach 1992, over all films and views at once).

use rayon::prelude::*;

use super::emphasis::importance;
use super::request::{DesignRequest, OpticsModel, Progress};
use super::result::Design;
use crate::optics::{film_weights, ideal_weights};
use crate::picture::Picture;
use crate::projection::FilmTaps;
use crate::volume::Volume;

/// Sweeps over all films in which voxels choose again.
const LAST_SWEEPS: usize = 3;

/// Brings every voxel of `volume` to one of `levels` evenly spaced values from 0 to 1, so that the views of
/// `request` change least.
pub(super) fn halftone(
    request: &DesignRequest,
    volume: &mut Volume,
    levels: u16,
    report: &mut dyn FnMut(Progress),
) {
    let views = seen(request, volume);
    let size = request.stack.film_len() * request.stack.films;
    let settled: usize = volume
        .values_mut()
        .par_chunks_mut(size.max(1))
        .enumerate()
        .map(|(channel, films)| Channel::new(request, &views, channel, films, levels).settle())
        .sum();
    report(Progress::at("halftoning", settled, settled));
}

/// A view as the design shows it before halftoning.
struct SeenView {
    taps: Vec<FilmTaps>,
    /// Of each film: its weight times the view's gain.
    film_weights: Vec<f32>,
    /// How much a pixel's squared error counts.
    importance: Picture,
}

fn seen(request: &DesignRequest, volume: &Volume) -> Vec<SeenView> {
    let design = Design::of(request, volume.clone());
    let targets = request.targets();
    let stack = &request.stack;
    request
        .views
        .iter()
        .zip(&design.views)
        .zip(&targets)
        .enumerate()
        .map(|(index, ((view, designed), target))| {
            let weights = match request.settings.optics {
                OpticsModel::Ideal => ideal_weights(stack),
                OpticsModel::Stack => film_weights(stack, view.direction, designed.emphasis),
            };
            let gain = designed.quality.gain;
            let rays = request.rays(index);
            let film_weights: Vec<f64> = weights.iter().map(|weight| weight * gain).collect();
            let mut importance =
                target.map(|wanted| view.weight as f32 * importance(request.settings.tone, wanted));
            if let Some(weights) = view.pixel_weights() {
                for (value, weight) in importance.values_mut().iter_mut().zip(weights.iter().cycle()) {
                    *value *= weight;
                }
            }
            SeenView {
                taps: (0..stack.films).map(|film| rays.taps(film)).collect(),
                film_weights: film_weights.iter().map(|&weight| weight as f32).collect(),
                importance,
            }
        })
        .collect()
}

/// One colour: its films, and what each view shows amiss.
struct Channel<'a> {
    films: &'a mut [f32],
    views: Vec<ChannelView<'a>>,
    film_count: usize,
    width: usize,
    height: usize,
    steps: f32,
}

struct ChannelView<'a> {
    seen: &'a SeenView,
    /// What is shown, times the gain, less what was shown before.
    error: Vec<f32>,
    importance: &'a [f32],
}

/// What a voxel may become.
#[derive(Clone, Copy, PartialEq)]
enum Values {
    /// Anything in 0..=1.
    Any,
    /// One of the printer's levels.
    Levels,
}

impl<'a> Channel<'a> {
    fn new(
        request: &DesignRequest,
        views: &'a [SeenView],
        channel: usize,
        films: &'a mut [f32],
        levels: u16,
    ) -> Self {
        let views = views.iter().map(|seen| ChannelView {
            seen,
            error: vec![0.0; request.stack.film_len()],
            importance: seen.importance.channel(channel),
        });
        Self {
            films,
            views: views.collect(),
            film_count: request.stack.films,
            width: request.stack.width_px,
            height: request.stack.height_px,
            steps: f32::from(levels.max(2) - 1),
        }
    }

    /// Settles all films and returns how many there are.
    fn settle(mut self) -> usize {
        let films = self.film_count;
        let order = outside_in(films);
        for (settled, &film) in order.iter().enumerate() {
            self.sweep(film, Values::Levels);
            for &open in &order[settled + 1..] {
                self.sweep(open, Values::Any);
            }
        }
        for _ in 0..LAST_SWEEPS {
            for &film in &order {
                self.sweep(film, Values::Levels);
            }
        }
        films
    }

    /// Lets every voxel of a film choose its best value; row by row, there and back.
    fn sweep(&mut self, film: usize, values: Values) {
        for row in 0..self.height {
            for step in 0..self.width {
                let column = if row % 2 == 0 { step } else { self.width - 1 - step };
                self.choose(film, row, column, values);
            }
        }
    }

    fn choose(&mut self, film: usize, row: usize, column: usize, values: Values) {
        let at = (film * self.height + row) * self.width + column;
        let value = self.films[at];
        let (mut slope, mut curvature) = (0.0, 0.0);
        for view in &self.views {
            let weight = view.seen.film_weights[film];
            let taps = &view.seen.taps[film];
            for &(picture_row, row_weight) in taps.rows.of(row) {
                let line = picture_row as usize * self.width;
                for &(picture_column, column_weight) in taps.columns.of(column) {
                    let pixel = line + picture_column as usize;
                    let share = weight * row_weight * column_weight;
                    let pull = view.importance[pixel] * share;
                    slope += pull * view.error[pixel];
                    curvature += pull * share;
                }
            }
        }
        if curvature <= 0.0 {
            self.films[at] =
                if values == Values::Any { value } else { (value * self.steps).round() / self.steps };
            return;
        }
        let best = (value - slope / curvature).clamp(0.0, 1.0);
        let chosen = match values {
            Values::Any => best,
            Values::Levels => (best * self.steps).round() / self.steps,
        };
        if chosen != value {
            self.films[at] = chosen;
            self.show(film, row, column, chosen - value);
        }
    }

    /// Lets the views see that a voxel has changed.
    fn show(&mut self, film: usize, row: usize, column: usize, change: f32) {
        for view in &mut self.views {
            let weight = change * view.seen.film_weights[film];
            let taps = &view.seen.taps[film];
            for &(picture_row, row_weight) in taps.rows.of(row) {
                let line = picture_row as usize * self.width;
                for &(picture_column, column_weight) in taps.columns.of(column) {
                    view.error[line + picture_column as usize] += weight * row_weight * column_weight;
                }
            }
        }
    }
}

/// 0, last, 1, last but one, ... : the outer films first, for they part the views most.
fn outside_in(films: usize) -> Vec<usize> {
    (0..films).map(|index| if index % 2 == 0 { index / 2 } else { films - 1 - index / 2 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, Stop, Tone, ViewRequest};
    use crate::measure::mean_square_error;
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;
    use crate::stack::Stack;

    fn request(tone: Tone) -> DesignRequest {
        let side = 40;
        let pattern = |phase: f32| {
            let mut picture = Picture::new(side, side);
            for (index, value) in picture.values_mut().iter_mut().enumerate() {
                let (x, y) = ((index % side) as f32, (index / side % side) as f32);
                *value = 0.5 + 0.3 * (0.35 * x + phase).sin() * (0.2 * y + phase).cos();
            }
            picture
        };
        let views = [("left", -25.0), ("right", 25.0)].iter().enumerate().map(|(index, (id, degrees))| {
            ViewRequest::new(*id, pattern(index as f32 * 2.0), Direction::new(*degrees, 5.0))
        });
        DesignRequest {
            stack: Stack { films: 8, width_px: side, height_px: side, width_mm: 10.0, ..Stack::default() },
            distance: ViewerDistance::Parallel,
            views: views.collect(),
            settings: DesignSettings { optics: OpticsModel::Ideal, tone, ..DesignSettings::default() },
            stop: Stop::default(),
        }
    }

    /// Ink in the middle of its range, as an optimiser leaves it.
    fn volume(request: &DesignRequest) -> Volume {
        let stack = &request.stack;
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        for (index, value) in volume.values_mut().iter_mut().enumerate() {
            *value = 0.4 + 0.35 * ((index % 11) as f32 / 11.0 - 0.5);
        }
        volume
    }

    /// Squared difference of what two volumes show, over all views.
    fn loss(request: &DesignRequest, volume: &Volume, given: &Volume) -> f64 {
        let shown = |volume: &Volume| Design::of(request, volume.clone()).views;
        let views = shown(volume).into_iter().zip(shown(given));
        views.map(|(a, b)| mean_square_error(a.projection.values(), b.projection.values())).sum()
    }

    #[test]
    fn only_the_printers_levels_remain() {
        for levels in [2u16, 4, 16] {
            let request = request(Tone::Code);
            let mut volume = volume(&request);
            halftone(&request, &mut volume, levels, &mut |_| ());
            for value in volume.values() {
                let step = value * f32::from(levels - 1);
                assert!((step - step.round()).abs() < 1e-5, "{value} is none of {levels} levels");
            }
        }
    }

    #[test]
    fn joint_levels_show_the_pictures_better_than_rounded_ones() {
        let request = request(Tone::Code);
        let given = volume(&request);
        for levels in [2u16, 4] {
            let mut rounded = given.clone();
            let steps = f32::from(levels - 1);
            rounded.values_mut().iter_mut().for_each(|value| *value = (*value * steps).round() / steps);
            let mut joint = given.clone();
            halftone(&request, &mut joint, levels, &mut |_| ());
            let (joint, rounded) = (loss(&request, &joint, &given), loss(&request, &rounded, &given));
            assert!(joint < 0.5 * rounded, "{levels} levels: {joint} against {rounded}");
        }
    }

    #[test]
    fn films_are_settled_from_the_outside_in() {
        assert_eq!(outside_in(5), [0, 4, 1, 3, 2]);
        assert_eq!(outside_in(4), [0, 3, 1, 2]);
    }
}
