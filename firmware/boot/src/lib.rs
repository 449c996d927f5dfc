//! Signed firmware images in flash: verified at every start, installed and gone back from, whatever happens to the power.
//!
//! Pure: flash comes in as a trait, so that the computer's tests cut the power at every step. The boot loader
//! (`firmware/bootloader`), the firmware and the simulated controller run this same code.
//!
//! # Three places
//!
//! An image runs in place, so it is linked to one address. Three places of the same size hold one image each, its
//! [`Header`] in front:
//!
//! | place | holds |
//! |---|---|
//! | active | what runs; the only one at the address that images are linked to |
//! | new | what a host has sent |
//! | old | what ran before |
//!
//! # An update
//!
//! [`Staging`] writes what a host sends to the new place, and when it is whole and signed stores [`Progress::Wanted`]. The
//! boot loader does the rest, in [`start()`]. Each step leaves its source untouched and may be begun anew; what is stored
//! of the progress says which is under way, in two slots that a power cut cannot take both:
//!
//! ```text
//! Wanted      active -> old    the image that runs is kept; it stays whole meanwhile
//! Installing  new -> active    a tear is begun anew: the new image is still there
//! OnTrial     the new image runs and has a minute to confirm itself (trial)
//! GoingBack   old -> active    after any other start on trial; a tear is begun anew: the old image is still there
//! Settled     nothing to do, and how the last update ended
//! ```
//!
//! Whatever is stored, nothing runs from the active place whose signature does not verify at this very start. A damaged
//! image is replaced by the old one, else by the new one, else nothing runs. So even a progress that is lost or made up
//! cannot start a mixture of two images.
//!
//! What verifies an image when a host has sent it is the same code, so that most of what could go wrong is told to the host.
//!
//! The signature covers the header, and the header the image's BLAKE3 hash: on a processor of this size that is three times
//! faster than the hash of the SHA-2 family, and every start pays for it.
//!
//! A copy always erases and writes every sector anew: what a power cut has torn may read right today and wrong tomorrow.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

mod header;
mod image;
mod progress;
mod staging;
mod start;
#[cfg(test)]
mod tests;
pub mod trial;
mod updates;

pub use ed25519_dalek::VerifyingKey;
pub use header::{HEADER_BYTES, Header, SIGNED_BYTES};
pub use image::{Key, LAYOUT, Layout, Slot, verify};
pub use progress::{progress, store_progress};
pub use staging::Staging;
pub use start::{Start, start};
pub use updates::Updates;
pub use vitrine_protocol::firmware::{ImageFault, Outcome, Progress};

include!(concat!(env!("OUT_DIR"), "/keys.rs"));

/// Whether this build takes images of the development key, for which anybody can sign.
pub fn takes_development_key() -> bool {
    PUBLIC_KEY == DEVELOPMENT_KEY
}

/// The key by which this build verifies images; none where what was compiled in is no point of the curve.
pub fn public_key() -> Option<VerifyingKey> {
    VerifyingKey::from_bytes(&PUBLIC_KEY).ok()
}
