//! From a chart's plane to a photograph of it.

use super::solve::solve;

/// A projective map of the plane: (x, y) goes to ((a x + b y + c) / w, (d x + e y + f) / w), w = g x + h y + 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective([f64; 8]);

impl Perspective {
    /// The map that takes each of four points `from` to its fellow of `to`; `None` where three of them lie in line.
    pub fn through(from: [[f64; 2]; 4], to: [[f64; 2]; 4]) -> Option<Self> {
        let (mut matrix, mut right) = (Vec::new(), Vec::new());
        for ([x, y], [u, v]) in from.into_iter().zip(to) {
            matrix.push(vec![x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y]);
            matrix.push(vec![0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y]);
            right.extend([u, v]);
        }
        let map: [f64; 8] = solve(matrix, right)?.try_into().ok()?;
        let map = Self(map);
        // The chart lies in front of the camera, all of it.
        from.iter().all(|&[x, y]| map.weight(x, y) > 1e-6).then_some(map)
    }

    fn weight(&self, x: f64, y: f64) -> f64 {
        let Self([.., g, h]) = *self;
        g * x + h * y + 1.0
    }

    /// Where the point (x, y) goes.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Self([a, b, c, d, e, f, ..]) = *self;
        let weight = self.weight(x, y);
        [(a * x + b * y + c) / weight, (d * x + e * y + f) / weight]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_points_and_what_lies_between_are_met() {
        let from = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]];
        let map = Perspective([3.0, 0.2, 5.0, -0.1, 2.0, 7.0, 0.01, 0.02]);
        let found = Perspective::through(from, from.map(|point| map.apply(point))).unwrap();
        for point in [[1.0, 1.0], [3.5, 0.3], [0.0, 2.0]] {
            let (a, b) = (map.apply(point), found.apply(point));
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9);
        }
        assert_eq!(Perspective::through([[0.0; 2], [1.0; 2], [2.0; 2], [3.0; 2]], from), None);
    }
}
