//! What is hidden: behind something else in every view.
//!
//! A voxel on film k with its middle at (x, y, z) appears at ((x - z s) / m, (y - z t) / m), with (s, t) the slope of the
//! line of sight and m = 1 - z sqrt(1 + s^2 + t^2) / D for a viewer at distance D, 1 for one far away. It is seen where no
//! voxel of a film above appears in the same pixel; it is hidden where no view sees it.

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

/// Takes away what no view sees; returns how many voxels that were.
pub(super) fn remove(layers: &Layers, stack: &Stack, sights: &[Sight]) -> u64 {
    let taken = layers.occupied();
    let mut seen = vec![false; taken.len()];
    for sight in sights {
        see(&taken, &mut seen, stack, sight);
    }
    let hidden = taken.iter().zip(&seen).enumerate().filter(|(_, (taken, seen))| **taken && !**seen);
    hidden.map(|(voxel, _)| layers.clear(voxel)).count() as u64
}

/// Notes which of the `taken` voxels (film, row, column) are seen.
fn see(taken: &[bool], seen: &mut [bool], stack: &Stack, sight: &Sight) {
    let size = stack.film_len();
    let mut before = vec![false; 0];
    let films: Vec<Appearance> = (0..stack.films).map(|film| Appearance::of(stack, film, sight)).collect();
    let margin = films.iter().map(|film| film.margin_px(stack)).fold(0.0, f64::max).ceil() as usize + 1;
    let (width, height) = (stack.width_px + 2 * margin, stack.height_px + 2 * margin);
    before.resize(width * height, false);
    for (film, appearance) in films.iter().enumerate() {
        let here = film * size..(film + 1) * size;
        let voxels = || taken[here.clone()].iter().enumerate().filter(|(_, taken)| **taken);
        let pixel = |at: usize| {
            let place = appearance.place(stack, at % stack.width_px, at / stack.width_px);
            let [column, row] = place.map(|value| (value.round() + margin as f64).max(0.0) as usize);
            row.min(height - 1) * width + column.min(width - 1)
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

    /// How far beyond the film's edges its pixels appear.
    fn margin_px(&self, stack: &Stack) -> f64 {
        let corners = [[0, 0], [stack.width_px - 1, stack.height_px - 1]];
        let beyond = corners.into_iter().flat_map(|[column, row]| {
            let [x, y] = self.place(stack, column, row);
            [-x, -y, x - stack.width_px as f64, y - stack.height_px as f64]
        });
        beyond.fold(0.0, f64::max)
    }
}
