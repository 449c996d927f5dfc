//! The aggregated watchdog: it is fed only when every task has checked in since the last feed.
//!
//! A task that hangs stops the feeding, and the chip resets within 500 ms: dark, as every reset is. The dose ledger
//! counts such starts, and latches the controller dark when they come too often.

use core::pin::pin;

use defmt::{info, warn};
use embassy_futures::select::{Either, select};
use embassy_rp::watchdog::Watchdog;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Timer};
use portable_atomic::{AtomicBool, AtomicU32, Ordering};

use crate::board::DogResources;
use crate::last_words;

/// From the last feed to the reset: with all tolerances of the watchdog's tick within the 500 ms that a stuck task may
/// leave the lamps lit.
const TIMEOUT: Duration = Duration::from_millis(480);

/// The longest that a sector's erase takes, in which nobody can check in: W25Q16JV, sector erase time at most.
const LONGEST_ERASE: Duration = Duration::from_millis(400);

/// After an erase all check in within this time: the slowest is a transfer on a sensor bus that somebody holds.
const ALL_CHECK_IN: Duration = Duration::from_millis(50);

/// An erase begins within this time of a feed, and so there is one at the most for each: the watchdog outlasts it.
const TIME_TO_BEGIN_AN_ERASE: Duration =
    Duration::from_ticks(TIMEOUT.as_ticks() - LONGEST_ERASE.as_ticks() - ALL_CHECK_IN.as_ticks());

/// How often a task says that it is alive while it has nothing to do.
pub(crate) const ALIVE: Duration = Duration::from_millis(100);

/// Who must check in at least every 400 ms.
#[derive(Clone, Copy)]
#[repr(u32)]
pub(crate) enum Client {
    /// The owner of the state.
    Controller = 1 << 0,
    /// The owner of both lamps.
    Lamps = 1 << 1,
    /// The owner of the sensor bus.
    Sensors = 1 << 2,
    /// The owner of the converter.
    Analog = 1 << 3,
    /// The owner of flash.
    Store = 1 << 4,
    /// The link over USB.
    Usb = 1 << 5,
    /// The link over the service port.
    Serial = 1 << 6,
    /// The owner of the radar's port.
    Radar = 1 << 7,
    /// The owner of status LED and staff key.
    Front = 1 << 8,
    /// The device side of USB.
    UsbDevice = 1 << 9,
}

const ALL_CLIENTS: u32 = (1 << 10) - 1;

static CHECKED_IN: AtomicU32 = AtomicU32::new(0);

/// Everybody has checked in since the last feed.
static EVERYBODY: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// When the watchdog was last fed, in milliseconds since the start.
static FED_AT: AtomicU32 = AtomicU32::new(0);

/// The watchdog was fed: for the owner of flash, who has waited for it.
pub(crate) static FED: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Everybody has checked in at least once.
static ALL_ALIVE: AtomicBool = AtomicBool::new(false);

/// Tells whether every task has checked in; who does not go on doing so is reset.
pub(crate) fn all_have_checked_in() -> bool {
    ALL_ALIVE.load(Ordering::Relaxed)
}

/// Says that a task is alive.
pub(crate) fn check_in(client: Client) {
    #[cfg(feature = "bench")]
    if crate::hooks::obey(client) {
        return;
    }
    let others = CHECKED_IN.fetch_or(client as u32, Ordering::Relaxed);
    if others | client as u32 == ALL_CLIENTS {
        EVERYBODY.signal(());
    }
}

/// Does work that may take long, and says meanwhile that the task is alive.
pub(crate) async fn alive_while<F: Future>(client: Client, work: F) -> F::Output {
    let mut work = pin!(work);
    loop {
        check_in(client);
        if let Either::First(output) = select(work.as_mut(), Timer::after(ALIVE)).await {
            return output;
        }
    }
}

/// Tells whether an erase that begins now ends, and all check in after it, before the watchdog bites.
pub(crate) fn outlasts_an_erase() -> bool {
    now_ms().wrapping_sub(FED_AT.load(Ordering::Relaxed)) < TIME_TO_BEGIN_AN_ERASE.as_millis() as u32
}

/// Wraps around after 49 days: only differences count.
fn now_ms() -> u32 {
    Instant::now().as_millis() as u32
}

/// The dog, and why it woke.
pub(crate) struct Dog {
    watchdog: Watchdog,
    after_fault: bool,
}

impl Dog {
    /// Starts the watchdog.
    pub(crate) fn wake(resources: DogResources) -> Self {
        let mut watchdog = Watchdog::new(resources.watchdog);
        let was_meant = last_words::take_meant();
        let after_fault = watchdog.reset_reason().is_some() && !was_meant;
        if was_meant {
            info!("restarted as it was to be");
        } else if after_fault {
            warn!("started after a fault or a task that hung");
        } else {
            info!("started by power or by the reset line");
        }
        watchdog.pause_on_debug(true);
        watchdog.start(TIMEOUT);
        Self { watchdog, after_fault }
    }

    /// Tells whether the watchdog, a panic or a fault restarted the controller.
    pub(crate) fn after_fault(&self) -> bool {
        self.after_fault
    }
}

/// Feeds the watchdog whenever everybody has checked in, at once.
#[embassy_executor::task]
pub(crate) async fn run(mut dog: Dog) -> ! {
    loop {
        EVERYBODY.wait().await;
        let everybody = critical_section::with(|_| {
            let everybody = CHECKED_IN.load(Ordering::Relaxed) & ALL_CLIENTS == ALL_CLIENTS;
            if everybody {
                CHECKED_IN.store(0, Ordering::Relaxed);
            }
            everybody
        });
        if everybody {
            ALL_ALIVE.store(true, Ordering::Relaxed);
            dog.watchdog.feed(TIMEOUT);
            FED_AT.store(now_ms(), Ordering::Relaxed);
            FED.signal(());
        }
    }
}
