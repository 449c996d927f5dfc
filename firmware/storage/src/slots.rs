//! One record in two slots; the newest with a valid CRC counts.
//!
//! ```text
//! slot:  header (20 bytes) | free (12) | body (length bytes) | erased
//! header:  "VSLT" | generation u32 | length u32 | CRC of the body u32 | CRC of the header u32     little-endian
//! ```
//!
//! A new record goes to the slot that does not hold the newest: the slot's first sector is erased, and with it the
//! old header, then the body is written, sector after sector, verified, and the header written last.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use crate::{CRC, Error, map::SECTOR_BYTES};

const MAGIC: [u8; 4] = *b"VSLT";
const HEADER_BYTES: usize = 20;
const BODY_OFFSET: u32 = 32;
const READ_BYTES: usize = 64;

/// Two slots of the same size, one behind the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TwoSlots {
    start: u32,
    slot_bytes: u32,
}

impl TwoSlots {
    /// Two slots of `slot_bytes` from the address `start` on, both multiples of a sector.
    pub const fn new(start: u32, slot_bytes: u32) -> Self {
        assert!(start.is_multiple_of(SECTOR_BYTES) && slot_bytes.is_multiple_of(SECTOR_BYTES));
        assert!(slot_bytes > 0);
        Self { start, slot_bytes }
    }

    /// The first address.
    pub const fn start(&self) -> u32 {
        self.start
    }

    /// The first address behind both slots.
    pub const fn end(&self) -> u32 {
        self.start + 2 * self.slot_bytes
    }

    /// The longest record, in bytes.
    pub const fn capacity(&self) -> u32 {
        self.slot_bytes - BODY_OFFSET
    }

    /// Finds the newest valid record.
    pub fn newest<F: ReadNorFlash>(&self, flash: &mut F) -> Result<Option<Record>, Error<F::Error>> {
        let first = self.read_header(flash, 0)?;
        let second = self.read_header(flash, 1)?;
        let mut candidates = [first, second];
        candidates.sort_unstable_by_key(|record| {
            core::cmp::Reverse(record.as_ref().map(|record| record.generation))
        });
        for record in candidates.into_iter().flatten() {
            if checksum(flash, record.body, record.length)? == record.crc {
                return Ok(Some(record));
            }
        }
        Ok(None)
    }

    /// Stores a record that is in memory as a whole.
    pub fn store<F: NorFlash>(&self, flash: &mut F, bytes: &[u8]) -> Result<Record, Error<F::Error>> {
        let length = u32::try_from(bytes.len()).map_err(|_| Error::TooLong { most: self.capacity() })?;
        let mut writer = self.begin(flash, length)?;
        writer.append(flash, bytes)?;
        writer.finish(flash)
    }

    /// Begins a record of `length` bytes. The newest record stays valid until [`Writer::finish`].
    pub fn begin<F: NorFlash>(&self, flash: &mut F, length: u32) -> Result<Writer, Error<F::Error>> {
        const { assert!(F::WRITE_SIZE == 1 && F::READ_SIZE == 1, "the layout wants flash written by bytes") }
        if length > self.capacity() {
            return Err(Error::TooLong { most: self.capacity() });
        }
        let newest = self.newest(flash)?;
        let (slot, generation) =
            newest.map_or((0, 1), |newest| (1 - newest.slot, newest.generation.wrapping_add(1)));
        let header = self.header_address(slot);
        flash.erase(header, header + SECTOR_BYTES)?;
        let record = Record { slot, generation, body: header + BODY_OFFSET, length, crc: 0 };
        Ok(Writer { record, written: 0, erased_to: header + SECTOR_BYTES, digest: CRC.digest() })
    }

    fn header_address(&self, slot: u32) -> u32 {
        self.start + slot * self.slot_bytes
    }

    fn read_header<F: ReadNorFlash>(
        &self,
        flash: &mut F,
        slot: u32,
    ) -> Result<Option<Record>, Error<F::Error>> {
        let mut header = [0; HEADER_BYTES];
        let address = self.header_address(slot);
        flash.read(address, &mut header)?;
        let [magic, generation, length, crc, header_crc] = split_words(&header);
        let (checked, _) = header.split_at(HEADER_BYTES - 4);
        let length = u32::from_le_bytes(length);
        let valid = magic == MAGIC
            && length <= self.capacity()
            && CRC.checksum(checked) == u32::from_le_bytes(header_crc);
        Ok(valid.then(|| Record {
            slot,
            generation: u32::from_le_bytes(generation),
            body: address + BODY_OFFSET,
            length,
            crc: u32::from_le_bytes(crc),
        }))
    }
}

/// A record in flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    slot: u32,
    generation: u32,
    body: u32,
    length: u32,
    crc: u32,
}

impl Record {
    /// Its length in bytes.
    pub const fn length(&self) -> u32 {
        self.length
    }

    /// The CRC-32 of its bytes.
    pub const fn crc(&self) -> u32 {
        self.crc
    }

    /// How many records were stored here before it, and itself.
    pub const fn generation(&self) -> u32 {
        self.generation
    }

    /// Where its first byte lies, counted from the beginning of the flash.
    pub const fn address(&self) -> u32 {
        self.body
    }

    /// Reads from `offset` on until `part` is full or the record ends; gives the number of bytes read.
    pub fn read<F: ReadNorFlash>(
        &self,
        flash: &mut F,
        offset: u32,
        part: &mut [u8],
    ) -> Result<usize, Error<F::Error>> {
        let left = self.length.saturating_sub(offset);
        let wanted = part.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        if let Some(part) = part.get_mut(..wanted).filter(|part| !part.is_empty()) {
            flash.read(self.body + offset, part)?;
        }
        Ok(wanted)
    }
}

/// A record being written.
#[derive(Clone)]
pub struct Writer {
    record: Record,
    written: u32,
    erased_to: u32,
    digest: crc::Digest<'static, u32>,
}

impl core::fmt::Debug for Writer {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Writer").field("record", &self.record).field("written", &self.written).finish()
    }
}

impl Writer {
    /// How many bytes are written.
    pub const fn written(&self) -> u32 {
        self.written
    }

    /// Whether [`Writer::append`] of so many bytes will erase a sector, which stops the processor for a while.
    pub const fn will_erase(&self, bytes: u32) -> bool {
        self.record.body + self.written + bytes > self.erased_to
    }

    /// Writes the next bytes. After an error of its write the record has to be begun anew; where an erase was refused,
    /// nothing has changed and the same bytes may be tried again.
    pub fn append<F: NorFlash>(&mut self, flash: &mut F, bytes: &[u8]) -> Result<(), Error<F::Error>> {
        let too_long = Error::TooLong { most: self.record.length };
        let length = u32::try_from(bytes.len()).map_err(|_| Error::TooLong { most: self.record.length })?;
        let end =
            self.written.checked_add(length).filter(|end| *end <= self.record.length).ok_or(too_long)?;
        while self.record.body + end > self.erased_to {
            flash.erase(self.erased_to, self.erased_to + SECTOR_BYTES)?;
            self.erased_to += SECTOR_BYTES;
        }
        flash.write(self.record.body + self.written, bytes)?;
        self.digest.update(bytes);
        self.written = end;
        Ok(())
    }

    /// Reads what is written back and gives it as a record that is not valid yet, to be examined before
    /// [`Writer::finish`].
    pub fn staged<F: ReadNorFlash>(&self, flash: &mut F) -> Result<Record, Error<F::Error>> {
        if self.written < self.record.length {
            return Err(Error::Incomplete { written: self.written });
        }
        let crc = self.digest.clone().finalize();
        if checksum(flash, self.record.body, self.record.length)? != crc {
            return Err(Error::NotAsWritten);
        }
        Ok(Record { crc, ..self.record })
    }

    /// Verifies the bytes and writes the header: from its last byte on, this is the newest record.
    pub fn finish<F: NorFlash>(self, flash: &mut F) -> Result<Record, Error<F::Error>> {
        let record = self.staged(flash)?;
        let mut header = [0; HEADER_BYTES];
        let (checked, header_crc) = header.split_at_mut(HEADER_BYTES - 4);
        let words =
            [MAGIC, record.generation.to_le_bytes(), record.length.to_le_bytes(), record.crc.to_le_bytes()];
        for (place, word) in checked.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word);
        }
        header_crc.copy_from_slice(&CRC.checksum(checked).to_le_bytes());
        let address = record.body - BODY_OFFSET;
        flash.write(address, &header)?;
        let mut read_back = [0; HEADER_BYTES];
        flash.read(address, &mut read_back)?;
        if read_back == header { Ok(record) } else { Err(Error::NotAsWritten) }
    }
}

fn split_words(header: &[u8; HEADER_BYTES]) -> [[u8; 4]; HEADER_BYTES / 4] {
    let mut words = [[0; 4]; HEADER_BYTES / 4];
    for (word, bytes) in words.iter_mut().zip(header.chunks_exact(4)) {
        word.copy_from_slice(bytes);
    }
    words
}

/// The CRC of a stretch of flash.
fn checksum<F: ReadNorFlash>(flash: &mut F, address: u32, length: u32) -> Result<u32, Error<F::Error>> {
    let mut digest = CRC.digest();
    let mut buffer = [0; READ_BYTES];
    let mut done = 0;
    while done < length {
        let step = (length - done).min(READ_BYTES as u32);
        let Some(part) = buffer.get_mut(..step as usize) else { break };
        flash.read(address + done, part)?;
        digest.update(part);
        done += step;
    }
    Ok(digest.finalize())
}
