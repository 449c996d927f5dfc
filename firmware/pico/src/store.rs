//! The owner of flash: plan, settings, dose ledger, event log and what is known of the clock; and, as nearly all that hosts ask leads there, of the server.
//!
//! Every call of the flash stops all interrupts: a page for 0.4 ms, a sector for 45 ms. Whatever can wait for that
//! waits until the lamps are dark or at a steady level. A reservation of the ledger waits only for a moment: without
//! it the lamps would go dark.

use defmt::{info, warn};
use embassy_futures::select::{Either4, select4};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::peripherals::FLASH;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Timer};
use heapless::String;
use static_cell::StaticCell;
use vitrine_exhibit::clock::ClockRecord;
use vitrine_exhibit::events::Event;
use vitrine_exhibit::ledger::{LedgerRecord, StoredReservation};
use vitrine_exhibit::plan::ValidPlan;
use vitrine_protocol::frame::Frame;
use vitrine_protocol::plan_file::MAX_PLAN_BYTES;
use vitrine_protocol::server::{Incoming, Server};
use vitrine_storage::{EventLog, Ledger, clock};

use crate::board::StorageResources;
use crate::controller::{self, EVENTS, PlanSlot, STORED, TO_STORE};
use crate::links::LINKS;
use crate::plans::{self, Plans};
use crate::sensors::SET_CLOCK;
use crate::updates::Updates;
use crate::watchdog::{Client, check_in};
use crate::{chip, flash_map, readings, settings};

/// The chip.
pub(crate) type Chip = Flash<'static, FLASH, Blocking, { flash_map::FLASH_BYTES }>;

/// The longest that a reservation waits for steady lamps; the ledger asks a second before it needs it.
const RESERVATION_PATIENCE: Duration = Duration::from_millis(300);

/// How often the owner says that it is alive.
const ALIVE: Duration = Duration::from_millis(100);

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
    pub(crate) log: Option<EventLog>,
    /// What a host's setting has taught of the battery clock: to be kept before the clock is set.
    pub(crate) clock_to_keep: Option<ClockRecord>,
}

impl Store {
    /// Takes the flash and reads what is there; loads the plan into `active`. Gives the newest ledger record too.
    pub(crate) fn open(
        resources: StorageResources,
        active: &mut Option<ValidPlan>,
        spare: PlanSlot,
    ) -> (Self, LedgerRecord) {
        let mut chip = Chip::new_blocking(resources.flash);
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
        (Self { chip, plans, updates, serial_number, ledger, log, clock_to_keep: None }, record)
    }

    /// Writes a ledger record; tells whether it is safely there.
    fn reserve(&mut self, record: &LedgerRecord) -> bool {
        self.ledger.as_mut().is_some_and(|ledger| ledger.store(&mut self.chip, record).is_ok())
    }

    fn write_log(&mut self, event: Event) {
        let uptime_s = u32::try_from(Instant::now().as_secs()).unwrap_or(u32::MAX);
        let time = readings::clock().now;
        let written = self.log.as_mut().map(|log| log.keep(&mut self.chip, time, uptime_s, event));
        if !matches!(written, Some(Ok(_))) {
            warn!("an event did not reach the log");
        }
    }
}

impl Store {
    /// Keeps what a host's setting has taught of the battery clock, and only then has the clock set: a clock that was
    /// set without a note of it would be taken for one that does not drift.
    async fn keep_clock(&mut self) {
        let Some(record) = self.clock_to_keep.take() else { return };
        controller::steady_lamps(RESERVATION_PATIENCE).await;
        if clock::store(&mut self.chip, &record).is_err() {
            warn!("what is known of the clock cannot be written");
        }
        SET_CLOCK.signal(());
    }
}

/// Serves flash and hosts for ever.
#[embassy_executor::task]
pub(crate) async fn run(mut store: Store) -> ! {
    let mut server = Server::new();
    info!("serial number {}", store.serial_number.as_str());
    loop {
        check_in(Client::Store);
        store.plans.take_back();
        store.updates.look_after(&mut store.chip);
        store.keep_clock().await;
        match select4(TO_STORE.wait(), INCOMING.receive(), EVENTS.receive(), Timer::after(ALIVE)).await {
            Either4::First(record) => {
                if store.ledger.is_some_and(|ledger| ledger.will_erase()) {
                    controller::steady_lamps(RESERVATION_PATIENCE).await;
                }
                if store.reserve(&record) {
                    STORED.signal(StoredReservation { sequence: record.sequence });
                } else {
                    warn!("the ledger cannot be written");
                }
            }
            Either4::Second((link, incoming)) => {
                let answer = server.answer(&incoming, Instant::now().as_millis(), &mut store);
                if let Some(channel) = ANSWERS.get(usize::from(link)) {
                    let _ = channel.try_send(answer);
                }
            }
            Either4::Third(event) => {
                if store.log.is_some_and(|log| log.will_erase()) {
                    // Events wait in their channel meanwhile; only the watchdog and reservations must not.
                    controller::steady_lamps(RESERVATION_PATIENCE).await;
                }
                store.write_log(event);
            }
            Either4::Fourth(()) => {}
        }
    }
}
