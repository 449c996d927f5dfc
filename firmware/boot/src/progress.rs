//! How far an update is, in flash.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_protocol::firmware::Progress;
use vitrine_storage::Error;

use crate::image::Layout;

/// No progress is longer in postcard's encoding.
const MOST_BYTES: usize = 8;

/// Reads how far an update is; where nothing is stored, or nothing that this version knows, there is none.
///
/// # Errors
/// The flash cannot be read.
pub fn progress<F: ReadNorFlash>(flash: &mut F, layout: &Layout) -> Result<Progress, Error<F::Error>> {
    let Some(record) = layout.progress.newest(flash)? else { return Ok(Progress::default()) };
    let mut bytes = [0; MOST_BYTES];
    let length = record.read(flash, 0, &mut bytes)?;
    Ok(bytes.get(..length).and_then(|bytes| postcard::from_bytes(bytes).ok()).unwrap_or_default())
}

/// Stores how far an update is; erases a sector. A power cut leaves this or what was stored before.
///
/// # Errors
/// The flash failed.
pub fn store_progress<F: NorFlash>(
    flash: &mut F,
    layout: &Layout,
    progress: Progress,
) -> Result<(), Error<F::Error>> {
    let mut bytes = [0; MOST_BYTES];
    let used =
        postcard::to_slice(&progress, &mut bytes).map_err(|_| Error::TooLong { most: MOST_BYTES as u32 })?;
    layout.progress.store(flash, used).map(|_| ())
}
