//! From pixels to printer dots, and back without loss.
//!
//! Printers lay dots in a grid whose pitch differs along both axes, such as 5,760 x 1,440 an inch. A film is printed
//! true to size: along each axis it gets the whole number of dots nearest to its length, so that it is at most half a
//! dot too long or too short, and every dot shows the pixel in which its centre lies. Nothing is interpolated: ink
//! values reach the printer as they were designed. Where a pixel has at least one dot, the dot nearest to its centre
//! gives it back exactly.

use serde::Serialize;
use thiserror::Error;

/// Millimetres of an inch.
pub const INCH_MM: f64 = 25.4;

/// Dots per inch along both axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// Along the width.
    pub dpi_x: f64,
    /// Along the height.
    pub dpi_y: f64,
}

/// The pixels of one axis of a film in the dots of the printer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DotAxis {
    pixels: usize,
    dots: usize,
}

/// A printer whose dots are coarser than the film's pixels.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error(
    "{pixels} pixels on {length_mm} mm need at least {least_dpi} dots per inch, and the printer lays {dpi}"
)]
pub struct TooCoarse {
    /// Pixels along the axis.
    pub pixels: usize,
    /// Length of the axis.
    pub length_mm: f64,
    /// The printer's resolution.
    pub dpi: f64,
    /// The resolution that gives each pixel a dot.
    pub least_dpi: f64,
}

impl Resolution {
    /// The dot boundary nearest to `mm` from the left edge.
    pub fn x(self, mm: f64) -> usize {
        (mm / INCH_MM * self.dpi_x).round() as usize
    }

    /// The dot boundary nearest to `mm` from the upper edge.
    pub fn y(self, mm: f64) -> usize {
        (mm / INCH_MM * self.dpi_y).round() as usize
    }
}

impl DotAxis {
    /// Lays `pixels` (1 or more) on `length_mm` at `dpi`.
    ///
    /// # Errors
    /// When there are fewer dots than pixels.
    pub fn new(pixels: usize, length_mm: f64, dpi: f64) -> Result<Self, TooCoarse> {
        let dots = (length_mm / INCH_MM * dpi).round() as usize;
        if dots < pixels {
            let least_dpi = (pixels as f64 * INCH_MM / length_mm).ceil();
            return Err(TooCoarse { pixels, length_mm, dpi, least_dpi });
        }
        Ok(Self { pixels, dots })
    }

    /// Pixels along the axis.
    pub fn pixels(self) -> usize {
        self.pixels
    }

    /// Dots along the axis.
    pub fn dots(self) -> usize {
        self.dots
    }

    /// The pixel in which the centre of dot `dot` lies.
    pub fn pixel_of(self, dot: usize) -> usize {
        ((2 * dot + 1) * self.pixels / (2 * self.dots)).min(self.pixels - 1)
    }

    /// The first dot of pixel `pixel`; of the one after the last, the number of dots.
    pub fn first_dot(self, pixel: usize) -> usize {
        (2 * pixel * self.dots).saturating_sub(self.pixels).div_ceil(2 * self.pixels)
    }

    /// The dot nearest to the centre of pixel `pixel`.
    pub fn middle_dot(self, pixel: usize) -> usize {
        (2 * pixel + 1) * self.dots / (2 * self.pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_pixel_comes_back_from_its_middle_dot(pixels in 1..3000usize, more in 1.0..40.0f64) {
            let length_mm = pixels as f64 * INCH_MM / 720.0 * more;
            let axis = DotAxis::new(pixels, length_mm, 720.0).unwrap();
            for pixel in 0..pixels {
                prop_assert_eq!(axis.pixel_of(axis.middle_dot(pixel)), pixel);
                let (first, next) = (axis.first_dot(pixel), axis.first_dot(pixel + 1));
                prop_assert!(first < next);
                prop_assert_eq!((axis.pixel_of(first), axis.pixel_of(next - 1)), (pixel, pixel));
            }
            prop_assert_eq!(axis.first_dot(pixels), axis.dots());
        }
    }

    #[test]
    fn the_papers_film_has_its_size_on_the_papers_printer() {
        let across = DotAxis::new(512, 35.0, 5760.0).unwrap();
        let down = DotAxis::new(512, 35.0, 1440.0).unwrap();
        assert_eq!((across.dots(), down.dots()), (7937, 1984));
        // Half a dot at most: 2.2 and 8.8 micrometres.
        assert!((7937.0 / 5760.0 * INCH_MM - 35.0f64).abs() < 0.0022);
        assert!((1984.0 / 1440.0 * INCH_MM - 35.0f64).abs() < 0.0089);
    }

    #[test]
    fn a_printer_with_fewer_dots_than_pixels_is_refused() {
        let error = DotAxis::new(512, 35.0, 360.0).unwrap_err();
        assert_eq!(error.least_dpi, 372.0);
        assert!(DotAxis::new(512, 35.0, 372.0).is_ok());
    }
}
