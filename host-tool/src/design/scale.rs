//! A design in small: the same stack, views and patterns with coarser pixels.
//!
//! What views cannot share lies at low frequencies, a few cycles a picture, and the geometry there does not
//! depend on the pixels. So a design of 64 pixels a side errs as one of thousands does, lamps and whites can be
//! settled on it, and larger films begin from it.

use std::ops::Range;

use rayon::prelude::*;

use super::request::{DesignRequest, Tone, ViewRequest};
use crate::picture::Picture;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

/// Returns the request with the longer side of its films reduced to `side_px` pixels, patterns averaged in
/// the values in which films add up; a request that is no larger is returned as it is.
pub(super) fn reduced(request: &DesignRequest, side_px: usize) -> DesignRequest {
    let stack = &request.stack;
    let (width_px, height_px) = reduced_size(stack, side_px);
    if (width_px, height_px) == (stack.width_px, stack.height_px) {
        return request.clone();
    }
    let views = request.views.iter().map(|view| ViewRequest {
        id: view.id.clone(),
        pattern: averaged_in(&view.pattern, width_px, height_px, request.settings.tone),
        mask: view.mask.as_ref().map(|mask| averaged_plane(mask, stack.width_px, width_px, height_px)),
        ..*view
    });
    DesignRequest {
        stack: Stack { width_px, height_px, ..stack.clone() },
        distance: request.distance,
        views: views.collect(),
        settings: request.settings.clone(),
        stop: request.stop.clone(),
    }
}

/// Columns and rows of films whose longer side is reduced to `side_px` pixels.
pub(super) fn reduced_size(stack: &Stack, side_px: usize) -> (usize, usize) {
    let longer = stack.width_px.max(stack.height_px);
    let size = |pixels: usize| ((pixels * side_px) as f64 / longer as f64).round().max(2.0) as usize;
    if longer <= side_px {
        (stack.width_px, stack.height_px)
    } else {
        (size(stack.width_px), size(stack.height_px))
    }
}

/// Reduces a picture of code values, averaging light or code values as `tone` says.
fn averaged_in(picture: &Picture, width: usize, height: usize, tone: Tone) -> Picture {
    match tone {
        Tone::Linear => averaged(&picture.decoded(), width, height).encoded(),
        Tone::Code => averaged(picture, width, height),
    }
}

/// Reduces a picture: every pixel is the mean over the area that it covers.
pub(super) fn averaged(picture: &Picture, width: usize, height: usize) -> Picture {
    let mut reduced = Picture::new(width, height);
    for channel in 0..CHANNELS {
        let plane = averaged_plane(picture.channel(channel), picture.width(), width, height);
        reduced.channel_mut(channel).copy_from_slice(&plane);
    }
    reduced
}

/// Reduces one plane (row, column) of `from` columns to `width` x `height` means.
pub(super) fn averaged_plane(plane: &[f32], from: usize, width: usize, height: usize) -> Vec<f32> {
    let columns = shares(from, width);
    let rows = shares(plane.len() / from, height);
    let narrow: Vec<f32> = plane
        .chunks_exact(from)
        .flat_map(|line| columns.iter().map(|share| share.sum(|at| line[at])))
        .collect();
    let at = |row: usize, column: usize| narrow[row * width + column];
    let means = rows.iter().flat_map(|share| (0..width).map(move |column| share.sum(|row| at(row, column))));
    means.collect()
}

/// Enlarges a picture, interpolating linearly between pixel centres; at the edges it stays as it is there.
pub(super) fn enlarged(picture: &Picture, width: usize, height: usize) -> Picture {
    let grid = Grid::new((picture.width(), picture.height()), (width, height));
    let mut large = Picture::new(width, height);
    for channel in 0..CHANNELS {
        grid.enlarge(picture.channel(channel), large.channel_mut(channel));
    }
    large
}

/// Enlarges every film as [`enlarged`] does a picture.
pub(super) fn enlarged_volume(volume: &Volume, width: usize, height: usize) -> Volume {
    let mut large = Volume::new(volume.films(), height, width);
    let from = (volume.width(), volume.height());
    enlarge_planes(volume.values(), from, large.values_mut(), (width, height));
    large
}

/// Enlarges every plane of `small` into `large`; sizes are columns and rows.
pub(super) fn enlarge_planes(small: &[f32], from: (usize, usize), large: &mut [f32], to: (usize, usize)) {
    let grid = Grid::new(from, to);
    let planes = large.par_chunks_exact_mut(to.0 * to.1).zip(small.par_chunks_exact(from.0 * from.1));
    planes.for_each(|(large, small)| grid.enlarge(small, large));
}

/// From some rows of a small plane to some rows of a large one; sizes are columns and rows of the whole planes. Rows
/// beyond these are those at their edges.
pub(super) struct Enlarging {
    pub(super) from: (usize, usize),
    /// The rows of the small plane that there are.
    pub(super) held: Range<i64>,
    pub(super) to: (usize, usize),
    /// The rows of the large plane that are wanted.
    pub(super) wanted: Range<i64>,
}

impl Enlarging {
    /// Enlarges `small` into `large`.
    pub(super) fn plane(&self, small: &[f32], large: &mut [f32]) {
        let mut grid = Grid::new(self.from, self.to);
        let held =
            |row: usize| ((row as i64).clamp(self.held.start, self.held.end - 1) - self.held.start) as usize;
        let wanted = self.wanted.clone().map(|row| grid.rows[row.clamp(0, self.to.1 as i64 - 1) as usize]);
        grid.rows = wanted.map(|(row, next, down)| (held(row), held(next), down)).collect();
        grid.enlarge(small, large);
    }
}

/// Where the pixels of a large plane lie between those of a small one.
struct Grid {
    from_width: usize,
    columns: Vec<(usize, usize, f32)>,
    rows: Vec<(usize, usize, f32)>,
}

impl Grid {
    /// Sizes are columns and rows.
    fn new(from: (usize, usize), to: (usize, usize)) -> Self {
        Self { from_width: from.0, columns: positions(from.0, to.0), rows: positions(from.1, to.1) }
    }

    fn enlarge(&self, source: &[f32], target: &mut [f32]) {
        let line_of = |row: usize| &source[row * self.from_width..(row + 1) * self.from_width];
        for (line, &(row, next_row, down)) in target.chunks_exact_mut(self.columns.len()).zip(&self.rows) {
            let (upper, lower) = (line_of(row), line_of(next_row));
            for (value, &(at, next, right)) in line.iter_mut().zip(&self.columns) {
                let above = upper[at] + right * (upper[next] - upper[at]);
                let below = lower[at] + right * (lower[next] - lower[at]);
                *value = above + down * (below - above);
            }
        }
    }
}

/// The part of one axis that a reduced pixel covers.
struct Share {
    first: usize,
    weights: Vec<f32>,
}

impl Share {
    fn sum(&self, value: impl Fn(usize) -> f32) -> f32 {
        self.weights.iter().enumerate().map(|(offset, weight)| weight * value(self.first + offset)).sum()
    }
}

fn shares(from: usize, to: usize) -> Vec<Share> {
    let ratio = from as f64 / to as f64;
    let share = |index: usize| {
        let (start, end) = (index as f64 * ratio, (index + 1) as f64 * ratio);
        let first = (start.floor() as usize).min(from - 1);
        let last = (end.ceil() as usize).clamp(first + 1, from);
        let covered = |at: usize| (end.min(at as f64 + 1.0) - start.max(at as f64)).max(0.0) / ratio;
        Share { first, weights: (first..last).map(|at| covered(at) as f32).collect() }
    };
    (0..to).map(share).collect()
}

/// For each pixel of the large axis: the two small pixels between which it lies, and how far from the first.
fn positions(from: usize, to: usize) -> Vec<(usize, usize, f32)> {
    let place = |index: usize| {
        let position = ((index as f64 + 0.5) * from as f64 / to as f64 - 0.5).clamp(0.0, (from - 1) as f64);
        let lower = position.floor() as usize;
        (lower, (lower + 1).min(from - 1), (position - lower as f64) as f32)
    };
    (0..to).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: usize, height: usize) -> Picture {
        let mut picture = Picture::new(width, height);
        for channel in 0..CHANNELS {
            for (index, value) in picture.channel_mut(channel).iter_mut().enumerate() {
                *value = (index % width) as f32 / width as f32 + (index / width) as f32 * 0.01;
            }
        }
        picture
    }

    #[test]
    fn averaging_keeps_the_mean_at_any_ratio() {
        let picture = ramp(50, 31);
        let mean = |picture: &Picture| {
            picture.values().iter().map(|&v| f64::from(v)).sum::<f64>() / picture.values().len() as f64
        };
        for (width, height) in [(50, 31), (25, 31), (16, 9), (7, 2)] {
            let reduced = averaged(&picture, width, height);
            assert!((mean(&reduced) - mean(&picture)).abs() < 1e-5, "{width} x {height}");
        }
    }

    #[test]
    fn enlarging_keeps_a_ramp_but_for_its_ends() {
        let small = ramp(16, 16);
        let large = enlarged(&small, 64, 64);
        let again = averaged(&large, 16, 16);
        for row in 1..15 {
            for column in 1..15 {
                let at = row * 16 + column;
                assert!((again.channel(1)[at] - small.channel(1)[at]).abs() < 1e-5);
            }
        }
    }
}
