//! Films too large for memory, designed some rows at a time.
//!
//! What views cannot share lies at low frequencies, so lamps, whites and the report come of the same exhibit in small
//! ([`StripRequest::small`]), and each strip of rows is then designed in full for these lamps.
//!
//! Eq. 1 looks at each voxel by itself: strips of it are, value for value, what the whole design is. The optimiser looks
//! at neighbours. So a strip is solved with rows above and below it that are then thrown away: twice as many as any ray
//! climbs on its way through the stack, and the reach of the structure loss. What is kept differs from the whole design
//! only by what its far neighbours would have pulled at it.

mod levels;

use std::ops::Range;

use rayon::prelude::*;

use super::request::{DesignError, DesignRequest, Method, Progress, Tone};
use super::result::Design;
use crate::picture::Picture;
use crate::projection::Rays;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Carried, Volume};
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
    /// Rows of a strip.
    pub rows: usize,
}

/// A design by strips, its lamps found.
pub struct StripDesign {
    request: StripRequest,
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
    rows: Range<usize>,
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
        let way = match lighting {
            Some(lighting) => {
                Way::LeastSquares(Box::new(Levels::new(&request.stack, small, &design.volume, lighting)))
            }
            None => Way::Product(traced_back(&request.stack, small)),
        };
        Ok((Self { request, way }, design))
    }

    /// How many strips there are.
    pub fn strips(&self) -> usize {
        self.request.stack.height_px.div_ceil(self.request.rows)
    }

    /// The rows of strip `strip`.
    pub fn rows(&self, strip: usize) -> Range<usize> {
        let first = strip * self.request.rows;
        first..(first + self.request.rows).min(self.request.stack.height_px)
    }

    /// Designs strip `strip`.
    ///
    /// # Errors
    /// When the request is asked to stop.
    pub fn strip(&self, strip: usize, report: &mut dyn FnMut(Progress)) -> Result<Strip<'_>, DesignError> {
        let rows = self.rows(strip);
        let found = match &self.way {
            Way::Product(rays) => Found::Product(self.seen(rays, &rows)),
            Way::LeastSquares(levels) => Found::LeastSquares(levels.solve(&self.request, &rows, report)),
        };
        self.request.small.go_on()?;
        let carried = Carried::start(self.request.stack.width_px, rows.len(), rows.start);
        Ok(Strip { design: self, rows, found, given: 0, carried })
    }

    /// The parts of the patterns that Eq. 1 multiplies on some rows.
    fn seen<'a>(&self, rays: &'a [Rays], rows: &Range<usize>) -> Vec<(&'a Rays, Range<usize>, Picture)> {
        let stack = &self.request.stack;
        let views = rays.iter().zip(&self.request.patterns);
        let seen = views.map(|(rays, pattern)| {
            let reach = rays.reach(rows.clone());
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
    /// The next films, as a volume of them and of the strip's rows alone, rounded to the values that will be written.
    fn next_films(&mut self) -> Volume {
        let stack = &self.design.request.stack;
        let first = self.given;
        let films = FILMS_AT_ONCE.min(stack.films - first);
        let mut volume = Volume::new(films, self.rows.len(), stack.width_px);
        let planes = volume.values_mut().par_chunks_mut(self.rows.len() * stack.width_px);
        planes.enumerate().for_each(|(index, plane)| {
            let (channel, film) = (index / films, first + index % films);
            match &self.found {
                Found::Product(seen) => {
                    plane.fill(1.0);
                    for (rays, reach, target) in seen {
                        rays.multiply_rows(
                            film,
                            self.rows.start,
                            target.channel(channel),
                            reach.start,
                            plane,
                        );
                    }
                }
                Found::LeastSquares(solved) => {
                    let size = (stack.width_px, stack.height_px);
                    solved.write(channel, film, size, self.rows.clone(), plane);
                }
            }
        });
        volume.quantise_below(self.design.request.small.settings.ink_depth, &mut self.carried);
        self.given += films;
        volume
    }
}

impl Iterator for Strip<'_> {
    type Item = Volume;

    fn next(&mut self) -> Option<Volume> {
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
    // Of each row of the strip, and whatever its rows are.
    let (row, beside) = match small.settings.method {
        Method::LeastSquares => {
            let finest = Level::finest(stack, small);
            let solved = row_bytes(&finest.stack, views);
            let finer = stack.height_px as f64 / finest.stack.height_px as f64;
            let kept = (stack.films * CHANNELS * size_of::<f32>() * finest.stack.width_px) as f64;
            let held = (small.stack.film_len() * stack.films * CHANNELS * size_of::<f32>()) as f64;
            let around = 2.0 * (finest.around + 1) as f64;
            ((solved / finer).max(writing + kept / finer), around * solved + held)
        }
        Method::Product => {
            let climbs = traced_back(stack, small).iter().map(Rays::climb).max().unwrap_or_default();
            let seen = views as f64 * SEEN_BYTES * pixels;
            let rays = (views * stack.films * (stack.width_px + stack.height_px)) as f64 * RAY_BYTES;
            (seen + writing, 2.0 * climbs as f64 * seen + rays)
        }
    };
    let rows = ((memory_mib * MIB - beside) / row).max(0.0) as usize;
    (rows > 0).then(|| rows.min(stack.height_px))
}

#[cfg(test)]
mod tests;
