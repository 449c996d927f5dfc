//! The event log in flash: numbered from 1 without gaps, the newest entries are kept.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use vitrine_exhibit::{
    events::{DarkReason, Event, LogEntry},
    units::UtcSeconds,
};

use crate::{
    Error, RingPosition,
    map::{LOG, LOG_ENTRY_BYTES},
};

/// The event log's place in flash.
#[derive(Clone, Copy, Debug)]
pub struct EventLog {
    position: RingPosition,
    /// The last that was kept of the lamps is that they are dark.
    says_dark: bool,
}

impl EventLog {
    /// Finds the newest entry, to be done once after the start.
    pub fn open<F: ReadNorFlash>(flash: &mut F) -> Result<Self, Error<F::Error>> {
        LOG.open(flash).map(|opened| Self { position: opened.position, says_dark: true })
    }

    /// The oldest entry kept; [`EventLog::next`] if there is none.
    pub const fn oldest(&self) -> u32 {
        self.position.oldest()
    }

    /// The number that the next entry gets.
    pub const fn next(&self) -> u32 {
        self.position.next()
    }

    /// Whether there is a sector to erase ahead of need.
    pub const fn wants_room(&self) -> bool {
        LOG.wants_room(&self.position)
    }

    /// Erases ahead of need, which stops the processor for a while. The oldest entries go.
    pub fn make_room<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), Error<F::Error>> {
        LOG.make_room(flash, &mut self.position)
    }

    /// Adds an event, if it is worth its place; gives its number. What comes and goes with every visitor is not: it
    /// would push out what a technician or a conservator looks for.
    pub fn keep<F: NorFlash>(
        &mut self,
        flash: &mut F,
        time: Option<UtcSeconds>,
        uptime_s: u32,
        event: Event,
    ) -> Result<Option<u32>, Error<F::Error>> {
        let kept = match event {
            Event::Dark(DarkReason::NobodyThere | DarkReason::NothingToShow) => false,
            Event::Lit => self.says_dark,
            event => event.is_kept(),
        };
        if !kept {
            return Ok(None);
        }
        let sequence = self.append(flash, time, uptime_s, event)?;
        match event {
            Event::Dark(_) => self.says_dark = true,
            Event::Lit => self.says_dark = false,
            _ => {}
        }
        Ok(Some(sequence))
    }

    /// Adds an event; gives its number. Erases a sector first where [`EventLog::make_room`] has not.
    pub fn append<F: NorFlash>(
        &mut self,
        flash: &mut F,
        time: Option<UtcSeconds>,
        uptime_s: u32,
        event: Event,
    ) -> Result<u32, Error<F::Error>> {
        let mut bytes = [0; LOG_ENTRY_BYTES];
        let most = LOG_ENTRY_BYTES as u32;
        postcard::to_slice(&(time, uptime_s, event), &mut bytes).map_err(|_| Error::TooLong { most })?;
        LOG.append(flash, &mut self.position, &bytes)
    }

    /// Reads an entry; none if it is no longer kept, or was written by a firmware with other events.
    pub fn read<F: ReadNorFlash>(
        &self,
        flash: &mut F,
        sequence: u32,
    ) -> Result<Option<LogEntry>, Error<F::Error>> {
        let entry = LOG.read(flash, &self.position, sequence)?;
        Ok(entry
            .and_then(|bytes| postcard::from_bytes(&bytes).ok())
            .map(|(time, uptime_s, event)| LogEntry { sequence, time, uptime_s, event }))
    }
}
