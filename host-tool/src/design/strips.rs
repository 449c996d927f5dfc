//! Films too large for memory, designed some rows at a time.
//!
//! What views cannot share lies at low frequencies, so lamps, whites and the report come of the same exhibit in small
//! ([`StripRequest::small`]), and each strip of rows is then designed in full for these lamps.
//!
//! Eq. 1 looks at each voxel by itself: strips of it are, value for value, what the whole design is. The optimiser looks
//! at neighbours. So a strip is solved with rows above and below it that are then thrown away: twice as many as any ray
//! climbs on its way through the stack, and the reach of the structure loss. What is kept differs from the whole design
//! only by what its far neighbours would have pulled at it.

use std::ops::Range;

use rayon::prelude::*;

use super::joint;
use super::optimise::{Lighting, improve, set_up};
use super::request::{DesignError, DesignRequest, Method, Progress, Tone, ViewRequest};
use super::result::Design;
use super::scale::enlarged_rows;
use crate::picture::Picture;
use crate::projection::Rays;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

/// Gives some rows of a picture as large as a film: sRGB code values.
pub trait PictureRows: Send + Sync {
    /// The rows `rows`, all columns.
    fn rows(&self, rows: Range<usize>) -> Picture;

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
    /// For Eq. 1: of each view, from the films back to its picture.
    rays: Vec<Rays>,
    /// Rows on either side of a strip that are solved with it.
    around: usize,
    /// For the optimiser: where it starts, and for which lamps.
    settled: Option<(Volume, Lighting)>,
}

/// How far the structure loss reaches, with room for what it passes on.
const STRUCTURE_ROWS: usize = 16;
/// Bytes of a value.
const VALUE: f64 = size_of::<f32>() as f64;
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
        let design = super::design(small, report)?;
        let settled = match small.settings.method {
            Method::Product => None,
            Method::LeastSquares => Some(joint::settle(small, None, &[], report)),
        };
        small.go_on()?;
        let whole = DesignRequest { stack: request.stack.clone(), views: Vec::new(), ..small.clone() };
        let rays = match settled {
            None => small.views.iter().map(|view| whole.rays_of(view).traced_back()).collect(),
            Some(_) => Vec::new(),
        };
        let around = rows_around(&request.stack, small);
        Ok((Self { request, rays, around, settled }, design))
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

    /// How many rows are computed for each that is kept.
    pub fn solved_part(&self) -> f64 {
        let rows = self.request.rows as f64;
        ((rows + 2.0 * self.around as f64) / rows).min(self.strips() as f64)
    }

    /// Designs strip `strip`, rounded to the values that will be written; it is a volume of fewer rows.
    ///
    /// # Errors
    /// When the request is asked to stop.
    pub fn strip(&self, strip: usize, report: &mut dyn FnMut(Progress)) -> Result<Volume, DesignError> {
        let rows = self.rows(strip);
        let mut volume = match &self.settled {
            None => self.multiplied(rows.clone()),
            Some((start, lighting)) => self.solved(rows.clone(), start, lighting, report),
        };
        self.request.small.go_on()?;
        volume.quantise_from(self.request.small.settings.ink_depth, rows.start);
        Ok(volume)
    }

    /// Eq. 1 on some rows.
    fn multiplied(&self, rows: Range<usize>) -> Volume {
        let stack = &self.request.stack;
        let seen: Vec<(&Rays, Range<usize>, Picture)> = (self.rays.iter().zip(&self.request.patterns))
            .map(|(rays, pattern)| {
                let reach = rays.reach(rows.clone());
                let target = self.target(pattern.rows(reach.clone()));
                (rays, reach, target)
            })
            .collect();
        let mut volume = Volume::new(stack.films, rows.len(), stack.width_px);
        let planes = volume.values_mut().par_chunks_mut(rows.len() * stack.width_px);
        planes.enumerate().for_each(|(index, plane)| {
            let (channel, film) = (index / stack.films, index % stack.films);
            plane.fill(1.0);
            for (rays, reach, target) in &seen {
                rays.multiply_rows(film, rows.start, target.channel(channel), reach.start, plane);
            }
        });
        volume
    }

    fn target(&self, pattern: Picture) -> Picture {
        match self.request.small.settings.tone {
            Tone::Linear => pattern.decoded(),
            Tone::Code => pattern,
        }
    }

    /// The optimiser on some rows and their surroundings.
    fn solved(
        &self,
        rows: Range<usize>,
        start: &Volume,
        lighting: &Lighting,
        report: &mut dyn FnMut(Progress),
    ) -> Volume {
        let stack = &self.request.stack;
        let window = rows.start.saturating_sub(self.around)..(rows.end + self.around).min(stack.height_px);
        let request = self.windowed(window.clone());
        let mut volume = enlarged_rows(start, stack.width_px, stack.height_px, window.clone());
        let effort = joint::effort(&request.settings);
        let problem = set_up(&request, &request.targets(), lighting, None);
        improve(&request, &problem, &mut volume, effort, report);
        request.emission().turn_into_ink(volume.values_mut());
        kept(&volume, rows.start - window.start..rows.end - window.start)
    }

    /// The request of some rows alone.
    fn windowed(&self, rows: Range<usize>) -> DesignRequest {
        let StripRequest { small, stack, patterns, masks, .. } = &self.request;
        let middle = |first: usize, count: usize| first as f64 + (count as f64 - 1.0) / 2.0;
        let views = small.views.iter().zip(patterns).zip(masks);
        let views = views.map(|((view, pattern), mask)| ViewRequest {
            id: view.id.clone(),
            pattern: pattern.rows(rows.clone()),
            mask: mask.as_ref().map(|mask| mask.rows(rows.clone()).channel(0).to_vec()),
            ..*view
        });
        DesignRequest {
            stack: Stack {
                height_px: rows.len(),
                above_middle_px: middle(0, stack.height_px) - middle(rows.start, rows.len()),
                ..stack.clone()
            },
            views: views.collect(),
            ..small.clone()
        }
    }
}

/// Some rows of every film.
fn kept(volume: &Volume, rows: Range<usize>) -> Volume {
    let width = volume.width();
    let mut strip = Volume::new(volume.films(), rows.len(), width);
    for channel in 0..CHANNELS {
        for film in 0..volume.films() {
            let source = &volume.film(channel, film)[rows.start * width..rows.end * width];
            strip.film_mut(channel, film).copy_from_slice(source);
        }
    }
    strip
}

/// Rows on either side of a strip that are solved with it.
fn rows_around(stack: &Stack, small: &DesignRequest) -> usize {
    match small.settings.method {
        Method::Product => 0,
        Method::LeastSquares => {
            let whole = DesignRequest { stack: stack.clone(), views: Vec::new(), ..small.clone() };
            let climbs = small.views.iter().map(|view| whole.rays_of(view).climb());
            2 * climbs.max().unwrap_or_default() + STRUCTURE_ROWS
        }
    }
}

/// The rows of a strip for which a design by strips, beside its patterns, stays within `memory_mib`; `None` where not
/// even one row does.
pub fn rows_within(stack: &Stack, small: &DesignRequest, memory_mib: f64) -> Option<usize> {
    /// Of a view's pixel: its pattern, its target, and what the optimiser answers with.
    const VIEW_VALUES: f64 = 16.0;
    /// Of a voxel of one channel: where it is and its step, in 16 bits each, and its light.
    const SOLVER_VALUES: f64 = 2.0;
    /// Bytes of a voxel's three inks on their way into a file.
    const FILE_BYTES: f64 = 24.0;
    let films = stack.films as f64;
    let solver = match small.settings.method {
        Method::LeastSquares => SOLVER_VALUES * VALUE,
        Method::Product => 0.0,
    };
    let views = small.views.len() as f64 * VIEW_VALUES * VALUE;
    let pixel =
        films * (2.0 * CHANNELS as f64 * VALUE + solver).max(CHANNELS as f64 * VALUE + FILE_BYTES) + views;
    let rows = (memory_mib * MIB / (pixel * stack.width_px as f64)) as usize;
    rows.checked_sub(2 * rows_around(stack, small))
        .filter(|rows| *rows > 0)
        .map(|rows| rows.min(stack.height_px))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, OpticsModel, design};
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;

    /// A whole picture of which rows are given.
    struct Whole(Picture);

    impl PictureRows for Whole {
        fn rows(&self, rows: Range<usize>) -> Picture {
            let width = self.0.width();
            let values = (0..CHANNELS)
                .flat_map(|channel| self.0.channel(channel)[rows.start * width..rows.end * width].to_vec());
            Picture::from_values(width, rows.len(), values.collect()).unwrap()
        }

        fn held_bytes(&self) -> usize {
            0
        }
    }

    fn pattern(stack: &Stack, seed: usize) -> Picture {
        let mut picture = Picture::new(stack.width_px, stack.height_px);
        let width = stack.width_px;
        for channel in 0..CHANNELS {
            for (index, value) in picture.channel_mut(channel).iter_mut().enumerate() {
                let (x, y) = ((index % width) as f32, (index / width) as f32);
                let wave = ((x * 0.13 + channel as f32) * (1.0 + seed as f32 * 0.4)).sin() * (y * 0.21).cos();
                *value = 0.5 + 0.5 * wave;
            }
        }
        picture
    }

    fn requests(method: Method, distance: ViewerDistance) -> (DesignRequest, StripRequest) {
        let stack = Stack { films: 6, width_px: 40, height_px: 90, width_mm: 4.0, ..Stack::default() };
        let directions = [Direction::new(20.0, 0.0), Direction::new(-20.0, 6.0), Direction::new(0.0, -9.0)];
        let views = directions.iter().enumerate();
        let views = views
            .map(|(at, direction)| ViewRequest::new(format!("view-{at}"), pattern(&stack, at), *direction));
        let settings =
            DesignSettings { method, optics: OpticsModel::Ideal, tone: Tone::Code, ..Default::default() };
        let whole = DesignRequest {
            stack: stack.clone(),
            distance,
            views: views.collect(),
            settings,
            stop: Default::default(),
        };
        let patterns =
            whole.views.iter().map(|view| Box::new(Whole(view.pattern.clone())) as Box<dyn PictureRows>);
        let request = StripRequest {
            small: super::super::scale::reduced(&whole, 45),
            stack,
            patterns: patterns.collect(),
            masks: vec![None, None, None],
            rows: 25,
        };
        (whole, request)
    }

    fn by_strips(request: StripRequest) -> Volume {
        let (stack, quiet) = (request.stack.clone(), &mut |_: Progress| ());
        let (strips, _) = StripDesign::prepare(request, quiet).unwrap();
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        for index in 0..strips.strips() {
            let (rows, strip) = (strips.rows(index), strips.strip(index, quiet).unwrap());
            for channel in 0..CHANNELS {
                for film in 0..stack.films {
                    let place = rows.start * stack.width_px..rows.end * stack.width_px;
                    volume.film_mut(channel, film)[place].copy_from_slice(strip.film(channel, film));
                }
            }
        }
        volume
    }

    #[test]
    fn the_product_by_strips_is_the_whole_product() {
        for distance in [ViewerDistance::Parallel, ViewerDistance::Millimetres(60.0)] {
            let (whole, request) = requests(Method::Product, distance);
            let whole = design(&whole, &mut |_| ()).unwrap().volume;
            assert!(by_strips(request) == whole, "{distance:?}");
        }
    }

    #[test]
    fn least_squares_by_strips_shows_what_the_whole_design_shows() {
        for distance in [ViewerDistance::Parallel, ViewerDistance::Millimetres(60.0)] {
            let (whole, request) = requests(Method::LeastSquares, distance);
            let designed = design(&whole, &mut |_| ()).unwrap();
            let strips = Design::of(&whole, by_strips(request));
            for (one, other) in designed.views.iter().zip(&strips.views) {
                let lost = one.quality.psnr_db - other.quality.psnr_db;
                assert!(lost < 0.1, "{distance:?}, {}: {lost} dB lost", one.id);
            }
        }
    }
}
