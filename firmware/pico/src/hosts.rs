//! What hosts may ask of this board.

use heapless::Vec;
use vitrine_exhibit::inputs::Request;
use vitrine_exhibit::settings::Settings;
use vitrine_exhibit::units::UtcSeconds;
use vitrine_protocol::firmware::FirmwareState;
use vitrine_protocol::message::{LogPage, MAX_LOG_ENTRIES};
use vitrine_protocol::server::Controller;
use vitrine_protocol::status::{ClockState, Status};
use vitrine_protocol::{FINGERPRINT, Hello, Refusal, VERSION};

use crate::controller::{self, REQUESTS};
use crate::steady_flash::refusal;
use crate::store::Store;
use crate::{links, live, readings, settings};

impl Controller for Store {
    fn hello(&mut self) -> Hello {
        Hello {
            version: VERSION,
            fingerprint: FINGERPRINT,
            serial_number: self.serial_number.clone(),
            firmware: self.updates.state().version,
            name: self.plans.name(),
        }
    }

    fn status(&mut self) -> Status {
        let snapshot = controller::snapshot();
        Status {
            snapshot,
            clock: self.clock(),
            plan: self.plans.state(snapshot.view),
            log_next: self.log.map_or(0, |log| log.next()),
            damaged_frames: links::damaged_frames(),
        }
    }

    fn clock(&mut self) -> ClockState {
        readings::clock()
    }

    fn set_clock(&mut self, now: UtcSeconds) -> Result<(), Refusal> {
        self.clock_to_keep = Some(readings::clock_set_by_host(now));
        Ok(())
    }

    fn request(&mut self, request: Request) -> Result<(), Refusal> {
        if let Request::Hold { view, .. } = request
            && view >= self.plans.views()
        {
            let views = self.plans.views();
            return Err(if views == 0 { Refusal::NoPlan } else { Refusal::NoSuchView { views } });
        }
        REQUESTS
            .try_send(request)
            .map_err(|_| Refusal::TooManyRequests { retry: vitrine_exhibit::units::Milliseconds(20) })
    }

    fn begin_plan(&mut self, length: u32) -> Result<(), Refusal> {
        self.plans.begin(&mut self.chip, length)
    }

    fn append_plan(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        self.plans.append(&mut self.chip, bytes)
    }

    fn plan_asks_for_more(&mut self, crc: u32) -> Result<bool, Refusal> {
        self.plans.asks_for_more(&mut self.chip, crc)
    }

    fn commit_plan(&mut self, crc: u32) -> Result<(), Refusal> {
        self.plans.commit(&mut self.chip, crc)
    }

    fn read_plan(&mut self, offset: u32, part: &mut [u8]) -> Result<(u32, usize), Refusal> {
        self.plans.read(&mut self.chip, offset, part)
    }

    fn settings(&mut self) -> Settings {
        settings::now()
    }

    fn change_settings(&mut self, settings: &Settings) -> Result<(), Refusal> {
        vitrine_storage::settings::store(&mut self.chip, settings).map_err(refusal)?;
        settings::change(settings);
        Ok(())
    }

    fn read_live(&mut self, from: Option<u16>, part: &mut [u8]) -> Result<(u16, usize), Refusal> {
        Ok(live::read(from, part))
    }

    fn firmware(&mut self) -> FirmwareState {
        self.updates.state()
    }

    fn begin_update(&mut self, length: u32) -> Result<(), Refusal> {
        self.updates.begin(&mut self.chip, length)
    }

    fn append_update(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        self.updates.append(&mut self.chip, bytes)
    }

    fn commit_update(&mut self, crc: u32) -> Result<(), Refusal> {
        self.updates.commit(&mut self.chip, crc)
    }

    fn restart(&mut self) -> Result<(), Refusal> {
        self.updates.restart();
        Ok(())
    }

    fn read_log(&mut self, from: u32) -> Result<LogPage, Refusal> {
        let log = self.log.ok_or(Refusal::StorageFailed)?;
        let mut entries = Vec::new();
        for sequence in (from.max(log.oldest())..log.next()).take(MAX_LOG_ENTRIES) {
            if let Some(entry) = log.read(&mut self.chip, sequence).map_err(|_| Refusal::StorageFailed)? {
                let _ = entries.push(entry);
            }
        }
        Ok(LogPage { oldest: log.oldest(), next: log.next(), entries })
    }
}
