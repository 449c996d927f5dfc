//! The inside of closed meshes: where a line of sight from the front has crossed the surface an odd number of times.
//!
//! Through the middle of every column of voxels goes a line; a triangle that it crosses at the height h changes sides of
//! all voxels whose middles lie below h. Corners are rounded to a 256th of a pixel and compared in whole numbers, so that
//! a line through an edge crosses exactly one of the two triangles that share it. A column that is crossed an odd number
//! of times is not closed: nothing is filled there.

use std::sync::atomic::{AtomicBool, Ordering};

use super::shape::{Triangle, Vector};

/// Parts of a pixel to which corners are rounded.
const PARTS: f64 = 256.0;
/// Corners further out, in pixels, are moved to this distance: far beyond any film.
const FARTHEST_PX: f64 = 1e9;

/// Which columns have been crossed where.
pub(super) struct Crossings {
    columns: usize,
    rows: usize,
    layers: usize,
    /// Of each voxel (layer from the bottom, row from the bottom, column): whether sides change just above its middle.
    changes: Vec<AtomicBool>,
    /// Of each column of voxels: whether the number of all crossings is odd.
    odd: Vec<AtomicBool>,
}

impl Crossings {
    /// Columns that nothing has crossed yet.
    pub(super) fn new(columns: usize, rows: usize, layers: usize) -> Self {
        let unset = |count: usize| (0..count).map(|_| AtomicBool::new(false)).collect();
        Self { columns, rows, layers, changes: unset(columns * rows * layers), odd: unset(columns * rows) }
    }

    /// Notes where a triangle, its positions in voxels from the lower, left, rear corner, is crossed.
    pub(super) fn cross(&self, triangle: &Triangle) {
        let Some(flat) = Flat::of(triangle) else { return };
        for row in flat.span(1, self.rows) {
            for column in flat.span(0, self.columns) {
                let Some(height) = flat.height_at(column, row) else { continue };
                let column = row * self.columns + column;
                self.odd[column].fetch_xor(true, Ordering::Relaxed);
                // Layer n has its middle at n + 1/2: so many lie below.
                let below = (height - 0.5).ceil().clamp(0.0, self.layers as f64) as usize;
                if let Some(layer) = below.checked_sub(1) {
                    self.changes[layer * self.odd.len() + column].fetch_xor(true, Ordering::Relaxed);
                }
            }
        }
    }

    /// The layers of a column that lie inside, from the top; `None` where the mesh is not closed.
    pub(super) fn inside(&self, column: usize, row: usize) -> Option<impl Iterator<Item = usize>> {
        let column = row * self.columns + column;
        let mut is_inside = false;
        let layers = (0..self.layers).rev().filter(move |layer| {
            is_inside ^= self.changes[layer * self.odd.len() + column].load(Ordering::Relaxed);
            is_inside
        });
        (!self.odd[column].load(Ordering::Relaxed)).then_some(layers)
    }
}

/// A triangle as seen from the front, in parts of a pixel, its corners anticlockwise.
struct Flat {
    corners: [[i64; 2]; 3],
    heights: [f64; 3],
    twice_area: i128,
}

impl Flat {
    fn of(triangle: &Triangle) -> Option<Self> {
        let part = |value: f64| (value.clamp(-FARTHEST_PX, FARTHEST_PX) * PARTS).round() as i64;
        let flat = |position: Vector| [part(position[0]), part(position[1])];
        let mut corners = triangle.map(|corner| flat(corner.position));
        let mut heights = triangle.map(|corner| corner.position[2]);
        let mut twice_area = side(corners[0], corners[1], corners[2]);
        if twice_area < 0 {
            corners.swap(1, 2);
            heights.swap(1, 2);
            twice_area = -twice_area;
        }
        (twice_area > 0).then_some(Self { corners, heights, twice_area })
    }

    /// The pixels along an axis whose middles may lie within.
    fn span(&self, axis: usize, count: usize) -> std::ops::Range<usize> {
        let places = self.corners.map(|corner| corner[axis]);
        let least = places.iter().min().map_or(0, |least| least.div_euclid(PARTS as i64));
        let most = places.iter().max().map_or(0, |most| most.div_euclid(PARTS as i64) + 1);
        let inside = |place: i64| place.clamp(0, count as i64) as usize;
        inside(least)..inside(most)
    }

    /// The height at which the line through the middle of a pixel crosses the triangle.
    fn height_at(&self, column: usize, row: usize) -> Option<f64> {
        let middle = [column, row].map(|pixel| pixel as i64 * PARTS as i64 + PARTS as i64 / 2);
        let mut height = self.heights[0];
        for index in 0..3 {
            let (from, to) = (self.corners[(index + 1) % 3], self.corners[(index + 2) % 3]);
            let part = side(from, to, middle);
            // Of two triangles that share an edge, a line through it crosses the one to the right or below.
            let owns_edge = to[1] < from[1] || (to[1] == from[1] && to[0] < from[0]);
            if part < 0 || (part == 0 && !owns_edge) {
                return None;
            }
            // The heights' differences leave no rounding where all are alike.
            height += part as f64 / self.twice_area as f64 * (self.heights[index] - self.heights[0]);
        }
        Some(height)
    }
}

/// Twice the area of a triangle, positive where its corners are anticlockwise.
fn side(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i128 {
    let difference = |one: i64, other: i64| i128::from(one) - i128::from(other);
    difference(b[0], a[0]) * difference(c[1], a[1]) - difference(b[1], a[1]) * difference(c[0], a[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::shape::Corner;
    use proptest::prelude::*;

    /// The twelve triangles of a box.
    fn box_between(least: Vector, most: Vector) -> Vec<Triangle> {
        let corner = |index: usize| {
            let pick = |axis: usize| if index >> axis & 1 == 0 { least[axis] } else { most[axis] };
            Corner { position: [pick(0), pick(1), pick(2)], ..Corner::default() }
        };
        let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        faces
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .map(|face| face.map(corner))
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        /// A voxel is inside exactly where its middle is, corners on middles and edges included.
        #[test]
        fn a_box_is_filled_exactly(
            least in proptest::array::uniform3(-8i32..24),
            size in proptest::array::uniform3(1i32..24),
        ) {
            let least = least.map(|value| f64::from(value) / 2.0);
            let most = [0, 1, 2].map(|axis| least[axis] + f64::from(size[axis]) / 2.0);
            let crossings = Crossings::new(10, 10, 10);
            box_between(least, most).iter().for_each(|triangle| crossings.cross(triangle));
            for column in 0..10 {
                for row in 0..10 {
                    let found: Vec<usize> = crossings.inside(column, row).unwrap().collect();
                    let within = |axis: usize, at: usize| {
                        let middle = at as f64 + 0.5;
                        least[axis] <= middle && middle < most[axis]
                    };
                    // Of edges on middles, the left and the upper belong to the box.
                    let y = row as f64 + 0.5;
                    let flat = within(0, column) && least[1] < y && y <= most[1];
                    let wanted: Vec<usize> = (0..10).rev().filter(|&layer| flat && within(2, layer)).collect();
                    prop_assert_eq!(found, wanted, "{} {}", column, row);
                }
            }
        }
    }

    #[test]
    fn an_open_mesh_fills_nothing_where_it_is_open() {
        let crossings = Crossings::new(10, 10, 10);
        // The front face is missing.
        let mut triangles = box_between([1.0; 3], [6.0; 3]);
        triangles.drain(2..4);
        triangles.iter().for_each(|triangle| crossings.cross(triangle));
        assert!(crossings.inside(3, 3).is_none());
        assert_eq!(crossings.inside(8, 8).unwrap().count(), 0);
    }
}
