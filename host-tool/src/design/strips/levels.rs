//! The optimiser on some rows: from the exhibit in small to ever finer pixels.
//!
//! Large films would need many iterations from a start in small. So a strip is solved with coarse pixels first, which
//! cost little, and each finer one begins where the coarser has come to.
//!
//! Where every film lies astray by more than a pixel, what is finer than that never reaches an eye: the films'
//! expected light has lost it (see [`robust`]). Then the finest pixels that are solved are as large as the least of
//! these errors, and the films are enlarged from there.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::lean::{Tile, picture_rows};
use super::{PictureRows, StripRequest};
use crate::design::joint;
use crate::design::optimise::{Lighting, improve, set_up_counting};
use crate::design::request::{DesignRequest, Progress, ViewRequest};
use crate::design::robust;
use crate::design::scale::{Enlarging, reduced_size};
use crate::picture::Picture;
use crate::stack::{Stack, StripPlace};
use crate::volume::{CHANNELS, Volume};

/// The least error of a film's place in pixels that are solved, where these are larger than the films' own: designs of
/// photographs and of sharp patterns with such pixels showed 0.02 to 0.09 dB less as built.
const LEAST_ERROR_PX: f64 = 0.95;
/// How far the structure loss reaches, with room for what it passes on.
const STRUCTURE_ROWS: usize = 16;
/// The part of a film's greatest error to which rows beyond a strip's are solved with it, in standard deviations: twice as
/// much made no difference.
const ERRORS_AROUND: f64 = 1.0;
/// A strip with pixels so much finer than where it would begin has a coarser one before it.
const FARTHEST_START: usize = 3;

/// Iterations on pixels coarser than the films', which began on coarser ones: ten more gained 0.005 dB.
const ERRORS_ITERATIONS: usize = 10;

/// Films with pixels of one size.
pub(super) struct Level {
    /// The whole films.
    pub(super) stack: Stack,
    /// Rows on either side of what is wanted that are solved with it, beside those for the climbing of rays.
    around: usize,
}

/// How strips are solved.
pub(super) struct Levels {
    /// The volume in small, of glow, from which the coarsest level begins.
    pub(super) start: Volume,
    pub(super) lighting: Lighting,
    /// How much scattered light counts in each view.
    counts: Vec<f32>,
    /// From the coarsest to the finest.
    levels: Vec<Level>,
}

/// The ink of some rows of all films.
pub(super) struct Solved {
    volume: Volume,
    /// Films with such pixels, and which of their rows these are.
    stack: Stack,
}

impl Level {
    /// Films with `side_px` pixels along their longer side, else as `stack`.
    fn new(stack: &Stack, side_px: usize, small: &DesignRequest) -> Self {
        let (width_px, height_px) = reduced_size(stack, side_px);
        let stack = Stack { width_px, height_px, ..stack.clone() };
        let whole = DesignRequest { stack: stack.clone(), ..small.clone() };
        let astray = (ERRORS_AROUND * robust::errors_px(&whole).1).ceil() as usize;
        Self { stack, around: STRUCTURE_ROWS + astray }
    }

    /// Rows on either side of `tile` that are solved with it.
    pub(super) fn around(&self, tile: &Tile) -> usize {
        2 * tile.climb(&self.stack) + self.around
    }

    /// The finest pixels that are solved.
    pub(super) fn finest(stack: &Stack, small: &DesignRequest) -> Self {
        let longer = stack.width_px.max(stack.height_px);
        let whole = DesignRequest { stack: stack.clone(), ..small.clone() };
        let grain = (robust::errors_px(&whole).0 / LEAST_ERROR_PX).floor().max(1.0);
        Self::new(stack, (longer as f64 / grain).round() as usize, small)
    }

    fn longer(&self) -> usize {
        self.stack.width_px.max(self.stack.height_px)
    }

    /// The films of this level with the rows that are solved for the sake of `tile`, of which the rows `wanted` of each film
    /// are needed, counted in films of `height` rows.
    fn window(&self, tile: &Tile, wanted: &[Range<usize>], height: usize) -> Stack {
        let mut window = tile.leaning(&self.stack);
        let around = self.around(tile);
        let rows = wanted.iter().map(|rows| {
            let first = (rows.start * self.stack.height_px / height).saturating_sub(around);
            let last = (rows.end * self.stack.height_px).div_ceil(height) + around;
            if rows.is_empty() { 0..0 } else { first..last.min(self.stack.height_px) }
        });
        let rows: Vec<Range<usize>> = rows.collect();
        // Where nothing is wanted, any rows will do.
        let Range { start: first, end: last } = picture_rows(&window, &rows).unwrap_or(0..2);
        window.height_px = (last - first) as usize;
        window.strip = window.strip.map(|strip| StripPlace { first_row: first, ..strip });
        window
    }
}

/// The request of the rows `window` of the films alone.
fn windowed(request: &StripRequest, window: &Stack) -> DesignRequest {
    let StripRequest { small, patterns, masks, .. } = request;
    let views = small.views.iter().zip(patterns).zip(masks).map(|((view, pattern), mask)| {
        let mut windowed = ViewRequest {
            id: view.id.clone(),
            pattern: rows_of(&**pattern, window),
            mask: mask.as_deref().map(|mask| rows_of(mask, window).channel(0).to_vec()),
            ..*view
        };
        // Pixels count as they do in the whole picture.
        windowed.weight *= view.mask_share() / windowed.mask_share();
        windowed
    });
    DesignRequest { stack: window.clone(), views: views.collect(), ..small.clone() }
}

/// The rows of a picture that `window` has on the middle plane; black beyond its edges, where nobody looks.
fn rows_of(picture: &dyn PictureRows, window: &Stack) -> Picture {
    let size @ (width, whole_px) = window.whole_size();
    let (first, height) = (window.first_picture_row(), window.height_px);
    let exists = |row: i64| row.clamp(0, whole_px as i64) as usize;
    let existing = exists(first)..exists(first + height as i64);
    if existing.len() == height {
        return picture.rows(size, existing);
    }
    let mut placed = Picture::new(width, height);
    if !existing.is_empty() {
        let above = (existing.start as i64 - first) as usize * width;
        let rows = picture.rows(size, existing);
        for channel in 0..CHANNELS {
            let rows = rows.channel(channel);
            placed.channel_mut(channel)[above..above + rows.len()].copy_from_slice(rows);
        }
    }
    placed
}

/// Whether a film of `stack` has such a row.
fn exists(stack: &Stack, row: i64) -> bool {
    (0..stack.whole_size().1 as i64).contains(&row)
}

/// The voxels of rows beyond the edges of the films (film, row, column), where there are some: no ink comes there.
fn beyond_edges(stack: &Stack) -> Option<Arc<[bool]>> {
    let rows = || (0..stack.films).flat_map(|film| stack.rows(film));
    if rows().all(|row| exists(stack, row)) {
        return None;
    }
    Some(rows().flat_map(|row| std::iter::repeat_n(!exists(stack, row), stack.width_px)).collect())
}

/// What one volume, of films `stack`, is on the rows and pixels of the films `window`.
fn brought_to(window: &Stack, volume: &Volume, stack: &Stack) -> Volume {
    let mut brought = Volume::new(window.films, window.height_px, window.width_px);
    let planes = brought.values_mut().par_chunks_mut(window.film_len()).enumerate();
    planes.for_each(|(index, plane)| {
        let (channel, film) = (index / window.films, index % window.films);
        enlarging(stack, film, window.whole_size(), window.rows(film))
            .plane(volume.film(channel, film), plane);
        let lines = plane.chunks_mut(window.width_px).zip(window.rows(film));
        lines.filter(|(_, row)| !exists(window, *row)).for_each(|(line, _)| line.fill(0.0));
    });
    brought
}

/// From a film of `stack` to the rows `wanted` of one of `to` columns and rows.
fn enlarging(stack: &Stack, film: usize, to: (usize, usize), wanted: Range<i64>) -> Enlarging {
    Enlarging { from: stack.whole_size(), held: stack.rows(film), to, wanted }
}

impl Levels {
    /// Begins from `start`, the volume of ink in small, lit by `lighting`.
    pub(super) fn new(stack: &Stack, small: &DesignRequest, start: &Volume, lighting: Lighting) -> Self {
        let mut levels = vec![Level::finest(stack, small)];
        let begin = start.width().max(start.height());
        while levels[0].longer() > FARTHEST_START * begin {
            levels.insert(0, Level::new(stack, levels[0].longer() / 2, small));
        }
        let start = small.emission().glow_of(start).into_owned();
        Self { start, lighting, counts: robust::counts(small, &small.targets()), levels }
    }

    /// Rows of the whole films of each level.
    #[cfg(test)]
    pub(super) fn heights_px(&self) -> Vec<usize> {
        self.levels.iter().map(|level| level.stack.height_px).collect()
    }

    /// Solves the rows of `tile`.
    pub(super) fn solve(
        &self,
        request: &StripRequest,
        tile: &Tile,
        report: &mut dyn FnMut(Progress),
    ) -> Solved {
        let stack = &request.stack;
        let mut windows: Vec<Stack> = Vec::new();
        let (mut wanted, mut height) = (tile.films.clone(), stack.height_px);
        for level in self.levels.iter().rev() {
            let window = level.window(tile, &wanted, height);
            height = level.stack.height_px;
            let row = |row: i64| row.clamp(0, height as i64) as usize;
            let rows = (0..stack.films).map(|film| window.rows(film));
            wanted = rows.map(|rows| row(rows.start)..row(rows.end)).collect();
            windows.push(window);
        }
        let mut solved: Option<Solved> = None;
        for window in windows.into_iter().rev() {
            let mut volume = match &solved {
                None => brought_to(&window, &self.start, &request.small.stack),
                Some(solved) => brought_to(&window, &solved.volume, &solved.stack),
            };
            let request = windowed(request, &window);
            let mut problem = set_up_counting(&request, &self.counts, &self.lighting, None);
            problem.fixed = beyond_edges(&window);
            let mut effort = joint::effort(&request.settings);
            if solved.is_some() && window.width_px < stack.width_px {
                effort.iterations = effort.iterations.min(ERRORS_ITERATIONS);
            }
            improve(&request, &problem, &mut volume, effort, report);
            solved = Some(Solved { volume, stack: window });
        }
        let start = || Solved { volume: self.start.clone(), stack: request.small.stack.clone() };
        let mut solved = solved.unwrap_or_else(start);
        request.small.emission().turn_into_ink(solved.volume.values_mut());
        solved
    }
}

impl Solved {
    /// Writes the rows `rows` of film `film` of one channel, of a film of `size` columns and rows.
    pub(super) fn write(
        &self,
        channel: usize,
        film: usize,
        size: (usize, usize),
        rows: Range<usize>,
        plane: &mut [f32],
    ) {
        let rows = rows.start as i64..rows.end as i64;
        enlarging(&self.stack, film, size, rows).plane(self.volume.film(channel, film), plane);
    }
}

/// Bytes that the optimiser takes for each row of films with these pixels, for so many views.
pub(super) fn row_bytes(stack: &Stack, views: usize) -> f64 {
    /// Bytes of a value.
    const VALUE: f64 = size_of::<f32>() as f64;
    /// Of a view's pixel: its pattern, its target, its structure, and what the optimiser answers with.
    const VIEW_VALUES: f64 = 12.0;
    /// The coarser level's part.
    const COARSER: f64 = 0.25;
    // Of a voxel, beside its three colours: where one of them is and its step, in 16 bits each, its light, its print.
    let solver = if stack.blur_um > 0.0 { 3.0 } else { 2.0 };
    let voxel = (1.0 + COARSER) * CHANNELS as f64 + solver;
    VALUE * stack.width_px as f64 * (stack.films as f64 * voxel + views as f64 * VIEW_VALUES)
}
