//! What is known of the battery clock, in flash: its last setting and its drift.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_exhibit::clock::ClockRecord;

use crate::{Error, map::CLOCK};

/// No record is longer: three integers of 64 bits at most, with their tags.
const MOST_BYTES: usize = 32;

/// Reads the newest record; the default where there is none, or one of another firmware.
///
/// # Errors
/// The flash cannot be read.
pub fn read<F: ReadNorFlash>(flash: &mut F) -> Result<ClockRecord, Error<F::Error>> {
    let Some(record) = CLOCK.newest(flash)? else { return Ok(ClockRecord::default()) };
    let mut bytes = [0; MOST_BYTES];
    let length = record.read(flash, 0, &mut bytes)?;
    Ok(bytes.get(..length).and_then(|bytes| postcard::from_bytes(bytes).ok()).unwrap_or_default())
}

/// Stores a record; erases a sector, which stops the processor for a while. When it returns, the record survives a
/// power cut; a cut before leaves the one before it.
///
/// # Errors
/// The flash failed.
pub fn store<F: NorFlash>(flash: &mut F, record: &ClockRecord) -> Result<(), Error<F::Error>> {
    let mut bytes = [0; MOST_BYTES];
    let most = MOST_BYTES as u32;
    let used = postcard::to_slice(record, &mut bytes).map_err(|_| Error::TooLong { most })?;
    CLOCK.store(flash, used).map(|_| ())
}
