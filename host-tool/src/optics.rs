//! How light reaches the films and leaves them: directions, lamps and the weight of each film in a view.

use crate::stack::Stack;

/// A line of sight, in degrees outside the stack: positive horizontal means that the viewer stands to the
/// right, positive vertical above. Both lie strictly between -90 and 90.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direction {
    /// Angle to the right of the stack's normal.
    pub horizontal_deg: f64,
    /// Angle above the stack's normal.
    pub vertical_deg: f64,
}

impl Direction {
    /// Makes a direction from its two angles in degrees.
    pub fn new(horizontal_deg: f64, vertical_deg: f64) -> Self {
        Self { horizontal_deg, vertical_deg }
    }

    /// Returns the slope (x per z, y per z) of the line of sight inside a stack of refractive index `index`:
    /// sin(inside) = sin(outside) / index in the ray's plane.
    pub fn slope(self, index: f64) -> (f64, f64) {
        let (x, y) = (self.horizontal_deg.to_radians().tan(), self.vertical_deg.to_radians().tan());
        let length = (x * x + y * y + 1.0).sqrt();
        let (x, y) = (x / length / index, y / length / index);
        let z = (1.0 - x * x - y * y).sqrt();
        (x / z, y / z)
    }

    /// Returns the cosine of the angle between the line of sight inside the stack and its normal.
    pub fn cosine_inside(self, index: f64) -> f64 {
        let (x, y) = self.slope(index);
        1.0 / (1.0 + x * x + y * y).sqrt()
    }
}

/// Levels of the two UV lamps, linear in irradiance, 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampPair {
    /// Level of the lamp on the viewer's side.
    pub top: f64,
    /// Level of the lamp behind the stack.
    pub bottom: f64,
}

impl LampPair {
    /// Both lamps full.
    pub const FULL: Self = Self { top: 1.0, bottom: 1.0 };
    /// The top lamp alone.
    pub const TOP: Self = Self { top: 1.0, bottom: 0.0 };
    /// The bottom lamp alone.
    pub const BOTTOM: Self = Self { top: 0.0, bottom: 1.0 };

    /// Makes a pair from its two levels.
    pub fn new(top: f64, bottom: f64) -> Self {
        Self { top, bottom }
    }

    /// Returns the pair with both levels times `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(self.top * factor, self.bottom * factor)
    }

    /// Returns the pair scaled so that its larger level is 1; a dark pair becomes both lamps full.
    pub fn normalised(self) -> Self {
        let larger = self.top.max(self.bottom);
        if larger > 0.0 { Self::new(self.top / larger, self.bottom / larger) } else { Self::FULL }
    }
}

/// Returns the weight of every film in a view: the UV that the lamps bring to it times the part of its light
/// that reaches the viewer.
///
/// The weight of film k of N is `(top * tau_uv^k + bottom * tau_uv^(N-1-k)) * tau_visible^(k / cos)`, with
/// the angle inside the stack and tau of a film and its spacer together.
pub fn film_weights(stack: &Stack, direction: Direction, lamps: LampPair) -> Vec<f64> {
    let cosine = direction.cosine_inside(stack.index);
    let (uv, visible) = (stack.layer_tau_uv(), stack.layer_tau_visible());
    let last = stack.films - 1;
    (0..stack.films)
        .map(|k| {
            let light = lamps.top * uv.powi(k as i32) + lamps.bottom * uv.powi((last - k) as i32);
            light * visible.powf(k as f64 / cosine)
        })
        .collect()
}

/// Returns the weights of ideal optics, where nothing absorbs: 1 for every film.
pub fn ideal_weights(stack: &Stack) -> Vec<f64> {
    vec![1.0; stack.films]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn snells_law_holds_in_the_rays_plane(h in -80.0..80.0f64, v in -80.0..80.0f64, index in 1.0..2.0f64) {
            let sine = |(x, y): (f64, f64)| ((x * x + y * y) / (1.0 + x * x + y * y)).sqrt();
            let outside = Direction::new(h, v).slope(1.0);
            let inside = Direction::new(h, v).slope(index);
            prop_assert!((sine(outside) - index * sine(inside)).abs() < 1e-12);
            prop_assert!((outside.0 * inside.1 - outside.1 * inside.0).abs() < 1e-9 * (1.0 + sine(outside)) * 1e3);
        }

        #[test]
        fn weights_are_linear_in_the_lamps(top in 0.0..1.0f64, bottom in 0.0..1.0f64) {
            let stack = Stack::default();
            let direction = Direction::new(20.0, -10.0);
            let both = film_weights(&stack, direction, LampPair::new(top, bottom));
            let one = film_weights(&stack, direction, LampPair::TOP);
            let other = film_weights(&stack, direction, LampPair::BOTTOM);
            for k in 0..stack.films {
                prop_assert!((both[k] - top * one[k] - bottom * other[k]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn weights_follow_the_formula() {
        let stack = Stack { films: 3, ..Stack::default() };
        let weights = film_weights(&stack, Direction::new(60.0, 0.0), LampPair::new(1.0, 0.5));
        // cos 60 = 0.5, so each film that lies above takes 0.9 squared.
        let expected =
            [1.0 + 0.5 * 0.82 * 0.82, (0.82 + 0.5 * 0.82) * 0.81, (0.82 * 0.82 + 0.5) * 0.81 * 0.81];
        for (weight, expected) in weights.iter().zip(expected) {
            assert!((weight - expected).abs() < 1e-12, "{weight} {expected}");
        }
    }

    #[test]
    fn a_pair_is_normalised_to_its_larger_level() {
        assert_eq!(LampPair::new(0.5, 0.25).normalised(), LampPair::new(1.0, 0.5));
        assert_eq!(LampPair::new(0.0, 0.0).normalised(), LampPair::FULL);
    }
}
