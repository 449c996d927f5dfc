//! Images in their places: verifying and copying.

use ed25519_dalek::{Signature, Verifier, VerifyingKey};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_protocol::firmware::ImageFault;
use vitrine_storage::map::{ACTIVE_IMAGE, IMAGE_BYTES, NEW_IMAGE, OLD_IMAGE, PROGRESS, SECTOR_BYTES};
use vitrine_storage::{Error, TwoSlots};

use crate::header::{HEADER_BYTES, Header, SIGNED_BYTES};

/// Where the processor sees the beginning of the flash: the same on RP2040 and RP2350 (their data sheets, 2.2).
const FLASH_BASE: u32 = 0x1000_0000;

/// What is read and written at once: a page of the flash.
const PAGE_BYTES: usize = 256;

/// A place for one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    start: u32,
    bytes: u32,
}

impl Slot {
    /// A place of `bytes` from the address `start` of the flash on, both multiples of a sector.
    pub const fn new(start: u32, bytes: u32) -> Self {
        assert!(start.is_multiple_of(SECTOR_BYTES) && bytes.is_multiple_of(SECTOR_BYTES) && bytes > 0);
        Self { start, bytes }
    }

    /// Its first address in the flash.
    pub const fn start(&self) -> u32 {
        self.start
    }

    /// How many bytes it holds, an image's header among them.
    pub const fn bytes(&self) -> u32 {
        self.bytes
    }
}

/// The places of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The board's name, as images name it, filled up with zeros.
    pub board: [u8; 8],
    /// What runs.
    pub active: Slot,
    /// What a host has sent.
    pub new: Slot,
    /// What ran before.
    pub old: Slot,
    /// How far an update is.
    pub progress: TwoSlots,
}

/// The places of the Raspberry Pi Pico.
pub const LAYOUT: Layout = Layout {
    board: *b"rp2040\0\0",
    active: Slot::new(ACTIVE_IMAGE, IMAGE_BYTES),
    new: Slot::new(NEW_IMAGE, IMAGE_BYTES),
    old: Slot::new(OLD_IMAGE, IMAGE_BYTES),
    progress: PROGRESS,
};

impl Layout {
    /// The address at which the processor finds the active image's vector table, and to which images are linked.
    pub const fn address(&self) -> u32 {
        FLASH_BASE + self.active.start + HEADER_BYTES
    }

    /// Holds a header against this board and the key: everything but its signature and the image behind it.
    ///
    /// # Errors
    /// Why it is not for this board, or names another key.
    pub fn suits(&self, bytes: &[u8; HEADER_BYTES as usize], key: &impl Key) -> Result<Header, ImageFault> {
        let header = Header::from_bytes(bytes)?;
        if header.board != self.board {
            return Err(ImageFault::OtherBoard);
        }
        if header.address != self.address() {
            return Err(ImageFault::OtherAddress);
        }
        if header.length == 0 || header.length > self.active.bytes - HEADER_BYTES {
            return Err(ImageFault::Length);
        }
        if header.key != key.hint() {
            return Err(ImageFault::OtherKey);
        }
        Ok(header)
    }

    /// The same, and its signature.
    ///
    /// # Errors
    /// Why it is not for this board, or not signed.
    pub fn vouch(&self, bytes: &[u8; HEADER_BYTES as usize], key: &impl Key) -> Result<Header, ImageFault> {
        let header = self.suits(bytes, key)?;
        let signed = bytes.get(..SIGNED_BYTES).unwrap_or_default();
        if key.has_signed(signed, &header.signature) { Ok(header) } else { Err(ImageFault::Signature) }
    }
}

/// A key by which images are verified.
pub trait Key {
    /// Its first bytes, as a header names it.
    fn hint(&self) -> [u8; 8];
    /// Whether the signature is this key's, of this message.
    fn has_signed(&self, message: &[u8], signature: &[u8; 64]) -> bool;
}

impl Key for VerifyingKey {
    fn hint(&self) -> [u8; 8] {
        self.as_bytes().first_chunk().copied().unwrap_or_default()
    }

    fn has_signed(&self, message: &[u8], signature: &[u8; 64]) -> bool {
        self.verify(message, &Signature::from_bytes(signature)).is_ok()
    }
}

/// Nobody's key: it has signed nothing.
impl<K: Key> Key for Option<K> {
    fn hint(&self) -> [u8; 8] {
        self.as_ref().map(Key::hint).unwrap_or_default()
    }

    fn has_signed(&self, message: &[u8], signature: &[u8; 64]) -> bool {
        self.as_ref().is_some_and(|key| key.has_signed(message, signature))
    }
}

/// Verifies the image in a place: board, address, length, signature, and that all of it is what was signed.
///
/// # Errors
/// The flash cannot be read. Within: why it is no image to run.
pub fn verify<F: ReadNorFlash>(
    flash: &mut F,
    layout: &Layout,
    slot: Slot,
    key: &impl Key,
) -> Result<Result<Header, ImageFault>, Error<F::Error>> {
    let mut bytes = [0; HEADER_BYTES as usize];
    flash.read(slot.start, &mut bytes)?;
    let header = match layout.vouch(&bytes, key) {
        Ok(header) => header,
        Err(fault) => return Ok(Err(fault)),
    };
    let mut digest = blake3::Hasher::new();
    let body = slot.start + HEADER_BYTES;
    in_pages(body, header.length, |at, page| {
        flash.read(at, page)?;
        digest.update(page);
        Ok(())
    })?;
    let is_whole = *digest.finalize().as_bytes() == header.digest;
    Ok(if is_whole { Ok(header) } else { Err(ImageFault::Damaged) })
}

/// Copies an image with its header, and reads it back. The rest of the last sector is left erased.
///
/// # Errors
/// The flash failed, or does not hold what was written.
pub(crate) fn copy<F: NorFlash>(
    flash: &mut F,
    from: Slot,
    to: Slot,
    image: &Header,
) -> Result<(), Error<F::Error>> {
    let total = HEADER_BYTES + image.length;
    in_pages(0, total, |offset, page| {
        let (source, target) = (from.start + offset, to.start + offset);
        if offset.is_multiple_of(SECTOR_BYTES) {
            flash.erase(target, target + SECTOR_BYTES)?;
        }
        flash.read(source, page)?;
        flash.write(target, page)?;
        Ok(())
    })?;
    in_pages(0, total, |offset, page| {
        let mut copied = [0; PAGE_BYTES];
        let copied = copied.get_mut(..page.len()).unwrap_or_default();
        flash.read(from.start + offset, page)?;
        flash.read(to.start + offset, copied)?;
        if page == copied { Ok(()) } else { Err(Error::NotAsWritten) }
    })
}

/// Calls `page` for each page from `start` on, the last one cut to the length.
fn in_pages<E>(
    start: u32,
    length: u32,
    mut page: impl FnMut(u32, &mut [u8]) -> Result<(), Error<E>>,
) -> Result<(), Error<E>> {
    let mut buffer = [0; PAGE_BYTES];
    for offset in (0..length).step_by(PAGE_BYTES) {
        let bytes = (length - offset).min(PAGE_BYTES as u32) as usize;
        page(start + offset, buffer.get_mut(..bytes).unwrap_or_default())?;
    }
    Ok(())
}
