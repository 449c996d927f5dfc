//! The owner of the state: one step of the exhibit's mind, a hundred times a second.
//!
//! Runs on the interrupt executor, above all tasks that talk to sensors, hosts and flash. Everything comes to it as
//! values, and leaves it as values; it waits for nothing but the next tick.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Ticker};
use heapless::Vec;
use portable_atomic::{AtomicU32, Ordering};
use vitrine_drivers::interlock::Loops;
use vitrine_exhibit::controller::{Snapshot, State, step};
use vitrine_exhibit::events::{Event, Events};
use vitrine_exhibit::inputs::{Contact, Inputs, InterlockLoops, Request};
use vitrine_exhibit::ledger::{LedgerRecord, StoredReservation};
use vitrine_exhibit::plan::ValidPlan;
use vitrine_exhibit::units::Milliseconds;
use vitrine_exhibit::viewer::ThermalFrame;

use crate::guard::Interlock;
use crate::watchdog::{Client, check_in};
use crate::{darkness, front, lamps, readings, settings};

/// A hundred steps a second.
const STEP: Duration = Duration::from_millis(10);

/// A level that has stood for so long is steady.
const STEADY_FOR_MS: u32 = 50;

/// The most requests of one step; more wait for the next.
const REQUESTS_A_STEP: usize = 4;

/// What hosts ask.
pub(crate) static REQUESTS: Channel<CriticalSectionRawMutex, Request, 8> = Channel::new();

/// A plan slot: the store fills it, the controller keeps it while it is the active one.
pub(crate) type PlanSlot = &'static mut Option<ValidPlan>;

/// A new plan, on its way to the controller.
pub(crate) static NEW_PLAN: Channel<CriticalSectionRawMutex, PlanSlot, 1> = Channel::new();

/// The slot of the plan before, on its way back to the store.
pub(crate) static OLD_PLAN: Channel<CriticalSectionRawMutex, PlanSlot, 2> = Channel::new();

/// A ledger record that must be stored before the lamps may go on.
pub(crate) static TO_STORE: Signal<CriticalSectionRawMutex, LedgerRecord> = Signal::new();

/// The ledger record that was stored last.
pub(crate) static STORED: Signal<CriticalSectionRawMutex, StoredReservation> = Signal::new();

/// An event, and when it happened.
pub(crate) struct Happened {
    pub(crate) at: Instant,
    pub(crate) event: Event,
}

impl Happened {
    /// An event of this moment.
    pub(crate) fn now(event: Event) -> Self {
        Self { at: Instant::now(), event }
    }
}

/// What happened, for the log. It waits here while the lamps fade and the log has no room that is erased. What finds no
/// room is lost, counted and told: the loop does not wait for flash.
pub(crate) static EVENTS: Channel<CriticalSectionRawMutex, Happened, 64> = Channel::new();

/// Events that found no room; the bench looks here.
#[cfg_attr(feature = "bench", unsafe(export_name = "VITRINE_LOST_EVENTS"))]
static LOST_EVENTS: AtomicU32 = AtomicU32::new(0);

static SNAPSHOT: CriticalSectionMutex<RefCell<Option<Snapshot>>> =
    CriticalSectionMutex::new(RefCell::new(None));

/// What the controller tells of itself after its last step.
pub(crate) fn snapshot() -> Snapshot {
    SNAPSHOT.lock(|snapshot| *snapshot.borrow()).unwrap_or_default()
}

/// How many events were lost since the start.
pub(crate) fn lost_events() -> u32 {
    LOST_EVENTS.load(Ordering::Relaxed)
}

/// Since when the lamps have not changed, in milliseconds since the start.
static STEADY_SINCE: AtomicU32 = AtomicU32::new(0);

/// Tells whether the lamps are dark or have been at the same level for a while.
pub(crate) fn lamps_are_steady() -> bool {
    now_ms().wrapping_sub(STEADY_SINCE.load(Ordering::Relaxed)) >= STEADY_FOR_MS
}

/// For how long the lamps are asked to stand still at a time: for them to be steady, for the watchdog to be fed, and for an
/// erase at its longest.
const STILL_FOR: Duration = Duration::from_millis(800);

/// Until when the lamps are asked to stand still, in milliseconds since the start.
static STILL_UNTIL: AtomicU32 = AtomicU32::new(0);

/// Asks the lamps to stand still for a moment. The governor decides.
pub(crate) fn stand_still() {
    STILL_UNTIL.store(now_ms().wrapping_add(STILL_FOR.as_millis() as u32), Ordering::Relaxed);
}

fn is_asked_to_stand_still() -> bool {
    let left = STILL_UNTIL.load(Ordering::Relaxed).wrapping_sub(now_ms());
    left > 0 && left <= STILL_FOR.as_millis() as u32
}

/// Wraps around after 49 days: only differences count.
fn now_ms() -> u32 {
    Instant::now().as_millis() as u32
}

/// Steps the mind for ever.
#[embassy_executor::task]
pub(crate) async fn run(state: &'static mut State, mut interlock: Interlock, mut plan: PlanSlot) -> ! {
    let mut ticker = Ticker::every(STEP);
    let mut last = Instant::now();
    let mut stored_sequence = None;
    loop {
        ticker.next().await;
        #[cfg(feature = "bench")]
        crate::hooks::step(true);
        if let Ok(new) = NEW_PLAN.try_receive() {
            let old = core::mem::replace(&mut plan, new);
            // Room for both slots: this cannot fail.
            let _ = OLD_PLAN.try_send(old);
        }
        let now = Instant::now();
        let elapsed = now.saturating_duration_since(last).as_millis();
        last += Duration::from_millis(elapsed);
        let elapsed = Milliseconds(u32::try_from(elapsed).unwrap_or(u32::MAX));
        let events = one_step(state, loops(&mut interlock), plan.as_ref(), elapsed);
        tell(state, &events, &mut stored_sequence);
        #[cfg(feature = "bench")]
        crate::hooks::step(false);
        check_in(Client::Controller);
    }
}

fn one_step(
    state: &mut State,
    interlock: InterlockLoops,
    plan: Option<&ValidPlan>,
    elapsed: Milliseconds,
) -> Events {
    let readings = readings::take();
    let [left, right] = readings.thermal;
    let placed = |frame| settings::with(|settings| settings.placed(frame));
    let left = left.map(ThermalFrame::left).map(placed);
    let right = right.map(ThermalFrame::right).map(placed);
    let mut requests: Vec<Request, REQUESTS_A_STEP> = Vec::new();
    while !requests.is_full()
        && let Ok(request) = REQUESTS.try_receive()
    {
        let _ = requests.push(request);
    }
    let inputs = Inputs {
        plan,
        thermal: [left.as_ref(), right.as_ref()],
        radar: readings.radar.as_ref(),
        interlock,
        boards: readings.lamp_boards,
        enclosure: readings.enclosure,
        supply: readings.supply,
        ultraviolet: readings.ultraviolet,
        now: readings.now,
        clock_was_set: readings.clock_was_set,
        requests: &requests,
        staff_key: front::staff_key_is_pressed(),
        stored: STORED.try_take(),
        stand_still: is_asked_to_stand_still(),
    };
    let before = state.snapshot().levels;
    let (command, events) = step(state, &inputs, elapsed);
    if command.levels() != before {
        STEADY_SINCE.store(now_ms(), Ordering::Relaxed);
    }
    lamps::COMMAND.signal(command);
    events
}

/// What the loops read now. An opening that came and went between two steps, which only the guard has seen, is told as an
/// open reading: the governor follows, and knows what to make of a bounce.
fn loops(interlock: &mut Interlock) -> InterlockLoops {
    // Forgotten before the loops are read: an edge after this line counts against the command of this step.
    let opened = darkness::take_opening();
    let Loops { a_closed, b_closed } = interlock.read();
    let contact = |closed: bool| if closed && !opened { Contact::Closed } else { Contact::Open };
    InterlockLoops { a: contact(a_closed), b: contact(b_closed) }
}

fn tell(state: &State, events: &Events, stored_sequence: &mut Option<u32>) {
    if let Some(record) = state.ledger().to_store()
        && *stored_sequence != Some(record.sequence)
    {
        *stored_sequence = Some(record.sequence);
        TO_STORE.signal(*record);
    }
    let kept = events.iter().filter(|event| event.is_kept());
    let refused = kept.filter(|event| EVENTS.try_send(Happened::now(*event)).is_err()).count() as u32;
    let lost = refused.saturating_add(u32::from(events.lost()));
    if lost > 0 {
        LOST_EVENTS.store(LOST_EVENTS.load(Ordering::Relaxed).saturating_add(lost), Ordering::Relaxed);
    }
    let snapshot = *state.snapshot();
    SNAPSHOT.lock(|shared| *shared.borrow_mut() = Some(snapshot));
}
