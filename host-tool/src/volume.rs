//! The ink values of all films.

use std::ops::Range;

use rayon::prelude::*;
use thiserror::Error;

use crate::simd::vectorised;

/// Colour channels of a volume and of a picture: red, green, blue.
pub const CHANNELS: usize = 3;

/// Values that one task of the thread pool rounds.
const VALUES_AT_ONCE: usize = 1 << 14;

/// Bits of each ink value as it is written to a film's file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InkDepth {
    /// 8 bits, 0 to 255.
    #[default]
    Eight,
    /// 16 bits, 0 to 65,535.
    Sixteen,
}

impl InkDepth {
    /// The value that stands for full ink.
    pub fn full(self) -> f32 {
        match self {
            Self::Eight => 255.0,
            Self::Sixteen => 65_535.0,
        }
    }
}

/// Ink values in 0..=1 of all films, planar: channel, film, row, column; film 0 is the top one.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    films: usize,
    height: usize,
    width: usize,
    values: Vec<f32>,
}

/// A film whose values do not have the volume's size.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("a film has {found} values, but {expected} are needed for its size")]
pub struct FilmSizeError {
    /// Values needed.
    pub expected: usize,
    /// Values given.
    pub found: usize,
}

impl Volume {
    /// Makes a volume without ink.
    pub fn new(films: usize, height: usize, width: usize) -> Self {
        Self { films, height, width, values: vec![0.0; CHANNELS * films * height * width] }
    }

    /// Number of films.
    pub fn films(&self) -> usize {
        self.films
    }

    /// Rows of a film.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Columns of a film.
    pub fn width(&self) -> usize {
        self.width
    }

    /// All values: channel, film, row, column.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All values, to write: channel, film, row, column.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// All films of one channel.
    pub fn channel(&self, channel: usize) -> &[f32] {
        let size = self.films * self.height * self.width;
        &self.values[channel * size..(channel + 1) * size]
    }

    /// All films of one channel, to write.
    pub fn channel_mut(&mut self, channel: usize) -> &mut [f32] {
        let size = self.films * self.height * self.width;
        &mut self.values[channel * size..(channel + 1) * size]
    }

    /// One channel of one film, row by row.
    pub fn film(&self, channel: usize, film: usize) -> &[f32] {
        let size = self.height * self.width;
        let start = (channel * self.films + film) * size;
        &self.values[start..start + size]
    }

    /// One channel of one film, row by row, to write.
    pub fn film_mut(&mut self, channel: usize, film: usize) -> &mut [f32] {
        let size = self.height * self.width;
        let start = (channel * self.films + film) * size;
        &mut self.values[start..start + size]
    }

    /// Rounds every value to one of the two that `depth` can write next to it. What a film loses by it, the
    /// film below gains: faint ink that plain rounding would wipe from every film stays in their sum.
    pub fn quantise(&mut self, depth: InkDepth) {
        let mut carried = Carried::start(self.width, 0..self.height as i64);
        self.quantise_below(depth, &mut carried, 0);
    }

    /// As [`Volume::quantise`], for the films below those that left over `carried`; leaves there what these do. Row 0 of
    /// these films lies below row `first_row` of what is carried.
    pub fn quantise_below(&mut self, depth: InkDepth, carried: &mut Carried, first_row: i64) {
        let size = self.width * self.height;
        if size == 0 {
            return;
        }
        let first = (first_row - carried.first_row) as usize * self.width;
        for (channel, carried) in self.values.chunks_mut((self.films * size).max(1)).zip(&mut carried.inks) {
            quantise_films(channel, &mut carried[first..first + size], depth);
        }
    }

    /// One film as interleaved 8-bit RGB, rounded to the nearest value.
    pub fn film_rgb8(&self, film: usize) -> Vec<u8> {
        self.interleave(film, |value| (value * 255.0).round() as u8)
    }

    /// One film as interleaved 16-bit RGB, rounded to the nearest value.
    pub fn film_rgb16(&self, film: usize) -> Vec<u16> {
        self.interleave(film, |value| (value * 65_535.0).round() as u16)
    }

    /// Takes one film from interleaved 8-bit RGB.
    ///
    /// # Errors
    /// When `pixels` is not three times the pixels of a film.
    pub fn set_film_rgb8(&mut self, film: usize, pixels: &[u8]) -> Result<(), FilmSizeError> {
        self.set_film(film, pixels, |value| f32::from(value) / 255.0)
    }

    /// Takes one film from interleaved 16-bit RGB.
    ///
    /// # Errors
    /// When `pixels` is not three times the pixels of a film.
    pub fn set_film_rgb16(&mut self, film: usize, pixels: &[u16]) -> Result<(), FilmSizeError> {
        self.set_film(film, pixels, |value| f32::from(value) / 65_535.0)
    }

    /// BLAKE3 of all values as they are written: film by film, row by row, interleaved RGB;
    /// 16-bit values with their low byte first.
    pub fn blake3(&self, depth: InkDepth) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        for film in 0..self.films {
            match depth {
                InkDepth::Eight => hasher.update(&self.film_rgb8(film)),
                InkDepth::Sixteen => {
                    let bytes: Vec<u8> = self.film_rgb16(film).iter().flat_map(|v| v.to_le_bytes()).collect();
                    hasher.update(&bytes)
                }
            };
        }
        *hasher.finalize().as_bytes()
    }

    fn interleave<T>(&self, film: usize, convert: impl Fn(f32) -> T) -> Vec<T> {
        let [red, green, blue] = [0, 1, 2].map(|channel| self.film(channel, film));
        let mut pixels = Vec::with_capacity(CHANNELS * red.len());
        for ((&r, &g), &b) in red.iter().zip(green).zip(blue) {
            pixels.extend([r, g, b].map(|value| convert(value.clamp(0.0, 1.0))));
        }
        pixels
    }

    fn set_film<T: Copy>(
        &mut self,
        film: usize,
        pixels: &[T],
        convert: impl Fn(T) -> f32,
    ) -> Result<(), FilmSizeError> {
        let expected = CHANNELS * self.height * self.width;
        if pixels.len() != expected {
            return Err(FilmSizeError { expected, found: pixels.len() });
        }
        for channel in 0..CHANNELS {
            for (value, pixel) in self.film_mut(channel, film).iter_mut().zip(pixels.chunks_exact(CHANNELS)) {
                *value = convert(pixel[channel]);
            }
        }
        Ok(())
    }
}

/// What the films above have lost by rounding, in steps, on some rows.
#[derive(Clone, Debug)]
pub struct Carried {
    first_row: i64,
    /// Of each ink: row, column.
    inks: [Vec<f32>; CHANNELS],
}

impl Carried {
    /// What the top film begins from, of so many columns and of these rows.
    pub fn start(width: usize, rows: Range<i64>) -> Self {
        let size = width * rows.clone().count();
        let ink = start_of_carried(size, width, rows.start);
        Self { first_row: rows.start, inks: [ink.clone(), ink.clone(), ink] }
    }
}

/// As [`Volume::quantise`], for the films of one channel, each of `size` values in rows of `width`.
pub(crate) fn quantise_channel(films: &mut [f32], (size, width): (usize, usize), depth: InkDepth) {
    quantise_films(films, &mut start_of_carried(size, width, 0), depth);
}

/// What rounding begins from on the top film, from row `first_row` on.
fn start_of_carried(size: usize, width: usize, first_row: i64) -> Vec<f32> {
    (0..size).map(|at| dither(at % width, first_row + (at / width) as i64)).collect()
}

fn quantise_films(films: &mut [f32], carried: &mut [f32], depth: InkDepth) {
    let full = depth.full();
    for film in films.chunks_mut(carried.len().max(1)) {
        let lines = film.par_chunks_mut(VALUES_AT_ONCE).zip(carried.par_chunks_mut(VALUES_AT_ONCE));
        lines.for_each(|(values, carried)| {
            vectorised(
                #[inline(always)]
                || {
                    for (value, carried) in values.iter_mut().zip(carried) {
                        round(value, carried, full);
                    }
                },
            );
        });
    }
}

/// Rounds one ink value up or down, `carried` being what the films above lost by it, in steps.
#[inline(always)]
fn round(value: &mut f32, carried: &mut f32, full: f32) {
    let wanted = on_step(value.clamp(0.0, 1.0) * full);
    let written = (wanted + *carried + 0.5).floor().clamp(wanted.floor(), wanted.ceil());
    *carried = (*carried + wanted - written).clamp(-0.5, 0.5);
    *value = written / full;
}

/// Returns `value`, or the whole number from which only the arithmetic's rounding parts it.
#[inline(always)]
fn on_step(value: f32) -> f32 {
    let whole = (value + 0.5).floor();
    if (value - whole).abs() < 2e-7 * whole.max(1.0) { whole } else { value }
}

/// Returns an even spread over -0.5..0.5 in which neighbours differ much: the additive sequence of the
/// plastic number in two dimensions (Roberts 2018).
fn dither(column: usize, row: i64) -> f32 {
    const A: f64 = 0.754_877_666_246_692_8;
    const B: f64 = 0.569_840_290_998_053_3;
    ((column as f64 * A + row as f64 * B).rem_euclid(1.0) - 0.5) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn eight_bits_come_back_as_they_were(pixels in proptest::collection::vec(any::<u8>(), 3 * 2 * 3)) {
            let mut volume = Volume::new(2, 2, 3);
            volume.set_film_rgb8(1, &pixels).unwrap();
            prop_assert_eq!(volume.film_rgb8(1), pixels);
        }

        #[test]
        fn sixteen_bits_come_back_as_they_were(pixels in proptest::collection::vec(any::<u16>(), 3 * 2 * 3)) {
            let mut volume = Volume::new(2, 2, 3);
            volume.set_film_rgb16(1, &pixels).unwrap();
            prop_assert_eq!(volume.film_rgb16(1), pixels);
        }
    }

    #[test]
    fn values_are_rounded_to_the_nearest() {
        let mut volume = Volume::new(1, 1, 2);
        volume.film_mut(0, 0).copy_from_slice(&[0.499 / 255.0, 0.501 / 255.0]);
        volume.film_mut(2, 0).copy_from_slice(&[-1.0, 2.0]);
        assert_eq!(volume.film_rgb8(0), [0, 0, 0, 1, 0, 255]);
        let hash = volume.blake3(InkDepth::Eight);
        assert_eq!(hash, *blake3::hash(&[0, 0, 0, 1, 0, 255]).as_bytes());
    }

    #[test]
    fn quantising_keeps_faint_ink_in_the_sum_and_moves_no_value_by_a_step() {
        let mut volume = Volume::new(20, 8, 8);
        for (index, value) in volume.values_mut().iter_mut().enumerate() {
            *value = (index % 97) as f32 / 97.0 * 0.01;
        }
        let before = volume.clone();
        volume.quantise(InkDepth::Eight);
        for (written, value) in volume.values().iter().zip(before.values()) {
            assert!((written - value).abs() < 1.0 / 255.0);
            assert!((written * 255.0 - (written * 255.0).round()).abs() < 1e-4);
        }
        let column = |volume: &Volume| (0..20).map(|film| volume.film(1, film)[37]).sum::<f32>();
        assert!((column(&volume) - column(&before)).abs() < 1.01 / 255.0);
        let once = volume.clone();
        volume.quantise(InkDepth::Eight);
        assert_eq!(volume, once);
    }

    #[test]
    fn a_film_of_another_size_is_refused() {
        let error = Volume::new(1, 2, 2).set_film_rgb8(0, &[0; 11]).unwrap_err();
        assert_eq!(error, FilmSizeError { expected: 12, found: 11 });
    }
}
