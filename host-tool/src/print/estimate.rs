//! What printing will take, told beforehand.

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::job::{PrintJob, Sheet};
use super::laid::LaidRows;
use super::pdf;
use super::raster::Raster;
use super::rows::{OpenFilm, SheetRows};
use super::separation::Separation;
use super::strips::RowCoder;
use super::tiff::TiffRows;
use super::write::{Formats, PrintError};
use crate::deflate::{Deflater, Piece};
use crate::volume::CHANNELS;

/// What printing will take: extrapolated from some of the films.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Sheets of paper.
    pub sheets: usize,
    /// The part of the paper that is no film with its marks.
    pub waste: f64,
    /// Bytes of all files, about.
    pub bytes: u64,
    /// Seconds that writing them takes on this computer, about.
    pub seconds: f64,
    /// The mean amount of each channel on the films' pictures, 1 for full.
    pub coverage: [f64; CHANNELS],
    /// Ink of each channel that the films' pictures take, in ml.
    pub ink_ml: [f64; CHANNELS],
    /// The films that were looked at; the others are taken to be like them.
    pub films_read: usize,
}

/// Samples that are read at most.
const MOST_SAMPLES: usize = 1 << 30;
/// One of so many rows is compressed to see how long that takes and what comes of it.
const SAMPLED_ROWS: usize = 16;
/// Rows of dots of a sampled row of pixels that a halftone lays out: the last is looked at.
const SETTLING_ROWS: usize = 4;
/// Rows that marks make different from their neighbours, for every row of films on a sheet.
const MARKED_ROWS: usize = 400;

impl Estimate {
    /// Looks at some films; full ink of one channel takes `full_ink_ml_m2`.
    ///
    /// # Errors
    /// When a film cannot be read.
    pub fn of(
        job: &PrintJob,
        formats: Formats,
        open: OpenFilm<'_>,
        separation: &dyn Separation,
        full_ink_ml_m2: f64,
    ) -> Result<Self, PrintError> {
        let stack = &job.request.stack;
        let samples = stack.film_len() * CHANNELS;
        let films = &job.request.films;
        let films_read = (MOST_SAMPLES / samples).clamp(1, films.len().max(1));
        let look = (0..films_read)
            .into_par_iter()
            .map(|read| Look::at(job, films[read * films.len() / films_read], open, separation))
            .try_reduce(Look::default, |one, other| Ok(one.with(other)))?;
        let (width, height) = job.film_dots();
        let dots = (width * height * films.len()) as f64;
        let sheet_dots: f64 = job.sheets.iter().map(|sheet| (sheet.width * sheet.height) as f64).sum();
        let blank = Deflater::new().piece(&vec![0; 1 << 20]).compressed_len() as f64 / f64::from(1 << 20);
        // An empty dot has as many bytes before compression as any.
        let blank_bytes = (sheet_dots - dots).max(0.0) * blank * 2.0 * CHANNELS as f64;
        // Without a halftone, a pixel's rows of dots are the same.
        let halftoned = separation.top_level().is_some();
        let rows = if halftoned { height } else { job.down.pixels() };
        let worked = (rows * width * films.len()) as f64;
        let (mut bytes, mut seconds) =
            (0.0, look.read_seconds / look.pixels.max(1) as f64 * (stack.film_len() * films.len()) as f64);
        if halftoned {
            seconds += look.halftone_seconds / look.dots() * dots;
        }
        if formats.tiff.is_some() {
            bytes += look.tiff.bytes / look.dots() * dots + blank_bytes;
            bytes += job.sheets.iter().map(|sheet| drawn_bytes(job, sheet)).sum::<f64>();
            if separation.top_level() == Some(1) {
                // What lies beside each film is compressed by itself.
                let beside = films.len() + job.sheets.iter().map(|sheet| tops(sheet).len()).sum::<usize>();
                bytes += (Deflater::new().piece(&[0; 1 << 10]).compressed_len() * beside * height) as f64;
            }
            seconds += look.tiff.seconds / look.dots() * sheet_rows_dots(job, rows);
        }
        if formats.pdf {
            bytes += look.pdf.bytes / look.dots() * dots;
            bytes += job.sheets.iter().map(|sheet| pdf::drawn_bytes(sheet) as f64).sum::<f64>();
            seconds += look.pdf.seconds / look.dots() * worked;
        }
        let area_m2 = stack.width_mm * stack.height_mm() * 1e-6 * films.len() as f64;
        let coverage = look.coverage();
        Ok(Self {
            sheets: job.sheets(),
            waste: job.waste(),
            bytes: bytes as u64,
            seconds: seconds / rayon::current_num_threads() as f64,
            coverage,
            ink_ml: coverage.map(|part| part * area_m2 * full_ink_ml_m2),
            films_read,
        })
    }
}

/// Dots of a sheet's rows that are painted and compressed, where a film has `film_rows` of them.
fn sheet_rows_dots(job: &PrintJob, film_rows: usize) -> f64 {
    let sheet_dots = |sheet: &Sheet| (tops(sheet).len() * (film_rows + MARKED_ROWS) * sheet.width) as f64;
    job.sheets.iter().map(sheet_dots).sum()
}

/// Bytes in a TIFF of what is drawn above, below and between films, from some of the rows.
fn drawn_bytes(job: &PrintJob, sheet: &Sheet) -> f64 {
    let raster = Raster::new(&sheet.drawing, job.request.resolution, sheet.width);
    let mut deflater = Deflater::new();
    let bytes = (SAMPLED_ROWS / 2..sheet.height).step_by(SAMPLED_ROWS).map(|row| {
        let spans = raster.row(row);
        let (start, end) =
            (spans.iter().map(|span| span.start).min(), spans.iter().map(|span| span.end).max());
        let has_films =
            sheet.films.iter().any(|film| (film.y_dots..film.y_dots + job.down.dots()).contains(&row));
        let (Some(start), Some(end), false) = (start, end, has_films) else { return 0 };
        let mut dots = vec![0; (end - start) * CHANNELS * 2];
        for span in spans {
            dots[(span.start - start) * CHANNELS * 2..(span.end - start) * CHANNELS * 2].fill(u8::MAX);
        }
        deflater.piece(&dots).compressed_len()
    });
    (bytes.sum::<usize>() * SAMPLED_ROWS) as f64
}

/// Where rows of films begin on a sheet.
fn tops(sheet: &Sheet) -> Vec<usize> {
    let mut tops: Vec<usize> = sheet.films.iter().map(|film| film.y_dots).collect();
    tops.dedup();
    tops
}

/// What was seen on some films.
#[derive(Default)]
struct Look {
    sums: [u64; CHANNELS],
    pixels: u64,
    read_seconds: f64,
    sampled_dots: usize,
    halftone_seconds: f64,
    tiff: Compressed,
    pdf: Compressed,
}

/// What compression made of the sampled rows, and in what time.
#[derive(Default)]
struct Compressed {
    bytes: f64,
    seconds: f64,
}

impl Look {
    fn at(
        job: &PrintJob,
        film: usize,
        open: OpenFilm<'_>,
        separation: &dyn Separation,
    ) -> Result<Self, PrintError> {
        let mut look = Self::default();
        let mut film_rows = LaidRows::open(job, film, open)?;
        let sheet = job.alone(film);
        let rows = SheetRows::new(job, &sheet, separation);
        let mut layout = rows.layout(film);
        let width = job.across.dots();
        let tiff = TiffRows::new(&rows, width);
        let (_, pdf_form) = pdf::row_form(width, separation.top_level());
        let [mut tiff_coder, mut pdf_coder] = [tiff.form, pdf_form].map(RowCoder::new);
        for row in 0..job.down.pixels() {
            let begun = Instant::now();
            let mut samples = film_rows.next_row()?;
            separation.separate(film, row, &mut samples);
            look.read_seconds += begun.elapsed().as_secs_f64();
            for pixel in samples.as_chunks::<CHANNELS>().0 {
                for (sum, sample) in look.sums.iter_mut().zip(pixel) {
                    *sum += u64::from(*sample);
                }
            }
            look.pixels += (samples.len() / CHANNELS) as u64;
            if row % SAMPLED_ROWS == SAMPLED_ROWS / 2 {
                let begun = Instant::now();
                let pixels = job.runs(&samples).into();
                // Error diffusion begins with too little ink.
                (1..SETTLING_ROWS).for_each(|_| drop(layout.row(&pixels)));
                let content = layout.row(&pixels);
                look.halftone_seconds += begun.elapsed().as_secs_f64() / SETTLING_ROWS as f64;
                look.tiff.see(|| tiff.film_piece(&mut tiff_coder, &content));
                look.pdf.see(|| pdf::film_piece(&mut pdf_coder, &rows, &content));
                look.sampled_dots += width;
            }
        }
        Ok(look)
    }

    fn with(self, other: Self) -> Self {
        let both = |one: Compressed, other: Compressed| Compressed {
            bytes: one.bytes + other.bytes,
            seconds: one.seconds + other.seconds,
        };
        Self {
            sums: std::array::from_fn(|channel| self.sums[channel] + other.sums[channel]),
            pixels: self.pixels + other.pixels,
            read_seconds: self.read_seconds + other.read_seconds,
            sampled_dots: self.sampled_dots + other.sampled_dots,
            halftone_seconds: self.halftone_seconds + other.halftone_seconds,
            tiff: both(self.tiff, other.tiff),
            pdf: both(self.pdf, other.pdf),
        }
    }

    fn dots(&self) -> f64 {
        self.sampled_dots.max(1) as f64
    }

    fn coverage(&self) -> [f64; CHANNELS] {
        let full = self.pixels.max(1) as f64 * f64::from(u16::MAX);
        self.sums.map(|sum| sum as f64 / full)
    }
}

impl Compressed {
    /// Looks at how a row of a film is compressed.
    fn see(&mut self, compress: impl FnOnce() -> Piece) {
        let begun = Instant::now();
        self.bytes += compress().compressed_len() as f64;
        self.seconds += begun.elapsed().as_secs_f64();
    }
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [red, green, blue] = self.ink_ml;
        write!(
            out,
            "{} {} ({:.0} % waste), about {:.1} MB, {}; ink {red:.3} + {green:.3} + {blue:.3} ml",
            self.sheets,
            if self.sheets == 1 { "sheet" } else { "sheets" },
            100.0 * self.waste,
            self.bytes as f64 / 1e6,
            duration(self.seconds)
        )
    }
}

/// Seconds, minutes or hours.
fn duration(seconds: f64) -> String {
    match seconds {
        few if few < 90.0 => format!("{few:.0} s"),
        some if some < 5400.0 => format!("{:.0} min", some / 60.0),
        many => format!("{:.1} h", many / 3600.0),
    }
}
