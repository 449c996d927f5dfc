//! The inks of printed sheets: film values become coverages, and coverages dots.

use std::sync::atomic::{AtomicU64, Ordering};

use super::profile::{ProfileSpace, profile};
use super::screen::{Screen, Screens};
use super::separate::Separator;
use crate::print::{self, Dot, Run};
use crate::volume::CHANNELS;

/// A sample that stands for full ink.
const FULL: f32 = u16::MAX as f32;

/// Separates films for the printer, and lays out their dots where that is wanted.
#[derive(Debug)]
pub struct SheetInks {
    /// `None` where the values are coverages already.
    separator: Option<Separator>,
    screens: Option<Screens>,
    spots: AtomicU64,
    dimmed: AtomicU64,
}

impl SheetInks {
    /// Prepares for films whose values are light (with `separator`), or coverages (without); dots are laid out by
    /// `screens`, if there are any.
    pub fn new(separator: Option<Separator>, screens: Option<Screens>) -> Self {
        Self { separator, screens, spots: AtomicU64::new(0), dimmed: AtomicU64::new(0) }
    }

    /// The profiles of the inks of these `names`; none where the values are coverages already, whose light is unknown.
    pub fn profiles(&self, names: &[String; CHANNELS]) -> Option<print::Profiles> {
        let of = |space| Some(profile(self.separator.as_ref()?, names, space));
        Some(print::Profiles { samples: of(ProfileSpace::Samples)?, inks: of(ProfileSpace::Inks)? })
    }

    /// The part of the pixels separated so far that the ink limit has dimmed, 0..=1.
    pub fn dimmed(&self) -> f64 {
        let spots = self.spots.load(Ordering::Relaxed).max(1);
        self.dimmed.load(Ordering::Relaxed) as f64 / spots as f64
    }
}

impl print::Separation for SheetInks {
    fn separate(&self, _film: usize, _row: usize, samples: &mut [u16]) {
        let Some(separator) = &self.separator else { return };
        let (pixels, _) = samples.as_chunks_mut::<CHANNELS>();
        let mut dimmed = 0;
        for pixel in pixels.iter_mut() {
            let (coverages, was_dimmed) = separator.spot(pixel.map(|sample| f32::from(sample) / FULL));
            *pixel = coverages.map(|coverage| (coverage * FULL).round() as u16);
            dimmed += u64::from(was_dimmed);
        }
        self.spots.fetch_add(pixels.len() as u64, Ordering::Relaxed);
        self.dimmed.fetch_add(dimmed, Ordering::Relaxed);
    }

    fn top_level(&self) -> Option<u8> {
        self.screens.as_ref().map(Screens::top)
    }

    fn halftone(&self, film: usize, width: usize) -> Option<Box<dyn print::Halftone>> {
        let screen = self.screens.as_ref()?.film(film, width);
        Some(Box::new(Rows { screen, next: 0 }))
    }
}

/// A film's dots, row by row.
struct Rows {
    screen: Screen,
    next: usize,
}

impl print::Halftone for Rows {
    fn row(&mut self, runs: &[Run], dots: &mut [Dot]) {
        self.screen.row(self.next, runs, dots);
        self.next += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{Halftone, Inks};
    use crate::print::Separation as _;

    #[test]
    fn a_row_of_film_becomes_coverages_and_then_dots_of_one_ink() {
        let inks = SheetInks::new(
            Some(Separator::new(&Inks::default())),
            Some(Screens::new(Halftone::BlueNoise, 2, 4.0)),
        );
        let mut samples = vec![13_107_u16; 3 * 128];
        samples.extend([65_535; 3]);
        inks.separate(0, 0, &mut samples);
        // 0.2 of white: full red ink, thinned green and blue.
        assert_eq!(&samples[..3], &[13_107, 6_631, 6_333]);
        assert!((inks.dimmed() - 1.0 / 129.0).abs() < 1e-9);
        let mut halftone = inks.halftone(3, 128).unwrap();
        let run = Run { end: 128, amounts: [samples[0], samples[1], samples[2]] };
        let mut sums = [0_usize; 3];
        for _ in 0..64 {
            let mut dots = [Dot::NONE; 128];
            halftone.row(&[run], &mut dots);
            for (ink, level) in dots.map(Dot::ink) {
                sums[ink] += usize::from(level);
            }
        }
        for (sum, sample) in sums.iter().zip(&samples) {
            let (mean, wanted) = (*sum as f64 / (64.0 * 128.0), f64::from(*sample) / 65_535.0);
            assert!((mean - wanted).abs() < 1.0 / 2048.0, "{mean} for {wanted}");
        }
        assert!(SheetInks::new(None, None).halftone(0, 1).is_none());
    }
}
