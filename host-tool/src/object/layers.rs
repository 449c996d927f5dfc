//! The films as layers of space: which point goes to which pixel of which film.

#[cfg(test)]
mod tests;

use std::hint::black_box;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::config::ObjectSettings;
use crate::design::Tone;
use crate::picture::srgb_decode;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

use super::fill::Crossings;
use super::placement::Placement;
use super::shape::{Corner, Point, Sink, Triangle, Vector};
use super::surface::{Inside, sample};
use super::texture::Texture;

/// Values of a point's height within its layer that are told apart, so that the nearest of several in one place stays.
const NEARNESSES: f64 = 254.0;

/// Points whose voxels are looked at before the first is changed.
const CELLS_AT_ONCE: usize = 128;

/// The films as layers of space, to which points are given.
///
/// With N films of pitch d, layer n from 0 at the bottom to N - 1 on top spans Z_n <= z < Z_(n+1), Z_n = (n - N/2) d, so
/// that its film lies in its middle; its film is number N - n from the top. Pixels likewise hold their left and lower
/// edges: column i takes -w/2 + i p <= x < -w/2 + (i + 1) p, with w the film's width and p the pixel's.
///
/// A voxel keeps one point: the one nearest to the viewer in its layer, and of several as near the brightest (the
/// largest as a number 0xRRGGBB). That is the same in whatever order points come.
///
/// Films too large for memory are kept some rows at a time; what is counted, is counted on all of them.
pub struct Layers {
    stack: Stack,
    placement: Placement,
    /// Z_n for n from 0 to N.
    faces_mm: Vec<f64>,
    half_width_mm: f64,
    half_height_mm: f64,
    /// Radius of a point, in pixels.
    radius_px: f64,
    depth_dither: bool,
    /// The colour of everything, where one is chosen.
    colour: Option<[u8; 3]>,
    /// The rows that are kept, from the top.
    rows: Range<usize>,
    /// Of each voxel (film, row, column) of these: 0, or the point's nearness times 2^24 and its colour.
    voxels: Vec<AtomicU32>,
    /// Where lines of sight cross meshes, where they are filled.
    crossings: Option<Crossings>,
    counts: Counts,
    /// Of each film.
    on_film: Vec<AtomicU64>,
}

/// Counts in the order of [`Tally`], from its second on.
type Counts = [AtomicU64; 6];
const OUTSIDE: usize = 0;
const NOT_FINITE: usize = 1;
const TRIANGLES: usize = 2;
const TRIANGLES_CUT: usize = 3;
const TRIANGLES_OUTSIDE: usize = 4;
const TRIANGLES_NOT_FINITE: usize = 5;

/// What became of the points and triangles of a model. On films, outside and not finite together are all points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Points that lie on films.
    pub on_films: u64,
    /// Points that lie beside, above or below the films.
    pub outside: u64,
    /// Points with a coordinate that is no finite number.
    pub not_finite: u64,
    /// Triangles of the model.
    pub triangles: u64,
    /// Triangles of which a part lies outside.
    pub triangles_cut: u64,
    /// Triangles that lie outside wholly.
    pub triangles_outside: u64,
    /// Triangles with a coordinate that is no finite number.
    pub triangles_not_finite: u64,
}

impl Tally {
    /// What became of the points and triangles, in words.
    pub fn in_words(&self) -> String {
        let mut parts = Vec::new();
        let points = self.on_films + self.outside + self.not_finite;
        let of = |parts: &mut Vec<String>, count: u64, what: &str| {
            if count > 0 {
                parts.push(format!("{count} {what}"));
            }
        };
        if points > 0 || self.triangles == 0 {
            parts.push(format!("of {points} points {} on films", self.on_films));
            of(&mut parts, self.outside, "outside");
            of(&mut parts, self.not_finite, "without finite coordinates");
        }
        if self.triangles > 0 {
            let lost = self.triangles_outside + self.triangles_not_finite;
            parts.push(format!("of {} triangles {} on films", self.triangles, self.triangles - lost));
            of(&mut parts, self.triangles_cut, "of them cut at the stack's faces");
            of(&mut parts, self.triangles_outside, "outside");
            of(&mut parts, self.triangles_not_finite, "without finite coordinates");
        }
        parts.join(", ")
    }
}

/// Where a point goes.
struct Cell {
    film: usize,
    row: usize,
    column: usize,
    /// In pixels from the left and from the lower edge.
    across_px: f64,
    up_px: f64,
    nearness: u8,
}

impl Layers {
    /// Films of `stack` without any point.
    pub fn new(stack: &Stack, placement: Placement, settings: &ObjectSettings) -> Self {
        Self::of_rows(stack, placement, settings, 0..stack.height_px)
    }

    /// As [`Layers::new`], but only the voxels of `rows` are kept.
    pub(super) fn of_rows(
        stack: &Stack,
        placement: Placement,
        settings: &ObjectSettings,
        rows: Range<usize>,
    ) -> Self {
        let half = stack.films as f64 / 2.0;
        let pitch_mm = stack.film_pitch_mm();
        let empty = |count: usize| (0..count).map(|_| AtomicU32::new(0)).collect();
        Self {
            placement,
            faces_mm: (0..=stack.films).map(|n| (n as f64 - half) * pitch_mm).collect(),
            half_width_mm: stack.width_mm / 2.0,
            half_height_mm: stack.height_mm() / 2.0,
            radius_px: settings.point_mm / 2.0 / stack.pixel_mm(),
            depth_dither: settings.depth_dither,
            voxels: empty(stack.films * stack.width_px * rows.len()),
            colour: settings.colour,
            crossings: settings.filled.then(|| Crossings::new(stack.width_px, rows.len(), stack.films)),
            rows,
            counts: Counts::default(),
            on_film: (0..stack.films).map(|_| AtomicU64::new(0)).collect(),
            stack: stack.clone(),
        }
    }

    /// What became of the points so far.
    pub fn tally(&self) -> Tally {
        let count = |index: usize| self.counts[index].load(Ordering::Relaxed);
        Tally {
            on_films: self.points_of_films().iter().sum(),
            outside: count(OUTSIDE),
            not_finite: count(NOT_FINITE),
            triangles: count(TRIANGLES),
            triangles_cut: count(TRIANGLES_CUT),
            triangles_outside: count(TRIANGLES_OUTSIDE),
            triangles_not_finite: count(TRIANGLES_NOT_FINITE),
        }
    }

    /// How many points went to each film, film 1 first.
    pub fn points_of_films(&self) -> Vec<u64> {
        self.on_film.iter().map(|count| count.load(Ordering::Relaxed)).collect()
    }

    /// How many voxels of each film hold a point, film 1 first.
    pub fn voxels_of_films(&self) -> Vec<u64> {
        let films = self.voxels.par_chunks(self.film_len().max(1));
        let taken = |voxel: &&AtomicU32| voxel.load(Ordering::Relaxed) != 0;
        films.map(|voxels| voxels.iter().filter(taken).count() as u64).collect()
    }

    /// The rows that are kept, from the top.
    pub(super) fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// Fills the inside of meshes, where that is wanted, with the colour of the surface before it; returns in how many
    /// columns of voxels they are not closed.
    pub(super) fn fill(&self) -> u64 {
        let Some(crossings) = &self.crossings else { return 0 };
        let rows = self.rows.clone().into_par_iter();
        rows.map(|row| {
            (0..self.stack.width_px).filter(|column| !self.fill_column(crossings, *column, row)).count()
                as u64
        })
        .sum()
    }

    /// Fills one column; returns whether the mesh is closed there.
    fn fill_column(&self, crossings: &Crossings, column: usize, row: usize) -> bool {
        let Some(inside) = crossings.inside(column, self.rows.end - 1 - row) else { return false };
        let at = |film: usize| {
            let voxel = film * self.film_len() + (row - self.rows.start) * self.stack.width_px + column;
            &self.voxels[voxel]
        };
        let (mut film, mut colour) = (0, None);
        for layer in inside {
            let here = self.stack.films - 1 - layer;
            // The surface may be on a film above the first voxel whose middle is inside.
            for above in film..=here {
                let taken = at(above).load(Ordering::Relaxed);
                if taken != 0 {
                    colour = Some(taken & 0x00ff_ffff);
                }
            }
            film = here + 1;
            at(here).fetch_max(1 << 24 | colour.unwrap_or(0x00ff_ffff), Ordering::Relaxed);
        }
        true
    }

    /// Takes the point of a voxel (film, kept row, column) away.
    pub(super) fn clear(&self, voxel: usize) {
        self.voxels[voxel].store(0, Ordering::Relaxed);
    }

    /// Whether each voxel (film, kept row, column) holds a point.
    pub fn occupied(&self) -> Vec<bool> {
        self.voxels.iter().map(|voxel| voxel.load(Ordering::Relaxed) != 0).collect()
    }

    /// Whether each voxel (film, row, column) of some of the rows that are kept holds a point.
    pub(super) fn occupied_of(&self, rows: Range<usize>) -> Vec<bool> {
        let (width, first) = (self.stack.width_px, rows.start - self.rows.start);
        let films = self.voxels.chunks(self.film_len().max(1));
        let voxels = films.flat_map(|film| film.iter().skip(first * width).take(rows.len() * width));
        voxels.map(|voxel| voxel.load(Ordering::Relaxed) != 0).collect()
    }

    /// The ink of the films: what the points' colours stand for in the values in which films add up.
    pub fn volume(&self, tone: Tone) -> Volume {
        self.volume_of(tone, 0..self.stack.films, self.rows.clone())
    }

    /// As [`Layers::volume`], of some films and some of the rows that are kept.
    pub(super) fn volume_of(&self, tone: Tone, films: Range<usize>, rows: Range<usize>) -> Volume {
        let width = self.stack.width_px;
        let mut volume = Volume::new(films.len(), rows.len(), width);
        let ink: Vec<f32> = (0..=u8::MAX)
            .map(|code| f32::from(code) / 255.0)
            .map(|code| if tone == Tone::Linear { srgb_decode(code) } else { code })
            .collect();
        for channel in 0..CHANNELS {
            let lines = volume.channel_mut(channel).par_chunks_mut(width).enumerate();
            lines.for_each(|(line, values)| {
                let (film, row) = (films.start + line / rows.len(), rows.start + line % rows.len());
                let first = film * self.film_len() + (row - self.rows.start) * width;
                for (value, voxel) in values.iter_mut().zip(&self.voxels[first..]) {
                    let colour = voxel.load(Ordering::Relaxed) >> (8 * (CHANNELS - 1 - channel));
                    *value = ink[(colour & 0xff) as usize];
                }
            });
        }
        volume
    }

    /// Voxels of one film that are kept.
    fn film_len(&self) -> usize {
        self.stack.width_px * self.rows.len()
    }

    fn count(&self, index: usize, more: u64) {
        self.counts[index].fetch_add(more, Ordering::Relaxed);
    }

    /// The stack in voxels: columns, rows, layers.
    fn size(&self) -> Vector {
        [self.stack.width_px, self.stack.height_px, self.stack.films].map(|count| count as f64)
    }

    /// The corner placed in the stack, in voxels from its left, lower, rear corner.
    fn in_voxels(&self, corner: Corner) -> Corner {
        let [x, y, z] = self.placement.place(corner.position);
        let pixel_mm = self.stack.pixel_mm();
        let position = [
            (x + self.half_width_mm) / pixel_mm,
            (y + self.half_height_mm) / pixel_mm,
            (z - self.faces_mm[0]) / self.stack.film_pitch_mm(),
        ];
        Corner { position, ..corner }
    }

    /// Marks the voxel in which a sample of a surface lies; one on an outer face belongs to the voxel within.
    fn mark_sample(&self, position: Vector, colour: [u8; 3]) {
        let [column, up, layer] = position.map(|value| value as usize);
        let (column, up) = (column.min(self.stack.width_px - 1), up.min(self.stack.height_px - 1));
        let row = self.stack.height_px - 1 - up;
        let layer = layer.min(self.stack.films - 1);
        let part = (position[2] - layer as f64).clamp(0.0, 1.0);
        let layer = if self.depth_dither { self.dithered(layer, part, column, row) } else { layer };
        self.mark_voxel(
            self.stack.films - 1 - layer,
            row,
            column,
            nearness(part),
            self.colour.unwrap_or(colour),
        );
    }

    /// The place of a voxel among those that are kept.
    #[inline]
    fn kept(&self, film: usize, row: usize, column: usize) -> Option<&AtomicU32> {
        let place = || (film * self.rows.len() + row - self.rows.start) * self.stack.width_px + column;
        self.rows.contains(&row).then(|| &self.voxels[place()])
    }

    /// Looks at the voxels of all cells before one is changed: memory answers such looks at the same time, and changes,
    /// being atomic, one after another. Points in no order come 1.4 times as fast.
    fn fetch(&self, cells: &[(Cell, [u8; 3])]) {
        let voxels = cells.iter().filter_map(|(cell, _)| self.kept(cell.film, cell.row, cell.column));
        black_box(voxels.fold(0, |all, voxel| all | voxel.load(Ordering::Relaxed)));
    }

    #[inline]
    fn mark_voxel(&self, film: usize, row: usize, column: usize, nearness: u8, [red, green, blue]: [u8; 3]) {
        let Some(voxel) = self.kept(film, row, column) else { return };
        let value = u32::from_be_bytes([nearness, red, green, blue]);
        // Looking is cheaper than changing, and most points lie behind another one.
        if voxel.load(Ordering::Relaxed) < value {
            voxel.fetch_max(value, Ordering::Relaxed);
        }
    }

    /// Where a point at `[x, y, z]` mm goes; `None` outside.
    #[inline]
    fn cell(&self, [x, y, z]: [f64; 3]) -> Option<Cell> {
        let pixel_mm = self.stack.pixel_mm();
        let across_px = (x + self.half_width_mm) / pixel_mm;
        let up_px = (y + self.half_height_mm) / pixel_mm;
        let layer = self.layer(z)?;
        let inside = |value: f64, count: usize| value >= 0.0 && value < count as f64;
        if !(inside(across_px, self.stack.width_px) && inside(up_px, self.stack.height_px)) {
            return None;
        }
        let (column, row) = (across_px as usize, self.stack.height_px - 1 - up_px as usize);
        let part = ((z - self.faces_mm[layer]) / self.stack.film_pitch_mm()).clamp(0.0, 1.0);
        let layer = if self.depth_dither { self.dithered(layer, part, column, row) } else { layer };
        let film = self.stack.films - 1 - layer;
        Some(Cell { film, row, column, across_px, up_px, nearness: nearness(part) })
    }

    /// The layer n of Z_n <= z < Z_(n+1), by comparison with the faces themselves.
    #[inline]
    fn layer(&self, z: f64) -> Option<usize> {
        let guess = (z - self.faces_mm[0]) / self.stack.film_pitch_mm();
        // The division may be off by its rounding.
        let guess = guess.clamp(0.0, self.stack.films as f64 - 1.0) as usize;
        let low = if z < self.faces_mm[guess] { guess.checked_sub(1)? } else { guess };
        let layer = if z >= self.faces_mm[low + 1] { low + 1 } else { low };
        (layer < self.stack.films && z >= self.faces_mm[layer]).then_some(layer)
    }

    /// The film of the two between which a point lies, `part` of the way up its layer: the upper one where the height
    /// above the lower, as a part of the pitch, exceeds the pixel's threshold.
    fn dithered(&self, layer: usize, part: f64, column: usize, row: usize) -> usize {
        let above_film = part - 0.5;
        let upper = |above_lower: f64| above_lower > threshold(column, row);
        if above_film >= 0.0 {
            if upper(above_film) { (layer + 1).min(self.stack.films - 1) } else { layer }
        } else if upper(1.0 + above_film) {
            layer
        } else {
            layer.saturating_sub(1)
        }
    }

    /// The rows that are kept, counted from the lowest of the film.
    fn kept_up(&self) -> Range<usize> {
        self.stack.height_px - self.rows.end..self.stack.height_px - self.rows.start
    }

    /// Marks the pixels whose centres lie within the point's radius, and the one that it lies in.
    #[inline]
    fn mark(&self, cell: &Cell, colour: [u8; 3]) {
        self.mark_voxel(cell.film, cell.row, cell.column, cell.nearness, colour);
        if self.radius_px > 0.0 {
            let (width, height) = (self.stack.width_px, self.stack.height_px);
            let span = |middle: f64, kept: Range<usize>| {
                let first = (middle - self.radius_px - 0.5).ceil().max(kept.start as f64) as usize;
                first..((middle + self.radius_px - 0.5).floor() + 1.0).clamp(0.0, kept.end as f64) as usize
            };
            for up in span(cell.up_px, self.kept_up()) {
                for column in span(cell.across_px, 0..width) {
                    let (dx, dy) = (column as f64 + 0.5 - cell.across_px, up as f64 + 0.5 - cell.up_px);
                    if dx * dx + dy * dy <= self.radius_px * self.radius_px {
                        self.mark_voxel(cell.film, height - 1 - up, column, cell.nearness, colour);
                    }
                }
            }
        }
    }
}

impl Sink for Layers {
    fn points(&self, points: &[Point]) {
        let (mut outside, mut not_finite) = (0, 0);
        let mut on_film = vec![0u64; self.stack.films];
        let mut cells = Vec::with_capacity(CELLS_AT_ONCE);
        for points in points.chunks(CELLS_AT_ONCE) {
            cells.clear();
            for point in points {
                if !point.position.iter().all(|value| value.is_finite()) {
                    not_finite += 1;
                    continue;
                }
                match self.cell(self.placement.place(point.position)) {
                    Some(cell) => {
                        on_film[cell.film] += 1;
                        cells.push((cell, self.colour.unwrap_or(point.colour)));
                    }
                    None => outside += 1,
                }
            }
            self.fetch(&cells);
            for (cell, colour) in &cells {
                self.mark(cell, *colour);
            }
        }
        self.count(OUTSIDE, outside);
        self.count(NOT_FINITE, not_finite);
        for (total, count) in self.on_film.iter().zip(on_film).filter(|(_, count)| *count > 0) {
            total.fetch_add(count, Ordering::Relaxed);
        }
    }

    fn triangles(&self, triangles: &[Triangle], texture: Option<&Texture>) {
        let mut counts = [0; 3];
        let up = self.kept_up();
        let kept = [up.start as f64, up.end as f64];
        for triangle in triangles {
            let placed = triangle.map(|corner| self.in_voxels(corner));
            if !placed.iter().flat_map(|corner| corner.position).all(f64::is_finite) {
                counts[2] += 1;
                continue;
            }
            if let Some(crossings) = &self.crossings {
                crossings.cross(&placed.map(|corner| lowered(corner, up.start)));
            }
            let mark = &mut |place, colour| self.mark_sample(place, colour);
            match sample(&placed, self.size(), kept, texture, mark) {
                Inside::Whole => {}
                Inside::Part => counts[0] += 1,
                Inside::Nothing => counts[1] += 1,
            }
        }
        self.count(TRIANGLES, triangles.len() as u64);
        self.count(TRIANGLES_CUT, counts[0]);
        self.count(TRIANGLES_OUTSIDE, counts[1]);
        self.count(TRIANGLES_NOT_FINITE, counts[2]);
    }
}

/// The corner so many rows further down.
fn lowered(corner: Corner, rows: usize) -> Corner {
    let [x, y, z] = corner.position;
    Corner { position: [x, y - rows as f64, z], ..corner }
}

/// How near to the viewer something lies in its layer, `part` of the way up: 1 to 255.
fn nearness(part: f64) -> u8 {
    1 + (part * NEARNESSES) as u8
}

/// An even spread over 0..1 in which neighbours differ much: the additive sequence of the plastic number in two
/// dimensions (Roberts 2018).
fn threshold(column: usize, row: usize) -> f64 {
    const A: f64 = 0.754_877_666_246_692_8;
    const B: f64 = 0.569_840_290_998_053_3;
    (column as f64 * A + row as f64 * B).fract()
}
