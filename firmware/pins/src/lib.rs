//! The controller's pin map: hardware/pins.toml, as the builds of firmware and boot loader and the tests read it.

#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

/// The pin map.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// What the board is called where one buys it.
    pub board: String,
    /// Who owns pins in the firmware, by name.
    pub group: BTreeMap<String, Group>,
    /// All pins.
    pub pin: Vec<Pin>,
}

/// An owner of pins.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// What else of the chip it owns: the names there, by those in the firmware.
    #[serde(default)]
    pub peripherals: BTreeMap<String, String>,
    /// The firmware also needs the pins' numbers.
    #[serde(default)]
    pub by_number: bool,
}

/// A pin of the controller.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
#[serde(deny_unknown_fields)]
pub struct Pin {
    /// The number in "GP4".
    pub gp: u8,
    /// The wire's name in drawings and code.
    pub net: String,
    /// Who owns it.
    pub group: String,
    /// Its name there.
    pub role: String,
    /// `in`, `out` or `both`, as seen from the controller.
    pub direction: String,
    /// The wire's level while the controller is in reset: `low`, `high` or `analogue`.
    pub reset: String,
    /// What it does.
    pub function: String,
}

/// Why the pin map is none.
#[derive(Debug, Error)]
pub enum PinsError {
    /// The file cannot be read.
    #[error("{} cannot be read", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// It is not written as a pin map is.
    #[error("pins.toml: {0}")]
    Syntax(#[from] toml::de::Error),
    /// A pin belongs to nobody.
    #[error("pins.toml: GP{gp} names the unknown group '{group}'")]
    UnknownGroup {
        /// The pin.
        gp: u8,
        /// The group that it names.
        group: String,
    },
    /// Two pins have the same number, net, or name in their group.
    #[error("pins.toml: GP{gp}, its net {net} or its role is used twice")]
    Twice {
        /// One of them.
        gp: u8,
        /// Its net.
        net: String,
    },
    /// A net that the reader needs is missing.
    #[error("pins.toml: no net {0}")]
    NoNet(String),
}

impl Board {
    /// Where the pin map lies.
    pub fn path() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../hardware/pins.toml")
    }

    /// Reads the pin map.
    ///
    /// # Errors
    /// It cannot be read, or is none.
    pub fn read() -> Result<Self, PinsError> {
        let path = Self::path();
        let text = std::fs::read_to_string(&path).map_err(|source| PinsError::Unreadable { path, source })?;
        Self::parse(&text)
    }

    /// Reads the text of a pin map.
    ///
    /// # Errors
    /// It is none: see [`PinsError`].
    pub fn parse(text: &str) -> Result<Self, PinsError> {
        let board: Self = toml::from_str(text)?;
        for pin in &board.pin {
            if !board.group.contains_key(&pin.group) {
                return Err(PinsError::UnknownGroup { gp: pin.gp, group: pin.group.clone() });
            }
            let same = |other: &&Pin| {
                other.gp == pin.gp
                    || other.net == pin.net
                    || (&other.group, &other.role) == (&pin.group, &pin.role)
            };
            if board.pin.iter().filter(same).count() != 1 {
                return Err(PinsError::Twice { gp: pin.gp, net: pin.net.clone() });
            }
        }
        Ok(board)
    }

    /// The pin of a net.
    ///
    /// # Errors
    /// There is no such net.
    pub fn net(&self, name: &str) -> Result<&Pin, PinsError> {
        self.pin.iter().find(|pin| pin.net == name).ok_or_else(|| PinsError::NoNet(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(pins: &[(u8, &str, &str, &str)]) -> Result<Board, PinsError> {
        let mut text = "board = \"Pico\"\n[group.lamps]\n[group.front]\n".to_owned();
        for (gp, net, group, role) in pins {
            text += &format!(
                "[[pin]]\ngp = {gp}\nnet = \"{net}\"\ngroup = \"{group}\"\nrole = \"{role}\"\ndirection = \"out\"\nreset = \"low\"\nfunction = \"\"\n"
            );
        }
        Board::parse(&text)
    }

    #[test]
    fn a_pin_has_one_owner_one_net_and_one_role() {
        let board = with(&[(2, "TOP", "lamps", "top"), (25, "LED", "front", "top")]).expect("a pin map");
        assert_eq!(board.net("LED").expect("a net").gp, 25);
        assert!(matches!(board.net("KEY"), Err(PinsError::NoNet(_))));
        for wrong in [(2, "LED", "front", "led"), (3, "TOP", "front", "led"), (3, "LED", "lamps", "top")] {
            let found = with(&[(2, "TOP", "lamps", "top"), wrong]);
            assert!(matches!(found, Err(PinsError::Twice { .. })), "{wrong:?}: {found:?}");
        }
        assert!(matches!(with(&[(2, "TOP", "nobody", "top")]), Err(PinsError::UnknownGroup { gp: 2, .. })));
        assert!(matches!(Board::parse("board = 1"), Err(PinsError::Syntax(_))));
    }
}
