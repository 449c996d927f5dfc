//! What printing will take, told beforehand.

use std::time::Instant;

use serde::Serialize;

use super::job::PrintJob;
use super::rows::OpenFilm;
use super::separation::Separation;
use super::write::{Formats, PrintError};
use crate::deflate::Deflater;
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
        let films_read = (MOST_SAMPLES / samples).clamp(1, stack.films);
        let mut look = Look::default();
        for read in 0..films_read {
            look.read(job, read * stack.films / films_read, open, separation)?;
        }
        let (width, height) = job.film_dots();
        let dots = (width * height * stack.films) as f64;
        let film_bytes = look.bytes_per_dot() * dots;
        let sheet_dots: f64 = job.sheets.iter().map(|sheet| (sheet.width * sheet.height) as f64).sum();
        let blank = Deflater::new().piece(&vec![0; 1 << 20]).compressed_len() as f64 / f64::from(1 << 20);
        // An empty dot has as many bytes before compression as any.
        let blank_bytes = (sheet_dots - dots).max(0.0) * blank * 2.0 * CHANNELS as f64;
        let tiff = if formats.tiff.is_some() { film_bytes + blank_bytes } else { 0.0 };
        let pdf = if formats.pdf { film_bytes } else { 0.0 };
        let area_m2 = stack.width_mm * stack.height_mm() * 1e-6 * stack.films as f64;
        let coverage = look.coverage();
        Ok(Self {
            sheets: job.sheets(),
            waste: job.waste(),
            bytes: (tiff + pdf) as u64,
            seconds: look.seconds_per_dot() * worked_dots(job, formats) / rayon::current_num_threads() as f64,
            coverage,
            ink_ml: coverage.map(|part| part * area_m2 * full_ink_ml_m2),
            films_read,
        })
    }
}

/// Dots of all rows that are painted and compressed: those of the same pixels are once.
fn worked_dots(job: &PrintJob, formats: Formats) -> f64 {
    let stack = &job.request.stack;
    let width = job.across.dots();
    let films = if formats.pdf { (stack.height_px * width * stack.films) as f64 } else { 0.0 };
    let sheets: f64 = job
        .sheets
        .iter()
        .map(|sheet| {
            let mut tops: Vec<usize> = sheet.films.iter().map(|film| film.y_dots).collect();
            tops.dedup();
            (tops.len() * (stack.height_px + MARKED_ROWS) * sheet.width) as f64
        })
        .sum();
    films + if formats.tiff.is_some() { sheets } else { 0.0 }
}

/// What was seen on some films.
#[derive(Default)]
struct Look {
    sums: [u64; CHANNELS],
    pixels: u64,
    compressed: usize,
    compressed_dots: usize,
    seconds: f64,
}

impl Look {
    fn read(
        &mut self,
        job: &PrintJob,
        film: usize,
        open: OpenFilm<'_>,
        separation: &dyn Separation,
    ) -> Result<(), PrintError> {
        let mut rows = open(film)?;
        let mut deflater = Deflater::new();
        for row in 0..job.request.stack.height_px {
            let mut samples = rows.next_row()?;
            separation.separate(film, row, &mut samples);
            for pixel in samples.as_chunks::<CHANNELS>().0 {
                for (sum, sample) in self.sums.iter_mut().zip(pixel) {
                    *sum += u64::from(*sample);
                }
            }
            self.pixels += (samples.len() / CHANNELS) as u64;
            if row % SAMPLED_ROWS == SAMPLED_ROWS / 2 {
                let begun = Instant::now();
                self.compress(job, &samples, &mut deflater);
                self.seconds += begun.elapsed().as_secs_f64();
            }
        }
        Ok(())
    }

    /// Compresses the row of pixels as it will be in a file.
    fn compress(&mut self, job: &PrintJob, samples: &[u16], deflater: &mut Deflater) {
        let dots = job.across.dots();
        let mut bytes = vec![0u8; dots * CHANNELS * 2];
        let mut last = [0u16; CHANNELS];
        for (pixel, values) in samples.as_chunks::<CHANNELS>().0.iter().enumerate() {
            let at = job.across.first_dot(pixel) * CHANNELS * 2;
            for (channel, value) in values.iter().enumerate() {
                let difference = value.wrapping_sub(last[channel]).to_ne_bytes();
                bytes[at + 2 * channel..at + 2 * channel + 2].copy_from_slice(&difference);
            }
            last = *values;
        }
        self.compressed += deflater.piece(&bytes).compressed_len();
        self.compressed_dots += dots;
    }

    fn bytes_per_dot(&self) -> f64 {
        self.compressed as f64 / self.compressed_dots.max(1) as f64
    }

    fn seconds_per_dot(&self) -> f64 {
        self.seconds / self.compressed_dots.max(1) as f64
    }

    fn coverage(&self) -> [f64; CHANNELS] {
        let full = self.pixels.max(1) as f64 * f64::from(u16::MAX);
        self.sums.map(|sum| sum as f64 / full)
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
