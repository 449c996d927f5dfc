//! The rows of dots of a sheet, from the films' pixels as they are read.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::job::{PlacedFilm, PrintJob, Sheet};
use super::laid::LaidRows;
use super::raster::{Raster, Span};
use super::separation::{Dot, Halftone, Run, Separation};
use crate::build_folder::{FilmRows, OpenError};
use crate::deflate::FullDots;
use crate::volume::CHANNELS;

/// Opens the pixels of a film (0 on top) at its first row.
pub type OpenFilm<'a> = &'a (dyn Fn(usize) -> Result<FilmRows, OpenError> + Sync);

/// The samples of dots that are full or empty, by their kinds.
const FULL: [[u16; CHANNELS]; 4] = [[0, 0, 0], [u16::MAX, 0, 0], [0, u16::MAX, 0], [0, 0, u16::MAX]];

/// Bytes of dots that are worked on at once.
const BATCH_BYTES: usize = 1 << 25;

/// Rows of a sheet that follow each other.
pub(super) struct Batch {
    /// What the sheet's films show in each row, in the films' order.
    films: Vec<Vec<Option<Content>>>,
    /// What is drawn around them in each row.
    spans: Vec<Vec<Span>>,
}

/// Rows of dots that are all the same.
#[derive(Clone, Debug)]
pub(super) struct DotRows {
    /// Where each film begins, and what it shows there.
    films: Vec<(usize, Content)>,
    spans: Vec<Span>,
    /// How many rows there are.
    pub(super) repeat: usize,
}

/// What a film shows in a row of dots.
#[derive(Clone, Debug)]
pub(super) enum Content {
    /// Pixels, each to be spread over its dots, left to right.
    Pixels(Arc<[Run]>),
    /// Dots of a halftone of several levels.
    Dots(Arc<[Dot]>),
    /// Dots of a halftone that are full or empty.
    Full(Arc<FullDots>),
}

/// The rows of dots of one sheet.
pub(super) struct SheetRows<'a> {
    job: &'a PrintJob,
    sheet: &'a Sheet,
    separation: &'a dyn Separation,
    raster: Raster,
    /// Samples by dots, where there is a halftone.
    samples: Vec<[u16; CHANNELS]>,
}

impl<'a> SheetRows<'a> {
    pub(super) fn new(job: &'a PrintJob, sheet: &'a Sheet, separation: &'a dyn Separation) -> Self {
        let raster = Raster::new(&sheet.drawing, job.request.resolution, sheet.width);
        let samples = separation.top_level().map(Dot::samples).unwrap_or_default();
        Self { job, sheet, separation, raster, samples }
    }

    /// Gives all rows to `take`, from the top, some at once.
    ///
    /// # Errors
    /// Fails when a film cannot be read, and when `take` does.
    pub(super) fn each<E: From<OpenError> + Send>(
        &self,
        open: OpenFilm<'_>,
        take: &mut dyn FnMut(&Batch) -> Result<(), E>,
    ) -> Result<(), E> {
        let batch = (BATCH_BYTES / (self.sheet.width * CHANNELS * 2).max(1)).clamp(1, 4096);
        let mut feeders: Vec<Feeder<'_>> =
            self.sheet.films.iter().map(|&place| Feeder::new(self, place, open)).collect();
        for first in (0..self.sheet.height).step_by(batch) {
            let rows = first..(first + batch).min(self.sheet.height);
            let films = feeders
                .par_iter_mut()
                .map(|feeder| rows.clone().map(|row| feeder.row(row)).collect())
                .collect::<Result<_, OpenError>>()?;
            let spans = rows.map(|row| self.raster.row(row)).collect();
            take(&Batch { films, spans })?;
        }
        Ok(())
    }

    /// Whether films have dots that are full or empty.
    pub(super) fn is_full_or_empty(&self) -> bool {
        self.separation.top_level() == Some(1)
    }

    /// What lays out film `film`, 0 on top.
    pub(super) fn layout(&self, film: usize) -> FilmLayout {
        let width = self.job.across.dots();
        FilmLayout {
            halftone: self.separation.halftone(film, width),
            is_full_or_empty: self.is_full_or_empty(),
            dots: vec![Dot::NONE; width],
        }
    }

    /// The batch's rows of the whole sheet.
    pub(super) fn distinct(&self, batch: &Batch) -> Vec<DotRows> {
        let mut distinct: Vec<DotRows> = Vec::new();
        for (index, spans) in batch.spans.iter().enumerate() {
            let films = self.sheet.films.iter().zip(&batch.films);
            let films = films.filter_map(|(place, rows)| Some((place.x_dots, rows[index].clone()?)));
            let next = DotRows { films: films.collect(), spans: spans.clone(), repeat: 1 };
            match distinct.last_mut().filter(|last| last.shows_as(&next)) {
                Some(last) => last.repeat += 1,
                None => distinct.push(next),
            }
        }
        distinct
    }

    /// The row's parts from left to right, where its films have dots that are full or empty and nothing is drawn on them.
    pub(super) fn parts<'row>(&self, row: &'row DotRows) -> Option<Vec<Part<'row>>> {
        if !self.is_full_or_empty() {
            return None;
        }
        let (mut parts, mut start) = (Vec::new(), 0);
        let mut films: Vec<_> = row.films.iter().collect();
        films.sort_by_key(|film| film.0);
        for (left, content) in films {
            let Content::Full(dots) = content else { return None };
            let end = left + self.job.across.dots();
            if row.spans.iter().any(|span| span.start < end && *left < span.end) {
                return None;
            }
            parts.extend([Part::around(row, start..*left), Part::Film(dots)]);
            start = end;
        }
        parts.push(Part::around(row, start..self.sheet.width));
        Some(parts)
    }

    /// Paints rows into `dots`, the interleaved ink of the sheet's width.
    pub(super) fn paint(&self, rows: &DotRows, dots: &mut [u16]) {
        dots.fill(0);
        for (left, content) in &rows.films {
            let place = &mut dots[left * CHANNELS..(left + self.job.across.dots()) * CHANNELS];
            self.paint_film(content, place);
        }
        draw(&rows.spans, dots);
    }

    /// Paints what a film shows into `dots`, the interleaved ink of the film's width.
    pub(super) fn paint_film(&self, content: &Content, dots: &mut [u16]) {
        let (dots, _) = dots.as_chunks_mut::<CHANNELS>();
        match content {
            Content::Dots(shown) => {
                dots.iter_mut().zip(shown.iter()).for_each(|(dot, shown)| *dot = shown.sample(&self.samples));
            }
            Content::Full(shown) => {
                dots.iter_mut().zip(shown.kinds()).for_each(|(dot, kind)| *dot = FULL[kind]);
            }
            Content::Pixels(runs) => {
                let mut start = 0;
                for run in runs.iter() {
                    dots[start..run.end].fill(run.amounts);
                    start = run.end;
                }
            }
        }
    }
}

/// Lays `spans` over `dots`.
pub(super) fn draw(spans: &[Span], dots: &mut [u16]) {
    let (dots, _) = dots.as_chunks_mut::<CHANNELS>();
    spans.iter().for_each(|span| dots[span.start..span.end].fill(span.ink));
}

impl Batch {
    /// What the film of this index on the sheet shows, each with the number of its rows.
    pub(super) fn film(&self, index: usize) -> Vec<(Content, usize)> {
        let mut distinct: Vec<(Content, usize)> = Vec::new();
        for content in self.films[index].iter().flatten() {
            match distinct.last_mut().filter(|last| last.0.is(content)) {
                Some(last) => last.1 += 1,
                None => distinct.push((content.clone(), 1)),
            }
        }
        distinct
    }
}

impl Content {
    /// Whether both are the same row of pixels: rows of dots are new each time.
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Pixels(one), Self::Pixels(other)) => Arc::ptr_eq(one, other),
            _ => false,
        }
    }
}

/// A part of a row of dots.
pub(super) enum Part<'row> {
    /// A film's dots.
    Film(&'row FullDots),
    /// So many dots beside films, and what is drawn on them, from the first on.
    Around { width: usize, spans: Vec<Span> },
}

impl Part<'_> {
    fn around(row: &DotRows, dots: Range<usize>) -> Self {
        let here = row.spans.iter().filter(|span| span.start < dots.end && dots.start < span.end);
        let within = |dot: usize| dot.clamp(dots.start, dots.end) - dots.start;
        let spans = here.map(|span| Span { start: within(span.start), end: within(span.end), ink: span.ink });
        Self::Around { width: dots.len(), spans: spans.collect() }
    }
}

impl DotRows {
    fn shows_as(&self, other: &Self) -> bool {
        self.films.len() == other.films.len()
            && self.films.iter().zip(&other.films).all(|(one, other)| one.0 == other.0 && one.1.is(&other.1))
            && self.spans == other.spans
    }
}

/// Reads one film as far down as the rows need it.
struct Feeder<'a> {
    rows: &'a SheetRows<'a>,
    place: PlacedFilm,
    open: OpenFilm<'a>,
    film: Option<LaidRows>,
    /// Pixel rows that were read.
    read: usize,
    pixels: Arc<[Run]>,
    layout: FilmLayout,
}

impl<'a> Feeder<'a> {
    fn new(rows: &'a SheetRows<'a>, place: PlacedFilm, open: OpenFilm<'a>) -> Self {
        let layout = rows.layout(place.film - 1);
        Self { rows, place, open, film: None, read: 0, pixels: Arc::new([]), layout }
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
                None => self.film.insert(LaidRows::open(job, self.place.film - 1, self.open)?),
            };
            let mut samples = film.next_row()?;
            self.rows.separation.separate(self.place.film - 1, self.read, &mut samples);
            self.pixels = job.runs(&samples).into();
            self.read += 1;
        }
        Ok(Some(self.layout.row(&self.pixels)))
    }
}

/// Lays out one film's rows of dots, from the top.
pub(super) struct FilmLayout {
    halftone: Option<Box<dyn Halftone>>,
    is_full_or_empty: bool,
    dots: Vec<Dot>,
}

impl FilmLayout {
    /// The next row of dots, which shows `pixels`.
    pub(super) fn row(&mut self, pixels: &Arc<[Run]>) -> Content {
        let Some(halftone) = &mut self.halftone else { return Content::Pixels(pixels.clone()) };
        halftone.row(pixels, &mut self.dots);
        match self.is_full_or_empty {
            true => Content::Full(Arc::new(FullDots::new(&self.dots, Dot::kind))),
            false => Content::Dots(self.dots.as_slice().into()),
        }
    }
}

impl PrintJob {
    /// Where the pixels of a row lie, left to right: a mirrored film begins with its last.
    pub(super) fn runs(&self, samples: &[u16]) -> Vec<Run> {
        let (pixels, _) = samples.as_chunks::<CHANNELS>();
        let dots = self.across.dots();
        match self.request.mirrored {
            false => {
                let run = |(pixel, &amounts)| Run { end: self.across.first_dot(pixel + 1), amounts };
                pixels.iter().enumerate().map(run).collect()
            }
            true => {
                let run = |(pixel, &amounts)| Run { end: dots - self.across.first_dot(pixel), amounts };
                pixels.iter().enumerate().rev().map(run).collect()
            }
        }
    }
}
