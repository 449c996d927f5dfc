//! What films let through, from photographs of the chart with strips of them.
//!
//! What film without ink gives is taken off, and an uneven light is divided out (see [`crate::chart::Field`]). Ink i
//! behind n films then gives A_i tau^n, with A_i from its bare circles; tau is the one that fits the covered band with
//! the least squares, for each ink by itself and for all together.

use miette::Diagnostic;
use thiserror::Error;

use super::chart::{COVERED, chart, column_of};
use crate::chart::{ChartError, Field, Found, Reading, Sample, find_rather_than, plane, read_patches};
use crate::ink::wedge;
use crate::picture::Picture;
use crate::volume::CHANNELS;

/// What to do with a photograph of the other chart.
const WEDGE: &str = "this is the wedge that tells of inks: measure it with `vitrine calibrate`";
/// Light of bare circles below which there is too little to measure.
const FAINT: f64 = 0.03;
/// The part of a circle that may be at the channel's end.
const CLIPPED: f64 = 0.02;
/// The largest deviation from the fit, as a part of a bare circle's light, that noise explains.
const SPREAD: f64 = 0.06;
/// Between these lies what a film lets through.
const RANGE: (f64, f64) = (0.2, 1.05);
/// Steps of the search, each of which leaves 0.618 of the range.
const STEPS: usize = 40;

/// What one film leaves of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmFit {
    /// From all inks together.
    pub tau: f64,
    /// From each ink by itself: red, green, blue.
    pub tau_by_ink: [f64; CHANNELS],
    /// Root mean square of the deviations from the fit, as a part of a bare circle's light.
    pub spread: f64,
    /// What was measured of each ink behind 0 (which is 1) to 25 films, as a part of its bare light.
    pub measured: [Vec<f64>; CHANNELS],
    /// Where the chart lies in the photograph.
    pub found: Found,
}

/// Why nothing can be fitted.
#[derive(Clone, Debug, Error, Diagnostic, PartialEq)]
pub enum FitError {
    /// The chart is not found.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Chart(#[from] ChartError),
    /// Bare circles are at the end of what the camera holds.
    #[error("the photograph is overexposed: bare circles of the {ink} ink have lost their light")]
    #[diagnostic(code("vitrine::experiment::overexposed"), help("expose half as long, or less"))]
    Overexposed {
        /// The ink.
        ink: &'static str,
    },
    /// Bare circles hardly glow.
    #[error("bare circles of the {ink} ink hold {percent:.1} % of the light that the photograph could")]
    #[diagnostic(
        code("vitrine::experiment::too_faint"),
        help("expose longer, and look whether this ink was printed at all")
    )]
    TooFaint {
        /// The ink.
        ink: &'static str,
        /// Light of a bare circle, in percent.
        percent: f64,
    },
    /// The covered band does not fall off as films let it.
    #[error("the covered circles differ from any film's by {percent:.0} % of a bare one's light")]
    #[diagnostic(
        code("vitrine::experiment::no_staircase"),
        help(
            "lay the strips so that column n of the middle band lies behind n films, flat and free of glare"
        )
    )]
    NoStaircase {
        /// Root mean square of the deviations, in percent.
        percent: f64,
    },
}

/// Fits what one film leaves of the light to the `light` of a photograph of the chart with its strips.
///
/// # Errors
/// When the chart is not found, or its circles are too bright, too dark, or fall off otherwise than films let them.
pub fn fit(light: &Picture) -> Result<FilmFit, FitError> {
    const NAMES: [&str; CHANNELS] = ["red", "green", "blue"];
    let chart = chart();
    let found = find_rather_than(light, &chart, (&wedge(), WEDGE))?;
    let readings = read_patches(light, &chart, &found);
    let place = |reading: &Reading| {
        (2.0 * reading.patch.x_mm / chart.width_mm - 1.0, 2.0 * reading.patch.y_mm / chart.height_mm - 1.0)
    };
    let band = readings.len() / 3;
    let covered = COVERED * band..(COVERED + 1) * band;
    let mut samples = Vec::new();
    for (ink, name) in NAMES.iter().enumerate() {
        let inked = |reading: &Reading| reading.patch.coverages[ink] > 0.0;
        if readings.iter().any(|reading| inked(reading) && reading.clipped[ink] > CLIPPED) {
            return Err(FitError::Overexposed { ink: name });
        }
        let blank: Vec<_> = readings
            .iter()
            .filter(|reading| reading.patch.coverages == [0.0; CHANNELS])
            .map(|reading| (place(reading).0, place(reading).1, reading.light[ink]))
            .collect();
        let [a, b, c] = plane(&blank).unwrap_or_default();
        for (index, reading) in readings.iter().enumerate().filter(|(_, reading)| inked(reading)) {
            let (x, y) = place(reading);
            let layers = if covered.contains(&index) { column_of(&reading.patch) } else { 0 };
            samples.push(Sample {
                x,
                y,
                group: ink,
                layers,
                light: reading.light[ink] - (a + b * x + c * y),
            });
        }
    }
    let field = Field::fit(&samples, CHANNELS).ok_or(ChartError::AnotherChart)?;
    let bare = field.levels(&samples, CHANNELS);
    for (ink, name) in NAMES.iter().enumerate() {
        if bare[ink] < FAINT {
            return Err(FitError::TooFaint { ink: name, percent: bare[ink] * 100.0 });
        }
    }
    let part = |s: &Sample| (s.group, s.layers, s.light / field.at(s.x, s.y) / bare[s.group]);
    let parts: Vec<(usize, usize, f64)> =
        samples.iter().filter(|sample| sample.layers > 0).map(part).collect();
    let of_ink = |ink: usize| move |part: &&(usize, usize, f64)| part.0 == ink;
    let tau_by_ink = [0, 1, 2].map(|ink| nearest_tau(parts.iter().filter(of_ink(ink))));
    let tau = nearest_tau(parts.iter());
    let spread = (squares(parts.iter(), tau) / parts.len() as f64).sqrt();
    if spread > SPREAD {
        return Err(FitError::NoStaircase { percent: spread * 100.0 });
    }
    let measured = [0, 1, 2]
        .map(|ink| std::iter::once(1.0).chain(parts.iter().filter(of_ink(ink)).map(|part| part.2)).collect());
    Ok(FilmFit { tau, tau_by_ink, spread, measured, found })
}

/// The sum of the squared deviations from `tau` to the power of the films.
fn squares<'a>(parts: impl Iterator<Item = &'a (usize, usize, f64)>, tau: f64) -> f64 {
    parts.map(|&(_, films, part)| (part - tau.powi(films as i32)).powi(2)).sum()
}

/// The tau with the least squares, by golden sections: there is one least, for measured parts fall.
fn nearest_tau<'a>(parts: impl Iterator<Item = &'a (usize, usize, f64)> + Clone) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = RANGE;
    for _ in 0..STEPS {
        let step = golden * (high - low);
        if squares(parts.clone(), high - step) < squares(parts.clone(), low + step) {
            high = low + step;
        } else {
            low = high - step;
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::photograph::Camera;
    use crate::experiment::films::{MOST_FILMS, strip_mm};

    const CORNERS: [[f64; 2]; 4] = [[70.0, 90.0], [1150.0, 60.0], [1120.0, 700.0], [110.0, 730.0]];

    /// The inks behind as many strips as lie over them, under a lamp to the left.
    fn glow(tau: [f64; 3]) -> impl Fn(usize, f32, [f64; 2]) -> f64 {
        move |ink, coverage, [x, y]| {
            let over = |number: &usize| {
                let [left, top, width, height] = strip_mm(*number);
                (left..left + width).contains(&x) && (top..top + height).contains(&y)
            };
            let films = (1..=MOST_FILMS).filter(over).count();
            let lamp = 1.0 - 0.0015 * x - 0.000_03 * (y - 50.0).powi(2);
            [0.4, 0.8, 0.8][ink] * f64::from(coverage) * lamp * tau[ink].powi(films as i32)
        }
    }

    fn photograph(glow: &dyn Fn(usize, f32, [f64; 2]) -> f64) -> Picture {
        Camera {
            width: 1220,
            height: 800,
            corners: CORNERS,
            glow,
            ambient: 0.01,
            vignetting: 0.3,
            noise: 0.01,
            blur: 1,
        }
        .take(&chart())
        .decoded()
    }

    #[test]
    fn what_films_let_through_is_recovered_within_a_hundredth() {
        for tau in [[0.82; 3], [0.9, 0.91, 0.89]] {
            let fitted = fit(&photograph(&glow(tau))).unwrap();
            for (found, wanted) in fitted.tau_by_ink.iter().zip(tau) {
                assert!((found / wanted - 1.0).abs() < 0.01, "{found} for {wanted}");
            }
            assert!((fitted.tau / (tau.iter().sum::<f64>() / 3.0) - 1.0).abs() < 0.01, "{}", fitted.tau);
            assert!(fitted.spread < 0.03 && fitted.measured[2].len() == 26, "{}", fitted.spread);
            assert!((fitted.measured[1][3] - tau[1].powi(3)).abs() < 0.03);
        }
    }

    #[test]
    fn charts_without_strips_in_order_are_refused() {
        let bare = glow([1.0; 3]);
        let random = |ink: usize, coverage: f32, at: [f64; 2]| {
            let covered = (39.0..65.0).contains(&at[1]) && ((at[0] / 17.0) as usize).is_multiple_of(2);
            bare(ink, coverage, at) * if covered { 0.3 } else { 1.0 }
        };
        assert!(matches!(fit(&photograph(&random)), Err(FitError::NoStaircase { .. })));
        let bright = |ink: usize, coverage: f32, at: [f64; 2]| 2.0 * bare(ink, coverage, at);
        assert!(matches!(fit(&photograph(&bright)), Err(FitError::Overexposed { ink: "green" })));
        assert!(matches!(fit(&Picture::new(400, 300)), Err(FitError::Chart(ChartError::TooDark { .. }))));
    }
}
