//! What is known of the battery clock, in flash: its last setting and its drift.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_exhibit::clock::ClockRecord;

use crate::{Error, map::CLOCK, small};

/// Reads the newest record; the default where there is none, or one of another firmware.
///
/// # Errors
/// The flash cannot be read.
pub fn read<F: ReadNorFlash>(flash: &mut F) -> Result<ClockRecord, Error<F::Error>> {
    small::read(&CLOCK, flash)
}

/// Stores a record; erases a sector, which stops the processor for a while. When it returns, the record survives a
/// power cut; a cut before leaves the one before it.
///
/// # Errors
/// The flash failed.
pub fn store<F: NorFlash>(flash: &mut F, record: &ClockRecord) -> Result<(), Error<F::Error>> {
    small::store(&CLOCK, flash, record)
}
