//! Emphasis: the pair of lamp levels that shows a view, or several, at their best.
//!
//! What a view shows under a pair is `top * t + bottom * b`, with t and b its pictures under either lamp alone.
//! With a gain of its own its squared error against the pattern y is a quotient of sums over pixels, so six sums
//! tell the error under every pair.

use super::request::Tone;
use crate::optics::LampPair;
use crate::picture::srgb_encode;

/// Pairs between the top lamp alone and the bottom lamp alone that are looked at before the best is refined.
const DIRECTIONS: usize = 90;
/// Golden-section steps of the refinement; each leaves 0.62 of the distance.
const REFINEMENTS: usize = 30;
/// Light errs by about this much; the sRGB curve is judged by its chord over that distance.
const CHORD: f32 = 0.02;

/// The sums that tell how well a view is shown under any lamp pair, each with its best gain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LampSums {
    tt: f64,
    tb: f64,
    bb: f64,
    ty: f64,
    by: f64,
    yy: f64,
}

impl LampSums {
    /// Sums up what a view shows under either lamp alone at full level (`top`, `bottom`) against its `target`, all in
    /// the values in which films add up; errors of light count as the code values do that `tone` measures.
    pub fn of(top: &[f32], bottom: &[f32], target: &[f32], tone: Tone) -> Self {
        let mut sums = Self::default();
        for ((&t, &b), &y) in top.iter().zip(bottom).zip(target) {
            let weight = f64::from(importance(tone, y));
            let (t, b, y) = (f64::from(t), f64::from(b), f64::from(y));
            sums.tt += weight * t * t;
            sums.tb += weight * t * b;
            sums.bb += weight * b * b;
            sums.ty += weight * t * y;
            sums.by += weight * b * y;
            sums.yy += weight * y * y;
        }
        sums
    }

    /// The squared error under `pair` with the gain that fits best, as a part of the target's square, 0..=1.
    pub fn error(&self, pair: LampPair) -> f64 {
        let LampPair { top, bottom } = pair;
        let product = top * self.ty + bottom * self.by;
        let square = top * top * self.tt + 2.0 * top * bottom * self.tb + bottom * bottom * self.bb;
        if square > 0.0 && self.yy > 0.0 {
            (1.0 - product * product / (square * self.yy)).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }

    /// Returns the pair, its larger level 1, under which the error is least: a least-squares problem of two
    /// non-negative unknowns, solved in closed form as the unconstrained solution if it is non-negative, or else the
    /// better of the two lamps alone.
    pub fn best_pair(&self) -> LampPair {
        let determinant = self.tt * self.bb - self.tb * self.tb;
        if determinant > 1e-9 * self.tt * self.bb {
            let pair = LampPair::new(
                (self.ty * self.bb - self.by * self.tb) / determinant,
                (self.by * self.tt - self.ty * self.tb) / determinant,
            );
            if pair.top >= 0.0 && pair.bottom >= 0.0 {
                return pair.normalised();
            }
        } else if self.tt > 0.0 && self.bb > 0.0 {
            // Both lamps show the same picture: they serve alike.
            return LampPair::FULL;
        }
        if self.error(LampPair::TOP) <= self.error(LampPair::BOTTOM) {
            LampPair::TOP
        } else {
            LampPair::BOTTOM
        }
    }
}

/// Returns the pair, its larger level 1, that is best for all these views at once, each with a gain and a weight of
/// its own: the one whose sum of the views' PSNR is largest.
pub fn pair_for_all(views: &[(LampSums, f64)]) -> LampPair {
    // The sum of PSNR falls with the sum of the errors' logarithms. An error of nothing must not outweigh all else.
    let cost = |angle: f64| -> f64 {
        let pair = LampPair::new(angle.cos().max(0.0), angle.sin().max(0.0));
        views.iter().map(|(sums, weight)| weight * sums.error(pair).max(1e-6).ln()).sum()
    };
    let step = std::f64::consts::FRAC_PI_2 / DIRECTIONS as f64;
    let costs: Vec<f64> = (0..=DIRECTIONS).map(|index| cost(index as f64 * step)).collect();
    let least = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
    let mut low = least.saturating_sub(1) as f64 * step;
    let mut high = (least + 1).min(DIRECTIONS) as f64 * step;
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..REFINEMENTS {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if cost(left) < cost(right) { high = right } else { low = left }
    }
    let ends = [0.0, std::f64::consts::FRAC_PI_2, f64::midpoint(low, high)];
    let best = ends.into_iter().min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(low);
    LampPair::new(snapped(best.cos()), snapped(best.sin())).normalised()
}

/// A level that is off but for rounding is off.
fn snapped(level: f64) -> f64 {
    if level < 1e-6 { 0.0 } else { level }
}

/// How much a squared error counts where `wanted` is to be seen: 1 for code values, and for light the square of the
/// encoding's chord.
pub(super) fn importance(tone: Tone, wanted: f32) -> f32 {
    match tone {
        Tone::Code => 1.0,
        Tone::Linear => {
            let (low, high) = ((wanted - CHORD / 2.0).max(0.0), (wanted + CHORD / 2.0).clamp(CHORD, 1.0));
            ((srgb_encode(high) - srgb_encode(low)) / (high - low).max(CHORD / 2.0)).powi(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{fit, least_squares_gain};
    use crate::picture::Picture;
    use proptest::prelude::*;

    type Pixel = (f32, f32, f32);

    fn pixels() -> impl Strategy<Value = Vec<Pixel>> {
        proptest::collection::vec((0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0), 3..12)
    }

    /// One row of pixels, the same in all channels.
    fn picture(values: &[f32]) -> Picture {
        Picture::from_values(values.len(), 1, values.repeat(3)).unwrap()
    }

    fn sums(pixels: &[Pixel]) -> LampSums {
        let of = |value: fn(&Pixel) -> f32| pixels.iter().map(value).collect::<Vec<_>>();
        LampSums::of(&of(|p| p.0), &of(|p| p.1), &of(|p| p.2), Tone::Code)
    }

    /// The squared error under a pair by its definition, as a part of the target's square.
    fn error(pixels: &[Pixel], pair: LampPair) -> f64 {
        let light: Vec<f32> =
            pixels.iter().map(|(t, b, _)| pair.top as f32 * t + pair.bottom as f32 * b).collect();
        let target: Vec<f32> = pixels.iter().map(|p| p.2).collect();
        let gain = least_squares_gain(&light, &target) as f32;
        let error: f64 = light.iter().zip(&target).map(|(l, t)| f64::from(gain * l - t).powi(2)).sum();
        error / target.iter().map(|t| f64::from(*t).powi(2)).sum::<f64>()
    }

    fn pairs() -> impl Iterator<Item = LampPair> {
        (0..=40).flat_map(|step| {
            let level = f64::from(step) / 40.0;
            [LampPair::new(1.0, level), LampPair::new(level, 1.0)]
        })
    }

    proptest! {
        #[test]
        fn no_other_pair_fits_better(pixels in pixels()) {
            let sums = sums(&pixels);
            let best = sums.best_pair();
            prop_assert_eq!(best.top.max(best.bottom), 1.0);
            for other in pairs() {
                prop_assert!((sums.error(other) - error(&pixels, other)).abs() < 1e-4);
                prop_assert!(error(&pixels, best) <= error(&pixels, other) + 1e-4);
            }
        }

        #[test]
        fn no_other_pair_serves_two_views_better(one in pixels(), other in pixels()) {
            let views = [(sums(&one), 1.0), (sums(&other), 1.0)];
            let best = pair_for_all(&views);
            prop_assert_eq!(best.top.max(best.bottom), 1.0);
            let cost = |pair| views.iter().map(|(sums, _)| sums.error(pair).max(1e-6).ln()).sum::<f64>();
            for pair in pairs() {
                prop_assert!(cost(best) <= cost(pair) + 1e-3, "{:?} against {:?}", best, pair);
            }
        }
    }

    #[test]
    fn a_target_made_of_both_lamps_gives_their_ratio() {
        let pixels = [(1.0, 0.0), (0.0, 1.0), (2.0, 1.0), (1.0, 3.0)].map(|(t, b)| (t, b, 0.2 * t + 0.8 * b));
        let pair = sums(&pixels).best_pair();
        assert!((pair.top - 0.25).abs() < 1e-6 && pair.bottom == 1.0, "{pair:?}");
        let alone = pair_for_all(&[(sums(&pixels), 1.0)]);
        assert!((alone.top - 0.25).abs() < 0.02 && alone.bottom == 1.0, "{alone:?}");
    }

    #[test]
    fn the_weightier_view_decides() {
        let (top, bottom) = ([(1.0, 0.0, 1.0), (0.2, 1.0, 0.2)], [(1.0, 0.0, 0.0), (0.2, 1.0, 1.0)]);
        let pair = |weight| pair_for_all(&[(sums(&top), weight), (sums(&bottom), 1.0)]);
        assert!(pair(10.0).top > pair(10.0).bottom, "{:?}", pair(10.0));
        assert!(pair(0.1).top < pair(0.1).bottom, "{:?}", pair(0.1));
    }

    #[test]
    fn dark_places_count_more_where_light_is_measured_by_its_codes() {
        // The top lamp errs in the light, the bottom lamp in the dark.
        let (top, bottom, target) = ([0.7, 0.05], [0.8, 0.15], [0.8, 0.05]);
        let sums = LampSums::of(&top, &bottom, &target, Tone::Linear);
        let measured = |shown: &[f32]| {
            let fitted = fit(&picture(shown), &picture(&target).encoded(), Tone::Linear).picture;
            crate::measure::psnr_db(&fitted, &picture(&target).encoded())
        };
        assert!(measured(&top) > measured(&bottom));
        assert!(sums.error(LampPair::TOP) < sums.error(LampPair::BOTTOM));
    }
}
