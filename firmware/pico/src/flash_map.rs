//! Where records lie in flash: memory.x says it to the linker, the storage crate to the code, and here both are held
//! to each other.

use vitrine_storage::map;

include!(concat!(env!("OUT_DIR"), "/flash_map.rs"));

const _: () = {
    assert!(PLAN.start == map::IMAGE_END && PLAN.end == map::PLAN.end());
    assert!(SETTINGS.start == map::PLAN.end() && SETTINGS.end == map::SETTINGS.end());
    assert!(LEDGER.start == map::LEDGER.start() && LEDGER.end == map::LEDGER.end());
    assert!(CLOCK.start == map::LEDGER.end() && CLOCK.end == map::CLOCK.end());
    assert!(LOG.start == map::LOG.start() && LOG.end == map::LOG.end());
    assert!(FLASH_BYTES == map::FLASH_BYTES as usize);
};

#[cfg(feature = "rp2040")]
const _: () = {
    assert!(PROGRESS.end == map::PROGRESS.end() && ACTIVE.start == map::ACTIVE_IMAGE);
    assert!(NEW.start == map::NEW_IMAGE && OLD.start == map::OLD_IMAGE);
    assert!(ACTIVE.end == NEW.start && NEW.end == OLD.start && OLD.end == map::IMAGE_END);
};
