//! Compatible pictures: how well each view will show its pattern, known before the design, and why.
//!
//! Views that differ in slope by s, through a stack of depth d, shift a picture's detail against each other
//! by d s from the top film to the bottom one. Detail that varies more slowly than once in d s along that
//! shift is the same in both views, whatever the films hold: that is where patterns have to agree. All of
//! it lies at low frequencies, so the smaller films on which a design settles its lamps tell the causes.
//! What finer detail adds to the error depends on the pictures (stars are lost in small), so one colour is then
//! designed as finely as it will be, and all err as much more as that one does.

use std::borrow::Cow;

use serde::Serialize;

use super::joint;
use super::least_squares::Effort;
use super::optimise::{Lighting, design_weights, set_up};
use super::request::{DesignError, DesignRequest, Method, Progress, ViewRequest};
use super::scale::{averaged, enlarge_planes, reduced};
use super::{Design, ViewDesign, design_unwatched};
use crate::measure::{fit, mean_square_error, structural_similarity};
use crate::picture::Picture;
use crate::projection::single;
use crate::stack::Stack;
use crate::volume::{CHANNELS, quantise_channel};

/// Side, in pixels, of the films on which causes are looked for; no larger ones are designed in full.
const SIDE_PX: usize = 128;
/// Larger films are predicted as if they had so many pixels along their longer side.
const MOST_SIDE_PX: usize = 512;
/// The colour that is designed as finely as it will be: green, which the eye sees best.
const FINE_CHANNEL: usize = 1;
/// The effort of that: pictures whose detail is fine take longer.
const FINE_EFFORT: Effort = Effort { iterations: 50, tolerance: 0.005 };
/// Views that have to agree on more than this many cycles a picture stand too close for the stack's depth.
const TOO_CLOSE_CYCLES: f64 = 10.0;
/// The share of a view's squared error above which a cause is worth naming.
const WORTH_NAMING: f64 = 0.25;

/// What a design will reach.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Mean of the views' expected PSNR in dB.
    pub mean_psnr_db: f64,
    /// The least view's expected PSNR in dB.
    pub least_psnr_db: f64,
    /// Mean of the views' expected structural similarity.
    pub mean_ssim: f64,
    /// The views, in the order of the request.
    pub views: Vec<ViewPrediction>,
}

/// What one view will reach, and what stands against more.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewPrediction {
    /// The view's name.
    pub id: String,
    /// Expected PSNR in dB.
    pub psnr_db: f64,
    /// Expected structural similarity.
    pub ssim: f64,
    /// What the view shares with each other view, the worst first.
    pub shared: Vec<SharedDetail>,
    /// What stands against more, the worst first; empty where nothing stands out.
    pub reasons: Vec<String>,
}

/// The detail that two views cannot show differently.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SharedDetail {
    /// The other view.
    pub with: String,
    /// The views agree below this many cycles a picture's width, along the line between the directions.
    pub below_cycles: f64,
    /// Root mean square of what the patterns differ by there, in code values.
    pub disagreement: f64,
    /// The part of this view's expected squared error that lies there, 0..=1.
    pub error_share: f64,
}

/// Predicts what the design of `request` will reach, in a part of its time.
///
/// # Errors
/// As [`design`](super::design).
pub fn predict(request: &DesignRequest, report: &mut dyn FnMut(Progress)) -> Result<Prediction, DesignError> {
    request.check()?;
    report(Progress::at("predicting the views", 0, 2));
    let limited = reduced(request, MOST_SIDE_PX);
    let longer = limited.stack.width_px.max(limited.stack.height_px);
    let (small, expected) = match request.settings.method {
        Method::LeastSquares if longer > SIDE_PX => {
            let coarse = rayon::scope(|_| Coarse::settled(&limited));
            limited.go_on()?;
            report(Progress::at("predicting the views", 1, 2).reaching(coarse.design.mean_psnr_db()));
            let fine = rayon::scope(|_| fine_channel(&limited, &coarse));
            limited.go_on()?;
            let expected = expected(&limited, &coarse, &fine);
            (Small::of(&coarse.request, &coarse.design), expected)
        }
        _ => {
            let design = design_unwatched(&limited, &[])?.0;
            let views = design.views.iter().zip(&limited.views);
            let expected = views.map(|(view, wanted)| Erring::of(&view.shown, &wanted.pattern)).collect();
            (Small::of(&limited, &design), expected)
        }
    };
    let views: Vec<ViewPrediction> = expected
        .into_iter()
        .enumerate()
        .map(|(index, expected)| {
            let shared = shared_details(&small, index);
            ViewPrediction {
                id: request.views[index].id.clone(),
                psnr_db: expected.psnr_db(),
                ssim: expected.ssim,
                reasons: reasons(&shared),
                shared,
            }
        })
        .collect();
    let mean = |value: fn(&ViewPrediction) -> f64| views.iter().map(value).sum::<f64>() / views.len() as f64;
    Ok(Prediction {
        mean_psnr_db: mean(|view| view.psnr_db),
        least_psnr_db: views.iter().map(|view| view.psnr_db).fold(f64::INFINITY, f64::min),
        mean_ssim: mean(|view| view.ssim),
        views,
    })
}

/// A request in small, and how its views err.
struct Small {
    request: DesignRequest,
    /// What each view shows less what it should, code values.
    errors: Vec<Picture>,
}

impl Small {
    fn of(request: &DesignRequest, design: &Design) -> Self {
        let small = reduced(request, SIDE_PX);
        let (width, height) = (small.stack.width_px, small.stack.height_px);
        let views = design.views.iter().zip(&request.views);
        let error = |(view, wanted): (&ViewDesign, &ViewRequest)| {
            averaged(&difference(&view.shown, &wanted.pattern), width, height)
        };
        Self { errors: views.map(error).collect(), request: small }
    }
}

/// The smaller films on which a design's lamps are settled.
struct Coarse {
    request: DesignRequest,
    design: Design,
    lighting: Lighting,
    /// The glow of the colour that is designed as finely as it will be.
    channel: Vec<f32>,
}

impl Coarse {
    fn settled(request: &DesignRequest) -> Self {
        let (mut volume, lighting) = joint::settle(request, None, &[], &mut |_| ());
        let channel = volume.channel(FINE_CHANNEL).to_vec();
        let request = reduced(request, volume.width().max(volume.height()));
        request.emission().turn_into_ink(volume.values_mut());
        volume.quantise(request.settings.ink_depth);
        let design = Design::of(&request, volume);
        Self { request, design, lighting, channel }
    }
}

/// How a view errs.
#[derive(Clone, Copy)]
struct Erring {
    mean_square_error: f64,
    ssim: f64,
}

impl Erring {
    fn of(shown: &Picture, pattern: &Picture) -> Self {
        Self {
            mean_square_error: mean_square_error(shown.values(), pattern.values()).max(1e-12),
            ssim: structural_similarity(shown, pattern),
        }
    }

    fn psnr_db(self) -> f64 {
        -10.0 * self.mean_square_error.log10()
    }
}

/// How every view will err, one colour of which is `fine`.
fn expected(request: &DesignRequest, coarse: &Coarse, fine: &[Picture]) -> Vec<Erring> {
    let of_channel = |picture: &Picture| one_channel(picture.channel(FINE_CHANNEL), picture.width());
    // One colour alone is fitted by a gain of its own, in small as well.
    let fitted = |shown: &Picture, pattern: &Picture| {
        let pattern = of_channel(pattern);
        Erring::of(&fit(shown, &pattern, request.settings.tone).picture, &pattern)
    };
    let views = coarse.design.views.iter().zip(&coarse.request.views).zip(&request.views).zip(fine);
    let expected = views.enumerate().map(|(view, (((designed, wanted), full), fine))| {
        let all = Erring::of(&designed.shown, &wanted.pattern);
        let small = fitted(&of_channel(&coarse.design.projection(&coarse.request, view)), &wanted.pattern);
        let fine = fitted(fine, &full.pattern);
        Erring {
            mean_square_error: all.mean_square_error * fine.mean_square_error / small.mean_square_error,
            ssim: (all.ssim + fine.ssim - small.ssim).clamp(0.0, 1.0),
        }
    });
    expected.collect()
}

/// Designs one colour as finely as `request` has it, from the coarse films; returns what each view shows of it.
fn fine_channel(request: &DesignRequest, coarse: &Coarse) -> Vec<Picture> {
    let emission = request.emission();
    let from = (coarse.request.stack.width_px, coarse.request.stack.height_px);
    let size @ (width, height) = (request.stack.width_px, request.stack.height_px);
    let mut films = vec![0.0; request.stack.films * width * height];
    enlarge_planes(&coarse.channel, from, &mut films, size);
    let problem = set_up(request, &request.targets(), &coarse.lighting, None);
    let problem = problem.of_yield(emission.yields()[FINE_CHANNEL]);
    let targets = request.channel_targets(FINE_CHANNEL);
    let targets: Vec<&[f32]> = targets.iter().map(Cow::as_ref).collect();
    problem.solve(&targets, &mut films, FINE_EFFORT, &mut |_, _| ());
    quantise_channel(&mut films, (width * height, width), request.settings.ink_depth);
    emission.spread_light(&mut films, FINE_CHANNEL, size);
    let shown = coarse.lighting.pairs.iter().enumerate().map(|(view, &pair)| {
        let weights = single(&design_weights(request, view, pair));
        let mut shown = vec![0.0; width * height];
        request.rays(view).project(&films, &weights, &mut shown);
        one_channel(&shown, width)
    });
    shown.collect()
}

/// A picture that has the same plane (row, column) in every channel.
fn one_channel(plane: &[f32], width: usize) -> Picture {
    let mut picture = Picture::new(width, plane.len() / width.max(1));
    for channel in 0..CHANNELS {
        picture.channel_mut(channel).copy_from_slice(plane);
    }
    picture
}

fn shared_details(small: &Small, view: usize) -> Vec<SharedDetail> {
    let stack = &small.request.stack;
    let own = &small.request.views[view];
    let error = &small.errors[view];
    let all = energy(error).max(1e-12);
    let mut shared: Vec<SharedDetail> = small
        .request
        .views
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != view)
        .map(|(_, other)| {
            let shift =
                Shift::between(stack, own.direction.slope(stack.index), other.direction.slope(stack.index));
            SharedDetail {
                with: other.id.clone(),
                below_cycles: shift.cycles_a_picture(stack),
                disagreement: energy(&shift.slow_part(&difference(&own.pattern, &other.pattern), stack))
                    .sqrt(),
                error_share: (energy(&shift.slow_part(error, stack)) / all).min(1.0),
            }
        })
        .collect();
    shared.sort_by(|a, b| b.error_share.total_cmp(&a.error_share));
    shared
}

fn reasons(shared: &[SharedDetail]) -> Vec<String> {
    let mut reasons = Vec::new();
    for detail in shared {
        let SharedDetail { with, below_cycles, disagreement, error_share } = detail;
        if *error_share < WORTH_NAMING {
            continue;
        }
        let close = if *below_cycles > TOO_CLOSE_CYCLES {
            ": the angles are too close for the depth of the stack"
        } else {
            ""
        };
        reasons.push(format!(
            "{:.0} % of its error is detail it shares with {with}, below {below_cycles:.1} cycles a picture{close}; \
             there the pictures differ by {disagreement:.2}",
            100.0 * error_share
        ));
    }
    if shared.len() > 2 && reasons.len() == shared.len() {
        reasons.push(format!(
            "it shares detail with all {} other views: they are too many for this depth",
            shared.len()
        ));
    }
    reasons
}

/// How far two views' details shift against each other from the top film to the bottom one.
#[derive(Clone, Copy, Debug)]
struct Shift {
    x_mm: f64,
    y_mm: f64,
}

impl Shift {
    fn between(stack: &Stack, one: (f64, f64), other: (f64, f64)) -> Self {
        let depth = stack.depth_mm();
        Self { x_mm: depth * (one.0 - other.0), y_mm: depth * (one.1 - other.1) }
    }

    fn length_mm(self) -> f64 {
        self.x_mm.hypot(self.y_mm)
    }

    /// The frequency below which the views agree; at most as many cycles as the film has pixels.
    fn cycles_a_picture(self, stack: &Stack) -> f64 {
        (stack.width_mm / self.length_mm().max(1e-9)).min(stack.width_px as f64)
    }

    /// Returns what varies more slowly along the shift than once in its length: the running mean over half
    /// of it, which halves the power at 0.89 cycles a length.
    fn slow_part(self, picture: &Picture, stack: &Stack) -> Picture {
        let steps = (self.length_mm() / 2.0 / stack.pixel_mm()).round() as i64;
        let offsets: Vec<(i64, i64)> = (0..=steps)
            .map(|step| {
                let along = (step as f64 - steps as f64 / 2.0) / steps.max(1) as f64 / 2.0;
                let pixels = |mm: f64| (along * mm / stack.pixel_mm()).round() as i64;
                (pixels(self.x_mm), -pixels(self.y_mm))
            })
            .collect();
        let (width, height) = (picture.width() as i64, picture.height() as i64);
        let mut slow = Picture::new(picture.width(), picture.height());
        for channel in 0..CHANNELS {
            let source = picture.channel(channel);
            for (index, value) in slow.channel_mut(channel).iter_mut().enumerate() {
                let (column, row) = (index as i64 % width, index as i64 / width);
                let (mut sum, mut count) = (0.0, 0.0f32);
                for (x, y) in &offsets {
                    let (column, row) = (column + x, row + y);
                    if (0..width).contains(&column) && (0..height).contains(&row) {
                        sum += source[(row * width + column) as usize];
                        count += 1.0;
                    }
                }
                *value = sum / count.max(1.0);
            }
        }
        slow
    }
}

fn difference(picture: &Picture, other: &Picture) -> Picture {
    let mut difference = picture.clone();
    difference.values_mut().iter_mut().zip(other.values()).for_each(|(value, other)| *value -= other);
    difference
}

fn energy(picture: &Picture) -> f64 {
    let sum: f64 = picture.values().iter().map(|&value| f64::from(value) * f64::from(value)).sum();
    sum / picture.values().len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, OpticsModel, Stop, Tone, ViewRequest, design};
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;

    /// Stripes along x with so many cycles a picture, about a mean.
    fn stripes(cycles: f32, mean: f32) -> Picture {
        let side = 64;
        let mut picture = Picture::new(side, side);
        for (index, value) in picture.values_mut().iter_mut().enumerate() {
            let x = (index % side) as f32 / side as f32;
            *value = mean + 0.2 * (std::f32::consts::TAU * cycles * x).sin();
        }
        picture
    }

    fn request(one: Picture, other: Picture) -> DesignRequest {
        let views = [("one", one, 30.0), ("other", other, -30.0)]
            .map(|(id, pattern, degrees)| ViewRequest::new(id, pattern, Direction::new(degrees, 0.0)));
        DesignRequest {
            stack: Stack { films: 12, width_px: 64, height_px: 64, ..Stack::default() },
            distance: ViewerDistance::Parallel,
            views: views.to_vec(),
            settings: DesignSettings {
                optics: OpticsModel::Ideal,
                tone: Tone::Code,
                ..DesignSettings::default()
            },
            stop: Stop::default(),
        }
    }

    #[test]
    fn views_thirty_degrees_apart_share_five_cycles_of_the_papers_stack() {
        let stack = Stack::default();
        let slope = |degrees| Direction::new(degrees, 0.0).slope(1.0);
        let shift = Shift::between(&stack, slope(30.0), slope(0.0));
        assert!((shift.cycles_a_picture(&stack) - 35.0 / (11.4 * 30f64.to_radians().tan())).abs() < 1e-9);
        assert!((shift.cycles_a_picture(&stack) - 5.3).abs() < 0.05);
    }

    #[test]
    fn the_slow_part_keeps_slow_stripes_and_loses_fast_ones() {
        let stack = Stack { width_px: 64, height_px: 64, ..Stack::default() };
        let shift = Shift { x_mm: 35.0 / 5.0, y_mm: 0.0 };
        let kept = |cycles| {
            let picture = stripes(cycles, 0.0);
            energy(&shift.slow_part(&picture, &stack)) / energy(&picture)
        };
        assert!(kept(1.0) > 0.9, "{}", kept(1.0));
        assert!(kept(20.0) < 0.1, "{}", kept(20.0));
    }

    #[test]
    fn pictures_that_disagree_slowly_are_told_apart_from_those_that_do_not() {
        let agreeing = predict(&request(stripes(16.0, 0.5), stripes(13.0, 0.5)), &mut |_| ()).unwrap();
        let disagreeing = predict(&request(stripes(16.0, 0.25), stripes(13.0, 0.75)), &mut |_| ()).unwrap();
        let disagreement = |prediction: &Prediction| prediction.views[0].shared[0].disagreement;
        assert!(disagreement(&agreeing) < 0.1, "{agreeing:?}");
        assert!((disagreement(&disagreeing) - 0.5).abs() < 0.05, "{disagreeing:?}");
    }

    #[test]
    fn a_small_request_is_predicted_as_its_own_design() {
        let request = request(stripes(3.0, 0.4), stripes(9.0, 0.6));
        let prediction = predict(&request, &mut |_| ()).unwrap();
        let design = design(&request, &mut |_| ()).unwrap();
        for (predicted, view) in prediction.views.iter().zip(&design.views) {
            assert!((predicted.psnr_db - view.quality.psnr_db).abs() < 1e-6);
            assert!((predicted.ssim - view.quality.ssim).abs() < 0.02);
        }
    }
}
