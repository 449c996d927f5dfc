//! An image on its way from a host to its place.

use crc::Digest as CrcDigest;
use embedded_storage::nor_flash::NorFlash;
use vitrine_protocol::firmware::{ImageFault, Outcome, Progress};
use vitrine_storage::map::SECTOR_BYTES;
use vitrine_storage::{CRC, Error};

use crate::header::{HEADER_BYTES, Header};
use crate::image::{Key, Layout};
use crate::progress::{progress, store_progress};

/// What is compared at once when a write is read back.
const READ_BYTES: usize = 64;

/// An image being written to the new place. Whatever is hashed has been read back from flash just before: verifying the whole
/// at its end would stop the tasks of a running firmware for too long.
#[derive(Clone)]
pub struct Staging {
    layout: Layout,
    length: u32,
    written: u32,
    crc: CrcDigest<'static, u32>,
    header: [u8; HEADER_BYTES as usize],
    digest: blake3::Hasher,
    /// What the whole image is, once it has been verified.
    verified: Option<Result<Header, ImageFault>>,
}

impl core::fmt::Debug for Staging {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Staging").field("length", &self.length).field("written", &self.written).finish()
    }
}

impl Staging {
    /// The most bytes of an image with its header.
    pub const fn capacity(layout: &Layout) -> u32 {
        layout.new.bytes()
    }

    /// Begins an image of `length` bytes, its header among them. A new image that waits for its installation is given up.
    ///
    /// # Errors
    /// The image does not fit, or the flash failed.
    pub fn begin<F: NorFlash>(flash: &mut F, layout: &Layout, length: u32) -> Result<Self, Error<F::Error>> {
        const { assert!(F::WRITE_SIZE == 1 && F::READ_SIZE == 1, "the layout wants flash written by bytes") }
        let most = Self::capacity(layout);
        if length <= HEADER_BYTES || length > most {
            return Err(Error::TooLong { most });
        }
        if progress(flash, layout)? == Progress::Wanted {
            store_progress(flash, layout, Progress::Settled(Outcome::NoUpdate))?;
        }
        Ok(Self {
            layout: *layout,
            length,
            written: 0,
            crc: CRC.digest(),
            header: [0; HEADER_BYTES as usize],
            digest: blake3::Hasher::new(),
            verified: None,
        })
    }

    /// How many bytes are written.
    pub const fn written(&self) -> u32 {
        self.written
    }

    /// Whether [`Staging::append`] of so many bytes will erase a sector, which stops the processor for a while.
    pub const fn will_erase(&self, bytes: u32) -> bool {
        let erased_to = self.written.next_multiple_of(SECTOR_BYTES);
        self.written + bytes > erased_to
    }

    /// Writes the next bytes and reads them back. After an error the image has to be begun anew, but where an erase was
    /// refused: then nothing has changed.
    ///
    /// # Errors
    /// More bytes than announced, or the flash failed.
    pub fn append<F: NorFlash>(&mut self, flash: &mut F, bytes: &[u8]) -> Result<(), Error<F::Error>> {
        let too_long = Error::TooLong { most: self.length };
        let Ok(count) = u32::try_from(bytes.len()) else { return Err(too_long) };
        let end = self.written.checked_add(count).filter(|end| *end <= self.length).ok_or(too_long)?;
        let start = self.layout.new.start();
        for sector in (self.written.next_multiple_of(SECTOR_BYTES)..end).step_by(SECTOR_BYTES as usize) {
            flash.erase(start + sector, start + sector + SECTOR_BYTES)?;
        }
        flash.write(start + self.written, bytes)?;
        let mut at = start + self.written;
        for part in bytes.chunks(READ_BYTES) {
            let mut read = [0; READ_BYTES];
            let read = read.get_mut(..part.len()).unwrap_or_default();
            flash.read(at, read)?;
            if read != part {
                return Err(Error::NotAsWritten);
            }
            at += part.len() as u32;
        }
        self.crc.update(bytes);
        let of_header = (HEADER_BYTES.saturating_sub(self.written) as usize).min(bytes.len());
        let (front, image) = bytes.split_at(of_header);
        for (place, byte) in self.header.iter_mut().skip(self.written as usize).zip(front) {
            *place = *byte;
        }
        self.digest.update(image);
        self.written = end;
        Ok(())
    }

    /// The header, when these bytes were the last of it: what it tells need not wait for the image.
    pub fn header_after(&self, bytes: usize) -> Option<&[u8; HEADER_BYTES as usize]> {
        let before = self.written.saturating_sub(u32::try_from(bytes).unwrap_or(u32::MAX));
        (before < HEADER_BYTES && self.written >= HEADER_BYTES).then_some(&self.header)
    }

    /// The CRC-32 of what is written.
    pub fn crc(&self) -> u32 {
        self.crc.clone().finalize()
    }

    /// Verifies the image, and has the next start install it. Where the erase for that was refused it may be tried again, and
    /// the image, of which nothing can have changed, is not verified again: that takes long.
    ///
    /// # Errors
    /// The image is incomplete, or the flash failed. Within: why it is no image to install.
    pub fn finish<F: NorFlash>(
        &mut self,
        flash: &mut F,
        key: &impl Key,
    ) -> Result<Result<Header, ImageFault>, Error<F::Error>> {
        if self.written < self.length {
            return Err(Error::Incomplete { written: self.written });
        }
        let verified = match self.verified.take() {
            Some(verified) => verified,
            None => self.verify(key),
        };
        self.verified = Some(verified.clone());
        if verified.is_ok() {
            store_progress(flash, &self.layout, Progress::Wanted)?;
        }
        Ok(verified)
    }

    fn verify(&self, key: &impl Key) -> Result<Header, ImageFault> {
        let header = self.layout.vouch(&self.header, key)?;
        // What lies behind the image would not be signed.
        if HEADER_BYTES + header.length != self.length {
            return Err(ImageFault::Length);
        }
        let is_whole = *self.digest.finalize().as_bytes() == header.digest;
        if is_whole { Ok(header) } else { Err(ImageFault::Damaged) }
    }
}
