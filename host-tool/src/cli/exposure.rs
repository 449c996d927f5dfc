//! What films have received and eyes may receive, by the firmware's own formulae.

use serde_json::{Value, json};
use vitrine_exhibit::Snapshot;
use vitrine_exhibit::exposure::{FILM_TRANSMISSION_PPM, Opening, at_eye, on_film, permitted_seconds};
use vitrine_exhibit::plan::Plan;

/// The eye's distance and the window's transmission (optical density 2) for which the design limit is meant.
const EYE_DISTANCE_MM: u32 = 200;
const WINDOW_PPM: u32 = 10_000;

/// What reaches films and eyes.
pub(super) struct Exposure {
    /// Life's dose of each film in kJ/m2, the top one first.
    films_kj_m2: Vec<f64>,
    /// Before the window, in mW/m2.
    eye_mw_m2: f64,
    /// How long an unprotected eye may stay there.
    permitted_s: Option<u64>,
}

impl Exposure {
    /// Of a stack as its plan describes it, films of 0.82 at 365 nm.
    pub(super) fn of(snapshot: &Snapshot, plan: &Plan) -> Self {
        let volume = &plan.volume;
        let dose = |film| on_film(snapshot.life_dose, film, volume.films, FILM_TRANSMISSION_PPM);
        let height_um =
            u64::from(volume.width_um) * u64::from(volume.height_px) / u64::from(volume.width_px.max(1));
        let area_mm2 = u64::from(volume.width_um) * height_um / 1_000_000;
        let opening = Opening {
            area_mm2: u32::try_from(area_mm2).unwrap_or(u32::MAX),
            window_ppm: WINDOW_PPM,
            distance_mm: EYE_DISTANCE_MM,
        };
        let eye = at_eye(snapshot.irradiance, opening);
        Self {
            films_kj_m2: (0..volume.films).map(|film| dose(film).0 as f64 / 1e9).collect(),
            eye_mw_m2: eye.0 as f64 / 1e3,
            permitted_s: permitted_seconds(eye),
        }
    }

    /// As lines to read.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let stay = match self.permitted_s {
            Some(seconds) if seconds < 8 * 3_600 => format!("an unprotected eye may stay {seconds} s"),
            _ => "an unprotected eye may stay all day".to_owned(),
        };
        let films = self.films_kj_m2.iter().map(|dose| format!("{dose:.1}")).collect::<Vec<_>>();
        vec![
            (
                "at the eye",
                format!("{:.2} mW/m2 at 0.2 m behind the window, of 35 at most: {stay}", self.eye_mw_m2),
            ),
            ("dose, films", format!("{} kJ/m2, the top film first", films.join(" "))),
        ]
    }

    /// The same with units in the keys.
    pub(super) fn as_json(&self) -> Value {
        json!({
            "films_life_dose_j_m2": self.films_kj_m2.iter().map(|dose| dose * 1_000.0).collect::<Vec<_>>(),
            "eye_w_m2": self.eye_mw_m2 / 1_000.0,
            "eye_permitted_s": self.permitted_s,
        })
    }
}
