//! The owner of flash: plan, dose ledger and event log; and, as nearly all that hosts ask leads there, of the server.
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
use vitrine_exhibit::events::Event;
use vitrine_exhibit::ledger::{LedgerRecord, StoredReservation};
use vitrine_exhibit::plan::ValidPlan;
use vitrine_protocol::frame::Frame;
use vitrine_protocol::server::{Incoming, Server};
use vitrine_storage::RingPosition;
use vitrine_storage::map::{LEDGER, LEDGER_ENTRY_BYTES, LOG, LOG_ENTRY_BYTES};

use crate::board::StorageResources;
use crate::controller::{self, EVENTS, PlanSlot, STORED, TO_STORE};
use crate::links::LINKS;
use crate::plans::Plans;
use crate::watchdog::{Client, check_in};
use crate::{flash_map, readings};

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

/// What is in flash at the start.
pub(crate) struct Found {
    /// The newest record of the ledger.
    pub(crate) ledger: LedgerRecord,
    /// Where the ledger goes on.
    ledger_position: Option<RingPosition>,
    /// Where the log goes on.
    log_position: Option<RingPosition>,
}

/// Flash, and what is known of its content.
pub(crate) struct Store {
    pub(crate) chip: Chip,
    pub(crate) plans: Plans,
    pub(crate) serial_number: String<24>,
    ledger: Option<RingPosition>,
    pub(crate) log: Option<RingPosition>,
}

impl Store {
    /// Takes the flash and reads what is there; loads the plan into `active`.
    pub(crate) fn open(
        resources: StorageResources,
        active: &mut Option<ValidPlan>,
        spare: PlanSlot,
    ) -> (Self, Found) {
        let mut chip = Chip::new_blocking(resources.flash);
        let serial_number = serial_number(&mut chip);
        let plans = Plans::load(&mut chip, active, spare);
        let found = find(&mut chip);
        let store =
            Self { chip, plans, serial_number, ledger: found.ledger_position, log: found.log_position };
        (store, found)
    }

    /// Writes a ledger record; tells whether it is safely there.
    fn reserve(&mut self, record: &LedgerRecord) -> bool {
        let mut entry = [0; LEDGER_ENTRY_BYTES];
        let Some(position) = &mut self.ledger else { return false };
        postcard::to_slice(record, &mut entry).is_ok()
            && LEDGER.append(&mut self.chip, position, &entry).is_ok()
    }

    fn write_log(&mut self, event: Event) {
        let uptime_s = u32::try_from(Instant::now().as_secs()).unwrap_or(u32::MAX);
        let mut entry = [0; LOG_ENTRY_BYTES];
        let Some(position) = &mut self.log else { return };
        let encoded = postcard::to_slice(&(readings::clock().now, uptime_s, event), &mut entry).is_ok();
        if !encoded || LOG.append(&mut self.chip, position, &entry).is_err() {
            warn!("an event did not reach the log");
        }
    }

    fn reservation_erases(&self) -> bool {
        self.ledger.is_some_and(|position| LEDGER.will_erase(&position))
    }

    fn log_erases(&self) -> bool {
        self.log.is_some_and(|position| LOG.will_erase(&position))
    }
}

fn serial_number(chip: &mut Chip) -> String<24> {
    let mut id = [0; 8];
    let mut text = String::new();
    if chip.blocking_unique_id(&mut id).is_ok() {
        for byte in id {
            let _ = core::fmt::write(&mut text, format_args!("{byte:02X}"));
        }
    }
    text
}

fn find(chip: &mut Chip) -> Found {
    let mut found = Found { ledger: LedgerRecord::default(), ledger_position: None, log_position: None };
    match LEDGER.open(chip) {
        Ok(opened) => {
            found.ledger_position = Some(opened.position);
            if let Some(record) =
                opened.newest.and_then(|entry| Some(postcard::take_from_bytes(&entry).ok()?.0))
            {
                found.ledger = record;
            }
        }
        Err(_) => warn!("the ledger cannot be read"),
    }
    match LOG.open(chip) {
        Ok(opened) => found.log_position = Some(opened.position),
        Err(_) => warn!("the log cannot be read"),
    }
    found
}

/// Serves flash and hosts for ever.
#[embassy_executor::task]
pub(crate) async fn run(mut store: Store) -> ! {
    let mut server = Server::new();
    info!("serial number {}", store.serial_number.as_str());
    loop {
        check_in(Client::Store);
        store.plans.take_back();
        match select4(TO_STORE.wait(), INCOMING.receive(), EVENTS.receive(), Timer::after(ALIVE)).await {
            Either4::First(record) => {
                if store.reservation_erases() {
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
                if store.log_erases() {
                    // Events wait in their channel meanwhile; only the watchdog and reservations must not.
                    controller::steady_lamps(RESERVATION_PATIENCE).await;
                }
                store.write_log(event);
            }
            Either4::Fourth(()) => {}
        }
    }
}
