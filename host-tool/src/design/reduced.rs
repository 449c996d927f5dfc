//! The same request on films of fewer pixels: what views share they share at low frequencies, so lamps and
//! whites can be settled there, and the films begin from there.

use super::request::{DesignRequest, ViewRequest};
use crate::picture::Picture;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

/// Returns the request with films of at most `pixels` along their longer side, reduced by a whole factor.
pub(super) fn reduced(request: &DesignRequest, pixels: usize) -> DesignRequest {
    let stack = &request.stack;
    let factor = stack.width_px.max(stack.height_px).div_ceil(pixels).max(1);
    let (width, height) = ((stack.width_px / factor).max(2), (stack.height_px / factor).max(2));
    // What does not fill a whole pixel at the right and the bottom is left out.
    let width_mm = stack.pixel_mm() * factor as f64 * width as f64;
    let views = request
        .views
        .iter()
        .map(|view| ViewRequest { pattern: shrink(&view.pattern, factor, width, height), ..view.clone() });
    DesignRequest {
        stack: Stack { width_px: width, height_px: height, width_mm, ..stack.clone() },
        views: views.collect(),
        ..request.clone()
    }
}

/// Returns the volume with films of `width` x `height`, interpolated between pixel centres.
pub(super) fn enlarged(volume: &Volume, width: usize, height: usize) -> Volume {
    let mut large = Volume::new(volume.films(), height, width);
    let columns = positions(volume.width(), width);
    let rows = positions(volume.height(), height);
    for channel in 0..CHANNELS {
        for film in 0..volume.films() {
            let source = volume.film(channel, film);
            let target = large.film_mut(channel, film);
            for (line, &(row, down)) in target.chunks_mut(width).zip(&rows) {
                let next = (row + 1).min(volume.height() - 1);
                let at = |row: usize, column: usize| source[row * volume.width() + column];
                for (value, &(column, across)) in line.iter_mut().zip(&columns) {
                    let right = (column + 1).min(volume.width() - 1);
                    let above = at(row, column) + across * (at(row, right) - at(row, column));
                    let below = at(next, column) + across * (at(next, right) - at(next, column));
                    *value = above + down * (below - above);
                }
            }
        }
    }
    large
}

/// For each of `to` pixels: the pixel of `from` before its centre, and how far beyond that it lies.
fn positions(from: usize, to: usize) -> Vec<(usize, f32)> {
    (0..to)
        .map(|at| {
            let position = ((at as f64 + 0.5) * from as f64 / to as f64 - 0.5).clamp(0.0, from as f64 - 1.0);
            (position.floor() as usize, position.fract() as f32)
        })
        .collect()
}

fn shrink(picture: &Picture, factor: usize, width: usize, height: usize) -> Picture {
    if factor == 1 {
        return picture.clone();
    }
    let mut small = Picture::new(width, height);
    let share = 1.0 / (factor * factor) as f32;
    for channel in 0..CHANNELS {
        let source = picture.channel(channel);
        let target = small.channel_mut(channel);
        for (row, line) in target.chunks_mut(width).enumerate() {
            for (column, value) in line.iter_mut().enumerate() {
                let rows = (0..factor).map(|r| (row * factor + r) * picture.width() + column * factor);
                *value =
                    rows.map(|start| source[start..start + factor].iter().sum::<f32>()).sum::<f32>() * share;
            }
        }
    }
    small
}
