//! Papers: sheets of a standard size, and rolls.

use std::str::FromStr;

use serde::Serialize;
use thiserror::Error;

/// What is printed on, fed upright: the printer's `dpi_x` runs along the width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Paper {
    /// A sheet of this width and height in mm.
    Sheet {
        /// Side along which the print head runs.
        width_mm: f64,
        /// Side along which the sheet is fed.
        height_mm: f64,
    },
    /// A roll of this width in mm, cut where the sheet ends.
    Roll {
        /// Side along which the print head runs.
        width_mm: f64,
    },
}

/// A paper that nobody knows.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("there is no paper \"{0}\": give {PAPERS}")]
pub struct UnknownPaper(String);

/// The papers in words.
pub const PAPERS: &str = "A0, A1, A2, A3, A4, letter, legal or tabloid, each also as in \"A4 landscape\", or a roll by its \
                          width of 50 to 5500 mm, as in \"roll 610\"";

/// ISO 216 and ANSI/ASME Y14.1 sizes in mm.
const SIZES: [(&str, f64, f64); 8] = [
    ("a0", 841.0, 1189.0),
    ("a1", 594.0, 841.0),
    ("a2", 420.0, 594.0),
    ("a3", 297.0, 420.0),
    ("a4", 210.0, 297.0),
    ("letter", 215.9, 279.4),
    ("legal", 215.9, 355.6),
    ("tabloid", 279.4, 431.8),
];

/// The narrowest and the widest roll in mm.
const ROLL_WIDTHS_MM: std::ops::RangeInclusive<f64> = 50.0..=5500.0;

impl FromStr for Paper {
    type Err = UnknownPaper;

    fn from_str(text: &str) -> Result<Self, UnknownPaper> {
        let unknown = || UnknownPaper(text.to_owned());
        let lower = text.to_ascii_lowercase();
        let words: Vec<&str> = lower.split([' ', ':']).filter(|word| !word.is_empty()).collect();
        match words.as_slice() {
            ["roll", width] => {
                let width_mm = width.trim_end_matches("mm").parse().map_err(|_| unknown())?;
                ROLL_WIDTHS_MM.contains(&width_mm).then_some(Self::Roll { width_mm }).ok_or_else(unknown)
            }
            [name, turned @ ..] => {
                let &(_, width_mm, height_mm) =
                    SIZES.iter().find(|size| size.0 == *name).ok_or_else(unknown)?;
                match turned {
                    [] => Ok(Self::Sheet { width_mm, height_mm }),
                    ["landscape"] => Ok(Self::Sheet { width_mm: height_mm, height_mm: width_mm }),
                    _ => Err(unknown()),
                }
            }
            [] => Err(unknown()),
        }
    }
}

impl Paper {
    /// The side along which the print head runs, in mm.
    pub fn width_mm(self) -> f64 {
        match self {
            Self::Sheet { width_mm, .. } | Self::Roll { width_mm } => width_mm,
        }
    }

    /// The side along which the paper is fed, in mm; `None` for a roll.
    pub fn height_mm(self) -> Option<f64> {
        match self {
            Self::Sheet { height_mm, .. } => Some(height_mm),
            Self::Roll { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn papers_are_known_by_name_and_rolls_by_width() {
        let sheet = |width_mm, height_mm| Ok(Paper::Sheet { width_mm, height_mm });
        assert_eq!("A4".parse(), sheet(210.0, 297.0));
        assert_eq!("a3 Landscape".parse(), sheet(420.0, 297.0));
        assert_eq!("letter".parse(), sheet(215.9, 279.4));
        assert_eq!("roll 610".parse(), Ok(Paper::Roll { width_mm: 610.0 }));
        assert_eq!("roll:1118mm".parse(), Ok(Paper::Roll { width_mm: 1118.0 }));
        for wrong in ["", "A9", "roll", "roll x", "roll 1e9", "roll nan", "A4 upside down", "landscape"] {
            assert!(wrong.parse::<Paper>().is_err(), "{wrong}");
        }
    }
}
