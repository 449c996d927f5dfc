//! How much films dim what lies behind them: Fig. 5 of Hirayama et al. 2017.
//!
//! Circles in the three inks are printed on one film; blank films lie on one side of it, from none to 25. Between lamp
//! and circles, n films leave tau_uv^n of the ultraviolet; between circles and viewer, tau_visible^n of the light;
//! where lamp and viewer are on the same side as the films, both.
//!
//! On the printed chart the circles stand in columns. Strips of film, each one column shorter than the one below, are
//! laid over the middle band so that column n lies behind n of them; the bands above and below stay bare and tell how
//! the chart is lit.

mod chart;
mod drawing;
mod fit;

pub use chart::{chart, strip_mm};
pub use drawing::draw;
pub use fit::{FilmFit, FitError, fit};

use serde::Serialize;

/// The most films that the circles lie behind.
pub const MOST_FILMS: usize = 25;

/// Where the blank films lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Between lamp and circles; the viewer is on the other side.
    Lamp,
    /// Between circles and viewer; the lamp is on the other side.
    Viewer,
    /// Between circles on one side, and lamp and viewer on the other.
    Both,
}

/// All sides.
pub const SIDES: [Side; 3] = [Side::Lamp, Side::Viewer, Side::Both];

/// What one film lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmittance {
    /// Of the UV, 0..=1.
    pub tau_uv: f64,
    /// Of the visible light, 0..=1.
    pub tau_visible: f64,
}

impl Transmittance {
    /// What one film on this side leaves of the circles' light.
    pub fn of(self, side: Side) -> f64 {
        match side {
            Side::Lamp => self.tau_uv,
            Side::Viewer => self.tau_visible,
            Side::Both => self.tau_uv * self.tau_visible,
        }
    }

    /// What `films` films on this side leave of the circles' light.
    pub fn behind(self, films: usize, side: Side) -> f64 {
        self.of(side).powi(films as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_films_leave_what_the_paper_says() {
        let films = Transmittance { tau_uv: 0.82, tau_visible: 0.90 };
        assert!((films.behind(1, Side::Lamp) - 0.82).abs() < 1e-12);
        assert!((films.behind(20, Side::Lamp) - 0.02).abs() < 0.002);
        assert!(films.behind(25, Side::Lamp) < 0.01);
        assert!((films.behind(2, Side::Both) - 0.82 * 0.82 * 0.81).abs() < 1e-12);
        assert_eq!(films.behind(0, Side::Viewer), 1.0);
    }
}
