//! The owner of flash: plan, settings, dose ledger, event log and what is known of the clock; and, as nearly all that hosts ask leads there, of the server.
//!
//! Nothing is erased while the lamps fade, and nothing but right after the watchdog was fed ([`crate::steady_flash`]). Ledger
//! and log are erased a sector ahead, so that their records are programmed at any time. A record for which that was not enough
//! waits, and so does what is known of the clock.
//!
//! A fade ends within a minute. Lamps that never come to rest, under viewers who never stop or heat that wavers, are asked to
//! stand still for a moment, and at once where a reservation waits: half a minute before the lamps would go dark for its want.

use core::future::pending;

use defmt::{info, warn};
use embassy_futures::select::{Either4, select, select4};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Timer, with_timeout};
use heapless::String;
use static_cell::StaticCell;
use vitrine_exhibit::clock::ClockRecord;
use vitrine_exhibit::events::Event;
use vitrine_exhibit::ledger::{LedgerRecord, StoredReservation};
use vitrine_exhibit::limits;
use vitrine_exhibit::plan::ValidPlan;
use vitrine_exhibit::units::UtcSeconds;
use vitrine_protocol::Request;
use vitrine_protocol::frame::Frame;
use vitrine_protocol::plan_file::MAX_PLAN_BYTES;
use vitrine_protocol::server::{Incoming, Server};
use vitrine_storage::{EventLog, Ledger, clock};

use crate::board::StorageResources;
use crate::controller::{self, EVENTS, Happened, PlanSlot, STORED, TO_STORE};
use crate::links::LINKS;
use crate::plans::{self, Plans};
use crate::sensors::SET_CLOCK;
use crate::steady_flash::{Chip, has_to_wait};
use crate::updates::Updates;
use crate::watchdog::{ALIVE, Client, FED, check_in};
use crate::{chip, readings, settings, watchdog};

/// No fade lasts longer: lamps that have put off an erase for so long do not come to rest by themselves.
const LONGEST_FADE: Duration = Duration::from_millis(limits::SLOWEST_FADE.0 as u64);

/// Requests of all links, each with its link's number.
pub(crate) static INCOMING: Channel<CriticalSectionRawMutex, (u8, Incoming), 2> = Channel::new();

/// The answers, for each link.
pub(crate) static ANSWERS: [Channel<CriticalSectionRawMutex, Frame, 1>; LINKS] =
    [const { Channel::new() }; LINKS];

/// Flash, and what is known of its content.
pub(crate) struct Store {
    pub(crate) chip: Chip,
    pub(crate) plans: Plans,
    pub(crate) updates: Updates,
    pub(crate) serial_number: String<24>,
    ledger: Option<Ledger>,
    /// A record of the ledger that is to be stored.
    reservation: Option<LedgerRecord>,
    pub(crate) log: Option<EventLog>,
    /// The oldest event that is to be logged.
    happened: Option<Happened>,
    /// Lost events of which the log tells already.
    told_lost: u32,
    /// What a host's setting has taught of the battery clock: to be kept before the clock is set.
    pub(crate) clock_to_keep: Option<ClockRecord>,
}

impl Store {
    /// Takes the flash and reads what is there; loads the plan into `active`. Gives the newest ledger record too. Apart from
    /// its caller, whose stack lives as long as the program starts.
    #[inline(never)]
    pub(crate) fn open(
        resources: StorageResources,
        active: &mut Option<ValidPlan>,
        spare: PlanSlot,
    ) -> (&'static mut Self, LedgerRecord) {
        let mut chip = Chip::take(resources);
        let serial_number = chip::serial_number(&mut chip);
        let updates = Updates::load(&mut chip);
        static BUFFER: StaticCell<plans::Buffer> = StaticCell::new();
        let buffer = BUFFER.init_with(|| [0; MAX_PLAN_BYTES]);
        let plans = Plans::load(&mut chip, active, spare, buffer);
        let (ledger, record) = match Ledger::open(&mut chip) {
            Ok((ledger, record)) => (Some(ledger), record.unwrap_or_default()),
            Err(_) => {
                // Without a ledger nothing is ever reserved, and the lamps stay dark.
                warn!("the ledger cannot be read");
                (None, LedgerRecord::default())
            }
        };
        let log = EventLog::open(&mut chip).ok();
        match vitrine_storage::settings::read(&mut chip) {
            Ok(kept) => settings::change(&kept),
            Err(_) => warn!("the settings cannot be read: defaults"),
        }
        match clock::read(&mut chip) {
            Ok(record) => readings::clock_record(record),
            Err(_) => warn!("what is known of the clock cannot be read"),
        }
        static STORE: StaticCell<Store> = StaticCell::new();
        let store = STORE.init_with(|| Self {
            chip,
            plans,
            updates,
            serial_number,
            ledger,
            reservation: None,
            log,
            happened: None,
            told_lost: 0,
            clock_to_keep: None,
        });
        (store, record)
    }
}

impl Store {
    /// Stores the ledger record that is due, and says so.
    fn reserve(&mut self) {
        let Some(record) = self.reservation.take() else { return };
        let stored = self.ledger.as_mut().map(|ledger| ledger.store(&mut self.chip, &record));
        match stored {
            Some(Ok(())) => STORED.signal(StoredReservation { sequence: record.sequence }),
            Some(outcome) if has_to_wait(&outcome) => self.reservation = Some(record),
            _ => warn!("the ledger cannot be written"),
        }
    }

    /// Logs the event that is due, and how many found no room in the queue behind it.
    fn write_log(&mut self) {
        if let Some(happened) = self.happened.take()
            && self.log_event(&happened) == Logged::Waits
        {
            self.happened = Some(happened);
            return;
        }
        let lost = controller::lost_events();
        if lost != self.told_lost {
            let of_loss = Happened::now(Event::EventsLost(lost.wrapping_sub(self.told_lost)));
            if self.log_event(&of_loss) != Logged::Waits {
                self.told_lost = lost;
            }
        }
    }

    fn log_event(&mut self, happened: &Happened) -> Logged {
        let Some(log) = &mut self.log else { return Logged::Never };
        let seconds = |instant: Duration| u32::try_from(instant.as_secs()).unwrap_or(u32::MAX);
        let ago_s = seconds(Instant::now().saturating_duration_since(happened.at));
        let time = readings::clock().now.map(|now| UtcSeconds(now.0.saturating_sub(i64::from(ago_s))));
        let uptime_s = seconds(happened.at.saturating_duration_since(Instant::MIN));
        let kept = log.keep(&mut self.chip, time, uptime_s, happened.event);
        match kept {
            Ok(_) => Logged::Kept,
            outcome if has_to_wait(&outcome) => Logged::Waits,
            Err(_) => {
                warn!("an event did not reach the log");
                Logged::Never
            }
        }
    }

    /// Erases what will be needed, and keeps what is known of the clock: a sector at a time.
    fn tidy_up(&mut self) {
        let wants_room = |ledger: &Ledger| ledger.wants_room();
        let ledger_wants_room = self.ledger.as_ref().is_some_and(wants_room);
        let log_wants_room = self.log.as_ref().is_some_and(EventLog::wants_room);
        let is_due = self.clock_to_keep.is_some() || ledger_wants_room || log_wants_room;
        if !is_due || self.chip.may_erase().is_err() {
            return;
        }
        if let Some(record) = self.clock_to_keep.take() {
            self.keep_clock(record);
        } else if let Some(ledger) = self.ledger.as_mut().filter(|_| ledger_wants_room) {
            // What fails is tried again by the record that needs it.
            let _ = ledger.make_room(&mut self.chip);
        } else if let Some(log) = &mut self.log {
            let _ = log.make_room(&mut self.chip);
        }
    }

    /// Has the lamps stand still where somebody is put off who cannot wait for the end of their motion.
    fn ask_for_stillness(&mut self) {
        let cannot_wait = self.reservation.is_some() || self.chip.put_off_for() > LONGEST_FADE;
        if self.chip.take_wish_for_stillness() && cannot_wait {
            controller::stand_still();
        }
    }

    /// Whether a request that is to be answered next erases a sector.
    fn will_erase(&self, incoming: &Incoming) -> bool {
        match incoming.request() {
            Some(Request::UploadChunk { bytes, .. }) => {
                self.plans.will_erase(bytes.len()) || self.updates.will_erase(bytes.len())
            }
            Some(
                Request::BeginUpload { .. }
                | Request::BeginUpdate { .. }
                | Request::CommitUpload { .. }
                | Request::Confirm { .. },
            ) => true,
            _ => false,
        }
    }

    /// Keeps what a host's setting has taught of the battery clock, and only then has the clock set: a clock that was
    /// set without a note of it would be taken for one that does not drift.
    fn keep_clock(&mut self, record: ClockRecord) {
        let outcome = clock::store(&mut self.chip, &record);
        if has_to_wait(&outcome) {
            self.clock_to_keep = Some(record);
            return;
        }
        if outcome.is_err() {
            warn!("what is known of the clock cannot be written");
        }
        SET_CLOCK.signal(());
    }
}

/// What became of an event.
#[derive(PartialEq, Eq)]
enum Logged {
    /// It is in the log, or the log does not keep its kind.
    Kept,
    /// It waits for steady lamps.
    Waits,
    /// It cannot be logged.
    Never,
}

/// Serves flash and hosts for ever.
#[embassy_executor::task]
pub(crate) async fn run(store: &'static mut Store) -> ! {
    let mut server = Server::new();
    info!("serial number {}", store.serial_number.as_str());
    loop {
        check_in(Client::Store);
        store.reserve();
        store.write_log();
        store.plans.take_back();
        store.updates.look_after(&mut store.chip);
        store.tidy_up();
        store.ask_for_stillness();
        let log_waits = store.happened.is_some();
        let next_event = async { if log_waits { pending().await } else { EVENTS.receive().await } };
        let next_look = select(FED.wait(), Timer::after(ALIVE));
        match select4(TO_STORE.wait(), INCOMING.receive(), next_event, next_look).await {
            Either4::First(record) => store.reservation = Some(record),
            Either4::Second((link, incoming)) => {
                if store.will_erase(&incoming) && !watchdog::outlasts_an_erase() {
                    check_in(Client::Store);
                    FED.reset();
                    let _ = with_timeout(ALIVE * 2, FED.wait()).await;
                }
                let answer = server.answer(&incoming, Instant::now().as_millis(), store);
                if let Some(channel) = ANSWERS.get(usize::from(link)) {
                    let _ = channel.try_send(answer);
                }
            }
            Either4::Third(happened) => store.happened = Some(happened),
            Either4::Fourth(_) => {}
        }
    }
}
