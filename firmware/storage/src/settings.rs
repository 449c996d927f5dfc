//! The settings made on the spot, in flash.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_exhibit::settings::Settings;

use crate::{Error, map::SETTINGS, small};

/// Reads the newest settings; the defaults where there are none, or where they are another firmware's or unfit.
///
/// # Errors
/// The flash cannot be read.
pub fn read<F: ReadNorFlash>(flash: &mut F) -> Result<Settings, Error<F::Error>> {
    let settings: Settings = small::read(&SETTINGS, flash)?;
    Ok(if settings.check().is_ok() { settings } else { Settings::default() })
}

/// Stores settings; erases a sector, which stops the processor for a while. When it returns, they survive a power cut; a
/// cut before leaves those before them.
///
/// # Errors
/// The flash failed.
pub fn store<F: NorFlash>(flash: &mut F, settings: &Settings) -> Result<(), Error<F::Error>> {
    small::store(&SETTINGS, flash, settings)
}
