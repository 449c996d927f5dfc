//! Compatible pictures: how well each view will show its pattern, known before the design, and why.
//!
//! Views that differ in slope by s, through a stack of depth d, shift a picture's detail against each other
//! by d s from the top film to the bottom one. Detail that varies more slowly than once in d s along that
//! shift is the same in both views, whatever the films hold: that is where patterns have to agree. All of
//! it lies at low frequencies, so two designs in small ([`super::scale`]) tell what the large one will
//! reach; what finer pixels add to the error is extrapolated along the patterns' variance.

use serde::Serialize;

use super::request::{DesignError, DesignRequest};
use super::scale::{enlarged, reduced};
use super::{Design, design};
use crate::measure::structural_similarity;
use crate::picture::Picture;
use crate::stack::Stack;
use crate::volume::CHANNELS;

/// Sides, in pixels, of the two designs in small.
const SIDES_PX: [usize; 2] = [64, 128];
/// Views that have to agree on more than this many cycles a picture stand too close for the stack's depth.
const TOO_CLOSE_CYCLES: f64 = 10.0;
/// The share of a view's squared error above which a cause is worth naming.
const WORTH_NAMING: f64 = 0.25;
/// The most that an error is extrapolated: by this part of what the larger design in small has.
const MOST_GROWTH: f64 = 0.5;

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

/// Predicts what the design of `request` will reach, in the time of two small designs.
///
/// # Errors
/// As [`design`].
pub fn predict(request: &DesignRequest) -> Result<Prediction, DesignError> {
    request.check()?;
    let coarse = Small::of(request, SIDES_PX[0])?;
    let fine = Small::of(request, SIDES_PX[1])?;
    let growth = growth_beyond(request, &coarse, &fine);
    let views: Vec<ViewPrediction> = (0..request.views.len())
        .map(|index| {
            let shared = shared_details(&fine, index);
            ViewPrediction {
                id: request.views[index].id.clone(),
                psnr_db: expected_psnr_db(&coarse, &fine, index, growth),
                ssim: expected_ssim(request, &fine, index),
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

/// A request in small with its design.
struct Small {
    request: DesignRequest,
    design: Design,
}

impl Small {
    fn of(request: &DesignRequest, side_px: usize) -> Result<Self, DesignError> {
        let request = reduced(request, side_px);
        let design = design(&request, &mut |_| ())?;
        Ok(Self { request, design })
    }

    fn mean_square_error(&self, view: usize) -> f64 {
        10f64.powf(-self.design.views[view].quality.psnr_db / 10.0)
    }

    /// What the view shows less what it should, code values.
    fn error(&self, view: usize) -> Picture {
        difference(&self.design.views[view].shown, &self.request.views[view].pattern)
    }
}

/// How much variance the patterns gain from the fine design to the full one, as a multiple of what they
/// gained from the coarse to the fine one.
fn growth_beyond(request: &DesignRequest, coarse: &Small, fine: &Small) -> f64 {
    let variances =
        |request: &DesignRequest| request.views.iter().map(|view| variance(&view.pattern)).sum::<f64>();
    let (coarse, fine, full) = (variances(&coarse.request), variances(&fine.request), variances(request));
    let gained = fine - coarse;
    if gained > 1e-6 { ((full - fine) / gained).clamp(0.0, 3.0) } else { 0.0 }
}

fn expected_psnr_db(coarse: &Small, fine: &Small, view: usize, growth: f64) -> f64 {
    let (coarse, fine) = (coarse.mean_square_error(view), fine.mean_square_error(view));
    let more = (growth * (fine - coarse)).clamp(-0.1 * fine, MOST_GROWTH * fine);
    -10.0 * (fine + more).log10()
}

/// The error in small, laid over the full pattern, is too smooth for the full one's window; measured in
/// small, it is as coarse as the picture. The full design lies between the two.
fn expected_ssim(request: &DesignRequest, fine: &Small, view: usize) -> f64 {
    let in_small = fine.design.views[view].quality.ssim;
    let pattern = &request.views[view].pattern;
    let mut shown = enlarged(&fine.error(view), pattern.width(), pattern.height());
    for (value, &wanted) in shown.values_mut().iter_mut().zip(pattern.values()) {
        *value = (*value + wanted).clamp(0.0, 1.0);
    }
    f64::midpoint(in_small, structural_similarity(&shown, pattern))
}

fn shared_details(fine: &Small, view: usize) -> Vec<SharedDetail> {
    let stack = &fine.request.stack;
    let own = &fine.request.views[view];
    let error = fine.error(view);
    let all = energy(&error).max(1e-12);
    let mut shared: Vec<SharedDetail> = fine
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
                error_share: (energy(&shift.slow_part(&error, stack)) / all).min(1.0),
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

fn variance(picture: &Picture) -> f64 {
    let mean =
        picture.values().iter().map(|&value| f64::from(value)).sum::<f64>() / picture.values().len() as f64;
    energy(picture) - mean * mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, OpticsModel, Stop, Tone, ViewRequest};
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
        let agreeing = predict(&request(stripes(16.0, 0.5), stripes(13.0, 0.5))).unwrap();
        let disagreeing = predict(&request(stripes(16.0, 0.25), stripes(13.0, 0.75))).unwrap();
        let disagreement = |prediction: &Prediction| prediction.views[0].shared[0].disagreement;
        assert!(disagreement(&agreeing) < 0.1, "{agreeing:?}");
        assert!((disagreement(&disagreeing) - 0.5).abs() < 0.05, "{disagreeing:?}");
    }

    #[test]
    fn a_small_request_is_predicted_as_its_own_design() {
        let request = request(stripes(3.0, 0.4), stripes(9.0, 0.6));
        let prediction = predict(&request).unwrap();
        let design = design(&request, &mut |_| ()).unwrap();
        for (predicted, view) in prediction.views.iter().zip(&design.views) {
            assert!((predicted.psnr_db - view.quality.psnr_db).abs() < 1e-6);
            assert!((predicted.ssim - view.quality.ssim).abs() < 0.02);
        }
    }
}
