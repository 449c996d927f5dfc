//! The optimiser on some rows: from the exhibit in small to ever finer pixels.
//!
//! Large films would need many iterations from a start in small. So a strip is solved with coarse pixels first, which
//! cost little, and each finer one begins where the coarser has come to.
//!
//! Where every film lies astray by more than a pixel, what is finer than that never reaches an eye: the films'
//! expected light has lost it (see [`robust`]). Then the finest pixels that are solved are as large as the least of
//! these errors, and the films are enlarged from there.

use std::ops::Range;

use super::{PictureRows, StripRequest};
use crate::design::joint;
use crate::design::optimise::{Lighting, improve, set_up_counting};
use crate::design::request::{DesignRequest, Progress, ViewRequest};
use crate::design::robust;
use crate::design::scale::{Enlarging, reduced_size};
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

/// The least error of a film's place in pixels that are solved, where these are larger than the films' own: designs of
/// photographs and of sharp patterns with such pixels showed 0.02 to 0.09 dB less as built.
const LEAST_ERROR_PX: f64 = 0.95;
/// How far the structure loss reaches, with room for what it passes on.
const STRUCTURE_ROWS: usize = 16;
/// The part of a film's greatest error to which rows beyond a strip's are solved with it, in standard deviations.
const ERRORS_AROUND: f64 = 2.0;
/// A strip with pixels so much finer than where it would begin has a coarser one before it.
const FARTHEST_START: usize = 3;

/// Iterations on pixels coarser than the films', which began on coarser ones: ten more gained 0.005 dB.
const ERRORS_ITERATIONS: usize = 10;

/// Films with pixels of one size.
pub(super) struct Level {
    /// The whole films.
    pub(super) stack: Stack,
    /// Rows on either side of what is wanted that are solved with it.
    pub(super) around: usize,
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
    pub(super) volume: Volume,
    /// Columns and rows of the whole films with such pixels.
    pub(super) size: (usize, usize),
    /// The rows of them that these are.
    pub(super) rows: Range<usize>,
}

impl Level {
    /// Films with `side_px` pixels along their longer side, else as `stack`.
    fn new(stack: &Stack, side_px: usize, small: &DesignRequest) -> Self {
        let (width_px, height_px) = reduced_size(stack, side_px);
        let stack = Stack { width_px, height_px, ..stack.clone() };
        let whole = DesignRequest { stack: stack.clone(), ..small.clone() };
        let climbs = small.views.iter().map(|view| whole.rays_of(view).climb());
        let astray = (ERRORS_AROUND * robust::errors_px(&whole).1).ceil() as usize;
        let around = 2 * climbs.max().unwrap_or_default() + STRUCTURE_ROWS + astray;
        Self { stack, around }
    }

    /// The finest pixels that are solved.
    pub(super) fn finest(stack: &Stack, small: &DesignRequest) -> Self {
        let longer = stack.width_px.max(stack.height_px);
        let whole = DesignRequest { stack: stack.clone(), ..small.clone() };
        let grain = (robust::errors_px(&whole).0 / LEAST_ERROR_PX).floor().max(1.0);
        Self::new(stack, (longer as f64 / grain).round() as usize, small)
    }

    fn size(&self) -> (usize, usize) {
        (self.stack.width_px, self.stack.height_px)
    }

    fn longer(&self) -> usize {
        self.stack.width_px.max(self.stack.height_px)
    }

    /// The rows that are solved for the sake of `rows` of films of `height` rows.
    fn window(&self, rows: &Range<usize>, height: usize) -> Range<usize> {
        let first = rows.start * self.stack.height_px / height;
        let last = (rows.end * self.stack.height_px).div_ceil(height);
        first.saturating_sub(self.around)..(last + self.around).min(self.stack.height_px)
    }

    /// The request of some rows alone.
    fn windowed(&self, request: &StripRequest, rows: Range<usize>) -> DesignRequest {
        let StripRequest { small, patterns, masks, .. } = request;
        let middle = |first: usize, count: usize| first as f64 + (count as f64 - 1.0) / 2.0;
        let views = small.views.iter().zip(patterns).zip(masks).map(|((view, pattern), mask)| {
            let grey = |mask: &dyn PictureRows| mask.rows(self.size(), rows.clone()).channel(0).to_vec();
            let mut windowed = ViewRequest {
                id: view.id.clone(),
                pattern: pattern.rows(self.size(), rows.clone()),
                mask: mask.as_deref().map(grey),
                ..*view
            };
            // Pixels count as they do in the whole picture.
            windowed.weight *= view.mask_share() / windowed.mask_share();
            windowed
        });
        let above_middle_px = middle(0, self.stack.height_px) - middle(rows.start, rows.len());
        DesignRequest {
            stack: Stack { height_px: rows.len(), above_middle_px, ..self.stack.clone() },
            views: views.collect(),
            ..small.clone()
        }
    }
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

    /// Solves the rows `rows` of the films as they will be written.
    pub(super) fn solve(
        &self,
        request: &StripRequest,
        rows: &Range<usize>,
        report: &mut dyn FnMut(Progress),
    ) -> Solved {
        let mut windows = vec![(rows.clone(), request.stack.height_px)];
        for level in self.levels.iter().rev() {
            let (finer, height) = &windows[windows.len() - 1];
            windows.push((level.window(finer, *height), level.stack.height_px));
        }
        let size = (self.start.width(), self.start.height());
        let mut solved: Option<Solved> = None;
        let stack = &request.stack;
        for (level, (window, _)) in self.levels.iter().zip(windows.into_iter().rev()) {
            let request = level.windowed(request, window.clone());
            let mut volume = Volume::new(stack.films, window.len(), level.stack.width_px);
            let (from, held, values) = match &solved {
                None => (size, 0..size.1, self.start.values()),
                Some(solved) => (solved.size, solved.rows.clone(), solved.volume.values()),
            };
            let enlarging = Enlarging { from, held, to: level.size(), wanted: window.clone() };
            enlarging.planes(values, volume.values_mut());
            let problem = set_up_counting(&request, &self.counts, &self.lighting, None);
            let mut effort = joint::effort(&request.settings);
            if solved.is_some() && level.longer() < stack.width_px.max(stack.height_px) {
                effort.iterations = effort.iterations.min(ERRORS_ITERATIONS);
            }
            improve(&request, &problem, &mut volume, effort, report);
            solved = Some(Solved { volume, size: level.size(), rows: window });
        }
        let mut solved =
            solved.unwrap_or_else(|| Solved { volume: self.start.clone(), size, rows: 0..size.1 });
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
        let enlarging = Enlarging { from: self.size, held: self.rows.clone(), to: size, wanted: rows };
        enlarging.planes(self.volume.film(channel, film), plane);
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
