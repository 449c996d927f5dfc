//! What is hidden: behind something else in every view.
//!
//! A voxel on film k with its middle at (x, y, z) appears at ((x - z s) / m, (y - z t) / m), with (s, t) the slope of the
//! line of sight and m = 1 - z sqrt(1 + s^2 + t^2) / D for a viewer at distance D, 1 for one far away. It is seen where no
//! voxel of a film above appears in the same pixel; it is hidden where no view sees it.

use std::ops::Range;

use super::layers::Layers;
use crate::optics::Direction;
use crate::projection::ViewerDistance;
use crate::stack::Stack;

/// From where an object is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The viewer's direction.
    pub direction: Direction,
    /// The viewer's distance.
    pub distance: ViewerDistance,
}

/// Takes away what no view sees; returns how many voxels that were. Where only some rows are kept, what is
/// [`rows_around`] within their edges may be hidden by what is not.
pub(super) fn remove(layers: &Layers, stack: &Stack, sights: &[Sight]) -> u64 {
    let taken = layers.occupied();
    let mut seen = vec![false; taken.len()];
    for sight in sights {
        see(&taken, &mut seen, (stack, layers.rows()), sight);
    }
    let hidden = taken.iter().zip(&seen).enumerate().filter(|(_, (taken, seen))| **taken && !**seen);
    hidden.map(|(voxel, _)| layers.clear(voxel)).count() as u64
}

/// How many rows away what hides a voxel may lie.
pub(super) fn rows_around(stack: &Stack, sights: &[Sight]) -> usize {
    let appearances =
        sights.iter().flat_map(|sight| (0..stack.films).map(|film| Appearance::of(stack, film, sight)));
    let climb = appearances.map(|film| film.moved_px(stack, &(0..stack.height_px))[1]).fold(0.0, f64::max);
    2 * climb.ceil() as usize + 1
}

/// Notes which of the `taken` voxels (film, row, column) of some rows are seen.
fn see(taken: &[bool], seen: &mut [bool], (stack, rows): (&Stack, Range<usize>), sight: &Sight) {
    let size = stack.width_px * rows.len();
    let films: Vec<Appearance> = (0..stack.films).map(|film| Appearance::of(stack, film, sight)).collect();
    let moved = films.iter().flat_map(|film| film.moved_px(stack, &rows));
    let margin = moved.fold(0.0, f64::max).ceil() as usize + 1;
    let (width, height) = (stack.width_px + 2 * margin, rows.len() + 2 * margin);
    let mut before = vec![false; width * height];
    for (film, appearance) in films.iter().enumerate() {
        let here = film * size..(film + 1) * size;
        let voxels = || taken[here.clone()].iter().enumerate().filter(|(_, taken)| **taken);
        let pixel = |at: usize| {
            let [column, row] =
                appearance.place(stack, at % stack.width_px, rows.start + at / stack.width_px);
            let from = |place: f64, first: usize, count: usize| {
                let index = (place.round() + margin as f64 - first as f64).max(0.0) as usize;
                index.min(count - 1)
            };
            from(row, rows.start, height) * width + from(column, 0, width)
        };
        for (at, _) in voxels() {
            seen[here.start + at] |= !before[pixel(at)];
        }
        voxels().for_each(|(at, _)| before[pixel(at)] = true);
    }
}

/// Where the pixels of one film appear.
struct Appearance {
    /// In pixels, to the right and down.
    shift: [f64; 2],
    scale: f64,
}

impl Appearance {
    fn of(stack: &Stack, film: usize, sight: &Sight) -> Self {
        let (slope_x, slope_y) = sight.direction.slope(stack.index);
        let z = stack.film_z_mm(film);
        let scale = match sight.distance {
            ViewerDistance::Parallel => 1.0,
            ViewerDistance::Millimetres(distance) => {
                1.0 - z * (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt() / distance
            }
        };
        Self { shift: [-z * slope_x / stack.pixel_mm(), z * slope_y / stack.pixel_mm()], scale }
    }

    /// Where the middle of a pixel appears, in pixels from the middle of the upper left one.
    fn place(&self, stack: &Stack, column: usize, row: usize) -> [f64; 2] {
        let along = |at: usize, count: usize, shift: f64| {
            let middle = (count as f64 - 1.0) / 2.0;
            middle + (at as f64 - middle + shift) / self.scale
        };
        [along(column, stack.width_px, self.shift[0]), along(row, stack.height_px, self.shift[1])]
    }

    /// How far at most the pixels of these rows appear from where they are, to a side and up or down.
    fn moved_px(&self, stack: &Stack, rows: &Range<usize>) -> [f64; 2] {
        let corners = [(0, rows.start), (stack.width_px - 1, rows.end.saturating_sub(1))];
        let moved = corners.map(|(column, row)| {
            let [x, y] = self.place(stack, column, row);
            [(x - column as f64).abs(), (y - row as f64).abs()]
        });
        [0, 1].map(|axis| moved[0][axis].max(moved[1][axis]))
    }
}
