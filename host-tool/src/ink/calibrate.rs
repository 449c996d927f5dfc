//! Measuring the inks' curves from a photograph of the wedge.
//!
//! The photograph has to be one whose values the camera or its developer has not bent beyond what its profile says (see
//! [`crate::picture::Photograph`]). Each ink is read in its own channel: what the bare patches give there is taken off,
//! an uneven light is divided out (see [`crate::chart::Field`]), and the repeats of each coverage are averaged.

use miette::Diagnostic;
use thiserror::Error;

use super::curve_file::{CurveFile, InkCurve};
use super::wedge::{COVERAGES, wedge};
use crate::chart::{ChartError, Field, Found, Reading, Sample, find_rather_than, plane, read_patches};
use crate::experiment::films;
use crate::picture::Picture;
use crate::volume::CHANNELS;

/// What to do with a photograph of the other chart.
const CIRCLES: &str =
    "these are the circles that tell of films: measure them with `vitrine experiment films --fit`";
/// Names of the inks, in the channels' order.
const NAMES: [&str; CHANNELS] = ["red", "green", "blue"];
/// The part of a patch that may be at the channel's end: reflections of dust.
const CLIPPED: f64 = 0.02;
/// Light of full coverage below which steps of 8-bit values are too coarse to measure by.
const FAINT: f64 = 0.03;
/// The largest deviation of repeats from their mean, as a part of full light, that dust and noise explain.
const SPREAD: f64 = 0.06;

/// Curves measured from a photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The curves, as they are written.
    pub file: CurveFile,
    /// Where the wedge lies in the photograph.
    pub found: Found,
    /// Root mean square of the deviations of equal patches from their mean, as a part of each ink's full light.
    pub spread: [f64; CHANNELS],
    /// Light of each ink at its brightest patch, 0..=1 of what the photograph holds.
    pub brightest: [f64; CHANNELS],
}

/// Why no curves can be measured.
#[derive(Clone, Debug, Error, Diagnostic, PartialEq)]
pub enum CalibrateError {
    /// The wedge is not found.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Chart(#[from] ChartError),
    /// An ink's patches are at the end of what the camera holds.
    #[error("the photograph is overexposed: the {ink} ink's patch of {coverage} coverage has lost its light")]
    #[diagnostic(
        code("vitrine::ink::overexposed"),
        help("expose half as long, or less; no patch may reach the end of its channel")
    )]
    Overexposed {
        /// The ink.
        ink: &'static str,
        /// The least coverage at which it happened.
        coverage: f64,
    },
    /// An ink hardly glows.
    #[error(
        "the {ink} ink is too dark in the photograph: its brightest patch holds {percent:.1} % of the light that it could"
    )]
    #[diagnostic(
        code("vitrine::ink::too_faint"),
        help("expose longer, and look whether this ink was printed at all")
    )]
    TooFaint {
        /// The ink.
        ink: &'static str,
        /// Light of its brightest patch above that of bare film.
        percent: f64,
    },
    /// Equal patches differ.
    #[error("equal patches of the {ink} ink differ by {percent:.0} % of its full light")]
    #[diagnostic(
        code("vitrine::ink::uneven"),
        help("look for glare, dust and shadows on the wedge, and photograph it again under even light")
    )]
    Uneven {
        /// The ink.
        ink: &'static str,
        /// Root mean square of the deviations.
        percent: f64,
    },
}

/// Measures the curves from the `light` of a photograph of the printed wedge, which `name` names in the file.
///
/// # Errors
/// When the wedge is not found in it, or is too bright, too dark or too uneven to be measured.
pub fn calibrate(light: &Picture, name: &str) -> Result<Calibration, CalibrateError> {
    let chart = wedge();
    let found = find_rather_than(light, &chart, (&films::chart(), CIRCLES))?;
    let readings = read_patches(light, &chart, &found);
    let mut samples = Vec::new();
    for ink in 0..CHANNELS {
        overexposed(&readings, ink)?;
        samples.extend(ink_samples(&readings, ink, chart.width_mm, chart.height_mm));
    }
    let groups = CHANNELS * COVERAGES.len();
    let flat = || Field::fit(&[], 0);
    let field = Field::fit(&samples, groups).or_else(flat).ok_or(ChartError::AnotherChart)?;
    let levels = field.levels(&samples, groups);
    let (mut spread, mut brightest) = ([0.0; CHANNELS], [0.0; CHANNELS]);
    let mut curves = Vec::new();
    for ink in 0..CHANNELS {
        let levels = &levels[ink * COVERAGES.len()..(ink + 1) * COVERAGES.len()];
        brightest[ink] = levels.iter().copied().fold(0.0, f64::max);
        if brightest[ink] < FAINT {
            return Err(CalibrateError::TooFaint { ink: NAMES[ink], percent: brightest[ink] * 100.0 });
        }
        spread[ink] = deviation(&samples, &field, levels, ink) / brightest[ink];
        if spread[ink] > SPREAD {
            return Err(CalibrateError::Uneven { ink: NAMES[ink], percent: spread[ink] * 100.0 });
        }
        curves.push(rising(levels));
    }
    let [red, green, blue] =
        <[InkCurve; CHANNELS]>::try_from(curves).map_err(|_| ChartError::AnotherChart)?;
    Ok(Calibration { file: CurveFile::new(name.to_owned(), [red, green, blue]), found, spread, brightest })
}

fn overexposed(readings: &[Reading], ink: usize) -> Result<(), CalibrateError> {
    let lost = readings
        .iter()
        .filter(|reading| reading.patch.coverages[ink] > 0.0 && reading.clipped[ink] > CLIPPED);
    match lost.map(|reading| f64::from(reading.patch.coverages[ink])).min_by(f64::total_cmp) {
        Some(coverage) => {
            Err(CalibrateError::Overexposed { ink: NAMES[ink], coverage: (coverage * 100.0).round() / 100.0 })
        }
        None => Ok(()),
    }
}

/// An ink's readings less what bare film gives in its channel.
fn ink_samples(readings: &[Reading], ink: usize, width_mm: f64, height_mm: f64) -> Vec<Sample> {
    let place = |reading: &Reading| {
        (2.0 * reading.patch.x_mm / width_mm - 1.0, 2.0 * reading.patch.y_mm / height_mm - 1.0)
    };
    let bare: Vec<(f64, f64, f64)> = readings
        .iter()
        .filter(|reading| reading.patch.coverages == [0.0; CHANNELS])
        .map(|reading| (place(reading).0, place(reading).1, reading.light[ink]))
        .collect();
    let [a, b, c] = plane(&bare).unwrap_or_default();
    let group = |coverage: f32| COVERAGES.iter().position(|&known| known as f32 == coverage);
    readings
        .iter()
        .filter_map(|reading| {
            let group = ink * COVERAGES.len() + group(reading.patch.coverages[ink])?;
            let (x, y) = place(reading);
            Some(Sample { x, y, group, layers: 0, light: reading.light[ink] - (a + b * x + c * y) })
        })
        .collect()
}

/// Root mean square of the samples' deviations from their levels.
fn deviation(samples: &[Sample], field: &Field, levels: &[f64], ink: usize) -> f64 {
    let first = ink * COVERAGES.len();
    let own = samples.iter().filter(|sample| (first..first + COVERAGES.len()).contains(&sample.group));
    let squares: Vec<f64> =
        own.map(|s| (s.light / field.at(s.x, s.y) - levels[s.group - first]).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// The rising curve nearest to `levels` up to their brightest (least squares: adjacent violators are pooled, Ayer et
/// al. 1955). Beyond the brightest the ink quenches itself, and more of it is of no use.
fn rising(levels: &[f64]) -> InkCurve {
    let peak = (0..levels.len()).max_by(|&a, &b| levels[a].total_cmp(&levels[b])).unwrap_or(0);
    // Sum and number of the levels in each pool.
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for &level in &levels[..=peak.min(levels.len() - 1)] {
        pools.push((level.max(0.0), 1));
        while let [.., (low, fewer), (high, more)] = pools[..]
            && low / fewer as f64 >= high / more as f64
        {
            pools.truncate(pools.len() - 2);
            pools.push((low + high, fewer + more));
        }
    }
    let brightest = pools.last().map_or(1.0, |&(sum, count)| sum / count as f64);
    let mut curve = InkCurve { coverage: vec![0.0], light: vec![0.0] };
    let mut next = 0;
    for (sum, count) in pools {
        let light = sum / count as f64 / brightest;
        if light > 0.0 {
            let within = &COVERAGES[next..next + count];
            let rounded = |value: f64| (value * 1e5).round() / 1e5;
            curve.coverage.push(rounded(within.iter().sum::<f64>() / count as f64));
            curve.light.push(rounded(light));
        }
        next += count;
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::photograph::{Camera, TILTED};

    /// What the inks of the tests glow, as a part of their most: with a peak before full coverage, with gain, straight.
    fn light(ink: usize, coverage: f64) -> f64 {
        match ink {
            0 => (coverage * (-1.25 * coverage).exp()) / (0.8 * (-1.0_f64).exp()),
            1 => coverage.powf(0.7),
            _ => coverage,
        }
    }

    fn glow(ink: usize, coverage: f32, [x, y]: [f64; 2]) -> f64 {
        let lamp = 1.0 - 0.002 * (x - 60.0) - 0.000_04 * (y - 40.0).powi(2);
        [0.4, 0.75, 0.7][ink] * light(ink, f64::from(coverage)) * lamp
    }

    fn camera(glow: &dyn Fn(usize, f32, [f64; 2]) -> f64) -> Camera<'_> {
        Camera {
            width: 1200,
            height: 960,
            corners: TILTED,
            glow,
            ambient: 0.012,
            vignetting: 0.35,
            noise: 0.012,
            blur: 2,
        }
    }

    #[test]
    fn curves_are_recovered_from_a_tilted_dim_noisy_photograph() {
        let calibration = calibrate(&camera(&glow).take(&wedge()).decoded(), "photo.jpg").unwrap();
        let curves = [&calibration.file.red, &calibration.file.green, &calibration.file.blue];
        for (ink, curve) in curves.into_iter().enumerate() {
            for (coverage, found) in curve.coverage.iter().zip(&curve.light) {
                let wanted = light(ink, *coverage);
                assert!(
                    (found - wanted).abs() < 0.02,
                    "{}: {coverage} gives {found}, {wanted} wanted",
                    NAMES[ink]
                );
            }
        }
        let fullest = *calibration.file.red.coverage.last().unwrap();
        assert!((0.7..=0.9).contains(&fullest), "{fullest}");
        assert!(calibration.spread.iter().all(|&spread| spread < 0.02), "{:?}", calibration.spread);
        let text = calibration.file.to_toml().unwrap();
        assert!(text.contains("measured_from = \"photo.jpg\""), "{text}");
    }

    #[test]
    fn bright_dark_and_glaring_photographs_are_refused() {
        let bright = |ink: usize, coverage: f32, at: [f64; 2]| 2.0 * glow(ink, coverage, at);
        let told = |glow: &dyn Fn(usize, f32, [f64; 2]) -> f64| {
            calibrate(&Camera { noise: 0.003, blur: 1, ..camera(glow) }.take(&wedge()).decoded(), "x")
                .unwrap_err()
        };
        assert!(matches!(told(&bright), CalibrateError::Overexposed { ink: "green", .. }));
        let no_blue =
            |ink: usize, coverage: f32, at: [f64; 2]| if ink == 2 { 0.0 } else { glow(ink, coverage, at) };
        assert!(matches!(told(&no_blue), CalibrateError::TooFaint { ink: "blue", .. }));
        let glare = |ink: usize, coverage: f32, at: [f64; 2]| {
            glow(ink, coverage, at) * if (at[0] - 70.0).hypot(at[1] - 60.0) < 12.0 { 0.3 } else { 1.0 }
        };
        assert!(matches!(told(&glare), CalibrateError::Uneven { .. }));
        let cut = Camera { corners: TILTED.map(|[x, y]| [x, y + 300.0]), ..camera(&glow) };
        assert_eq!(
            calibrate(&cut.take(&wedge()).decoded(), "x").unwrap_err(),
            CalibrateError::Chart(ChartError::CutOff { marks: 2 })
        );
    }

    #[test]
    fn levels_that_fall_by_noise_are_pooled_and_what_follows_the_peak_is_left_out() {
        let mut levels = COVERAGES.map(|coverage| coverage * 0.5);
        levels[4] = levels[3] * 0.9;
        levels[12] = 0.2;
        let curve = rising(&levels);
        assert!(curve.light.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!((curve.coverage.last(), curve.light.last()), (Some(&0.9), Some(&1.0)));
        assert!(curve.coverage.contains(&0.175), "{curve:?}");
    }
}
