//! The film stack: how many films, how large, how far apart, and what they absorb.

use std::ops::Range;

use thiserror::Error;

/// The most values a volume may have, per colour, that is held in memory: 4 GiB for its three colours.
pub const MOST_VOXELS_IN_MEMORY: usize = 360_000_000;

/// A film stack; `Default` is the paper's (20 films of 35 mm, 512 x 512 pixels, 0.6 mm apart).
///
/// Film 0 is the top one, nearest the viewer. Pixels are square.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Number of films, 1..=1000.
    pub films: usize,
    /// Pixels of a film from left to right, 2..=65,536.
    pub width_px: usize,
    /// Pixels of a film from top to bottom, 2..=65,536.
    pub height_px: usize,
    /// Width of the picture on a film in mm.
    pub width_mm: f64,
    /// Thickness of one film in mm.
    pub film_mm: f64,
    /// Thickness of the spacer between two films in mm.
    pub spacer_mm: f64,
    /// Refractive index between the outer faces of the stack; 1.0 means air between the films.
    pub index: f64,
    /// Part of the UV that one film lets through.
    pub tau_uv: f64,
    /// Part of the visible light that one film lets through at normal incidence.
    pub tau_visible: f64,
    /// Part of the UV that one spacer lets through.
    pub spacer_tau_uv: f64,
    /// Part of the visible light that one spacer lets through at normal incidence.
    pub spacer_tau_visible: f64,
    /// Where these rows lie, if they are a strip of larger films.
    pub strip: Option<StripPlace>,
    /// How far the light of one print dot spreads in its film: the standard deviation along each axis in µm.
    pub blur_um: f64,
    /// Light of the red, green and blue ink where they glow alike; 1 each where separations balance them.
    pub ink_yields: [f64; 3],
    /// Absorbance of full ink for the lamps' ultraviolet, by the natural logarithm: where it is high, more ink adds
    /// ever less light. 0 means that light is in proportion to ink.
    pub ink_absorbance: f64,
}

/// Where some rows of larger films lie.
///
/// A strip may lean with the rays of who looks at it: then its rows lie further down or up, film by film, by whole rows.
/// Rows beyond the films' and the picture's edges do not exist: there is no ink in them, and nobody looks at them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripPlace {
    /// Rows of the whole films.
    pub whole_px: usize,
    /// The row of the whole picture that is this strip's first; negative above its top edge.
    pub first_row: i64,
    /// How many rows further down than the picture's a film's rows begin, for each mm above the middle of the stack.
    pub rows_down_per_mm: f64,
}

/// What is wrong with the description of a stack.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{field} is {value}, but must be {allowed}")]
pub struct StackError {
    /// The field, by its name in exhibit.toml.
    pub field: &'static str,
    /// The value it has.
    pub value: f64,
    /// The values it may have, in words.
    pub allowed: &'static str,
}

impl Default for Stack {
    fn default() -> Self {
        Self {
            films: 20,
            width_px: 512,
            height_px: 512,
            width_mm: 35.0,
            film_mm: 0.1,
            spacer_mm: 0.5,
            index: 1.0,
            tau_uv: 0.82,
            tau_visible: 0.90,
            spacer_tau_uv: 1.0,
            spacer_tau_visible: 1.0,
            strip: None,
            blur_um: 0.0,
            ink_yields: [1.0; 3],
            ink_absorbance: 0.0,
        }
    }
}

impl Stack {
    /// Returns the stack if every field is within its range.
    ///
    /// # Errors
    /// Names the first field that is not.
    pub fn checked(self) -> Result<Self, StackError> {
        let fail = |field, value, allowed| Err(StackError { field, value, allowed });
        if !(1..=1000).contains(&self.films) {
            return fail("films", self.films as f64, "1 to 1000");
        }
        for size in [self.width_px, self.height_px] {
            if !(2..=65_536).contains(&size) {
                return fail("pixels", size as f64, "2 to 65536 in each direction");
            }
        }
        if !(self.width_mm.is_finite() && self.width_mm > 0.0) {
            return fail("width_mm", self.width_mm, "greater than 0");
        }
        if !(self.film_mm.is_finite() && self.film_mm > 0.0) {
            return fail("film_mm", self.film_mm, "greater than 0");
        }
        if !(self.spacer_mm.is_finite() && self.spacer_mm >= 0.0) {
            return fail("spacer_mm", self.spacer_mm, "0 or greater");
        }
        if !(1.0..=3.0).contains(&self.index) {
            return fail("index", self.index, "1.0 (air) to 3.0");
        }
        for (field, value) in [
            ("tau_uv", self.tau_uv),
            ("tau_visible", self.tau_visible),
            ("spacer_tau_uv", self.spacer_tau_uv),
            ("spacer_tau_visible", self.spacer_tau_visible),
        ] {
            if !(value > 0.0 && value <= 1.0) {
                return fail(field, value, "greater than 0 and at most 1");
            }
        }
        if !(0.0..=1000.0).contains(&self.blur_um) {
            return fail("blur_um", self.blur_um, "0 to 1000");
        }
        for part in self.ink_yields {
            if !(0.01..=1.0).contains(&part) {
                return fail("ink_yields", part, "0.01 to 1 for each ink");
            }
        }
        if !(0.0..=10.0).contains(&self.ink_absorbance) {
            return fail("ink_absorbance", self.ink_absorbance, "0 to 10");
        }
        Ok(self)
    }

    /// Distance from film to film in mm.
    pub fn film_pitch_mm(&self) -> f64 {
        self.film_mm + self.spacer_mm
    }

    /// Height of film `film` above the middle of the stack in mm, toward the viewer.
    pub fn film_z_mm(&self, film: usize) -> f64 {
        ((self.films as f64 - 1.0) / 2.0 - film as f64) * self.film_pitch_mm()
    }

    /// The row of the whole films that is the first of film `film`; negative above their top edge.
    pub fn first_row(&self, film: usize) -> i64 {
        let first = |strip: &StripPlace| {
            strip.first_row + (strip.rows_down_per_mm * self.film_z_mm(film)).round() as i64
        };
        self.strip.as_ref().map_or(0, first)
    }

    /// The rows of film `film`, by those of the whole films.
    pub fn rows(&self, film: usize) -> Range<i64> {
        let first = self.first_row(film);
        first..first + self.height_px as i64
    }

    /// The row of the whole picture that is the first of the picture on the middle plane.
    pub fn first_picture_row(&self) -> i64 {
        self.strip.map_or(0, |strip| strip.first_row)
    }

    /// Columns and rows of the whole films.
    pub fn whole_size(&self) -> (usize, usize) {
        (self.width_px, self.strip.map_or(self.height_px, |strip| strip.whole_px))
    }

    /// How far the middle of the picture lies below that of the whole one, in mm.
    pub fn below_middle_mm(&self) -> f64 {
        let above = (self.height_px as f64 - self.whole_size().1 as f64) / 2.0;
        (self.first_picture_row() as f64 + above) * self.pixel_mm()
    }

    /// Distance between the outermost films in mm.
    pub fn depth_mm(&self) -> f64 {
        (self.films as f64 - 1.0) * self.film_pitch_mm()
    }

    /// Side of one printed pixel in mm.
    pub fn pixel_mm(&self) -> f64 {
        self.width_mm / self.width_px as f64
    }

    /// Height of the picture on a film in mm.
    pub fn height_mm(&self) -> f64 {
        self.height_px as f64 * self.pixel_mm()
    }

    /// Part of the UV that one film and one spacer let through.
    pub fn layer_tau_uv(&self) -> f64 {
        self.tau_uv * self.spacer_tau_uv
    }

    /// Part of the visible light that one film and one spacer let through at normal incidence.
    pub fn layer_tau_visible(&self) -> f64 {
        self.tau_visible * self.spacer_tau_visible
    }

    /// Whether a volume of these films is larger than any that is held in memory.
    pub fn is_too_large_for_memory(&self) -> bool {
        self.film_len().saturating_mul(self.films) > MOST_VOXELS_IN_MEMORY
    }

    /// The print's blur along each axis as a variance in square pixels.
    pub fn blur_variance_px(&self) -> f64 {
        (self.blur_um / 1000.0 / self.pixel_mm()).powi(2)
    }

    /// Pixels of one film.
    pub fn film_len(&self) -> usize {
        self.width_px * self.height_px
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_stack_is_centred_on_the_origin() {
        let stack = Stack::default().checked().unwrap();
        assert!((stack.film_pitch_mm() - 0.6).abs() < 1e-12);
        assert!((stack.film_z_mm(0) - 5.7).abs() < 1e-12);
        assert!((stack.film_z_mm(19) + 5.7).abs() < 1e-12);
        assert!((stack.depth_mm() - 11.4).abs() < 1e-12);
    }

    #[test]
    fn a_field_out_of_range_is_named() {
        let error = Stack { tau_uv: 1.2, ..Stack::default() }.checked().unwrap_err();
        assert_eq!(error.field, "tau_uv");
        assert_eq!(error.to_string(), "tau_uv is 1.2, but must be greater than 0 and at most 1");
        assert_eq!(Stack { films: 0, ..Stack::default() }.checked().unwrap_err().field, "films");
        assert_eq!(Stack { width_mm: f64::NAN, ..Stack::default() }.checked().unwrap_err().field, "width_mm");
    }
}
