//! The simulated controller's firmware: what stands for it, and its updates, through the boot loader's own code.

use vitrine_boot::{
    DEVELOPMENT_KEY, HEADER_BYTES, LAYOUT, Start, VerifyingKey, start,
    trial::{Health, Verdict},
};
use vitrine_exhibit::{
    Snapshot,
    units::{Milliseconds, PerLamp},
};
use vitrine_protocol::{Refusal, firmware::ImageFault};

use super::FlashFile;
use crate::firmware::{SecretKey, sign};

/// What stands in for the firmware that a board is delivered with; nothing runs it.
const FACTORY_IMAGE: &[u8] = b"A simulated controller runs the firmware's crates, not this image.";

/// Images, and a restart that is due. The simulated controller takes the development key.
pub(super) struct Updates {
    pub(super) images: vitrine_boot::Updates<Option<VerifyingKey>>,
    pub(super) restart: bool,
}

impl Updates {
    /// Does what the boot loader does at a start. New flash is given an image as a factory would.
    pub(super) fn start(flash: &mut FlashFile) -> Result<Self, Refusal> {
        let key = VerifyingKey::from_bytes(&DEVELOPMENT_KEY).ok();
        if flash.is_erased(LAYOUT.active.start(), HEADER_BYTES) {
            let image = sign(FACTORY_IMAGE, env!("CARGO_PKG_VERSION"), &SecretKey::development());
            flash.program(LAYOUT.active.start(), &image).map_err(|_| Refusal::StorageFailed)?;
        }
        match start(flash, &LAYOUT, &key).map_err(super::machine::storage_failed)? {
            Start::Image { .. } => {
                let images = vitrine_boot::Updates::load(flash, &LAYOUT, key);
                Ok(Self { images, restart: false })
            }
            Start::Nothing => Err(Refusal::UnfitImage(ImageFault::NoImage)),
        }
    }

    /// Confirms firmware on trial that works; tells whether the controller is to restart.
    pub(super) fn look_after(&mut self, flash: &mut FlashFile, snapshot: &Snapshot) -> bool {
        let dark = !snapshot.enabled && snapshot.levels == PerLamp::default();
        // Everything runs in one thread: where this runs, all of it does.
        let health = Health { dark, supply: snapshot.supply, all_checked_in: true };
        let uptime = u32::try_from(snapshot.uptime_ms).unwrap_or(u32::MAX);
        self.restart || self.images.look_after(flash, health, Milliseconds(uptime)) == Verdict::GoBack
    }
}
