//! What the printer lays for the ink values of a film.

use crate::volume::CHANNELS;

/// Turns a film's ink values into what the three printer channels lay.
pub trait Separation: Sync {
    /// Turns one row of film `film` (0 on top) in place: interleaved red, green and blue, 65,535 for full ink, become
    /// the amounts of the three channels.
    fn separate(&self, film: usize, row: usize, samples: &mut [u16]);

    /// The highest level of a halftone's dots, 1..=255, where there is a halftone. Without it every dot of a pixel gets
    /// the pixel's amounts.
    fn top_level(&self) -> Option<u8>;

    /// The halftone of one film, for rows of `width` dots, where there is one.
    fn halftone(&self, film: usize, width: usize) -> Option<Box<dyn Halftone>>;
}

/// Lays a film's pixels out in dots of levels that the printer knows.
pub trait Halftone: Send {
    /// Lays out the next row of dots, from the top. Its pixels are `runs`, from left to right, the last of which ends
    /// with the row.
    fn row(&mut self, runs: &[Run], dots: &mut [Dot]);
}

/// Neighbouring dots of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The dot after its last.
    pub end: usize,
    /// What each channel lays on the pixel, 65,535 for full ink: at most that in all.
    pub amounts: [u16; CHANNELS],
}

/// A dot of a halftone: one channel's ink at some level, or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dot(u16);

impl Dot {
    /// A dot without ink.
    pub const NONE: Self = Self(0);

    /// The dot of channel `channel`, 0..=2, at `level`.
    pub fn new(channel: usize, level: u8) -> Self {
        Self((u16::from(level) << 2 | (channel & 3) as u16) * u16::from(level > 0))
    }

    /// What the dot lays: the channel, and its level.
    pub fn ink(self) -> (usize, u8) {
        (usize::from(self.0 & 3), (self.0 >> 2) as u8)
    }

    /// What a dot that is full or empty is: 0 without ink, 1 to 3 with that of channels 0 to 2.
    pub(super) fn kind(self) -> u8 {
        // A full dot has the level 1.
        (self.0 >> 2) as u8 + (self.0 & 3) as u8
    }

    /// Samples by dots of levels up to `top`: [`Dot::sample`] reads them.
    pub(super) fn samples(top: u8) -> Vec<[u16; CHANNELS]> {
        let full = u32::from(u16::MAX);
        let sample = |index: u16| {
            let (channel, level) = Self(index).ink();
            let amount = u32::from(level) * full / u32::from(top.max(1));
            std::array::from_fn(|at| if at == channel { amount.min(full) as u16 } else { 0 })
        };
        (0..(u16::from(top) + 1) << 2).map(sample).collect()
    }

    /// The dot's amounts of the three channels, from [`Dot::samples`].
    pub(super) fn sample(self, samples: &[[u16; CHANNELS]]) -> [u16; CHANNELS] {
        samples.get(usize::from(self.0)).copied().unwrap_or_default()
    }
}

/// Channels that lay what was designed, in tones as they come.
#[derive(Clone, Copy, Debug, Default)]
pub struct AsDesigned;

impl Separation for AsDesigned {
    fn separate(&self, _film: usize, _row: usize, _samples: &mut [u16]) {}

    fn top_level(&self) -> Option<u8> {
        None
    }

    fn halftone(&self, _film: usize, _width: usize) -> Option<Box<dyn Halftone>> {
        None
    }
}
