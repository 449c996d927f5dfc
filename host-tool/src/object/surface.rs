//! Triangles become points on their surface, as close as the films' voxels.
//!
//! A triangle is cut to the stack's box. With A its corner opposite to its shortest edge BC and lengths measured as the
//! largest of a vector's parts in voxels, it is sampled at
//!
//! ```text
//! P(s, t) = A + s ((1 - t) (B - A) + t (C - A)),  s = i / m, t = j / k
//! m = ceil(2 max(|B - A|, |C - A|)),  k = ceil(2 s |C - B|),  0 <= i <= m, 0 <= j <= k
//! ```
//!
//! so that neighbouring samples are at most half a voxel apart along each axis and no voxel that the surface crosses by
//! more than that is left out. Light is interpolated between the corners and multiplied with the texture's.

use std::ops::RangeInclusive;

use super::shape::{Corner, Triangle, Vector};
use super::texture::Texture;
use crate::picture::srgb_encode;

/// Samples per voxel along each axis.
const SAMPLES: f64 = 2.0;

/// How much of a triangle lies in the stack's box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Inside {
    /// All of it.
    Whole,
    /// A part of it.
    Part,
    /// Nothing of it.
    Nothing,
}

/// Samples the triangle, its positions in voxels from the box's corner, within `0..=size`; `mark` is given each sample's
/// position and its colour as sRGB code values. Samples whose second coordinate is not within `kept` may be left out.
pub(super) fn sample(
    triangle: &Triangle,
    size: Vector,
    kept: [f64; 2],
    texture: Option<&Texture>,
    mark: &mut impl FnMut(Vector, [u8; 3]),
) -> Inside {
    let polygon = clipped(triangle, size);
    let [first, rest @ ..] = polygon.as_slice() else { return Inside::Nothing };
    if polygon.len() < 3 {
        return Inside::Nothing;
    }
    for [second, third] in rest.array_windows() {
        sample_whole(&[*first, *second, *third], kept, texture, mark);
    }
    if polygon == triangle { Inside::Whole } else { Inside::Part }
}

fn sample_whole(
    triangle: &Triangle,
    kept: [f64; 2],
    texture: Option<&Texture>,
    mark: &mut impl FnMut(Vector, [u8; 3]),
) {
    let up = triangle.map(|corner| corner.position[1]);
    if up.iter().all(|up| *up < kept[0]) || up.iter().all(|up| *up > kept[1]) {
        return;
    }
    let [a, b, c] = with_shortest_edge_last(triangle);
    let longer = extent(&a, &b).max(extent(&a, &c));
    let rows = (SAMPLES * longer).ceil().max(1.0);
    let level = texture.map_or(0, |texture| texture.level(texture_step(&a, &b, &c, rows)));
    for row in 0..=rows as u64 {
        let s = row as f64 / rows;
        let (left, right) = (between(&a, &b, s), between(&a, &c, s));
        let columns = (SAMPLES * extent(&left, &right)).ceil().max(1.0);
        for column in kept_columns(left.position[1], right.position[1], columns, kept) {
            let corner = between(&left, &right, column as f64 / columns);
            let light = match texture {
                Some(texture) => {
                    let painted = texture.light(level, corner.texture);
                    [0, 1, 2].map(|channel| corner.light[channel] * painted[channel])
                }
                None => corner.light,
            };
            mark(corner.position, light.map(|light| (srgb_encode(light) * 255.0).round() as u8));
        }
    }
}

/// Of the samples 0 to `columns` between two heights, those within `kept`, with one more on either side.
fn kept_columns(left: f64, right: f64, columns: f64, kept: [f64; 2]) -> RangeInclusive<u64> {
    let lies_beside = left.max(right) < kept[0] || left.min(right) > kept[1];
    if lies_beside || left == right {
        let (first, last) = if lies_beside { (1, 0) } else { (0, columns as u64) };
        return first..=last;
    }
    let ends = kept.map(|height| (height - left) / (right - left) * columns);
    let first = (ends[0].min(ends[1]).floor() - 1.0).clamp(0.0, columns);
    let last = (ends[0].max(ends[1]).ceil() + 1.0).clamp(0.0, columns);
    first as u64..=last as u64
}

/// How far apart samples lie in the texture, as parts of its width and height.
fn texture_step(a: &Corner, b: &Corner, c: &Corner, rows: f64) -> [f32; 2] {
    [0, 1].map(|axis| {
        let span = (b.texture[axis] - a.texture[axis]).abs().max((c.texture[axis] - a.texture[axis]).abs());
        span / rows as f32
    })
}

/// The largest part of the vector between two corners.
fn extent(a: &Corner, b: &Corner) -> f64 {
    (0..3).map(|axis| (b.position[axis] - a.position[axis]).abs()).fold(0.0, f64::max)
}

fn with_shortest_edge_last([a, b, c]: &Triangle) -> Triangle {
    let (ab, bc, ca) = (extent(a, b), extent(b, c), extent(c, a));
    if bc <= ab && bc <= ca {
        [*a, *b, *c]
    } else if ca <= ab {
        [*b, *c, *a]
    } else {
        [*c, *a, *b]
    }
}

/// The corner `part` of the way from `a` to `b`.
fn between(a: &Corner, b: &Corner, part: f64) -> Corner {
    let mix = |a: f32, b: f32| a + part as f32 * (b - a);
    Corner {
        position: [0, 1, 2].map(|axis| a.position[axis] + part * (b.position[axis] - a.position[axis])),
        light: [0, 1, 2].map(|channel| mix(a.light[channel], b.light[channel])),
        texture: [0, 1].map(|axis| mix(a.texture[axis], b.texture[axis])),
    }
}

/// What of the triangle lies within `0..=size` (Sutherland and Hodgman 1974): a convex polygon.
fn clipped(triangle: &Triangle, size: Vector) -> Vec<Corner> {
    let mut polygon = triangle.to_vec();
    for (axis, most) in size.into_iter().enumerate() {
        polygon = cut(&polygon, |corner| corner.position[axis], |corner| corner.position[axis] = 0.0);
        polygon = cut(&polygon, |corner| most - corner.position[axis], |corner| corner.position[axis] = most);
    }
    polygon
}

/// Cuts off what has a negative `height`; `touch` puts a corner right on the cut.
fn cut(polygon: &[Corner], height: impl Fn(&Corner) -> f64, touch: impl Fn(&mut Corner)) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, corner) in polygon.iter().enumerate() {
        let before = &polygon[(index + polygon.len() - 1) % polygon.len()];
        let (here, there) = (height(corner), height(before));
        if (here < 0.0) != (there < 0.0) {
            let mut on_the_cut = between(before, corner, there / (there - here));
            touch(&mut on_the_cut);
            kept.push(on_the_cut);
        }
        if here >= 0.0 {
            kept.push(*corner);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn corner(position: Vector) -> Corner {
        Corner { position, light: [1.0; 3], texture: [0.0; 2] }
    }

    fn voxels(triangle: &Triangle, size: Vector) -> (Inside, BTreeSet<[i64; 3]>) {
        let mut found = BTreeSet::new();
        let inside = sample(triangle, size, [0.0, size[1]], None, &mut |position, colour| {
            assert_eq!(colour, [255; 3]);
            found.insert(position.map(|value| value.floor() as i64));
        });
        (inside, found)
    }

    #[test]
    fn a_flat_triangle_takes_every_voxel_that_it_covers() {
        let triangle = [[0.5, 0.5, 1.5], [8.5, 0.5, 1.5], [0.5, 8.5, 1.5]].map(corner);
        let (inside, found) = voxels(&triangle, [10.0; 3]);
        assert_eq!(inside, Inside::Whole);
        let covered = (0..9).flat_map(|x| (0..9 - x).map(move |y| [x, y, 1]));
        assert!(covered.into_iter().all(|voxel| found.contains(&voxel)), "{found:?}");
        // Its long edge runs through corners of the voxels beyond.
        assert!(found.iter().all(|voxel| voxel[2] == 1 && voxel[0] + voxel[1] <= 9));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        /// Whatever lies far outside, samples stay inside, and a plane through the box leaves no hole in it.
        #[test]
        fn a_plane_through_the_box_has_no_holes(slope in -0.9f64..0.9, level in 3.0f64..7.0) {
            let height = |x: f64, y: f64| level + slope * (x - 5.0) + 0.1 * (y - 5.0);
            let corners = [[-1e6, -1e6], [3e6, -1e6], [-1e6, 3e6]];
            let triangle = corners.map(|[x, y]| corner([x, y, height(x, y)]));
            let (inside, found) = voxels(&triangle, [10.0; 3]);
            prop_assert_eq!(inside, Inside::Part);
            for x in 0..10 {
                for y in 0..10 {
                    let z = height(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    // A column whose middle lies well inside the box is met.
                    if (1.0..9.0).contains(&z) {
                        let column = found.iter().any(|voxel| voxel[0] == i64::from(x) && voxel[1] == i64::from(y));
                        prop_assert!(column, "no voxel at {x}, {y}");
                    }
                }
            }
            prop_assert!(found.iter().all(|voxel| voxel.iter().all(|at| (0..=10).contains(at))));
        }
    }

    #[test]
    fn what_lies_outside_is_left_out_and_what_has_no_area_is_a_line() {
        let outside = [[11.0, 0.0, 0.0], [12.0, 5.0, 0.0], [13.0, 0.0, 5.0]].map(corner);
        assert_eq!(voxels(&outside, [10.0; 3]), (Inside::Nothing, BTreeSet::new()));
        let line = [[0.5, 0.5, 0.5], [4.5, 0.5, 0.5], [4.5, 0.5, 0.5]].map(corner);
        assert_eq!(voxels(&line, [10.0; 3]).1.len(), 5);
    }
}
