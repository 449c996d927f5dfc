//! Records in NOR flash that survive a power cut at any moment.
//!
//! Flash is programmed by clearing bits, byte by byte, and erased by whole sectors. A power cut leaves the byte
//! being programmed with any of its bits cleared, and the sector being erased with any of its parts erased, in any
//! order. So nothing here relies on the order within an erase: whatever is read back is believed only with its CRC,
//! and what is valid is never touched before its successor is.
//!
//! - [`TwoSlots`]: one record in two places, the newest valid one counts. For the plan and the settings.
//! - [`Ring`]: numbered entries of one size, the newest are kept. For the dose ledger and the event log.
//! - [`Ledger`], [`EventLog`], [`clock`], [`settings`]: those, with their own types.
//! - [`map`]: where each lies.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(any(test, feature = "mock"))]
extern crate std;

pub mod clock;
mod ledger;
mod log;
pub mod map;
#[cfg(any(test, feature = "mock"))]
#[allow(clippy::indexing_slicing, reason = "only tests use it, and they may panic")]
pub mod mock;
mod ring;
pub mod settings;
mod slots;
pub mod small;
#[cfg(test)]
mod tests;

pub use ledger::Ledger;
pub use log::EventLog;
pub use ring::{Opened, Ring, RingPosition};
pub use slots::{Record, TwoSlots, Writer};

use crc::{CRC_32_ISO_HDLC, Crc};

/// The checksum of everything stored: CRC-32/ISO-HDLC, as in zip and PNG.
pub const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Why something could not be stored or read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The flash failed.
    Flash(E),
    /// More bytes than fit.
    TooLong {
        /// How many fit.
        most: u32,
    },
    /// Fewer bytes were written than announced.
    Incomplete {
        /// How many were written.
        written: u32,
    },
    /// What is read back is not what was written: the flash is worn out, or was written by another.
    NotAsWritten,
}

impl<E> From<E> for Error<E> {
    fn from(error: E) -> Self {
        Self::Flash(error)
    }
}
