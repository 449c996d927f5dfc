//! What films and eyes receive, by the formulae of the safety analysis, in integers.
//!
//! ```text
//! H_film k = tau^k H_top + tau^(N-1-k) H_bottom
//! E_eye    = tau_window * A / (pi r^2) * (E_top + E_bottom)      diffuse, nothing absorbed: the worst case
//! t_max    = 10 kJ/m2 / E_eye
//! ```
//!
//! The temperature and age of a lamp would only lower its irradiance: both factors count as 1.

use crate::units::{Dose, Irradiance, PerLamp};

/// Ultraviolet transmission of the paper's film at 365 nm, in millionths.
pub const FILM_TRANSMISSION_PPM: u32 = 820_000;
/// The dose that an unprotected eye may receive in 8 hours, 315 to 400 nm (ICNIRP): 10 kJ/m².
pub const EYE_DOSE: Dose = Dose(10_000_000_000);

const MILLION: u64 = 1_000_000;
/// Pi times a million.
const PI_PPM: u64 = 3_141_593;

/// The opening through which a viewer looks at the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opening {
    /// Area of the lit stack in mm².
    pub area_mm2: u32,
    /// Transmission of the window at 365 nm, in millionths; optical density 2 is 10,000.
    pub window_ppm: u32,
    /// Distance of the eye in mm.
    pub distance_mm: u32,
}

/// An irradiance too small for [`Irradiance`], in µW/m².
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EyeIrradiance(pub u64);

/// The dose on a film, 0 being the top one, of what both lamps have given on their nearest films; rounded up.
///
/// A film that the stack does not have receives what the last one does.
pub fn on_film(given: PerLamp<Dose>, film: u16, films: u16, transmission_ppm: u32) -> Dose {
    let above = film.min(films.saturating_sub(1));
    let below = films.saturating_sub(1) - above;
    weakened(given.top, above, transmission_ppm).plus(weakened(given.bottom, below, transmission_ppm))
}

/// What reaches an eye before the window, if the stack scattered all of the lamps' ultraviolet forward; rounded up.
/// The nearest possible eye is 1 mm away.
pub fn at_eye(lamps: PerLamp<Irradiance>, opening: Opening) -> EyeIrradiance {
    // mW/m² times mm² times millionths, over mm²: stays below 2^33 * 2^32 * 2^20, so in 128 bits.
    let sum = u128::from(lamps.top.0) + u128::from(lamps.bottom.0);
    let through = sum * 1_000 * u128::from(opening.area_mm2) * u128::from(opening.window_ppm.min(1_000_000));
    let distance = u128::from(opening.distance_mm.max(1));
    let spread = u128::from(PI_PPM) * distance * distance;
    EyeIrradiance(u64::try_from(through.div_ceil(spread)).unwrap_or(u64::MAX))
}

/// The seconds for which an unprotected eye may stay in an irradiance; none where it may stay for ever.
pub const fn permitted_seconds(irradiance: EyeIrradiance) -> Option<u64> {
    // A dose is counted in µJ/m², so that µW/m² divide it into seconds.
    EYE_DOSE.0.checked_div(irradiance.0)
}

/// A dose behind some films, rounded up at each: the error is below a µJ/m² a film.
fn weakened(dose: Dose, films: u16, transmission_ppm: u32) -> Dose {
    let ppm = u64::from(transmission_ppm).min(MILLION);
    let mut left = dose.0;
    for _ in 0..films {
        if left == 0 {
            break;
        }
        let (whole, rest) = (left / MILLION, left % MILLION);
        left = whole * ppm + (rest * ppm).div_ceil(MILLION);
    }
    Dose(left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn films_receive_what_the_formula_says(
            top in 0_u64..10_000_000_000_000,
            bottom in 0_u64..10_000_000_000_000,
            films in 1_u16..60,
            film in 0_u16..60,
        ) {
            let film = film % films;
            let exact = 0.82_f64.powi(i32::from(film)) * top as f64
                + 0.82_f64.powi(i32::from(films - 1 - film)) * bottom as f64;
            let ours = on_film(PerLamp::new(Dose(top), Dose(bottom)), film, films, FILM_TRANSMISSION_PPM).0 as f64;
            prop_assert!(ours >= exact - exact * 1e-9 && ours <= exact + 120.0 + exact * 1e-9, "{ours} {exact}");
        }

        #[test]
        fn nothing_overflows(
            top: u32, bottom: u32, area_mm2: u32, window_ppm: u32, distance_mm: u32, dose: u64, film: u16, films: u16
        ) {
            let opening = Opening { area_mm2, window_ppm, distance_mm };
            let eye = at_eye(PerLamp::new(Irradiance(top), Irradiance(bottom)), opening);
            prop_assert_eq!(permitted_seconds(eye).is_none(), eye.0 == 0);
            let given = PerLamp::new(Dose(dose), Dose(dose));
            prop_assert!(on_film(given, film, films, window_ppm) >= on_film(given, film, films, 0));
        }
    }

    /// Both lamps at 10 W/m² behind a window of optical density 2: at 0.2 m within the public's 0.035 W/m².
    #[test]
    fn the_reference_exhibit_keeps_a_tenth_of_the_limit() {
        let opening = Opening { area_mm2: 35 * 35, window_ppm: 10_000, distance_mm: 200 };
        let eye = at_eye(PerLamp::new(Irradiance(10_000), Irradiance(10_000)), opening);
        assert_eq!(eye, EyeIrradiance(1_950));
        assert!(eye.0 < 35_000);
        assert!(permitted_seconds(eye).unwrap() > 8 * 3_600 * 100);
    }
}
