//! Halftone-aware design: films that hold only the printer's levels, chosen jointly.
//!
//! A printer that knows few levels leaves an error at every voxel. Rounded film by film, these errors are
//! strangers to each other and add up in every view. Here films are settled one after the other while the rest is
//! solved again, against the same loss as the design itself: under the views' own lamps, with the errors of hands
//! and viewers expected, spreading light and masks (see [`super::least_squares`]). Levels are even steps of ink; the
//! solver sees their glow.

use rayon::prelude::*;

use super::fixed::FixedInk;
use super::optimise::{Lighting, design_weights, set_up};
use super::request::{DesignRequest, Method, Progress};
use super::result::{Design, ViewDesign};
use crate::optics::LampPair;
use crate::picture::Picture;
use crate::volume::Volume;

/// Brings every voxel of `volume` to one of `levels` evenly spaced values from 0 to 1, so that the views of
/// `request` come nearest to their patterns, or for Eq. 1 to what they show. What is `fixed` has such values already and keeps them.
pub(super) fn halftone(
    request: &DesignRequest,
    volume: &mut Volume,
    fixed: Option<&FixedInk>,
    levels: u16,
    report: &mut dyn FnMut(Progress),
) {
    let films = request.stack.films;
    report(Progress::at("halftoning", 0, films));
    let design = Design::of(request, volume.clone());
    let targets = match request.settings.method {
        Method::LeastSquares => request.targets(),
        Method::Product => {
            let gains = design.views.iter().map(|view| view.quality.gain).enumerate();
            gains.map(|(view, gain)| shown(&design.projection(request, view), gain)).collect()
        }
    };
    let problem = set_up(request, &targets, &lighting(request, &design), fixed);
    let emission = request.emission();
    let steps = f32::from(levels.max(2) - 1);
    let glows: Vec<f32> =
        (0..levels.max(2)).map(|level| emission.glow(f64::from(f32::from(level) / steps)) as f32).collect();
    let mut glow = emission.glow_of(volume).into_owned();
    let channels = glow.values_mut().par_chunks_mut(request.stack.film_len() * films);
    channels.zip(emission.yields()).enumerate().for_each(|(channel, (films, ink_yield))| {
        let targets: Vec<&[f32]> = targets.iter().map(|target| target.channel(channel)).collect();
        problem.of_yield(ink_yield).settle(&targets, films, &glows);
    });
    emission.turn_into_ink(glow.values_mut());
    for (ink, settled) in volume.values_mut().iter_mut().zip(glow.values()) {
        *ink = (settled * steps).round() / steps;
    }
    report(Progress::at("halftoning", films, films));
}

fn shown(projection: &Picture, gain: f64) -> Picture {
    projection.map(|value| (gain as f32 * value).min(1.0))
}

/// How the design is lit, with the whites that it shows.
fn lighting(request: &DesignRequest, design: &Design) -> Lighting {
    let pairs: Vec<_> = design.views.iter().map(|view| view.emphasis).collect();
    let white = |(index, view): (usize, &ViewDesign)| {
        let weights = design_weights(request, index, pairs[index]);
        let full = request.settings.brightness * request.emission().white() * weights.iter().sum::<f64>();
        1.0 / (view.quality.gain * full).max(1e-9)
    };
    let whites = design.views.iter().enumerate().map(white).collect();
    Lighting { whites, pairs, ..Lighting::even(request.views.len(), LampPair::FULL) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, HandErrors, OpticsModel, Tone, ViewRequest, as_built};
    use crate::measure::mean_square_error;
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;
    use crate::stack::Stack;

    fn request(method: Method, optics: OpticsModel) -> DesignRequest {
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
            settings: DesignSettings { method, optics, tone: Tone::Code, ..DesignSettings::default() },
            stop: Default::default(),
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
        let [one, other] = [volume, given].map(|volume| Design::of(request, volume.clone()));
        let shown = |design: &Design, view: usize| design.projection(request, view);
        let views = 0..request.views.len();
        views.map(|view| mean_square_error(shown(&one, view).values(), shown(&other, view).values())).sum()
    }

    #[test]
    fn only_the_printers_levels_remain_whatever_the_inks_curve() {
        for (levels, ink_absorbance) in [(2u16, 0.0), (4, 2.0), (16, 0.5)] {
            let mut request = request(Method::LeastSquares, OpticsModel::Stack);
            request.stack.ink_absorbance = ink_absorbance;
            let mut volume = volume(&request);
            halftone(&request, &mut volume, None, levels, &mut |_| ());
            for value in volume.values() {
                let step = value * f32::from(levels - 1);
                assert!((step - step.round()).abs() < 1e-5, "{value} is none of {levels} levels");
            }
        }
    }

    #[test]
    fn joint_levels_show_the_pictures_better_than_rounded_ones() {
        let request = request(Method::Product, OpticsModel::Ideal);
        let given = volume(&request);
        for levels in [2u16, 4] {
            let mut rounded = given.clone();
            let steps = f32::from(levels - 1);
            rounded.values_mut().iter_mut().for_each(|value| *value = (*value * steps).round() / steps);
            let mut joint = given.clone();
            halftone(&request, &mut joint, None, levels, &mut |_| ());
            let (joint, rounded) = (loss(&request, &joint, &given), loss(&request, &rounded, &given));
            assert!(joint < 0.5 * rounded, "{levels} levels: {joint} against {rounded}");
        }
    }

    #[test]
    fn levels_that_expect_misplaced_films_stand_them_better() {
        let request = request(Method::LeastSquares, OpticsModel::Stack);
        // A pixel and a half.
        let errors = HandErrors::misplaced(375.0);
        let quality = |expected: HandErrors| {
            let mut wanted = request.clone();
            wanted.settings = wanted.settings.expecting(errors);
            let (mut volume, _) = super::super::joint::solve(&wanted, None, &[], &mut |_| ());
            wanted.settings = wanted.settings.expecting(expected);
            halftone(&wanted, &mut volume, None, 2, &mut |_| ());
            wanted.settings = wanted.settings.expecting(errors);
            let pairs: Vec<_> =
                Design::of(&wanted, volume.clone()).views.iter().map(|view| view.emphasis).collect();
            as_built(&wanted, &volume, &pairs, 4, 1)
        };
        let (robust, careless) = (quality(errors), quality(HandErrors::misplaced(0.0)));
        println!("{} {}", robust.mean_psnr_db(), careless.mean_psnr_db());
        assert!(robust.mean_psnr_db() > careless.mean_psnr_db() + 0.3);
    }
}
