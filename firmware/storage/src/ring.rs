//! Numbered entries of one size in a ring of sectors; the newest are kept.
//!
//! ```text
//! sector:  entry | entry | ... | unused rest
//! entry:   sequence u32 | payload (N bytes) | CRC of both u32        little-endian
//! ```
//!
//! Entries are programmed one behind the other. Before the first entry of a sector is programmed the sector is
//! erased, so the oldest entries go, a sector at a time; the newest lie in another sector and are never touched.
//! Who must not erase at the moment of an entry has that done ahead ([`Ring::make_room`]), as soon as the sector before is
//! begun. What was erased ahead before a power cut is erased again: nobody knows whether that erase came to its end.
//! An entry that was cut fails its CRC; its place is skipped, its number goes to the next.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use crate::{CRC, Error, map::SECTOR_BYTES};

const SEQUENCE_BYTES: usize = 4;
const CRC_BYTES: usize = 4;

/// A ring of sectors for entries of `N` bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ring<const N: usize> {
    start: u32,
    sectors: u32,
}

/// Where a ring goes on, found once after the start by [`Ring::open`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingPosition {
    place: u32,
    next: u32,
    oldest: u32,
    /// The sector that was erased since the start and holds nothing yet.
    erased: Option<u32>,
}

impl RingPosition {
    /// The number that the next entry gets; the first entry of all has 1.
    pub const fn next(&self) -> u32 {
        self.next
    }

    /// The oldest entry kept; `next` if there is none.
    pub const fn oldest(&self) -> u32 {
        self.oldest
    }
}

/// What [`Ring::open`] finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opened<const N: usize> {
    /// Where the ring goes on.
    pub position: RingPosition,
    /// The newest entry; none in an empty ring.
    pub newest: Option<[u8; N]>,
}

struct Entry<const N: usize> {
    sequence: u32,
    payload: [u8; N],
}

impl<const N: usize> Ring<N> {
    const ENTRY_BYTES: u32 = (SEQUENCE_BYTES + N + CRC_BYTES) as u32;
    const PER_SECTOR: u32 = SECTOR_BYTES / Self::ENTRY_BYTES;

    /// A ring from the address `start` on, a multiple of a sector; at least three sectors: the newest
    /// entry's, the one that is begun, and one that is erased ahead.
    pub const fn new(start: u32, sectors: u32) -> Self {
        assert!(start.is_multiple_of(SECTOR_BYTES) && sectors >= 3 && Self::PER_SECTOR >= 1);
        Self { start, sectors }
    }

    /// The first address of the ring.
    pub const fn start(&self) -> u32 {
        self.start
    }

    /// The first address behind the ring.
    pub const fn end(&self) -> u32 {
        self.start + self.sectors * SECTOR_BYTES
    }

    /// How many of the newest entries are kept at the least, if none was cut: those of all sectors but the one that is being
    /// filled and the one that is erased ahead.
    pub const fn kept_at_least(&self) -> u32 {
        (self.sectors - 2) * Self::PER_SECTOR
    }

    /// How many appends erase each sector once.
    pub const fn appends_per_round(&self) -> u32 {
        self.places()
    }

    /// Finds the newest entry and where to go on.
    pub fn open<F: ReadNorFlash>(&self, flash: &mut F) -> Result<Opened<N>, Error<F::Error>> {
        let mut newest: Option<(u32, Entry<N>)> = None;
        for place in 0..self.places() {
            if let Some(entry) = self.entry(flash, place)?
                && newest.as_ref().is_none_or(|(_, other)| entry.sequence > other.sequence)
            {
                newest = Some((place, entry));
            }
        }
        let Some((place, entry)) = newest else {
            return Ok(Opened {
                position: RingPosition { place: 0, next: 1, oldest: 1, erased: None },
                newest: None,
            });
        };
        let next = entry.sequence.saturating_add(1);
        let oldest = self.find_oldest(flash, place, entry.sequence)?;
        let position = RingPosition { place: self.after(place), next, oldest, erased: None };
        Ok(Opened { position, newest: Some(entry.payload) })
    }

    /// Whether the next append will erase a sector, which stops the processor for a while.
    pub const fn will_erase(&self, position: &RingPosition) -> bool {
        position.place.is_multiple_of(Self::PER_SECTOR) && self.wants_room(position)
    }

    /// Whether [`Ring::make_room`] has something to erase.
    pub const fn wants_room(&self, position: &RingPosition) -> bool {
        !matches!(position.erased, Some(erased) if erased == self.sector_to_begin(position))
    }

    /// Erases the sector that will be begun next, so that no append has to until that one is full; its entries are the
    /// oldest. On an error nothing has changed, and it may be tried again.
    pub fn make_room<F: NorFlash>(
        &self,
        flash: &mut F,
        position: &mut RingPosition,
    ) -> Result<(), Error<F::Error>> {
        let sector = self.sector_to_begin(position);
        let mut first_kept = position.oldest;
        for place in sector * Self::PER_SECTOR..(sector + 1) * Self::PER_SECTOR {
            if let Some(entry) = self.entry(flash, place)?
                && entry.sequence >= first_kept
                && entry.sequence < position.next
            {
                first_kept = entry.sequence + 1;
            }
        }
        let address = self.address(sector * Self::PER_SECTOR);
        flash.erase(address, address + SECTOR_BYTES)?;
        position.oldest = first_kept;
        position.erased = Some(sector);
        Ok(())
    }

    /// Adds an entry. On an error the entry may be tried again: its place is skipped.
    pub fn append<F: NorFlash>(
        &self,
        flash: &mut F,
        position: &mut RingPosition,
        payload: &[u8; N],
    ) -> Result<u32, Error<F::Error>> {
        const { assert!(F::WRITE_SIZE == 1 && F::READ_SIZE == 1, "the layout wants flash written by bytes") }
        for _ in 0..=Self::PER_SECTOR {
            if self.will_erase(position) {
                self.make_room(flash, position)?;
            }
            let place = position.place;
            if place.is_multiple_of(Self::PER_SECTOR) {
                position.erased = None;
            }
            position.place = self.after(place);
            if self.is_blank(flash, place)? {
                let sequence = position.next;
                self.program(flash, place, sequence, payload)?;
                position.next = sequence.saturating_add(1);
                return Ok(sequence);
            }
        }
        Err(Error::NotAsWritten)
    }

    /// Reads the entry with this number, if it is still kept.
    pub fn read<F: ReadNorFlash>(
        &self,
        flash: &mut F,
        position: &RingPosition,
        sequence: u32,
    ) -> Result<Option<[u8; N]>, Error<F::Error>> {
        if sequence < position.oldest || sequence >= position.next {
            return Ok(None);
        }
        // Places that were cut lie between: the entry is at least so many places back, and rarely further.
        let back = position.next - sequence;
        let mut place = self.before(position.place, back);
        for _ in 0..self.places() {
            if let Some(entry) = self.entry(flash, place)?
                && entry.sequence == sequence
            {
                return Ok(Some(entry.payload));
            }
            place = self.before(place, 1);
        }
        Ok(None)
    }

    /// The sector of the next place where that is its first, and the one behind it where it is not.
    const fn sector_to_begin(&self, position: &RingPosition) -> u32 {
        position.place.div_ceil(Self::PER_SECTOR) % self.sectors
    }

    const fn places(&self) -> u32 {
        self.sectors * Self::PER_SECTOR
    }

    const fn after(&self, place: u32) -> u32 {
        if place + 1 >= self.places() { 0 } else { place + 1 }
    }

    const fn before(&self, place: u32, back: u32) -> u32 {
        let places = self.places();
        (place + places - back % places) % places
    }

    const fn address(&self, place: u32) -> u32 {
        self.start + place / Self::PER_SECTOR * SECTOR_BYTES + place % Self::PER_SECTOR * Self::ENTRY_BYTES
    }

    /// Walks back from the newest entry as long as the numbers fall by one, over places that were cut.
    fn find_oldest<F: ReadNorFlash>(
        &self,
        flash: &mut F,
        newest_place: u32,
        newest: u32,
    ) -> Result<u32, Error<F::Error>> {
        let mut oldest = newest;
        let mut place = newest_place;
        for _ in 1..self.places() {
            place = self.before(place, 1);
            match self.entry(flash, place)? {
                Some(entry) if entry.sequence.checked_add(1) == Some(oldest) => oldest = entry.sequence,
                Some(_) => break,
                None => {}
            }
        }
        Ok(oldest)
    }

    fn program<F: NorFlash>(
        &self,
        flash: &mut F,
        place: u32,
        sequence: u32,
        payload: &[u8; N],
    ) -> Result<(), Error<F::Error>> {
        let address = self.address(place);
        let sequence_bytes = sequence.to_le_bytes();
        let mut digest = CRC.digest();
        digest.update(&sequence_bytes);
        digest.update(payload);
        flash.write(address, &sequence_bytes)?;
        flash.write(address + SEQUENCE_BYTES as u32, payload)?;
        flash.write(address + (SEQUENCE_BYTES + N) as u32, &digest.finalize().to_le_bytes())?;
        match self.entry(flash, place)? {
            Some(entry) if entry.sequence == sequence && entry.payload == *payload => Ok(()),
            _ => Err(Error::NotAsWritten),
        }
    }

    fn entry<F: ReadNorFlash>(&self, flash: &mut F, place: u32) -> Result<Option<Entry<N>>, Error<F::Error>> {
        let address = self.address(place);
        let mut sequence = [0; SEQUENCE_BYTES];
        flash.read(address, &mut sequence)?;
        if sequence == [0xff; SEQUENCE_BYTES] {
            return Ok(None);
        }
        let mut payload = [0; N];
        let mut crc = [0; CRC_BYTES];
        flash.read(address + SEQUENCE_BYTES as u32, &mut payload)?;
        flash.read(address + (SEQUENCE_BYTES + N) as u32, &mut crc)?;
        let mut digest = CRC.digest();
        digest.update(&sequence);
        digest.update(&payload);
        let valid = digest.finalize() == u32::from_le_bytes(crc);
        Ok(valid.then(|| Entry { sequence: u32::from_le_bytes(sequence), payload }))
    }

    fn is_blank<F: ReadNorFlash>(&self, flash: &mut F, place: u32) -> Result<bool, Error<F::Error>> {
        let address = self.address(place);
        let mut byte = [0; 16];
        let mut done = 0;
        while done < Self::ENTRY_BYTES {
            let step = (Self::ENTRY_BYTES - done).min(16);
            let Some(part) = byte.get_mut(..step as usize) else { break };
            flash.read(address + done, part)?;
            if part.iter().any(|byte| *byte != 0xff) {
                return Ok(false);
            }
            done += step;
        }
        Ok(true)
    }
}
