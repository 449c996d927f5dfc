//! The flash chip under the board's own rules: it erases only while the lamps are dark or at a steady level, and only right
//! after the watchdog was fed.
//!
//! Every call of the flash stops all interrupts: a page for 0.4 ms, a sector for 45 ms, and for 400 ms at worst. No fade runs
//! on meanwhile, no interlock is obeyed but by the hardware, and no task says that it is alive.

use embassy_rp::flash::{self, Blocking, Flash};
use embassy_rp::peripherals::FLASH;
use embassy_time::{Duration, Instant};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use vitrine_exhibit::units::Milliseconds;
use vitrine_protocol::Refusal;
use vitrine_storage::Error;

use crate::board::StorageResources;
use crate::{controller, flash_map, watchdog};

/// The library's driver.
pub(crate) type Driver = Flash<'static, FLASH, Blocking, { flash_map::FLASH_BYTES }>;

/// After this time a host may try again what waits for steady lamps or the watchdog.
pub(crate) const RETRY: Milliseconds = Milliseconds(50);

/// The chip.
pub(crate) struct Chip {
    driver: Driver,
    /// Erases that were put off.
    put_off: u32,
    /// Since when they have been, without one that was made.
    put_off_since: Option<Instant>,
    /// One was put off because the lamps are fading.
    wants_stillness: bool,
}

/// Why the chip did not do it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ChipError {
    /// The chip or its driver failed.
    Flash(flash::Error),
    /// An erase has to wait: the lamps are fading.
    LampsInMotion,
    /// An erase has to wait: the watchdog was fed too long ago.
    Unfed,
}

impl Chip {
    /// Takes the chip.
    pub(crate) fn take(resources: StorageResources) -> Self {
        let driver = Driver::new_blocking(resources.flash);
        Self { driver, put_off: 0, put_off_since: None, wants_stillness: false }
    }

    /// The chip's own number.
    #[cfg(feature = "rp2040")]
    pub(crate) fn unique_id(&mut self) -> Option<[u8; 8]> {
        let mut id = [0; 8];
        self.driver.blocking_unique_id(&mut id).ok().map(|()| id)
    }

    /// Asks whether an erase may begin now.
    pub(crate) fn may_erase(&mut self) -> Result<(), ChipError> {
        let outcome = if !controller::lamps_are_steady() {
            Err(ChipError::LampsInMotion)
        } else if !watchdog::outlasts_an_erase() {
            Err(ChipError::Unfed)
        } else {
            return Ok(());
        };
        self.wants_stillness |= matches!(outcome, Err(ChipError::LampsInMotion));
        self.put_off = self.put_off.wrapping_add(1);
        self.put_off_since.get_or_insert_with(Instant::now);
        outcome
    }

    /// How many erases were put off until now.
    pub(crate) const fn put_off(&self) -> u32 {
        self.put_off
    }

    /// For how long no erase was made though one was due.
    pub(crate) fn put_off_for(&self) -> Duration {
        self.put_off_since.map_or(Duration::MIN, |since| since.elapsed())
    }

    /// Tells whether an erase was put off by fading lamps since the last call.
    pub(crate) const fn take_wish_for_stillness(&mut self) -> bool {
        core::mem::replace(&mut self.wants_stillness, false)
    }
}

impl NorFlashError for ChipError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Flash(error) => error.kind(),
            Self::LampsInMotion | Self::Unfed => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for Chip {
    type Error = ChipError;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), ChipError> {
        self.driver.read(offset, bytes).map_err(ChipError::Flash)
    }

    fn capacity(&self) -> usize {
        self.driver.capacity()
    }
}

impl NorFlash for Chip {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = flash::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), ChipError> {
        // Asked and begun without an interrupt between: no fade begins before the erase does.
        critical_section::with(|_| {
            self.may_erase()?;
            self.put_off_since = None;
            self.driver.erase(from, to).map_err(ChipError::Flash)
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), ChipError> {
        self.driver.write(offset, bytes).map_err(ChipError::Flash)
    }
}

/// Tells whether an error is only that an erase has to wait.
pub(crate) fn has_to_wait<T>(outcome: &Result<T, Error<ChipError>>) -> bool {
    matches!(outcome, Err(Error::Flash(ChipError::LampsInMotion | ChipError::Unfed)))
}

/// What a host is told of an error.
pub(crate) fn refusal(error: Error<ChipError>) -> Refusal {
    match error {
        Error::Flash(error) => error.into(),
        _ => Refusal::StorageFailed,
    }
}

impl From<ChipError> for Refusal {
    fn from(error: ChipError) -> Self {
        match error {
            ChipError::LampsInMotion => Self::LampsInMotion { retry: RETRY },
            ChipError::Unfed => Self::TooManyRequests { retry: RETRY },
            ChipError::Flash(_) => Self::StorageFailed,
        }
    }
}
