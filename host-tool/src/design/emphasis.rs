//! Emphasis: the pair of lamp levels that shows a view at its best.

use crate::optics::LampPair;

/// Returns the pair, its larger level 1, whose light fits the target best with one gain.
///
/// `top` and `bottom` are what the view shows under either lamp alone at full level; light adds up, so the
/// best pair is a least-squares problem of two non-negative unknowns, solved in closed form: the
/// unconstrained solution if it is non-negative, or else the better of the two lamps alone.
pub fn best_pair(top: &[f32], bottom: &[f32], target: &[f32]) -> LampPair {
    let (mut tt, mut tb, mut bb, mut ty, mut by, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for ((&t, &b), &y) in top.iter().zip(bottom).zip(target) {
        let (t, b, y) = (f64::from(t), f64::from(b), f64::from(y));
        tt += t * t;
        tb += t * b;
        bb += b * b;
        ty += t * y;
        by += b * y;
        yy += y * y;
    }
    let determinant = tt * bb - tb * tb;
    if determinant > 1e-9 * tt * bb {
        let pair = LampPair::new((ty * bb - by * tb) / determinant, (by * tt - ty * tb) / determinant);
        if pair.top >= 0.0 && pair.bottom >= 0.0 {
            return pair.normalised();
        }
    } else if tt > 0.0 && bb > 0.0 {
        // Both lamps show the same picture: they serve alike.
        return LampPair::FULL;
    }
    let error = |product: f64, square: f64| if square > 0.0 { yy - product * product / square } else { yy };
    if error(ty, tt) <= error(by, bb) { LampPair::TOP } else { LampPair::BOTTOM }
}

/// Returns the pair for nobody in particular: the mean of the views' pairs, its larger level 1.
pub fn neutral_pair(pairs: &[LampPair]) -> LampPair {
    let sum = |level: fn(&LampPair) -> f64| pairs.iter().map(level).sum::<f64>();
    LampPair::new(sum(|pair| pair.top), sum(|pair| pair.bottom)).normalised()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(top: &[f32], bottom: &[f32], target: &[f32], pair: LampPair) -> f64 {
        let light: Vec<f32> =
            top.iter().zip(bottom).map(|(t, b)| pair.top as f32 * t + pair.bottom as f32 * b).collect();
        let gain = crate::measure::least_squares_gain(&light, target) as f32;
        light.iter().zip(target).map(|(l, t)| f64::from(gain * l - t).powi(2)).sum()
    }

    proptest! {
        #[test]
        fn no_other_pair_fits_better(values in proptest::collection::vec((0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0), 4..30)) {
            let top: Vec<f32> = values.iter().map(|v| v.0).collect();
            let bottom: Vec<f32> = values.iter().map(|v| v.1).collect();
            let target: Vec<f32> = values.iter().map(|v| v.2).collect();
            let best = best_pair(&top, &bottom, &target);
            prop_assert_eq!(best.top.max(best.bottom), 1.0);
            let least = error(&top, &bottom, &target, best);
            for step in 0..=40 {
                let level = f64::from(step) / 40.0;
                for other in [LampPair::new(1.0, level), LampPair::new(level, 1.0)] {
                    prop_assert!(least <= error(&top, &bottom, &target, other) + 1e-4);
                }
            }
        }
    }

    #[test]
    fn a_target_made_of_both_lamps_gives_their_ratio() {
        let (top, bottom) = ([1.0, 0.0, 2.0, 1.0], [0.0, 1.0, 1.0, 3.0]);
        let target: Vec<f32> = top.iter().zip(bottom).map(|(t, b)| 0.2 * t + 0.8 * b).collect();
        let pair = best_pair(&top, &bottom, &target);
        assert!((pair.top - 0.25).abs() < 1e-6 && pair.bottom == 1.0, "{pair:?}");
    }

    #[test]
    fn the_neutral_pair_is_the_normalised_mean() {
        assert_eq!(neutral_pair(&[LampPair::TOP, LampPair::new(1.0, 1.0)]), LampPair::new(1.0, 0.5));
    }
}
