//! What films and spacers are made of.
//!
//! What a film lets through depends on what lies against it. In air both its faces reflect, at normal incidence
//! ((n - 1) / (n + 1))^2 each (Fresnel); a spacer that is bonded to it, of nearly the same index, hardly leaves a
//! reflection. A polyester film's 0.90 in air is nearly all reflection: 0.89 for n = 1.64. So a bonded stack of the
//! same films is much clearer, and [`Spacer::on_film`] reckons that: what the film absorbs is its transmittance in air
//! divided by that of its two faces, at most 1, and is multiplied by that of its two faces against the spacer.
//!
//! These are starting points. `vitrine experiment films --fit` measures the films at hand.

/// A film to print on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Its name in exhibit.toml.
    pub name: &'static str,
    /// Thickness of one film in mm.
    pub film_mm: f64,
    /// Refractive index.
    pub index: f64,
    /// Part of the UV (365 nm) that one film lets through.
    pub tau_uv: f64,
    /// Part of the visible light that one film lets through.
    pub tau_visible: f64,
    /// Whether the transmittances were measured with air on both sides.
    pub in_air: bool,
    /// Where the numbers are from.
    pub source: &'static str,
}

/// What keeps films apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacer {
    /// Its name in exhibit.toml.
    pub name: &'static str,
    /// Refractive index.
    pub index: f64,
    /// Whether it is bonded to the films, without air between.
    pub bonded: bool,
    /// Part of the UV (365 nm) that passes 1 mm of it, apart from its faces.
    pub uv_per_mm: f64,
    /// Part of the visible light that passes 1 mm of it, apart from its faces.
    pub visible_per_mm: f64,
    /// Where the numbers are from.
    pub source: &'static str,
}

const HIRAYAMA: &str = "Hirayama et al. 2017, Scientific Reports 7:46511";
const ACRYLIC: &str = "index 1.49; visible: less than 0.5 % absorbed per inch (Acrylite's maker); UV: an ultraviolet-transmitting \
                       grade, by its reflection alone: ordinary grades absorb up to 30 % of it over a few mm";
const GLASS: &str = "soda-lime glass, index 1.525 (Rubin 1985, Solar Energy Materials 12:275); by its reflection alone: what it \
                     absorbs at 365 nm varies with its iron";

/// The films that are known.
pub const FILMS: [Film; 2] = [
    Film {
        name: "polyester",
        film_mm: 0.1,
        index: 1.64,
        tau_uv: 0.82,
        tau_visible: 0.90,
        in_air: true,
        source: "Hirayama et al. 2017, Scientific Reports 7:46511: 0.1 mm; index 1.636 at 633 nm (Filmetrics)",
    },
    Film {
        name: "pdms",
        film_mm: 0.1,
        index: 1.41,
        tau_uv: 0.99,
        tau_visible: 0.99,
        in_air: false,
        source: HIRAYAMA,
    },
];

/// The spacers that are known.
pub const SPACERS: [Spacer; 6] = [
    Spacer {
        name: "air",
        index: 1.0,
        bonded: false,
        uv_per_mm: 1.0,
        visible_per_mm: 1.0,
        source: "a frame around the picture",
    },
    Spacer {
        name: "acrylic",
        index: 1.49,
        bonded: false,
        uv_per_mm: 1.0,
        visible_per_mm: 0.9998,
        source: ACRYLIC,
    },
    Spacer {
        name: "bonded-acrylic",
        index: 1.49,
        bonded: true,
        uv_per_mm: 1.0,
        visible_per_mm: 0.9998,
        source: ACRYLIC,
    },
    Spacer { name: "glass", index: 1.525, bonded: false, uv_per_mm: 1.0, visible_per_mm: 1.0, source: GLASS },
    Spacer {
        name: "bonded-glass",
        index: 1.525,
        bonded: true,
        uv_per_mm: 1.0,
        visible_per_mm: 1.0,
        source: GLASS,
    },
    Spacer {
        name: "silicone",
        index: 1.41,
        bonded: true,
        uv_per_mm: 1.0,
        visible_per_mm: 1.0,
        source: "cast PDMS, index 1.41 (Sylgard 184); clear at 365 nm within what a film's 0.99 says (Hirayama et al. 2017)",
    },
];

/// What one film and one spacer let through at normal incidence, in the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Part of the UV that the film lets through.
    pub tau_uv: f64,
    /// Part of the visible light that the film lets through.
    pub tau_visible: f64,
    /// Part of the UV that the spacer lets through.
    pub spacer_tau_uv: f64,
    /// Part of the visible light that the spacer lets through.
    pub spacer_tau_visible: f64,
}

impl Spacer {
    /// What `film` and `spacer_mm` of this spacer let through.
    pub fn on_film(&self, film: &Film, spacer_mm: f64) -> Layer {
        let film_tau = |tau: f64| {
            if !(self.bonded && film.in_air) {
                return tau;
            }
            (tau / two_faces(1.0, film.index)).min(1.0) * two_faces(self.index, film.index)
        };
        // Between bonded films there is no air, and air has no faces.
        let faces = if self.bonded { 1.0 } else { two_faces(1.0, self.index) };
        Layer {
            tau_uv: rounded(film_tau(film.tau_uv)),
            tau_visible: rounded(film_tau(film.tau_visible)),
            spacer_tau_uv: rounded(faces * self.uv_per_mm.powf(spacer_mm)),
            spacer_tau_visible: rounded(faces * self.visible_per_mm.powf(spacer_mm)),
        }
    }
}

/// What both faces of a sheet of index `inside` let through that lies in a medium of index `outside`.
fn two_faces(outside: f64, inside: f64) -> f64 {
    let reflected = ((inside - outside) / (inside + outside)).powi(2);
    (1.0 - reflected).powi(2)
}

/// More digits than these are not known.
fn rounded(tau: f64) -> f64 {
    (tau * 1e4).round() / 1e4
}

/// The film of this name.
pub fn film(name: &str) -> Option<&'static Film> {
    FILMS.iter().find(|film| film.name == name)
}

/// The spacer of this name.
pub fn spacer(name: &str) -> Option<&'static Spacer> {
    SPACERS.iter().find(|spacer| spacer.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_apart_in_air_are_as_the_paper_measured_them() {
        let layer = spacer("air").unwrap().on_film(film("polyester").unwrap(), 0.5);
        assert_eq!(
            layer,
            Layer { tau_uv: 0.82, tau_visible: 0.90, spacer_tau_uv: 1.0, spacer_tau_visible: 1.0 }
        );
    }

    #[test]
    fn faces_in_air_reflect_and_bonded_ones_hardly_do() {
        let polyester = film("polyester").unwrap();
        let loose = spacer("acrylic").unwrap().on_film(polyester, 1.0);
        // Acrylic's makers say 92 %.
        assert!((loose.spacer_tau_visible - 0.92).abs() < 0.005, "{loose:?}");
        assert_eq!((loose.tau_uv, loose.tau_visible), (0.82, 0.90));
        let bonded = spacer("bonded-acrylic").unwrap().on_film(polyester, 1.0);
        // 0.82 / 0.8859 x 0.9954.
        assert!(
            (bonded.tau_uv - 0.9214).abs() < 5e-4 && (bonded.tau_visible - 0.9954).abs() < 5e-4,
            "{bonded:?}"
        );
        assert!(bonded.spacer_tau_visible > 0.999);
        let pdms = spacer("silicone").unwrap().on_film(film("pdms").unwrap(), 0.5);
        assert_eq!((pdms.tau_uv, pdms.spacer_tau_uv), (0.99, 1.0));
    }
}
