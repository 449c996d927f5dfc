//! The rows of dots of a sheet, from the films' pixels as they are read.

use std::sync::Arc;

use rayon::prelude::*;

use super::job::{PlacedFilm, PrintJob, Sheet};
use super::raster::{Raster, Span};
use super::separation::{Halftone, Separation};
use crate::build_folder::{FilmRows, OpenError};
use crate::volume::CHANNELS;

/// Opens the pixels of a film (0 on top) at its first row.
pub type OpenFilm<'a> = &'a (dyn Fn(usize) -> Result<FilmRows, OpenError> + Sync);

/// Bytes of dots that are worked on at once.
const BATCH_BYTES: usize = 1 << 25;

/// Rows of dots that are all the same.
#[derive(Clone, Debug)]
pub(super) struct DotRows {
    /// Where each film begins, and what it shows there.
    films: Vec<(usize, Content)>,
    spans: Vec<Span>,
    /// How many rows there are.
    pub(super) repeat: usize,
}

/// What a film shows in a row of dots: interleaved ink.
#[derive(Clone, Debug)]
enum Content {
    /// Pixels, to be spread over their dots.
    Pixels(Arc<[u16]>),
    /// Dots as they are.
    Dots(Arc<[u16]>),
}

/// The rows of dots of one sheet.
pub(super) struct SheetRows<'a> {
    job: &'a PrintJob,
    sheet: &'a Sheet,
    raster: Raster,
    /// Of each pixel column and of the end: the first dot.
    starts: Vec<usize>,
}

impl<'a> SheetRows<'a> {
    pub(super) fn new(job: &'a PrintJob, sheet: &'a Sheet) -> Self {
        let raster = Raster::new(&sheet.drawing, job.request.resolution, sheet.width);
        let starts = (0..=job.request.stack.width_px).map(|pixel| job.across.first_dot(pixel)).collect();
        Self { job, sheet, raster, starts }
    }

    /// Gives all rows to `take`, from the top, some at once.
    ///
    /// # Errors
    /// Fails when a film cannot be read, and when `take` does.
    pub(super) fn each<E: From<OpenError> + Send>(
        &self,
        open: OpenFilm<'_>,
        separation: &dyn Separation,
        take: &mut dyn FnMut(&[DotRows]) -> Result<(), E>,
    ) -> Result<(), E> {
        let batch = (BATCH_BYTES / (self.sheet.width * CHANNELS * 2).max(1)).clamp(1, 4096);
        let mut feeders: Vec<Feeder<'_>> =
            self.sheet.films.iter().map(|&place| Feeder::new(self, place, open, separation)).collect();
        for first in (0..self.sheet.height).step_by(batch) {
            let rows = first..(first + batch).min(self.sheet.height);
            let shown: Vec<Vec<Option<Content>>> = feeders
                .par_iter_mut()
                .map(|feeder| rows.clone().map(|row| feeder.row(row)).collect())
                .collect::<Result<_, OpenError>>()?;
            let mut distinct: Vec<DotRows> = Vec::new();
            for (index, row) in rows.enumerate() {
                let films = self.sheet.films.iter().zip(&shown);
                let films = films.filter_map(|(place, rows)| Some((place.x_dots, rows[index].clone()?)));
                let next = DotRows { films: films.collect(), spans: self.raster.row(row), repeat: 1 };
                match distinct.last_mut().filter(|last| last.shows_as(&next)) {
                    Some(last) => last.repeat += 1,
                    None => distinct.push(next),
                }
            }
            take(&distinct)?;
        }
        Ok(())
    }

    /// Paints rows into `dots`, the interleaved ink of the sheet's width.
    pub(super) fn paint(&self, rows: &DotRows, dots: &mut [u16]) {
        dots.fill(0);
        for (left, content) in &rows.films {
            let place = &mut dots[left * CHANNELS..(left + self.job.across.dots()) * CHANNELS];
            match content {
                Content::Dots(shown) => place.copy_from_slice(shown),
                Content::Pixels(pixels) => self.spread(pixels, place),
            }
        }
        for span in &rows.spans {
            fill(&mut dots[span.start * CHANNELS..span.end * CHANNELS], span.ink);
        }
    }

    /// Spreads pixels over their dots; a mirrored film begins with its last.
    fn spread(&self, pixels: &[u16], dots: &mut [u16]) {
        let count = self.job.across.dots();
        for (pixel, ends) in pixels.as_chunks::<CHANNELS>().0.iter().zip(self.starts.windows(2)) {
            let (start, end) = match self.job.request.mirrored {
                true => (count - ends[1], count - ends[0]),
                false => (ends[0], ends[1]),
            };
            fill(&mut dots[start * CHANNELS..end * CHANNELS], *pixel);
        }
    }
}

fn fill(dots: &mut [u16], ink: [u16; CHANNELS]) {
    dots.as_chunks_mut::<CHANNELS>().0.fill(ink);
}

impl DotRows {
    /// Whether both show the same: the same rows of pixels, for rows of dots are new each time.
    fn shows_as(&self, other: &Self) -> bool {
        let same = |(one, other): (&(usize, Content), &(usize, Content))| match (&one.1, &other.1) {
            (Content::Pixels(a), Content::Pixels(b)) => one.0 == other.0 && Arc::ptr_eq(a, b),
            _ => false,
        };
        self.films.len() == other.films.len()
            && self.films.iter().zip(&other.films).all(same)
            && self.spans == other.spans
    }
}

/// Reads one film as far down as the rows need it.
struct Feeder<'a> {
    rows: &'a SheetRows<'a>,
    place: PlacedFilm,
    open: OpenFilm<'a>,
    separation: &'a dyn Separation,
    film: Option<FilmRows>,
    /// Pixel rows that were read.
    read: usize,
    pixels: Arc<[u16]>,
    halftone: Option<Box<dyn Halftone>>,
}

impl<'a> Feeder<'a> {
    fn new(
        rows: &'a SheetRows<'a>,
        place: PlacedFilm,
        open: OpenFilm<'a>,
        separation: &'a dyn Separation,
    ) -> Self {
        let halftone = separation.halftone(place.film - 1);
        Self { rows, place, open, separation, film: None, read: 0, pixels: Arc::new([]), halftone }
    }

    /// What the film shows in row `row` of the sheet; rows are asked for from the top.
    fn row(&mut self, row: usize) -> Result<Option<Content>, OpenError> {
        let job = self.rows.job;
        let Some(dot) = row.checked_sub(self.place.y_dots).filter(|dot| *dot < job.down.dots()) else {
            self.film = None;
            return Ok(None);
        };
        let pixel = job.down.pixel_of(dot);
        while self.read <= pixel {
            let film = match &mut self.film {
                Some(film) => film,
                None => self.film.insert((self.open)(self.place.film - 1)?),
            };
            let mut samples = film.next_row()?;
            self.separation.separate(self.place.film - 1, self.read, &mut samples);
            self.pixels = samples.into();
            self.read += 1;
        }
        Ok(Some(match &mut self.halftone {
            None => Content::Pixels(self.pixels.clone()),
            Some(halftone) => {
                let mut dots = vec![0; job.across.dots() * CHANNELS];
                self.rows.spread(&self.pixels, &mut dots);
                halftone.row(&mut dots);
                Content::Dots(dots.into())
            }
        }))
    }
}
