//! The flash chip under the board's own rule: it erases only while the lamps are dark or at a steady level.
//!
//! Every call of the flash stops all interrupts: a page for 0.4 ms, a sector for 45 ms. No fade runs on meanwhile, and no
//! interlock is obeyed but by the hardware.

use embassy_rp::flash::{self, Blocking, Flash};
use embassy_rp::peripherals::FLASH;
use embassy_time::{Duration, Instant};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use vitrine_exhibit::units::Milliseconds;
use vitrine_protocol::Refusal;
use vitrine_storage::Error;

use crate::board::StorageResources;
use crate::{controller, flash_map};

/// The library's driver.
pub(crate) type Driver = Flash<'static, FLASH, Blocking, { flash_map::FLASH_BYTES }>;

/// After this time a host may try again what waits for steady lamps.
pub(crate) const RETRY: Milliseconds = Milliseconds(50);

/// Between two erases that nobody waits for: all tasks check in with the watchdog, and it is fed.
const REST: Duration = Duration::from_millis(150);

/// The chip.
pub(crate) struct Chip {
    driver: Driver,
    erased_at: Instant,
}

/// Why the chip did not do it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ChipError {
    /// The chip or its driver failed.
    Flash(flash::Error),
    /// An erase has to wait: the lamps are fading.
    LampsInMotion,
}

impl Chip {
    /// Takes the chip.
    pub(crate) fn take(resources: StorageResources) -> Self {
        Self { driver: Driver::new_blocking(resources.flash), erased_at: Instant::MIN }
    }

    /// The chip's own number.
    #[cfg(feature = "rp2040")]
    pub(crate) fn unique_id(&mut self) -> Option<[u8; 8]> {
        let mut id = [0; 8];
        self.driver.blocking_unique_id(&mut id).ok().map(|()| id)
    }

    /// Tells whether an erase that nobody waits for may be made now.
    pub(crate) fn may_tidy_up(&self) -> bool {
        controller::lamps_are_steady() && Instant::now() >= self.erased_at.saturating_add(REST)
    }
}

impl NorFlashError for ChipError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Flash(error) => error.kind(),
            Self::LampsInMotion => NorFlashErrorKind::Other,
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
        let outcome = critical_section::with(|_| {
            if controller::lamps_are_steady() {
                self.driver.erase(from, to).map_err(ChipError::Flash)
            } else {
                Err(ChipError::LampsInMotion)
            }
        });
        self.erased_at = Instant::now();
        outcome
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), ChipError> {
        self.driver.write(offset, bytes).map_err(ChipError::Flash)
    }
}

/// Tells whether an error is only that the lamps are fading.
pub(crate) fn is_in_motion<T>(outcome: &Result<T, Error<ChipError>>) -> bool {
    matches!(outcome, Err(Error::Flash(ChipError::LampsInMotion)))
}

/// What a host is told of an error.
pub(crate) fn refusal(error: Error<ChipError>) -> Refusal {
    match error {
        Error::Flash(ChipError::LampsInMotion) => Refusal::LampsInMotion { retry: RETRY },
        _ => Refusal::StorageFailed,
    }
}

/// Puts a host off while the lamps are fading, before work is done that ends in an erase.
pub(crate) fn wait_for_steady_lamps() -> Result<(), Refusal> {
    if controller::lamps_are_steady() { Ok(()) } else { Err(Refusal::LampsInMotion { retry: RETRY }) }
}
