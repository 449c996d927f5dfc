//! What the boot loader does at every start.

use embedded_storage::nor_flash::NorFlash;
use vitrine_protocol::firmware::{Outcome, Progress};
use vitrine_storage::Error;

use crate::header::Header;
use crate::image::{Key, Layout, copy, verify};
use crate::progress::{progress, store_progress};

/// What is to run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// The active image, which has just been verified.
    Image {
        /// Its header.
        header: Header,
        /// It runs for the first time, and the next start goes back unless it confirms itself.
        on_trial: bool,
    },
    /// No place holds an image that verifies: nothing may run.
    Nothing,
}

/// Brings an update as far as it goes, and tells what is to run. To be called at every start; after a power cut on the way it
/// goes on where it was.
///
/// # Errors
/// The flash failed; then nothing may run.
pub fn start<F: NorFlash>(flash: &mut F, layout: &Layout, key: &impl Key) -> Result<Start, Error<F::Error>> {
    let mut stage = progress(flash, layout)?;
    let mut on_trial = false;
    if stage == Progress::OnTrial {
        // It has been started before and has not confirmed itself since.
        stage = advance(flash, layout, Progress::GoingBack)?;
    }
    if stage == Progress::Wanted {
        let next = keep_active(flash, layout, key)?;
        stage = advance(flash, layout, next)?;
    }
    if stage == Progress::Installing {
        let next = install(flash, layout, key)?;
        stage = advance(flash, layout, next)?;
        on_trial = stage == Progress::OnTrial;
    }
    if stage == Progress::GoingBack {
        let next = go_back(flash, layout, key)?;
        advance(flash, layout, next)?;
    }
    if let Ok(header) = verify(flash, layout, layout.active, key)? {
        return Ok(Start::Image { header, on_trial });
    }
    restore(flash, layout, key)
}

fn advance<F: NorFlash>(flash: &mut F, layout: &Layout, next: Progress) -> Result<Progress, Error<F::Error>> {
    store_progress(flash, layout, next)?;
    Ok(next)
}

/// Keeps the active image before another takes its place. One that does not verify is not worth keeping.
fn keep_active<F: NorFlash>(
    flash: &mut F,
    layout: &Layout,
    key: &impl Key,
) -> Result<Progress, Error<F::Error>> {
    if verify(flash, layout, layout.new, key)?.is_err() {
        return Ok(Progress::Settled(Outcome::Refused));
    }
    if let Ok(active) = verify(flash, layout, layout.active, key)? {
        copy(flash, layout.active, layout.old, &active)?;
    }
    Ok(Progress::Installing)
}

fn install<F: NorFlash>(flash: &mut F, layout: &Layout, key: &impl Key) -> Result<Progress, Error<F::Error>> {
    let Ok(new) = verify(flash, layout, layout.new, key)? else { return Ok(Progress::GoingBack) };
    match copy(flash, layout.new, layout.active, &new) {
        Ok(()) => Ok(Progress::OnTrial),
        Err(Error::NotAsWritten) => Ok(Progress::GoingBack),
        Err(error) => Err(error),
    }
}

fn go_back<F: NorFlash>(flash: &mut F, layout: &Layout, key: &impl Key) -> Result<Progress, Error<F::Error>> {
    let Ok(old) = verify(flash, layout, layout.old, key)? else {
        return Ok(Progress::Settled(Outcome::NothingToGoBackTo));
    };
    copy(flash, layout.old, layout.active, &old)?;
    Ok(Progress::Settled(Outcome::WentBack))
}

/// Puts another image in the place of an active one that does not verify. Nothing needs to be stored on the way: until the
/// copy is whole, the next start finds the same and does the same.
fn restore<F: NorFlash>(flash: &mut F, layout: &Layout, key: &impl Key) -> Result<Start, Error<F::Error>> {
    for source in [layout.old, layout.new] {
        let Ok(header) = verify(flash, layout, source, key)? else { continue };
        copy(flash, source, layout.active, &header)?;
        store_progress(flash, layout, Progress::Settled(Outcome::Restored))?;
        return Ok(Start::Image { header, on_trial: false });
    }
    Ok(Start::Nothing)
}
