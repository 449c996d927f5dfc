//! An ink's light by its coverage.

use thiserror::Error;

/// Points of a computed curve.
const POINTS: usize = 129;

/// How much an ink glows, as a part of the most that it can, by its coverage: rising in both from nothing to light 1,
/// straight between points.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Coverage and light, both 0..=1.
    points: Vec<[f32; 2]>,
}

/// Why points are no curve of an ink.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CurveError {
    /// Too few points.
    #[error("it has {0} points, and needs at least two")]
    TooFew(usize),
    /// The first point is not that of no ink.
    #[error("it does not begin at coverage 0 with light 0")]
    NoOrigin,
    /// A value is no number in 0..=1.
    #[error("point {number} is coverage {coverage}, light {light}: both have to lie in 0 to 1")]
    OutOfRange {
        /// The point, from 1.
        number: usize,
        /// Its coverage.
        coverage: f64,
        /// Its light.
        light: f64,
    },
    /// Coverage or light does not rise.
    #[error("point {0} is not above the one before it, in coverage and in light")]
    NotRising(usize),
}

impl Curve {
    /// Light in proportion to coverage: what dots of full ink side by side give.
    pub fn linear() -> Self {
        Self { points: vec![[0.0, 0.0], [1.0, 1.0]] }
    }

    /// The light of an ink whose molecules quench each other: c exp(-`quench` c) by Perrin's model of static quenching
    /// (Perrin 1924: a molecule is dark when another lies within its sphere of action), as a part of the most over
    /// c = 0..=1. `quench` is 0 for none and finite; where it exceeds 1, the most lies at c = 1 / `quench`, and the curve ends there:
    /// more ink would glow less.
    pub fn quenching(quench: f64) -> Self {
        if quench <= 0.0 {
            return Self::linear();
        }
        let fullest = (1.0 / quench).min(1.0);
        let light = |coverage: f64| coverage * (-quench * coverage).exp();
        let point = |index: usize| {
            let coverage = fullest * index as f64 / (POINTS - 1) as f64;
            [coverage as f32, (light(coverage) / light(fullest)) as f32]
        };
        Self { points: (0..POINTS).map(point).collect() }
    }

    /// A measured curve from pairs of coverage and light; the last point's light counts as full.
    ///
    /// # Errors
    /// When the points do not rise in both from 0, 0, or leave 0..=1.
    pub fn measured(points: &[[f64; 2]]) -> Result<Self, CurveError> {
        let &[first, .., last] = points else { return Err(CurveError::TooFew(points.len())) };
        if first != [0.0, 0.0] {
            return Err(CurveError::NoOrigin);
        }
        for (index, &[coverage, light]) in points.iter().enumerate() {
            if !((0.0..=1.0).contains(&coverage) && (0.0..=1.0).contains(&light)) {
                return Err(CurveError::OutOfRange { number: index + 1, coverage, light });
            }
        }
        let scaled = |[coverage, light]: &[f64; 2]| [*coverage as f32, (light / last[1]) as f32];
        let points: Vec<[f32; 2]> = points.iter().map(scaled).collect();
        let rises = |pair: &[[f32; 2]]| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1];
        match points.windows(2).position(|pair| !rises(pair)) {
            Some(index) => Err(CurveError::NotRising(index + 2)),
            None => Ok(Self { points }),
        }
    }

    /// The coverage that glows most, 0..=1.
    pub fn fullest(&self) -> f32 {
        self.points.last().map_or(1.0, |point| point[0])
    }

    /// Whether light is in proportion to coverage.
    pub fn is_straight(&self) -> bool {
        self.points.len() == 2
    }

    /// The light of `coverage`, 0..=1; coverage beyond the fullest counts as that.
    pub fn light(&self, coverage: f32) -> f32 {
        self.across(coverage, 0)
    }

    /// The least coverage that gives `light`; light beyond 1 counts as 1.
    pub fn coverage(&self, light: f32) -> f32 {
        self.across(light, 1)
    }

    /// The other value where the value `from` (0 coverage, 1 light) is `value`.
    fn across(&self, value: f32, from: usize) -> f32 {
        let to = 1 - from;
        let after = self.points.partition_point(|point| point[from] < value).clamp(1, self.points.len() - 1);
        let (left, right) = (self.points[after - 1], self.points[after]);
        let part = ((value - left[from]) / (right[from] - left[from])).clamp(0.0, 1.0);
        left[to] + part * (right[to] - left[to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn coverage_gives_its_light_back(quench in 0.0..4.0, light in 0.0_f32..=1.0) {
            let curve = Curve::quenching(quench);
            let coverage = curve.coverage(light);
            prop_assert!((0.0..=curve.fullest()).contains(&coverage));
            prop_assert!((curve.light(coverage) - light).abs() < 1e-5);
        }

        #[test]
        fn quenching_follows_perrin(quench in 0.01..4.0, part in 0.0..=1.0) {
            let curve = Curve::quenching(quench);
            let fullest = f64::min(1.0, 1.0 / quench);
            let light = |coverage: f64| coverage * (-quench * coverage).exp();
            let exact = light(part * fullest) / light(fullest);
            prop_assert!((f64::from(curve.light((part * fullest) as f32)) - exact).abs() < 1e-4);
        }
    }

    #[test]
    fn measured_points_are_met_and_wrong_ones_refused() {
        let curve = Curve::measured(&[[0.0, 0.0], [0.5, 0.6], [0.9, 0.8]]).unwrap();
        assert_eq!(curve.light(0.5), 0.75);
        assert_eq!(curve.light(0.25), 0.375);
        assert_eq!(curve.coverage(0.75), 0.5);
        assert_eq!((curve.fullest(), curve.light(1.0), curve.coverage(2.0)), (0.9, 1.0, 0.9));
        assert_eq!(Curve::measured(&[[0.0, 0.0]]), Err(CurveError::TooFew(1)));
        assert_eq!(Curve::measured(&[[0.1, 0.0], [1.0, 1.0]]), Err(CurveError::NoOrigin));
        assert_eq!(Curve::measured(&[[0.0, 0.0], [0.5, 0.6], [1.0, 0.6]]), Err(CurveError::NotRising(3)));
        assert_eq!(Curve::measured(&[[0.0, 0.0], [1.0, 0.0]]), Err(CurveError::NotRising(2)));
        assert!(matches!(
            Curve::measured(&[[0.0, 0.0], [0.5, f64::NAN], [1.0, 1.0]]),
            Err(CurveError::OutOfRange { number: 2, .. })
        ));
    }
}
