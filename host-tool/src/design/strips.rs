//! Films too large for memory, designed some rows at a time.
//!
//! What views cannot share lies at low frequencies, so lamps, whites and the report come of the same exhibit in small
//! ([`StripRequest::small`]), and each strip of rows is then designed in full for these lamps.
//!
//! Eq. 1 looks at each voxel by itself: strips of it are, value for value, what the whole design is before rounding.
//! The optimiser looks at neighbours. So a strip is solved with rows above and below it that are then thrown away: twice
//! as many as any ray climbs beside it on its way through the stack, and the reach of the structure loss. What is kept
//! differs from the whole design only by what its far neighbours would have pulled at it.
//!
//! Strips lean with the rays (see [`lean`]), and rounding carries along them what the films above have lost.

mod lean;
mod levels;

use std::ops::Range;

use rayon::prelude::*;

use super::request::{DesignError, DesignRequest, Method, Progress, Tone};
use super::result::Design;
use crate::picture::Picture;
use crate::projection::Rays;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Carried, Volume};
use lean::{Tile, Tiles, picture_rows};
use levels::{Level, Levels, Solved, row_bytes};

/// Gives some rows of a picture at any size: sRGB code values.
pub trait PictureRows: Send + Sync {
    /// The rows `rows`, all columns, when the picture has `size` columns and rows.
    fn rows(&self, size: (usize, usize), rows: Range<usize>) -> Picture;

    /// Bytes of memory that it holds.
    fn held_bytes(&self) -> usize;
}

/// What is asked of a design by strips.
pub struct StripRequest {
    /// The exhibit with films of fewer pixels; its views, settings and everything but the pixels count.
    pub small: DesignRequest,
    /// The stack with all pixels.
    pub stack: Stack,
    /// The pattern of each view.
    pub patterns: Vec<Box<dyn PictureRows>>,
    /// The mask of each view, where it has one; grey.
    pub masks: Vec<Option<Box<dyn PictureRows>>>,
    /// Rows of the picture that a strip has; of each film it has as many, more or less where strips lean.
    pub rows: usize,
}

/// A design by strips, its lamps found.
pub struct StripDesign {
    request: StripRequest,
    tiles: Tiles,
    way: Way,
}

/// How strips are designed.
enum Way {
    /// By Eq. 1; of each view, from the films back to its picture.
    Product(Vec<Rays>),
    LeastSquares(Box<Levels>),
}

/// A strip that is designed; it gives its films from the top one down, some at a time, as they will be written.
pub struct Strip<'a> {
    design: &'a StripDesign,
    tile: Tile,
    /// The films as they lean.
    leaning: Stack,
    found: Found<'a>,
    /// Films that were given.
    given: usize,
    /// What they have lost by rounding.
    carried: Carried,
}

/// What tells a strip's films.
enum Found<'a> {
    /// Of each view: its rays, and the rows of its pattern that they come to.
    Product(Vec<(&'a Rays, Range<usize>, Picture)>),
    LeastSquares(Solved),
}

/// Films of a strip that are given at once: all of them would take more memory than solving them.
const FILMS_AT_ONCE: usize = 4;
const MIB: f64 = 1024.0 * 1024.0;

impl StripDesign {
    /// Designs the exhibit in small; gives that too, for its report and lamps.
    ///
    /// # Errors
    /// When the request cannot be met as it stands, and when it is asked to stop.
    pub fn prepare(
        request: StripRequest,
        report: &mut dyn FnMut(Progress),
    ) -> Result<(Self, Design), DesignError> {
        let small = &request.small;
        request.stack.clone().checked()?;
        let (design, lighting) = super::design_about(small, None, &[], report)?;
        let tiles = Tiles::new(&request.stack, small, request.rows);
        let way = match lighting {
            Some(lighting) => {
                Way::LeastSquares(Box::new(Levels::new(&request.stack, small, &design.volume, lighting)))
            }
            None => Way::Product(traced_back(&request.stack, small)),
        };
        Ok((Self { request, tiles, way }, design))
    }

    /// How many strips there are.
    pub fn strips(&self) -> usize {
        self.tiles.count()
    }

    /// Rows of the picture that a strip has.
    pub fn rows(&self) -> usize {
        self.request.rows
    }

    /// Designs strip `strip`.
    ///
    /// # Errors
    /// When the request is asked to stop.
    pub fn strip(&self, strip: usize, report: &mut dyn FnMut(Progress)) -> Result<Strip<'_>, DesignError> {
        let tile = self.tiles.tile(strip);
        let found = match &self.way {
            Way::Product(rays) => Found::Product(self.seen(rays, &tile)),
            Way::LeastSquares(levels) => Found::LeastSquares(levels.solve(&self.request, &tile, report)),
        };
        self.request.small.go_on()?;
        let leaning = tile.leaning(&self.request.stack);
        let rows = picture_rows(&leaning, &tile.films).unwrap_or_default();
        let carried = Carried::start(leaning.width_px, rows);
        Ok(Strip { design: self, tile, leaning, found, given: 0, carried })
    }

    /// The parts of the patterns that Eq. 1 multiplies on a strip.
    fn seen<'a>(&self, rays: &'a [Rays], tile: &Tile) -> Vec<(&'a Rays, Range<usize>, Picture)> {
        let stack = &self.request.stack;
        let views = rays.iter().zip(&self.request.patterns);
        let seen = views.map(|(rays, pattern)| {
            let reach = rays.reach(|film| tile.films[film].clone());
            let target = self.target(pattern.rows((stack.width_px, stack.height_px), reach.clone()));
            (rays, reach, target)
        });
        seen.collect()
    }

    fn target(&self, pattern: Picture) -> Picture {
        match self.request.small.settings.tone {
            Tone::Linear => pattern.decoded(),
            Tone::Code => pattern,
        }
    }
}

impl Strip<'_> {
    /// The next films, each as a volume of its rows in the strip alone, rounded to the values that will be written.
    fn next_films(&mut self) -> Vec<Volume> {
        let stack = &self.design.request.stack;
        let films = self.given..(self.given + FILMS_AT_ONCE).min(stack.films);
        let mut volumes: Vec<Volume> = films.clone().into_par_iter().map(|film| self.film(film)).collect();
        for (film, volume) in films.clone().zip(&mut volumes) {
            let first = self.tile.films[film].start as i64 - self.leaning.first_row(film);
            volume.quantise_below(self.design.request.small.settings.ink_depth, &mut self.carried, first);
        }
        self.given = films.end;
        volumes
    }

    fn film(&self, film: usize) -> Volume {
        let rows = &self.tile.films[film];
        let stack = &self.design.request.stack;
        let mut volume = Volume::new(1, rows.len(), stack.width_px);
        for channel in 0..CHANNELS {
            let plane = volume.channel_mut(channel);
            match &self.found {
                Found::Product(seen) => {
                    plane.fill(1.0);
                    for (rays, reach, target) in seen {
                        rays.multiply_rows(film, rows.start, target.channel(channel), reach.start, plane);
                    }
                }
                Found::LeastSquares(solved) => {
                    solved.write(channel, film, stack.whole_size(), rows.clone(), plane);
                }
            }
        }
        volume
    }
}

impl Iterator for Strip<'_> {
    type Item = Vec<Volume>;

    fn next(&mut self) -> Option<Vec<Volume>> {
        (self.given < self.design.request.stack.films).then(|| self.next_films())
    }
}

/// Of each view: the rays from the films back to its picture.
fn traced_back(stack: &Stack, small: &DesignRequest) -> Vec<Rays> {
    let whole = DesignRequest { stack: stack.clone(), views: Vec::new(), ..small.clone() };
    small.views.iter().map(|view| whole.rays_of(view).traced_back()).collect()
}

/// The rows of a strip for which a design by strips, beside its patterns, stays within `memory_mib`; `None` where not
/// even one row does.
pub fn rows_within(stack: &Stack, small: &DesignRequest, memory_mib: f64) -> Option<usize> {
    /// Bytes of a film's pixel on its way into a file: three inks, what they carry, 16 bits of each in four forms.
    const FILE_BYTES: f64 = 48.0;
    /// Bytes of a pixel of a pattern, as codes and as light.
    const SEEN_BYTES: f64 = 24.0;
    /// Bytes of a film's row or column along the rays of a view: where they meet it, and from where.
    const RAY_BYTES: f64 = 32.0;
    let views = small.views.len();
    let pixels = stack.width_px as f64;
    let writing = FILMS_AT_ONCE as f64 * FILE_BYTES * pixels;
    // Where rays climb most beside their strip's line.
    let tiles = Tiles::new(stack, small, 1);
    let ends = [0, tiles.count() - 1].map(|end| tiles.tile(end));
    // Bytes of each row of the strip and beside them, as often as both come together.
    let takes = match small.settings.method {
        Method::LeastSquares => {
            let finest = Level::finest(stack, small);
            let solving = row_bytes(&finest.stack, views);
            let finer = stack.height_px as f64 / finest.stack.height_px as f64;
            let solved = (stack.films * CHANNELS * size_of::<f32>() * finest.stack.width_px) as f64;
            let held = (small.stack.film_len() * stack.films * CHANNELS * size_of::<f32>()) as f64;
            let around = ends.iter().map(|end| finest.around(end)).max().unwrap_or_default();
            let around = 2.0 * (around + 1) as f64;
            [(solving / finer, around * solving + held), (writing + solved / finer, around * solved + held)]
        }
        Method::Product => {
            let climbs = ends.iter().map(|end| end.climb(stack)).max().unwrap_or_default();
            let seen = views as f64 * SEEN_BYTES * pixels;
            let rays = (views * stack.films * (stack.width_px + stack.height_px)) as f64 * RAY_BYTES;
            [(seen + writing, 2.0 * climbs as f64 * seen + rays); 2]
        }
    };
    // A leaning strip is higher on some films than on others, and each of its rows may climb beside its middle one: solved
    // with twice as many rows above and below.
    let leans = 1.0 + 3.0 * tiles.lean().spread();
    let rows = takes.map(|(row, beside)| ((memory_mib * MIB - beside) / (row * leans)).max(0.0) as usize);
    let rows = rows.into_iter().min().unwrap_or_default();
    (rows > 0).then(|| rows.min(stack.height_px))
}

#[cfg(test)]
mod tests;
