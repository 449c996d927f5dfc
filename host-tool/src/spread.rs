//! How light spreads along a film: a Gaussian on the pixels' grid.
//!
//! The spread is Lindeberg's discrete Gaussian ("Scale-space for discrete signals", IEEE Transactions on Pattern
//! Analysis and Machine Intelligence 12, 1990): of t square pixels of variance, the part `exp(-t) I_n(t)` of a pixel's
//! light goes n pixels to one side, with I_n the modified Bessel function. Its variance is t however small t is,
//! and two spreads in turn are one of the sum of their variances. What spreads beyond the film's edge is lost, so the
//! map is its own transpose.

use rayon::prelude::*;

use crate::simd::vectorised;

/// The part of the light that may be left out at the far ends.
const LEFT_OUT: f64 = 1e-3;

/// A point spread.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spread {
    across: Parts,
    down: Parts,
}

impl Spread {
    /// All light stays where it is.
    pub(crate) const NONE: Self = Self { across: Parts(Vec::new()), down: Parts(Vec::new()) };

    /// A spread of this variance along both axes, in square pixels; no light is lost but beyond the film's edge.
    pub(crate) fn of_variance(variance: f64) -> Self {
        Self::of_variances([variance; 2])
    }

    /// A spread of these variances along the rows and along the columns of a film, in square pixels.
    pub(crate) fn of_variances([across, down]: [f64; 2]) -> Self {
        Self { across: Parts::of_variance(across), down: Parts::of_variance(down) }
    }

    /// Whether all light stays where it is.
    pub(crate) fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// A spread of these parts to each neighbour along the rows and along the columns.
    pub(crate) fn to_neighbours([across, down]: [f64; 2]) -> Self {
        Self { across: Parts(vec![across as f32]), down: Parts(vec![down as f32]) }
    }

    /// How many pixels to each side the light of one goes.
    pub(crate) fn reach(&self) -> usize {
        self.across.0.len().max(self.down.0.len())
    }

    /// The pixels to which the light of one goes.
    pub(crate) fn pixels(&self) -> usize {
        (2 * self.across.0.len() + 1) * (2 * self.down.0.len() + 1)
    }

    /// Writes row `row` of a film of `height` rows after its light has spread; `line` gives the rows before, and
    /// `scratch` holds one row.
    #[inline(always)]
    pub(crate) fn write_row<'a>(
        &self,
        row: usize,
        height: usize,
        line: impl Fn(usize) -> &'a [f32],
        target: &mut [f32],
        scratch: &mut [f32],
    ) {
        scale(scratch, line(row), self.down.staying());
        for (distance, &part) in (1..).zip(&self.down.0) {
            match (row.checked_sub(distance), row + distance < height) {
                (Some(above), true) => add_both(scratch, line(above), line(row + distance), part),
                (Some(above), false) => add(scratch, line(above), part),
                (None, true) => add(scratch, line(row + distance), part),
                (None, false) => break,
            }
        }
        scale(target, scratch, self.across.staying());
        for (distance, &part) in (1..target.len()).zip(&self.across.0) {
            add(&mut target[distance..], scratch, part);
            add(target, &scratch[distance..], part);
        }
    }

    /// Returns one film (row, column) after its light has spread.
    pub(crate) fn of_film(&self, film: &[f32], width: usize) -> Vec<f32> {
        let mut spread = vec![0.0; film.len()];
        let mut scratch = vec![0.0; width];
        let line = |row: usize| &film[row * width..(row + 1) * width];
        vectorised(
            #[inline(always)]
            || {
                for (row, target) in spread.chunks_exact_mut(width).enumerate() {
                    self.write_row(row, film.len() / width, line, target, &mut scratch);
                }
            },
        );
        spread
    }

    /// Spreads the light of every film of so many columns and rows.
    pub(crate) fn apply(&self, films: &mut [f32], width: usize, height: usize) {
        if !self.is_none() {
            let films = films.par_chunks_mut(width * height);
            films.for_each(|film| film.copy_from_slice(&self.of_film(film, width)));
        }
    }
}

/// Along one axis, by distance in pixels from 1 on: the part of a pixel's light that goes so far to either side.
#[derive(Clone, Debug, PartialEq)]
struct Parts(Vec<f32>);

impl Parts {
    fn of_variance(variance: f64) -> Self {
        let mut sides = Vec::new();
        let mut sum = part(0, variance);
        while sum < 1.0 - LEFT_OUT {
            let next = part(sides.len() + 1, variance);
            sides.push(next);
            sum += 2.0 * next;
        }
        Self(sides.iter().map(|part| (part / sum) as f32).collect())
    }

    /// The part that stays in its pixel.
    fn staying(&self) -> f32 {
        1.0 - 2.0 * self.0.iter().sum::<f32>()
    }
}

/// `exp(-variance) I_distance(variance)`, by the trapezoid rule on Bessel's integral, which for a periodic integrand
/// errs by no more than the part that goes as far as there are points.
fn part(distance: usize, variance: f64) -> f64 {
    let points = 64 + 4 * distance + (16.0 * variance.sqrt()) as usize;
    let sum: f64 = (0..points)
        .map(|point| {
            let angle = (point as f64 + 0.5) * std::f64::consts::PI / points as f64;
            (variance * (angle.cos() - 1.0)).exp() * (distance as f64 * angle).cos()
        })
        .sum();
    sum / points as f64
}

#[inline(always)]
fn scale(target: &mut [f32], source: &[f32], part: f32) {
    target.iter_mut().zip(source).for_each(|(value, source)| *value = part * source);
}

#[inline(always)]
fn add(target: &mut [f32], source: &[f32], part: f32) {
    target.iter_mut().zip(source).for_each(|(value, source)| *value += part * source);
}

#[inline(always)]
fn add_both(target: &mut [f32], one: &[f32], other: &[f32], part: f32) {
    for ((value, one), other) in target.iter_mut().zip(one).zip(other) {
        *value += part * (one + other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Light that a single pixel sends to every column of its row, in a row of 2 * `reach` + 1.
    fn across(spread: &Spread, reach: usize) -> Vec<f64> {
        let mut film = vec![0.0; 2 * reach + 1];
        film[reach] = 1.0;
        spread.of_film(&film, 2 * reach + 1).into_iter().map(f64::from).collect()
    }

    proptest! {
        #[test]
        fn a_spread_keeps_the_light_and_has_its_variance(variance in 0.05..30.0f64) {
            let light = across(&Spread::of_variances([variance, 0.0]), 40);
            let moment = |power: i32| -> f64 {
                light.iter().enumerate().map(|(column, part)| part * (column as f64 - 40.0).powi(power)).sum()
            };
            prop_assert!((moment(0) - 1.0).abs() < 1e-5);
            // What is left out of a narrow spread would have gone two pixels far.
            let left_out = 4.0 * LEFT_OUT;
            prop_assert!((moment(2) - variance).abs() < 0.03 * variance + left_out, "{} {}", moment(2), variance);
        }

        #[test]
        fn a_spread_is_its_own_transpose(x in 0.0..4.0f64, y in 0.0..4.0f64, width in 2usize..12, height in 1usize..9) {
            let spread = Spread::of_variances([x, y]);
            let film = |factor: usize| -> Vec<f32> {
                (0..width * height).map(|index| (index * factor % 29) as f32 / 29.0).collect()
            };
            let (one, other) = (film(7), film(11));
            let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
            let (forward, back) = (dot(&spread.of_film(&one, width), &other), dot(&one, &spread.of_film(&other, width)));
            prop_assert!((forward - back).abs() < 1e-4 * forward.max(1e-3), "{} {}", forward, back);
        }
    }

    #[test]
    fn two_spreads_in_turn_are_one_of_the_sum_of_their_variances() {
        let film: Vec<f32> = (0..31 * 31).map(|index| f32::from(u8::from(index == 15 * 31 + 15))).collect();
        let spread = |variance: f64, film: &[f32]| Spread::of_variance(variance).of_film(film, 31);
        let (turns, one) = (spread(0.7, &spread(1.1, &film)), spread(1.8, &film));
        for (turns, one) in turns.iter().zip(one) {
            assert!((turns - one).abs() < 2e-3, "{turns} {one}");
        }
    }
}
