//! What a volume shows in a direction, and the exact transpose of that.
//!
//! A point (x, y, z) appears in a view of slope (s, t) at (x - z s, y - z t), measured on the middle plane.
//! For a viewer at distance D from the middle the eye E lies on that line, and the point appears at
//! `(x E_z - z E_x) / (E_z - z)`, likewise y. Either way one film maps to the picture by a scale and a shift
//! along each axis, so the map is separable. Between pixel centres the film is interpolated linearly; where
//! a ray passes outside the outermost pixel centres it meets no light.

mod axis;

use std::ops::Range;

use rayon::prelude::*;

use crate::optics::Direction;
use crate::picture::Picture;
use crate::simd::vectorised;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};
use axis::{Axis, Part};

/// Where the eye is along the line of sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ViewerDistance {
    /// So far away that all rays are parallel, as in the paper.
    #[default]
    Parallel,
    /// This far from the middle of the stack, in mm.
    Millimetres(f64),
}

/// The rays of one view: for every picture pixel, where they meet each film.
#[derive(Clone, Debug)]
pub struct Rays {
    width: usize,
    height: usize,
    films: Vec<FilmRays>,
}

#[derive(Clone, Debug)]
struct FilmRays {
    rows: Axis,
    columns: Axis,
}

impl Rays {
    /// Follows the rays from a viewer in `direction` at `distance` through the stack.
    ///
    /// A viewer nearer than the top film sees nothing of it.
    pub fn new(stack: &Stack, direction: Direction, distance: ViewerDistance) -> Self {
        Self::misplaced(stack, direction, distance, &[])
    }

    /// As [`Rays::new`], with film k moved by `shifts_mm[k]` (x to the right, y up); films beyond the end of
    /// `shifts_mm` are in their place.
    pub fn misplaced(
        stack: &Stack,
        direction: Direction,
        distance: ViewerDistance,
        shifts_mm: &[(f64, f64)],
    ) -> Self {
        let heights: Vec<f64> = (0..stack.films).map(|film| stack.film_z_mm(film)).collect();
        Self::at_heights(stack, direction, distance, shifts_mm, &heights)
    }

    /// As [`Rays::misplaced`], with film k at `heights_mm[k]` above the middle of the stack.
    pub fn at_heights(
        stack: &Stack,
        direction: Direction,
        distance: ViewerDistance,
        shifts_mm: &[(f64, f64)],
        heights_mm: &[f64],
    ) -> Self {
        let (slope_x, slope_y) = direction.slope(stack.index);
        let pixel = stack.pixel_mm();
        let (_, whole_px) = stack.whole_size();
        let films = heights_mm
            .iter()
            .enumerate()
            .map(|(film, &z)| {
                let scale = match distance {
                    ViewerDistance::Parallel => 1.0,
                    ViewerDistance::Millimetres(distance) => {
                        1.0 - z * (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt() / distance
                    }
                };
                let (dx, dy) = shifts_mm.get(film).copied().unwrap_or_default();
                FilmRays {
                    columns: Axis::new(stack.width_px, scale, (z * slope_x - dx) / pixel),
                    rows: Axis::of_part(
                        stack.height_px,
                        Part {
                            whole: whole_px,
                            picture: stack.first_picture_row(),
                            film: stack.first_row(film),
                        },
                        scale,
                        -(z * slope_y - dy) / pixel,
                    ),
                }
            })
            .collect();
        Self { width: stack.width_px, height: stack.height_px, films }
    }

    /// The part of a pixel of film `film` that its rays share with each neighbour, along the rows and along the columns:
    /// the mean of f (1 - f) for rays that meet the film f pixels beside a pixel's centre.
    pub(crate) fn shared_with_neighbours(&self, film: usize) -> [f64; 2] {
        self.films.get(film).map_or([0.0; 2], |rays| [rays.columns.shared(), rays.rows.shared()])
    }

    /// Columns of the picture and of each film.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the picture and of each film.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether every ray stays in its own row of pixels, so that each row is a problem of its own.
    pub fn rows_are_apart(&self) -> bool {
        self.films.iter().all(|film| film.rows.is_identity())
    }

    /// Adds to `picture` what the films of one channel show: for each pixel the sum over films of the
    /// film's weight times its interpolated ink. `films` is film, row, column; `picture` is row, column.
    pub fn project(&self, films: &[f32], weights: &[f32], picture: &mut [f32]) {
        picture.par_chunks_mut(self.width * ROWS_AT_ONCE).enumerate().for_each(|(chunk, rows)| {
            let mut scratch = vec![0.0; self.width];
            vectorised(
                #[inline(always)]
                || {
                    for (index, target) in rows.chunks_mut(self.width).enumerate() {
                        self.project_row(chunk * ROWS_AT_ONCE + index, films, weights, target, &mut scratch);
                    }
                },
            );
        });
    }

    /// Adds to `films` the transpose of [`Rays::project`] applied to `picture`.
    pub fn back_project(&self, picture: &[f32], weights: &[f32], films: &mut [f32]) {
        let size = self.width * self.height;
        films.par_chunks_mut(size).zip(&self.films).zip(weights).for_each(|((plane, rays), &weight)| {
            let mut scratch = vec![0.0; self.width];
            vectorised(
                #[inline(always)]
                || {
                    for (row, target) in plane.chunks_mut(self.width).enumerate() {
                        if let Some(source) = rays.rows.gather_transposed(row, picture, &mut scratch) {
                            rays.columns.add_transposed(source, weight, target);
                        }
                    }
                },
            );
        });
    }

    /// Adds to `target` what row `row` of the picture shows; `films` is film, row, column, and `scratch` holds
    /// one row.
    #[inline(always)]
    fn project_row(
        &self,
        row: usize,
        films: &[f32],
        weights: &[f32],
        target: &mut [f32],
        scratch: &mut [f32],
    ) {
        let (width, size) = (self.width, self.width * self.height);
        for ((plane, rays), &weight) in films.chunks_exact(size).zip(&self.films).zip(weights) {
            let line = |at: usize| &plane[at * width..(at + 1) * width];
            if let Some(source) = rays.rows.gather(row, line, scratch) {
                rays.columns.add(source, weight, target);
            }
        }
    }

    /// As [`Rays::project_row`], for films kept as row, film, column.
    #[inline(always)]
    pub(crate) fn project_row_of_lines(
        &self,
        row: usize,
        lines: &[f32],
        weights: &[f32],
        target: &mut [f32],
        scratch: &mut [f32],
    ) {
        let (width, films) = (self.width, self.films.len());
        for (film, (rays, &weight)) in self.films.iter().zip(weights).enumerate() {
            let line = |at: usize| &lines[(at * films + film) * width..(at * films + film + 1) * width];
            if let Some(source) = rays.rows.gather(row, line, scratch) {
                rays.columns.add(source, weight, target);
            }
        }
    }

    /// Adds to `target`, row `row` of film `film`, the transpose of the projection applied to `picture`;
    /// `scratch` holds one row.
    #[inline(always)]
    pub(crate) fn back_project_row(
        &self,
        film: usize,
        row: usize,
        picture: &[f32],
        weight: f32,
        target: &mut [f32],
        scratch: &mut [f32],
    ) {
        let Some(rays) = self.films.get(film) else { return };
        if let Some(source) = rays.rows.gather_transposed(row, picture, scratch) {
            rays.columns.add_transposed(source, weight, target);
        }
    }

    /// For views whose rows are apart: adds to `target` what `line`, a row of film `film`, shows.
    #[inline(always)]
    pub(crate) fn project_film_line(&self, film: usize, line: &[f32], weight: f32, target: &mut [f32]) {
        if let Some(rays) = self.films.get(film) {
            rays.columns.add(line, weight, target);
        }
    }

    /// For views whose rows are apart: adds to `line`, a row of film `film`, the transpose of
    /// [`Rays::project_film_line`] applied to `picture`.
    #[inline(always)]
    pub(crate) fn back_project_line(&self, film: usize, picture: &[f32], weight: f32, line: &mut [f32]) {
        if let Some(rays) = self.films.get(film) {
            rays.columns.add_transposed(picture, weight, line);
        }
    }

    /// Returns the rays followed the other way: from each film's pixels to where they appear in the picture.
    pub(crate) fn traced_back(&self) -> Self {
        let films = self.films.iter();
        let films = films
            .map(|film| FilmRays { rows: film.rows.inverse(), columns: film.columns.inverse() })
            .collect();
        Self { films, ..*self }
    }

    /// Along rays that were traced back: multiplies film `film` by what `picture` shows there; 0 where the
    /// film does not appear in the picture. `plane` and `picture` are row, column.
    pub(crate) fn multiply_film(&self, film: usize, picture: &[f32], plane: &mut [f32]) {
        self.multiply_rows(film, 0, picture, 0, plane);
    }

    /// As [`Rays::multiply_film`], where `plane` holds the film's rows from `first` on and `picture` those of the picture
    /// from `first_seen` on, as far as [`Rays::reach`] says.
    pub(crate) fn multiply_rows(
        &self,
        film: usize,
        first: usize,
        picture: &[f32],
        first_seen: usize,
        plane: &mut [f32],
    ) {
        let Some(rays) = self.films.get(film) else { return };
        let mut gathered = vec![0.0; self.width];
        let mut traced = vec![0.0; self.width];
        vectorised(
            #[inline(always)]
            || {
                for (row, target) in plane.chunks_mut(self.width).enumerate() {
                    traced.fill(0.0);
                    let line = |at: usize| {
                        let at = at - first_seen;
                        &picture[at * self.width..(at + 1) * self.width]
                    };
                    if let Some(source) = rays.rows.gather(first + row, line, &mut gathered) {
                        rays.columns.add(source, 1.0, &mut traced);
                    }
                    target.iter_mut().zip(&traced).for_each(|(value, factor)| *value *= factor);
                }
            },
        );
    }

    /// The rows that some rows sample on any film: `rows` of them, by the film; of the picture, where the rays were
    /// traced back.
    pub(crate) fn reach(&self, rows: impl Fn(usize) -> Range<usize>) -> Range<usize> {
        let films = self.films.iter().enumerate();
        let sampled = films.flat_map(|(film, rays)| rows(film).filter_map(|row| rays.rows.lower(row)));
        let (least, most) =
            sampled.fold((usize::MAX, 0), |(least, most), row| (least.min(row), most.max(row)));
        // Each samples the row below too, which may have no weight.
        if least > most { 0..0 } else { least..(most + 2).min(self.height) }
    }
}

/// Rows that one task of the thread pool computes: enough to outweigh its start.
const ROWS_AT_ONCE: usize = 16;

/// Returns what `volume` shows to a viewer in `direction` at `distance`, with a weight for every film
/// (see [`crate::optics`]). The picture is the bare sum: it is not divided by anything.
pub fn project(
    volume: &Volume,
    stack: &Stack,
    direction: Direction,
    distance: ViewerDistance,
    weights: &[f64],
) -> Picture {
    project_along(volume, &Rays::new(stack, direction, distance), weights)
}

/// As [`project`], along rays that are known already.
pub fn project_along(volume: &Volume, rays: &Rays, weights: &[f64]) -> Picture {
    let weights = single(weights);
    let mut picture = Picture::new(volume.width(), volume.height());
    for channel in 0..CHANNELS {
        rays.project(volume.channel(channel), &weights, picture.channel_mut(channel));
    }
    picture
}

/// Returns the transpose of [`project`] applied to `picture`.
pub fn back_project(
    picture: &Picture,
    stack: &Stack,
    direction: Direction,
    distance: ViewerDistance,
    weights: &[f64],
) -> Volume {
    let weights = single(weights);
    let rays = Rays::new(stack, direction, distance);
    let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
    for channel in 0..CHANNELS {
        rays.back_project(picture.channel(channel), &weights, volume.channel_mut(channel));
    }
    volume
}

/// Returns the weights in the precision of the pictures.
pub(crate) fn single(weights: &[f64]) -> Vec<f32> {
    weights.iter().map(|&weight| weight as f32).collect()
}

#[cfg(test)]
mod tests;
