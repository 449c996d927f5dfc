//! The flash of the exhibit's controller: 2 MiB, in sectors of 4 KiB that are erased as a whole.
//!
//! ```text
//! 0x000000  boot loader           56 KiB
//! 0x00E000  update's progress     2 slots of 4 KiB
//! 0x010000  active image          320 KiB, its header in front
//! 0x060000  new image             as many
//! 0x0B0000  old image             as many
//! 0x100000  plan                  2 slots of 16 KiB
//! 0x108000  settings              2 slots of 4 KiB
//! 0x10A000  dose ledger           ring of 8 sectors
//! 0x112000  clock                 2 slots of 4 KiB
//! 0x114000  free
//! 0x1E0000  event log             ring of 32 sectors
//! 0x200000  end
//! ```
//!
//! Addresses count from the beginning of the flash chip.

use crate::{Ring, TwoSlots};

/// The smallest part that can be erased, in bytes.
pub const SECTOR_BYTES: u32 = 4096;

/// The whole chip, in bytes.
pub const FLASH_BYTES: u32 = 2 * 1024 * 1024;

/// How far an update of the firmware is.
pub const PROGRESS: TwoSlots = TwoSlots::new(0xE000, SECTOR_BYTES);

/// Bytes of each place for an image.
pub const IMAGE_BYTES: u32 = 80 * SECTOR_BYTES;

/// The image that runs.
pub const ACTIVE_IMAGE: u32 = PROGRESS.end();

/// The image that a host has sent.
pub const NEW_IMAGE: u32 = ACTIVE_IMAGE + IMAGE_BYTES;

/// The image that ran before.
pub const OLD_IMAGE: u32 = NEW_IMAGE + IMAGE_BYTES;

/// The end of the space for boot loader and images.
pub const IMAGE_END: u32 = OLD_IMAGE + IMAGE_BYTES;

/// The plan.
pub const PLAN: TwoSlots = TwoSlots::new(IMAGE_END, 4 * SECTOR_BYTES);

/// The settings made on the spot.
pub const SETTINGS: TwoSlots = TwoSlots::new(PLAN.end(), SECTOR_BYTES);

/// Bytes of an entry of the dose ledger.
pub const LEDGER_ENTRY_BYTES: usize = 120;

/// The dose ledger.
pub const LEDGER: Ring<LEDGER_ENTRY_BYTES> = Ring::new(SETTINGS.end(), 8);

/// What is known of the battery clock.
pub const CLOCK: TwoSlots = TwoSlots::new(LEDGER.end(), SECTOR_BYTES);

/// Bytes of an entry of the event log.
pub const LOG_ENTRY_BYTES: usize = 32;

/// The event log, at the very end.
pub const LOG: Ring<LOG_ENTRY_BYTES> = Ring::new(FLASH_BYTES - 32 * SECTOR_BYTES, 32);

const _: () = {
    assert!(ACTIVE_IMAGE == 0x1_0000 && NEW_IMAGE == 0x6_0000 && OLD_IMAGE == 0xB_0000);
    assert!(IMAGE_END == 0x10_0000);
    assert!(PLAN.end() == 0x10_8000);
    assert!(SETTINGS.end() == 0x10_A000);
    assert!(LEDGER.end() == 0x11_2000);
    assert!(CLOCK.end() == 0x11_4000);
    assert!(CLOCK.end() <= LOG.start());
    assert!(LOG.end() == FLASH_BYTES);
};
