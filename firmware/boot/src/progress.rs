//! How far an update is, in flash.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_protocol::firmware::Progress;
use vitrine_storage::{Error, small};

use crate::image::Layout;

/// Reads how far an update is; where nothing is stored, or nothing that this version knows, there is none.
///
/// # Errors
/// The flash cannot be read.
pub fn progress<F: ReadNorFlash>(flash: &mut F, layout: &Layout) -> Result<Progress, Error<F::Error>> {
    small::read(&layout.progress, flash)
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
    small::store(&layout.progress, flash, &progress)
}
