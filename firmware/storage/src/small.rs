//! A small value in two slots, in postcard's encoding.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use serde::{Serialize, de::DeserializeOwned};

use crate::{Error, TwoSlots};

/// No value is longer.
const MOST_BYTES: usize = 96;

/// Reads the newest value; the default where there is none, or one of another firmware.
///
/// # Errors
/// The flash cannot be read.
pub fn read<T: DeserializeOwned + Default, F: ReadNorFlash>(
    slots: &TwoSlots,
    flash: &mut F,
) -> Result<T, Error<F::Error>> {
    let Some(record) = slots.newest(flash)? else { return Ok(T::default()) };
    let mut bytes = [0; MOST_BYTES];
    let length = record.read(flash, 0, &mut bytes)?;
    Ok(bytes.get(..length).and_then(|bytes| postcard::from_bytes(bytes).ok()).unwrap_or_default())
}

/// Stores a value; erases a sector, which stops the processor for a while. When it returns, the value survives a power
/// cut; a cut before leaves the one before it.
///
/// # Errors
/// The flash failed.
pub fn store<T: Serialize, F: NorFlash>(
    slots: &TwoSlots,
    flash: &mut F,
    value: &T,
) -> Result<(), Error<F::Error>> {
    let mut bytes = [0; MOST_BYTES];
    let most = MOST_BYTES as u32;
    let used = postcard::to_slice(value, &mut bytes).map_err(|_| Error::TooLong { most })?;
    slots.store(flash, used).map(|_| ())
}
