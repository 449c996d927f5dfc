//! New firmware: what a host sends of it, and whether the firmware that runs may stay. What is decided about it lies in
//! `vitrine-boot`; here is what the board adds: lamps that must not be fading, and the restart.

use defmt::{info, warn};
use embassy_time::{Duration, Instant};
use vitrine_boot::trial::{Health, Verdict};
use vitrine_boot::{LAYOUT, VerifyingKey, public_key, takes_development_key};
use vitrine_exhibit::units::{Milliseconds, PerLamp};
use vitrine_protocol::Refusal;
use vitrine_protocol::firmware::FirmwareState;

use crate::steady_flash::{Chip, RETRY};
use crate::{controller, last_words, watchdog};

/// The answer to a host that asked for a restart needs this time on its wire.
const RESTART_AFTER: Duration = Duration::from_millis(200);

/// Images, and a restart that is due.
pub(crate) struct Updates {
    images: vitrine_boot::Updates<Option<VerifyingKey>>,
    restart_at: Option<Instant>,
}

impl Updates {
    /// Reads what runs and how its update is.
    pub(crate) fn load(chip: &mut Chip) -> Self {
        let updates =
            Self { images: vitrine_boot::Updates::load(chip, &LAYOUT, public_key()), restart_at: None };
        let state = updates.state();
        info!("firmware {}, update: {}", state.version.as_str(), defmt::Debug2Format(&state.progress));
        if takes_development_key() {
            warn!("anybody can sign firmware for this board: it takes the development key");
        }
        updates
    }

    /// What is told to hosts.
    pub(crate) fn state(&self) -> FirmwareState {
        self.images.state(env!("CARGO_PKG_VERSION"))
    }

    /// Whether [`Updates::append`] of so many bytes will erase a sector.
    pub(crate) fn will_erase(&self, bytes: usize) -> bool {
        self.images.will_erase(bytes)
    }

    /// Prepares the place of the new image.
    pub(crate) fn begin(&mut self, chip: &mut Chip, length: u32) -> Result<(), Refusal> {
        or_put_off(chip, |chip| self.images.begin(chip, length))
    }

    /// Writes the next bytes.
    pub(crate) fn append(&mut self, chip: &mut Chip, bytes: &[u8]) -> Result<(), Refusal> {
        or_put_off(chip, |chip| self.images.append(chip, bytes))
    }

    /// Verifies the new image; the next start installs it. The signature takes a fifth of a second, in which a fade may have
    /// begun and after which the watchdog wants to be fed: what is verified is not verified again.
    pub(crate) fn commit(&mut self, chip: &mut Chip, crc: u32) -> Result<(), Refusal> {
        let supply = controller::snapshot().supply;
        or_put_off(chip, |chip| self.images.commit(chip, crc, supply))?;
        info!("new firmware is installed at the next start");
        Ok(())
    }

    /// Restarts in a moment.
    pub(crate) fn restart(&mut self) {
        self.restart_at = Some(Instant::now() + RESTART_AFTER);
    }

    /// Does what is due. To be called often.
    pub(crate) fn look_after(&mut self, chip: &mut Chip) {
        if self.restart_at.is_some_and(|at| Instant::now() >= at) {
            info!("a host asked for a restart");
            last_words::restart();
        }
        let snapshot = controller::snapshot();
        let health = Health {
            dark: !snapshot.enabled && snapshot.levels == PerLamp::default(),
            supply: snapshot.supply,
            all_checked_in: watchdog::all_have_checked_in(),
        };
        let uptime = u32::try_from(Instant::now().as_millis()).unwrap_or(u32::MAX);
        match self.images.look_after(chip, health, Milliseconds(uptime)) {
            Verdict::Wait => {}
            Verdict::Confirm => info!("the new firmware has confirmed itself"),
            Verdict::GoBack => {
                warn!("the new firmware has not confirmed itself within a minute");
                last_words::restart()
            }
        }
    }
}

/// Tells a host to ask again where nothing failed but an erase that was put off.
fn or_put_off(chip: &mut Chip, work: impl FnOnce(&mut Chip) -> Result<(), Refusal>) -> Result<(), Refusal> {
    let before = chip.put_off();
    work(chip).map_err(|refusal| match refusal {
        Refusal::StorageFailed if chip.put_off() != before => Refusal::LampsInMotion { retry: RETRY },
        other => other,
    })
}
