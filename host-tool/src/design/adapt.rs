//! Adapted pictures: patterns changed, slowly over their area, where views have to agree.
//!
//! What a stack cannot show of its patterns lies at low frequencies ([`super::compatibility`]), where the
//! optimiser strikes a compromise. So each pattern T gets a smooth offset toward what its view shows, S:
//!
//! ```text
//! T' = T + smooth(S - T) / (1 + reluctance / (m^2 + c))
//! ```
//!
//! with m the local mean. Smooth offsets keep the local structure that structural similarity judges; what
//! it judges beside that is the local mean, relative to itself: an offset harms dark places most. The
//! division spares them. Each view's reluctance is the least with which its picture stays as similar to the
//! given one as is asked. As soon as one picture gives way the others need not, so this is repeated.

use super::design_unwatched;
use super::request::{DesignError, DesignRequest, Progress};
use super::scale::{enlarged, reduced};
use crate::measure::structural_similarity;
use crate::picture::Picture;
use crate::volume::CHANNELS;

/// Side, in pixels, of the designs in small.
const SIDE_PX: usize = 64;
/// Side, in pixels, of the pictures on which similarity is judged on the way.
const JUDGE_SIDE_PX: usize = 256;
/// How far offsets are smoothed, as a part of the picture's width: a fortieth of it spans ten times the
/// window of structural similarity at 512 pixels.
const SMOOTHING: f64 = 1.0 / 40.0;
/// Added to the squared local mean, so that black places move a little too.
const DARK: f32 = 0.02;
/// Rounds in which pictures give way to each other.
const ROUNDS: usize = 5;
/// Steps of the search for a view's reluctance.
const SEARCH_STEPS: usize = 9;

/// Pictures that a stack can show better.
#[derive(Clone, Debug)]
pub struct Adapted {
    /// The request with the adapted patterns.
    pub request: DesignRequest,
    /// Structural similarity of each adapted pattern to the given one.
    pub similarity: Vec<f64>,
}

impl Adapted {
    /// Mean similarity of the adapted patterns to the given ones.
    pub fn mean_similarity(&self) -> f64 {
        self.similarity.iter().sum::<f64>() / self.similarity.len().max(1) as f64
    }
}

/// Adapts the patterns to each other; each keeps a structural similarity of at least `similarity`, 0..=1,
/// to what it was.
///
/// # Errors
/// As [`design`](super::design).
pub fn adapt(
    request: &DesignRequest,
    similarity: f64,
    report: &mut dyn FnMut(Progress),
) -> Result<Adapted, DesignError> {
    request.check()?;
    let given = reduced(request, SIDE_PX);
    let judged = reduced(request, JUDGE_SIDE_PX);
    let sigma_px = SMOOTHING * given.stack.width_px as f64;
    let local_means: Vec<Picture> =
        given.views.iter().map(|view| smoothed(&view.pattern, sigma_px)).collect();
    let mut small = given.clone();
    let mut offsets = Vec::new();
    let mut lighting = None;
    for round in 0..ROUNDS {
        let (designed, found) = design_unwatched(&small, lighting.as_slice())?;
        lighting = found;
        let progress = Progress::at("adapting the pictures", round, ROUNDS);
        report(progress.reaching(designed.mean_psnr_db()));
        offsets = (0..given.views.len())
            .map(|view| {
                let mut wanted = designed.views[view].shown.clone();
                add(&mut wanted, &given.views[view].pattern, -1.0);
                let wanted = Wanted { offset: smoothed(&wanted, sigma_px), local_mean: &local_means[view] };
                wanted.as_far_as(similarity, &judged.views[view].pattern)
            })
            .collect();
        for ((view, given), offset) in small.views.iter_mut().zip(&given.views).zip(&offsets) {
            view.pattern = moved(&given.pattern, offset, 1.0);
        }
    }
    Ok(apply(request, &offsets, similarity))
}

/// Moves the full patterns by the offsets, or by the part of them that keeps the similarity asked for.
fn apply(request: &DesignRequest, offsets: &[Picture], similarity: f64) -> Adapted {
    let mut adapted = Adapted { request: request.clone(), similarity: Vec::new() };
    for ((view, given), offset) in adapted.request.views.iter_mut().zip(&request.views).zip(offsets) {
        let offset = enlarged(offset, given.pattern.width(), given.pattern.height());
        let part = |part: f32| {
            let picture = moved(&given.pattern, &offset, part);
            (structural_similarity(&picture, &given.pattern), picture)
        };
        let parts = [1.0, 0.97, 0.94, 0.9, 0.8, 0.65, 0.5, 0.25];
        let kept = parts.into_iter().map(part).find(|(reached, _)| *reached >= similarity);
        let (reached, picture) = kept.unwrap_or_else(|| (1.0, given.pattern.clone()));
        view.pattern = picture;
        adapted.similarity.push(reached);
    }
    adapted
}

/// The offset that would bring a pattern to what its view shows.
struct Wanted<'a> {
    offset: Picture,
    local_mean: &'a Picture,
}

impl Wanted<'_> {
    /// Returns the offset with the least reluctance that keeps `pattern` similar to itself.
    fn as_far_as(&self, similarity: f64, pattern: &Picture) -> Picture {
        let keeps = |offset: &Picture| {
            let offset = enlarged(offset, pattern.width(), pattern.height());
            structural_similarity(&moved(pattern, &offset, 1.0), pattern) >= similarity
        };
        if keeps(&self.offset) {
            return self.offset.clone();
        }
        let (mut low, mut high) = (1e-4f32.ln(), 100f32.ln());
        for _ in 0..SEARCH_STEPS {
            let middle = f32::midpoint(low, high);
            if keeps(&self.reluctant(middle.exp())) {
                high = middle;
            } else {
                low = middle;
            }
        }
        self.reluctant(high.exp())
    }

    fn reluctant(&self, reluctance: f32) -> Picture {
        let mut offset = self.offset.clone();
        for (value, mean) in offset.values_mut().iter_mut().zip(self.local_mean.values()) {
            *value /= 1.0 + reluctance / (mean * mean + DARK);
        }
        offset
    }
}

fn moved(pattern: &Picture, offset: &Picture, part: f32) -> Picture {
    let mut moved = pattern.clone();
    add(&mut moved, offset, part);
    moved.map(|value| value.clamp(0.0, 1.0))
}

fn add(picture: &mut Picture, other: &Picture, factor: f32) {
    picture.values_mut().iter_mut().zip(other.values()).for_each(|(value, other)| *value += factor * other);
}

/// Returns the picture under a Gaussian of `sigma_px`; at the edges the Gaussian is cut.
fn smoothed(picture: &Picture, sigma_px: f64) -> Picture {
    let (width, height) = (picture.width(), picture.height());
    let columns = Gaussian::new(width, sigma_px);
    let rows = Gaussian::new(height, sigma_px);
    let mut smooth = picture.clone();
    for channel in 0..CHANNELS {
        let source = picture.channel(channel);
        let across: Vec<f32> = (0..width * height)
            .map(|at| columns.mean(at % width, |column| source[at / width * width + column]))
            .collect();
        for (at, value) in smooth.channel_mut(channel).iter_mut().enumerate() {
            *value = rows.mean(at / width, |row| across[row * width + at % width]);
        }
    }
    smooth
}

struct Gaussian {
    len: usize,
    taps: Vec<f32>,
}

impl Gaussian {
    fn new(len: usize, sigma: f64) -> Self {
        let reach = (3.0 * sigma).ceil() as usize;
        let taps = (0..=reach).map(|tap| (-0.5 * (tap as f64 / sigma).powi(2)).exp() as f32).collect();
        Self { len, taps }
    }

    fn mean(&self, middle: usize, value: impl Fn(usize) -> f32) -> f32 {
        let reach = self.taps.len() - 1;
        let (mut sum, mut weight) = (0.0, 0.0);
        for at in middle.saturating_sub(reach)..=(middle + reach).min(self.len - 1) {
            let tap = self.taps[at.abs_diff(middle)];
            sum += tap * value(at);
            weight += tap;
        }
        sum / weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, OpticsModel, Stop, Tone, ViewRequest, design};
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;
    use crate::stack::Stack;

    /// Pictures that are bright on opposite sides, with fine stripes of their own.
    fn opposed() -> DesignRequest {
        let side = 48;
        let views = [("one", 20.0f64, 1.0f32), ("other", -20.0, -1.0)].map(|(id, degrees, sign)| {
            let mut pattern = Picture::new(side, side);
            for (index, value) in pattern.values_mut().iter_mut().enumerate() {
                let (x, y) = ((index % side) as f32 / 47.0, (index / side % side) as f32);
                *value = 0.5 + sign * 0.25 * (2.0 * x - 1.0) + 0.2 * (0.9 * y * (1.5 + sign * 0.4)).sin();
            }
            ViewRequest::new(id, pattern, Direction::new(degrees, 0.0))
        });
        DesignRequest {
            stack: Stack { films: 6, width_px: side, height_px: side, ..Stack::default() },
            distance: ViewerDistance::Parallel,
            views: views.to_vec(),
            settings: DesignSettings {
                optics: OpticsModel::Ideal,
                tone: Tone::Code,
                iterations: 40,
                ..DesignSettings::default()
            },
            stop: Stop::default(),
        }
    }

    #[test]
    fn adapted_pictures_show_better_and_stay_similar() {
        let request = opposed();
        let before = design(&request, &mut |_| ()).unwrap().mean_psnr_db();
        let mut last = before;
        for similarity in [0.97, 0.9] {
            let adapted = adapt(&request, similarity, &mut |_| ()).unwrap();
            assert!(
                adapted.similarity.iter().all(|reached| *reached >= similarity),
                "{:?}",
                adapted.similarity
            );
            let inside = |view: &ViewRequest| view.pattern.values().iter().all(|v| (0.0..=1.0).contains(v));
            assert!(adapted.request.views.iter().all(inside));
            let after = design(&adapted.request, &mut |_| ()).unwrap().mean_psnr_db();
            assert!(after > last + 0.5, "{similarity}: {last} dB, then {after} dB");
            last = after;
        }
    }

    #[test]
    fn a_gaussian_keeps_what_is_even() {
        let even = Picture::new(9, 7).map(|_| 0.3);
        assert!(smoothed(&even, 2.0).values().iter().all(|value| (value - 0.3).abs() < 1e-6));
    }
}
