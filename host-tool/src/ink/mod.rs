//! From film values to three fluorescent inks.
//!
//! A film value, 0..=1 in red, green and blue, says how much a spot is to glow; equal values glow equally, so that
//! white is white. The inks do not: for the same ultraviolet light they give 0.43, 0.85 and 0.89 (red, green, blue;
//! Hirayama et al. 2017, Scientific Reports 7:46511). [`Separator`] scales the stronger inks to the weakest and gives
//! the coverage of each ink, [`Screens`] lays the coverages out as a printer's dots.
//!
//! Fluorescent inks add up while little of them lies in one place. With more, the molecules quench each other and the
//! light diminishes (Hersch, Donze, Chosson 2007, "Color images visible under UV light", ACM SIGGRAPH), so that paper
//! prints dots side by side and maps colours into what side by side can reach. Here likewise:
//!
//! - no dot carries two inks, whichever halftone is chosen;
//! - the coverages of a spot add up to no more than the ink limit;
//! - what needs more is mapped along the line to black, which keeps its hue: see [`Gamut`];
//! - an ink's light by its coverage is a [`Curve`], measured from a printed wedge or [`Curve::quenching`].
//!
//! [`profile()`] says the same as an ICC profile, for programs that want one.

mod calibrate;
mod curve;
mod curve_file;
mod mask;
mod profile;
mod screen;
mod separate;
mod sheets;
mod wedge;

pub use calibrate::{CalibrateError, Calibration, calibrate};
pub use curve::{Curve, CurveError};
pub use curve_file::{CurveFile, CurveFileError, InkCurve};
pub use profile::{ProfileSpace, profile};
pub use screen::{Halftone, Screen, Screens};
pub use separate::{Dots, Gamut, Inks, Separator};
pub use sheets::SheetInks;
pub use wedge::wedge;

/// How much each ink glows at full coverage under the same ultraviolet light: red, green, blue (Hirayama et al. 2017).
pub const YIELDS: [f64; 3] = [0.43, 0.85, 0.89];
