//! What the printer lays for the ink values of a film.

/// Turns a film's ink values into what the three printer channels lay.
pub trait Separation: Sync {
    /// Turns one row of film `film` (0 on top) in place: interleaved red, green and blue, 65,535 for full ink, become
    /// the amounts of the three channels.
    fn separate(&self, film: usize, row: usize, samples: &mut [u16]);

    /// Whether every dot of a halftone is full or empty.
    fn is_binary(&self) -> bool;

    /// The halftone of one film, where there is one. Without it every dot of a pixel gets the pixel's amounts.
    fn halftone(&self, film: usize) -> Option<Box<dyn Halftone>>;
}

/// Turns a film's dots into levels that the printer knows.
pub trait Halftone: Send {
    /// Turns the next row of dots in place, from the top: the interleaved amounts of the three channels.
    fn row(&mut self, dots: &mut [u16]);
}

/// Channels that lay what was designed, in tones as they come.
#[derive(Clone, Copy, Debug, Default)]
pub struct AsDesigned;

impl Separation for AsDesigned {
    fn separate(&self, _film: usize, _row: usize, _samples: &mut [u16]) {}

    fn is_binary(&self) -> bool {
        false
    }

    fn halftone(&self, _film: usize) -> Option<Box<dyn Halftone>> {
        None
    }
}
