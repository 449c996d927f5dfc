//! A running firmware's side of updates: what a host sends of a new one, and whether the one that runs may stay.

use embedded_storage::nor_flash::NorFlash;
use vitrine_exhibit::units::{Milliseconds, Millivolts};
use vitrine_protocol::Refusal;
use vitrine_protocol::firmware::{FirmwareState, Outcome, Progress};
use vitrine_storage::Error;

use crate::header::{HEADER_BYTES, Header};
use crate::image::{Key, Layout};
use crate::progress::{progress, store_progress};
use crate::staging::Staging;
use crate::trial::{Health, Verdict, is_supplied};

/// A host that would replace firmware on trial is to ask again then.
const ASK_AFTER_TRIAL: Milliseconds = Milliseconds(1_000);

/// What is known of images: the one that runs, and one on its way.
#[derive(Debug)]
pub struct Updates<K> {
    layout: Layout,
    key: K,
    running: Option<Header>,
    progress: Progress,
    staging: Option<Staging>,
}

impl<K: Key> Updates<K> {
    /// Reads what runs and how its update is. Firmware that was started without its boot loader has no header.
    pub fn load<F: NorFlash>(flash: &mut F, layout: &Layout, key: K) -> Self {
        let mut header = [0; HEADER_BYTES as usize];
        let running = match flash.read(layout.active.start(), &mut header) {
            Ok(()) => Header::from_bytes(&header).ok(),
            Err(_) => None,
        };
        let progress = progress(flash, layout).unwrap_or_default();
        Self { layout: *layout, key, running, progress, staging: None }
    }

    /// What is told to hosts; without a header the version is the one given.
    pub fn state(&self, built: &str) -> FirmwareState {
        let Self { progress, .. } = *self;
        match &self.running {
            Some(header) => {
                FirmwareState { version: header.version.clone(), digest: header.digest, progress }
            }
            None => FirmwareState {
                version: built.try_into().unwrap_or_default(),
                progress,
                ..FirmwareState::default()
            },
        }
    }

    /// Prepares the place of the new image.
    ///
    /// # Errors
    /// There is no boot loader, the firmware that runs is on trial, the length does not fit, or the flash failed.
    pub fn begin<F: NorFlash>(&mut self, flash: &mut F, length: u32) -> Result<(), Refusal> {
        self.may_be_replaced()?;
        self.staging = Some(Staging::begin(flash, &self.layout, length).map_err(refusal)?);
        if self.progress == Progress::Wanted {
            self.progress = Progress::default();
        }
        Ok(())
    }

    /// Whether [`Updates::append`] of so many bytes will erase a sector, which stops the processor for a while.
    pub fn will_erase(&self, bytes: usize) -> bool {
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        self.staging.as_ref().is_some_and(|staging| staging.will_erase(bytes))
    }

    /// Writes the next bytes and reads them back.
    ///
    /// # Errors
    /// No image has begun, or the flash failed; or these bytes end a header that is for another board or names another key, so
    /// that the host need not send the rest.
    pub fn append<F: NorFlash>(&mut self, flash: &mut F, bytes: &[u8]) -> Result<(), Refusal> {
        let staging = self.staging.as_mut().ok_or(Refusal::NoUpload)?;
        staging.append(flash, bytes).map_err(refusal)?;
        if let Some(header) = staging.header_after(bytes.len()) {
            self.layout.suits(header, &self.key).map_err(Refusal::UnfitImage)?;
        }
        Ok(())
    }

    /// Verifies the new image; the next start installs it. Erases a sector.
    ///
    /// # Errors
    /// The firmware that runs is on trial, no image of this CRC is there or it is none for this board, there is no lamp supply
    /// with which it could confirm itself, or the flash failed.
    pub fn commit<F: NorFlash>(
        &mut self,
        flash: &mut F,
        crc: u32,
        supply: Option<Millivolts>,
    ) -> Result<(), Refusal> {
        self.may_be_replaced()?;
        if !is_supplied(supply) {
            return Err(Refusal::NoSupply);
        }
        let staging = self.staging.as_mut().ok_or(Refusal::NoUpload)?;
        if staging.crc() != crc {
            return Err(Refusal::Checksum { expected: crc, found: staging.crc() });
        }
        staging.finish(flash, &self.key).map_err(refusal)?.map_err(Refusal::UnfitImage)?;
        self.staging = None;
        self.progress = Progress::Wanted;
        Ok(())
    }

    /// Judges the firmware that runs, where it is on trial, and keeps it once it has shown that it works. To be called often;
    /// erases a sector when it confirms, which it does in the dark only.
    pub fn look_after<F: NorFlash>(
        &mut self,
        flash: &mut F,
        health: Health,
        uptime: Milliseconds,
    ) -> Verdict {
        if self.progress != Progress::OnTrial {
            return Verdict::Wait;
        }
        let mut verdict = health.judge(uptime);
        if verdict == Verdict::Confirm {
            let confirmed = Progress::Settled(Outcome::Confirmed);
            match store_progress(flash, &self.layout, confirmed) {
                Ok(()) => self.progress = confirmed,
                Err(_) => verdict = Verdict::Wait,
            }
        }
        verdict
    }

    fn may_be_replaced(&self) -> Result<(), Refusal> {
        if self.running.is_none() {
            return Err(Refusal::NoBootLoader);
        }
        if self.progress == Progress::OnTrial {
            return Err(Refusal::OnTrial { retry: ASK_AFTER_TRIAL });
        }
        Ok(())
    }
}

fn refusal<E>(error: Error<E>) -> Refusal {
    match error {
        Error::TooLong { most } => Refusal::ImageLength { most },
        Error::Flash(_) | Error::Incomplete { .. } | Error::NotAsWritten => Refusal::StorageFailed,
    }
}
