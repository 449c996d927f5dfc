//! The dose ledger in flash: each record holds all totals, the newest valid one counts.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_exhibit::ledger::LedgerRecord;

use crate::{
    Error, Opened, RingPosition,
    map::{LEDGER, LEDGER_ENTRY_BYTES},
};

/// The dose ledger's place in flash.
#[derive(Clone, Copy, Debug)]
pub struct Ledger {
    position: RingPosition,
}

impl Ledger {
    /// Finds the newest record, to be done once after the start.
    pub fn open<F: ReadNorFlash>(flash: &mut F) -> Result<(Self, Option<LedgerRecord>), Error<F::Error>> {
        let Opened { position, newest } = LEDGER.open(flash)?;
        let record = newest.and_then(|bytes| postcard::from_bytes(&bytes).ok());
        Ok((Self { position }, record))
    }

    /// Whether there is a sector to erase ahead of need.
    pub const fn wants_room(&self) -> bool {
        LEDGER.wants_room(&self.position)
    }

    /// Erases ahead of need, which stops the processor for a while. The newest record lies elsewhere.
    pub fn make_room<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), Error<F::Error>> {
        LEDGER.make_room(flash, &mut self.position)
    }

    /// Stores a record; erases a sector first where [`Ledger::make_room`] has not. When it returns, the record survives a power cut.
    pub fn store<F: NorFlash>(
        &mut self,
        flash: &mut F,
        record: &LedgerRecord,
    ) -> Result<(), Error<F::Error>> {
        let mut bytes = [0; LEDGER_ENTRY_BYTES];
        let most = LEDGER_ENTRY_BYTES as u32;
        postcard::to_slice(record, &mut bytes).map_err(|_| Error::TooLong { most })?;
        LEDGER.append(flash, &mut self.position, &bytes).map(|_| ())
    }
}
