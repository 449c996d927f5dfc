//! Firmware images and their updates, as told to hosts and as stored by the boot loader.
//!
//! A boot loader stays on its board for good, and reads what a later firmware has stored: like the messages, these types
//! may have variants appended and nothing else.

use core::fmt;

use heapless::String;
use serde::{Deserialize, Serialize};

/// The version of an image, as in "0.1.0".
pub type Version = String<24>;

/// The BLAKE3 hash of an image.
pub type Digest = [u8; 32];

/// The firmware that runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FirmwareState {
    /// Its version.
    pub version: Version,
    /// The BLAKE3 hash in the header of the image that runs.
    pub digest: Digest,
    /// How far an update is.
    pub progress: Progress,
}

/// How far an update is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Progress {
    /// No update is under way; how the last one ended.
    Settled(Outcome),
    /// A new image is whole in its place and is to be installed at the next start.
    Wanted,
    /// The image before is kept, and the new one is being installed.
    Installing,
    /// The new image runs for the first time and has not yet confirmed itself.
    OnTrial,
    /// The image before is being installed again.
    GoingBack,
}

impl Default for Progress {
    fn default() -> Self {
        Self::Settled(Outcome::NoUpdate)
    }
}

/// How the last update ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// There was none.
    #[default]
    NoUpdate,
    /// The new image confirmed itself, and stays.
    Confirmed,
    /// The new image did not confirm itself, and the one before runs again.
    WentBack,
    /// The new image did not verify when it was to be installed; nothing has changed.
    Refused,
    /// The active image was damaged and another one took its place.
    Restored,
    /// The new image did not confirm itself, but there is no other.
    NothingToGoBackTo,
}

/// Why bytes are no image that this board runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ImageFault {
    /// They do not begin as an image does.
    NoImage,
    /// It is for another board.
    OtherBoard,
    /// It is linked to another address.
    OtherAddress,
    /// Its length does not fit its place.
    Length,
    /// It is signed with another key.
    OtherKey,
    /// Its signature is wrong: what stands in its header was changed.
    Signature,
    /// It is not what was signed: bytes were changed or are missing.
    Damaged,
}

impl fmt::Display for ImageFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoImage => "this is no signed firmware image",
            Self::OtherBoard => "the firmware is for another board",
            Self::OtherAddress => "the firmware is linked to another address",
            Self::Length => "the firmware does not fit its place in flash",
            Self::OtherKey => "the firmware is signed with another key than the one this board takes",
            Self::Signature => "the firmware's signature is wrong: its header was changed",
            Self::Damaged => "the firmware is not what was signed: bytes were changed or are missing",
        })
    }
}

impl core::error::Error for ImageFault {}
