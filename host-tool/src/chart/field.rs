//! How unevenly a chart is lit and photographed.
//!
//! A lamp's light and a lens's shade change slowly over a chart. Patches of the same coverage, spread over it, tell
//! by how much: with the field exp(q(x, y)), q a polynomial without constant term, and the level L_g of each group of
//! equal patches, the logarithms of the readings are fitted by log L_g + q with least squares. Where patches are dimmed
//! by layers of one kind, n of them, n log tau is fitted with them. A reading's logarithm is the surer the brighter it
//! is, so its weight is its square.

use super::solve::least_squares;

/// Terms of the polynomial: all to the third order, and the even ones of the fourth, as a lens's shade has them.
const TERMS: usize = 12;
/// Readings below this part of the brightest tell nothing about the field.
const FAINTEST: f64 = 0.02;

/// The light of a chart's places, relative to its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Field([f64; TERMS]);

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Its place from the left, -1..=1 over the chart.
    pub x: f64,
    /// Its place from above, -1..=1 over the chart.
    pub y: f64,
    /// Which samples are of equal coverage, counted from 0.
    pub group: usize,
    /// By how many layers it is dimmed, all alike.
    pub layers: usize,
    /// Its light; what glows less than nothing is noise.
    pub light: f64,
}

fn terms(x: f64, y: f64) -> [f64; TERMS] {
    let (xx, yy) = (x * x, y * y);
    [x, y, xx, x * y, yy, xx * x, xx * y, x * yy, yy * y, xx * xx, xx * yy, yy * yy]
}

impl Field {
    /// Fits the field to `samples` of `groups` groups; `None` where they do not determine it.
    pub fn fit(samples: &[Sample], groups: usize) -> Option<Self> {
        let brightest = samples.iter().map(|sample| sample.light).fold(0.0, f64::max);
        let bright: Vec<&Sample> =
            samples.iter().filter(|sample| sample.light > FAINTEST * brightest).collect();
        // Groups without bright samples have no level to solve for.
        let mut numbers = vec![None; groups];
        let mut found = 0;
        for sample in &bright {
            let number = numbers.get_mut(sample.group)?;
            if number.is_none() {
                *number = Some(found);
                found += 1;
            }
        }
        let layered = bright.iter().any(|sample| sample.layers > 0);
        let rows: Option<Vec<_>> = bright
            .iter()
            .map(|sample| {
                let mut factors = terms(sample.x, sample.y).to_vec();
                factors.resize(TERMS + found, 0.0);
                factors[TERMS + numbers[sample.group]?] = 1.0;
                factors.extend(layered.then_some(sample.layers as f64));
                Some((factors, sample.light.ln(), (sample.light / brightest).powi(2)))
            })
            .collect();
        let solved = least_squares(&rows?, TERMS + found + usize::from(layered))?;
        Some(Self(solved[..TERMS].try_into().ok()?))
    }

    /// The field at a place, 1 in the middle.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        terms(x, y).iter().zip(self.0).map(|(term, factor)| term * factor).sum::<f64>().exp()
    }

    /// The level of each group: the one that fits its readings without layers with the least squares.
    pub fn levels(&self, samples: &[Sample], groups: usize) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); groups];
        for sample in samples.iter().filter(|sample| sample.layers == 0) {
            let field = self.at(sample.x, sample.y);
            let (product, square) = &mut sums[sample.group];
            *product += field * sample.light;
            *square += field * field;
        }
        sums.into_iter().map(|(product, square)| if square > 0.0 { product / square } else { 0.0 }).collect()
    }
}

/// A plane a + b x + c y through (x, y, value), with the least squares; `None` where the places lie in line.
pub fn plane(points: &[(f64, f64, f64)]) -> Option<[f64; 3]> {
    let rows: Vec<_> = points.iter().map(|&(x, y, value)| (vec![1.0, x, y], value, 1.0)).collect();
    least_squares(&rows, 3)?.try_into().ok()
}
