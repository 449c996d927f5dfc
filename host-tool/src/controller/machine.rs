//! The simulated controller itself: the firmware's crates, wired as on the board.

use vitrine_exhibit::{
    Snapshot, State, events,
    governor::LampCommand,
    inputs::{Inputs, Request},
    ledger::StoredReservation,
    plan::{Bounds, ValidPlan},
    settings::Settings,
    step,
    units::{Level, Milliseconds, PerLamp, UtcSeconds},
};
use vitrine_protocol::{
    Controller, Hello, Refusal, Server, Status,
    firmware::FirmwareState,
    frame::Frame,
    message::{LogPage, MAX_LOG_ENTRIES},
    plan_file::{self, MAX_PLAN_BYTES},
    server::Incoming,
    status::{ClockState, PlanState},
};
use vitrine_storage::{EventLog, Ledger, Record, Writer, map::PLAN};

use super::{
    Clock, FlashFile, Noise, Surroundings, Viewer, Walk, thermal_frames, time::Time, updates::Updates,
};

/// The time of one step.
const STEP_MS: u32 = 10;
/// The thermal sensors give ten frames a second.
const FRAME_EVERY_MS: u64 = 100;
/// Levels that have not changed for so long are steady.
const STEADY_MS: u32 = 100;

struct ActivePlan {
    plan: ValidPlan,
    record: Record,
}

/// The controller, simulated.
pub struct VirtualController {
    name: String,
    flash: FlashFile,
    state: State,
    server: Server,
    plan: Option<ActivePlan>,
    writer: Option<Writer>,
    updates: Updates,
    ledger: Ledger,
    log: EventLog,
    stored: Option<StoredReservation>,
    requests: Vec<Request>,
    settings: Settings,
    clock_was_set: bool,
    command: LampCommand,
    steady_ms: u32,
    time_ms: u64,
    remainder_ms: u32,
    time: Time,
    walk: Walk,
    viewer: Option<Option<Viewer>>,
    noise: Noise,
    damaged_frames: u32,
    /// Interlock, supply, temperatures and staff key.
    pub surroundings: Surroundings,
}

impl VirtualController {
    /// A controller that has just been switched on, with the plan, ledger and log that its flash holds.
    ///
    /// # Errors
    /// Where the flash cannot be read.
    pub fn new(mut flash: FlashFile, clock: Clock) -> Result<Self, Refusal> {
        let updates = Updates::start(&mut flash)?;
        let (ledger, record) = Ledger::open(&mut flash).map_err(storage_failed)?;
        let log = EventLog::open(&mut flash).map_err(storage_failed)?;
        let time = Time::new(clock, vitrine_storage::clock::read(&mut flash).map_err(storage_failed)?);
        let settings = vitrine_storage::settings::read(&mut flash).map_err(storage_failed)?;
        let mut controller = Self {
            name: "SIMULATED".to_owned(),
            flash,
            state: State::new(record.unwrap_or_default(), false),
            server: Server::new(),
            plan: None,
            writer: None,
            updates,
            ledger,
            log,
            stored: None,
            requests: Vec::new(),
            settings,
            clock_was_set: false,
            command: LampCommand::DARK,
            steady_ms: STEADY_MS,
            time_ms: 0,
            remainder_ms: 0,
            time,
            walk: Walk::nobody(),
            viewer: None,
            noise: Noise::new(),
            damaged_frames: 0,
            surroundings: Surroundings::new(),
        };
        controller.plan = controller.load_plan()?;
        Ok(controller)
    }

    /// Names the controller: its serial number.
    pub fn with_name(mut self, name: &str) -> Self {
        self.name = name.chars().take(24).collect();
        self
    }

    /// Switches the power off and gives the flash back, for another start.
    pub fn power_off(self) -> FlashFile {
        self.flash
    }

    /// Starts anew, as after a reset: what stands around it stays, what it knew is what flash holds.
    fn restart(&mut self) -> Result<(), Refusal> {
        let flash = std::mem::replace(&mut self.flash, FlashFile::nothing());
        let clock = self.time.clock_after(self.time_ms);
        let fresh = Self::new(flash, clock)?;
        let before = std::mem::replace(self, fresh);
        self.name = before.name;
        (self.walk, self.viewer, self.noise) = (before.walk, before.viewer, before.noise);
        self.surroundings = before.surroundings;
        Ok(())
    }

    /// Sends a visitor on a walk; [`VirtualController::set_viewer`] overrides it.
    pub fn set_walk(&mut self, walk: Walk) {
        self.walk = walk;
        self.viewer = None;
    }

    /// Puts a viewer somewhere, or takes the viewer away.
    pub const fn set_viewer(&mut self, viewer: Option<Viewer>) {
        self.viewer = Some(viewer);
    }

    /// Lets simulated time pass, in steps of 10 ms; what is left over is added next time.
    pub fn advance(&mut self, ms: u32) {
        let total = self.remainder_ms + ms;
        for _ in 0..total / STEP_MS {
            self.step();
        }
        self.remainder_ms = total % STEP_MS;
    }

    /// Simulated time since the start, in ms.
    pub const fn time_ms(&self) -> u64 {
        self.time_ms
    }

    /// The lamps' levels.
    pub const fn lamps(&self) -> PerLamp<Level> {
        self.command.levels()
    }

    /// What the controller tells of itself.
    pub const fn snapshot(&self) -> &Snapshot {
        self.state.snapshot()
    }

    /// Answers a request that came in on one of its links.
    pub fn answer(&mut self, incoming: &Incoming) -> Frame {
        let mut server = std::mem::take(&mut self.server);
        let now_ms = self.time_ms;
        let frame = server.answer(incoming, now_ms, self);
        self.server = server;
        frame
    }

    /// Takes note that a host has gone: what it began to upload is free for others.
    pub fn link_closed(&mut self, link: u8) {
        self.server.link_closed(link);
    }

    /// Counts frames that came damaged on a link.
    pub const fn count_damaged_frames(&mut self, frames: u32) {
        self.damaged_frames = self.damaged_frames.saturating_add(frames);
    }

    fn step(&mut self) {
        self.time_ms += u64::from(STEP_MS);
        let viewer = self.viewer.unwrap_or_else(|| self.walk.at(self.time_ms));
        let frames =
            self.time_ms.is_multiple_of(FRAME_EVERY_MS).then(|| thermal_frames(viewer, &mut self.noise));
        let frames = frames.map(|frames| frames.map(|frame| self.settings.placed(frame)));
        let requests = std::mem::take(&mut self.requests);
        let plan = self.plan.as_ref().map(|active| &active.plan);
        let ultraviolet = frames.and(self.surroundings.ultraviolet(plan, self.command.levels()));
        let inputs = Inputs {
            plan,
            thermal: frames.as_ref().map_or([None; 2], |[left, right]| [Some(left), Some(right)]),
            interlock: self.surroundings.interlock,
            boards: self.surroundings.boards(),
            enclosure: self.surroundings.enclosure,
            supply: self.surroundings.supply,
            ultraviolet: ultraviolet.map(|reading| self.settings.ultraviolet(reading)),
            now: self.now(),
            clock_was_set: std::mem::take(&mut self.clock_was_set),
            requests: &requests,
            staff_key: self.surroundings.staff_key,
            stored: self.stored.take(),
            ..Inputs::default()
        };
        let (command, events) = step(&mut self.state, &inputs, Milliseconds(STEP_MS));
        self.surroundings.advance(&command, STEP_MS);
        self.steady_ms = if command.levels() == self.command.levels() {
            self.steady_ms.saturating_add(STEP_MS)
        } else {
            0
        };
        self.command = command;
        self.keep(&events);
        if self.updates.look_after(&mut self.flash, self.state.snapshot()) {
            let _a_controller_without_an_image_that_verifies_stays_as_it_is = self.restart();
        }
    }

    /// Writes to flash what the step wants kept. A write that fails is tried again with the next step: meanwhile the
    /// governor keeps the lamps dark.
    fn keep(&mut self, events: &events::Events) {
        if let Some(record) = self.state.ledger().to_store()
            && self.ledger.store(&mut self.flash, record).is_ok()
        {
            self.stored = Some(StoredReservation { sequence: record.sequence });
        }
        let uptime_s = u32::try_from(self.time_ms / 1_000).unwrap_or(u32::MAX);
        let now = self.now();
        for event in events.iter() {
            let _an_event_that_flash_refuses_is_lost = self.log.keep(&mut self.flash, now, uptime_s, event);
        }
    }

    fn now(&self) -> Option<UtcSeconds> {
        self.time.now(self.time_ms)
    }

    /// Reads the newest plan in flash. One that this firmware cannot take is none.
    fn load_plan(&mut self) -> Result<Option<ActivePlan>, Refusal> {
        let Some(record) = PLAN.newest(&mut self.flash).map_err(storage_failed)? else { return Ok(None) };
        Ok(self.read_as_plan(&record).ok().map(|plan| ActivePlan { plan, record }))
    }

    fn read_as_plan(&mut self, record: &Record) -> Result<ValidPlan, Refusal> {
        let mut bytes = [0; MAX_PLAN_BYTES];
        let read = record.read(&mut self.flash, 0, &mut bytes).map_err(storage_failed)?;
        let plan = plan_file::decode(&bytes[..read]).map_err(|_| Refusal::UnreadablePlan)?;
        ValidPlan::new(plan).map_err(Refusal::UnfitPlan)
    }

    /// Reads back what was uploaded, before it is valid.
    fn staged_plan(&mut self, crc: u32) -> Result<ValidPlan, Refusal> {
        let writer = self.writer.as_ref().ok_or(Refusal::NoUpload)?;
        let staged = writer.staged(&mut self.flash).map_err(storage_failed)?;
        if staged.crc() != crc {
            return Err(Refusal::Checksum { expected: crc, found: staged.crc() });
        }
        self.read_as_plan(&staged)
    }

    fn may_erase(&self) -> Result<(), Refusal> {
        if self.steady_ms >= STEADY_MS {
            Ok(())
        } else {
            Err(Refusal::LampsInMotion { retry: Milliseconds(STEADY_MS) })
        }
    }
}

impl Controller for VirtualController {
    fn hello(&mut self) -> Hello {
        Hello {
            version: 0,
            fingerprint: 0,
            serial_number: self.name.as_str().try_into().unwrap_or_default(),
            firmware: self.firmware().version,
            name: self.plan.as_ref().map(|active| active.plan.name.clone()).unwrap_or_default(),
        }
    }

    fn status(&mut self) -> Status {
        let snapshot = *self.state.snapshot();
        let plan = self.plan.as_ref().map(|active| PlanState {
            crc: active.record.crc(),
            length: active.record.length(),
            name: active.plan.name.clone(),
            views: active.plan.views.len() as u8,
            view_id: snapshot
                .view
                .and_then(|view| active.plan.views.get(usize::from(view)))
                .map(|view| view.id.clone())
                .unwrap_or_default(),
        });
        Status {
            snapshot,
            clock: self.clock(),
            plan,
            log_next: self.log.next(),
            damaged_frames: self.damaged_frames,
        }
    }

    fn clock(&mut self) -> ClockState {
        self.time.state(self.time_ms)
    }

    fn set_clock(&mut self, now: UtcSeconds) -> Result<(), Refusal> {
        let record = self.time.record_of(now, self.time_ms);
        vitrine_storage::clock::store(&mut self.flash, &record).map_err(storage_failed)?;
        self.time.set(now, self.time_ms, record);
        self.clock_was_set = true;
        Ok(())
    }

    fn request(&mut self, request: Request) -> Result<(), Refusal> {
        let views = self.plan.as_ref().map(|active| active.plan.views.len() as u8);
        if let Request::Hold { view, .. } = request {
            let views = views.ok_or(Refusal::NoPlan)?;
            if view >= views {
                return Err(Refusal::NoSuchView { views });
            }
        }
        self.requests.push(request);
        Ok(())
    }

    fn begin_plan(&mut self, length: u32) -> Result<(), Refusal> {
        let most = PLAN.capacity().min(MAX_PLAN_BYTES as u32);
        if length == 0 || length > most {
            return Err(Refusal::PlanLength { most });
        }
        self.may_erase()?;
        self.writer = None;
        self.writer = Some(PLAN.begin(&mut self.flash, length).map_err(storage_failed)?);
        Ok(())
    }

    fn append_plan(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        let erases = self
            .writer
            .as_ref()
            .ok_or(Refusal::NoUpload)?
            .will_erase(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        if erases {
            self.may_erase()?;
        }
        let writer = self.writer.as_mut().ok_or(Refusal::NoUpload)?;
        writer.append(&mut self.flash, bytes).map_err(storage_failed)
    }

    fn plan_asks_for_more(&mut self, crc: u32) -> Result<bool, Refusal> {
        let plan = self.staged_plan(crc)?;
        let bounds = self.plan.as_ref().map(|active| Bounds::of(&active.plan)).unwrap_or_default();
        Ok(bounds.are_exceeded_by(&plan))
    }

    fn commit_plan(&mut self, crc: u32) -> Result<(), Refusal> {
        let plan = self.staged_plan(crc)?;
        let writer = self.writer.take().ok_or(Refusal::NoUpload)?;
        let record = writer.finish(&mut self.flash).map_err(storage_failed)?;
        self.plan = Some(ActivePlan { plan, record });
        Ok(())
    }

    fn read_plan(&mut self, offset: u32, part: &mut [u8]) -> Result<(u32, usize), Refusal> {
        let record = self.plan.as_ref().ok_or(Refusal::NoPlan)?.record;
        let read = record.read(&mut self.flash, offset, part).map_err(storage_failed)?;
        Ok((record.length(), read))
    }

    fn settings(&mut self) -> Settings {
        self.settings.clone()
    }

    fn change_settings(&mut self, settings: &Settings) -> Result<(), Refusal> {
        self.may_erase()?;
        vitrine_storage::settings::store(&mut self.flash, settings).map_err(storage_failed)?;
        self.settings.clone_from(settings);
        Ok(())
    }

    fn firmware(&mut self) -> FirmwareState {
        self.updates.images.state(env!("CARGO_PKG_VERSION"))
    }

    fn begin_update(&mut self, length: u32) -> Result<(), Refusal> {
        self.may_erase()?;
        self.updates.images.begin(&mut self.flash, length)
    }

    fn append_update(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        if self.updates.images.will_erase(bytes.len()) {
            self.may_erase()?;
        }
        self.updates.images.append(&mut self.flash, bytes)
    }

    fn commit_update(&mut self, crc: u32) -> Result<(), Refusal> {
        self.may_erase()?;
        self.updates.images.commit(&mut self.flash, crc, self.surroundings.supply)
    }

    fn restart(&mut self) -> Result<(), Refusal> {
        self.updates.restart = true;
        Ok(())
    }

    fn read_log(&mut self, from: u32) -> Result<LogPage, Refusal> {
        let mut page = LogPage { oldest: self.log.oldest(), next: self.log.next(), ..LogPage::default() };
        let first = from.max(page.oldest);
        for sequence in (first..page.next).take(MAX_LOG_ENTRIES) {
            if let Some(entry) = self.log.read(&mut self.flash, sequence).map_err(storage_failed)? {
                let _there_is_room_for_all_taken = page.entries.push(entry);
            }
        }
        Ok(page)
    }
}

pub(super) fn storage_failed<E>(_: vitrine_storage::Error<E>) -> Refusal {
    Refusal::StorageFailed
}
