//! What the slow sensors said last, for the owner of the state: written by their owners, read once a step.
//!
//! A reading grows old: a sensor's owner that stops writing is a sensor that says nothing.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time::{Duration, Instant};
use vitrine_exhibit::clock::ClockRecord;
use vitrine_exhibit::inputs::TemperatureReading;
use vitrine_exhibit::units::{CentiCelsius, Irradiance, Millivolts, PerLamp, UtcSeconds};
use vitrine_exhibit::viewer::{PIXELS, RadarFrame};
use vitrine_protocol::status::{ClockSource, ClockState};

/// A reading that is older says nothing any more.
const STALE: Duration = Duration::from_millis(1_000);

/// One sensor's pixels, in quarter degrees.
pub(crate) type Pixels = [i16; PIXELS];

#[derive(Clone, Copy)]
struct Stamped<T> {
    value: T,
    at: Instant,
}

/// What is known, with its age.
struct Board {
    thermal: [Option<Pixels>; 2],
    lamp_boards: Option<Stamped<PerLamp<TemperatureReading>>>,
    supply: Option<Stamped<Millivolts>>,
    ultraviolet: Option<Irradiance>,
    enclosure: Option<Stamped<CentiCelsius>>,
    radar: Option<RadarFrame>,
    clock: Option<Stamped<UtcSeconds>>,
    /// What the battery clock shows, whether right or wrong.
    shown: Option<Stamped<UtcSeconds>>,
    clock_source: ClockSource,
    clock_record: Option<ClockRecord>,
    /// A host has set the time, and the battery clock does not have it yet.
    clock_is_being_set: bool,
    /// A host has set the time, and the state's owner does not know it yet.
    clock_was_set: bool,
}

static BOARD: CriticalSectionMutex<RefCell<Board>> = CriticalSectionMutex::new(RefCell::new(Board {
    thermal: [None, None],
    lamp_boards: None,
    supply: None,
    ultraviolet: None,
    enclosure: None,
    radar: None,
    clock: None,
    shown: None,
    clock_source: ClockSource::Nothing,
    clock_record: None,
    clock_is_being_set: false,
    clock_was_set: false,
}));

/// What one step of the controller gets to know.
pub(crate) struct Readings {
    /// New frames since the last call, of the left and of the right sensor.
    pub(crate) thermal: [Option<Pixels>; 2],
    /// Temperatures of the lamp boards.
    pub(crate) lamp_boards: PerLamp<Option<TemperatureReading>>,
    /// The lamp supply.
    pub(crate) supply: Option<Millivolts>,
    /// A new reading of the ultraviolet sensor since the last call.
    pub(crate) ultraviolet: Option<Irradiance>,
    /// The enclosure's air.
    pub(crate) enclosure: Option<CentiCelsius>,
    /// A new report of the radar since the last call.
    pub(crate) radar: Option<RadarFrame>,
    /// The time.
    pub(crate) now: Option<UtcSeconds>,
    /// A host has set it since the last call.
    pub(crate) clock_was_set: bool,
}

/// Takes what is new, and copies what is known and fresh.
pub(crate) fn take() -> Readings {
    let now = Instant::now();
    with(|board| Readings {
        thermal: [
            board.thermal.first_mut().and_then(Option::take),
            board.thermal.last_mut().and_then(Option::take),
        ],
        lamp_boards: fresh(board.lamp_boards, now).map_or(PerLamp::default(), |both| both.map(Some)),
        supply: fresh(board.supply, now),
        ultraviolet: board.ultraviolet.take(),
        enclosure: fresh(board.enclosure, now),
        radar: board.radar.take(),
        now: running(board.clock, now),
        clock_was_set: core::mem::take(&mut board.clock_was_set),
    })
}

/// Leaves a frame of the left (0) or right (1) thermal sensor.
pub(crate) fn thermal(sensor: usize, pixels: &Pixels) {
    with(|board| {
        if let Some(slot) = board.thermal.get_mut(sensor) {
            *slot = Some(*pixels);
        }
    });
}

/// Leaves temperatures and supply.
pub(crate) fn analog(lamp_boards: PerLamp<TemperatureReading>, supply: Millivolts) {
    let at = Instant::now();
    with(|board| {
        board.lamp_boards = Some(Stamped { value: lamp_boards, at });
        board.supply = Some(Stamped { value: supply, at });
    });
}

/// Leaves a reading of the ultraviolet sensor, and the temperature of the enclosure's air in which it hangs.
pub(crate) fn ultraviolet(irradiance: Irradiance, air: CentiCelsius) {
    let at = Instant::now();
    with(|board| {
        board.ultraviolet = Some(irradiance);
        board.enclosure = Some(Stamped { value: air, at });
    });
}

/// Leaves a report of the radar.
pub(crate) fn radar(report: RadarFrame) {
    with(|board| board.radar = Some(report));
}

/// Leaves what is known of the battery clock.
pub(crate) fn clock_record(record: ClockRecord) {
    with(|board| board.clock_record = Some(record));
}

/// Takes over what the battery clock shows, corrected by its drift; not while it is being set.
pub(crate) fn clock_from_battery(shown: UtcSeconds) {
    let at = Instant::now();
    with(|board| {
        if !board.clock_is_being_set {
            board.shown = Some(Stamped { value: shown, at });
            if let Some(value) = board.clock_record.unwrap_or_default().corrected(shown) {
                board.clock = Some(Stamped { value, at });
                board.clock_source = ClockSource::Battery;
            }
        }
    });
}

/// Takes over what a host says; gives what is known of the battery clock by that. The battery clock is to be set next.
pub(crate) fn clock_set_by_host(time: UtcSeconds) -> ClockRecord {
    let at = Instant::now();
    with(|board| {
        let record = board.clock_record.unwrap_or_default().set(running(board.shown, at), time);
        board.clock_record = Some(record);
        board.clock = Some(Stamped { value: time, at });
        board.clock_source = ClockSource::Host;
        board.clock_is_being_set = true;
        board.clock_was_set = true;
        record
    })
}

/// Takes note that the battery clock was set to this time, or that it did not take it.
pub(crate) fn clock_was_set(kept: Option<UtcSeconds>) {
    let at = Instant::now();
    with(|board| {
        board.clock_is_being_set = false;
        board.shown = kept.map(|value| Stamped { value, at });
        if kept.is_some() {
            board.clock_source = ClockSource::Battery;
        }
    });
}

/// The time now, as far as it is known.
pub(crate) fn time() -> Option<UtcSeconds> {
    let now = Instant::now();
    with(|board| running(board.clock, now))
}

/// The clock.
pub(crate) fn clock() -> ClockState {
    let now = Instant::now();
    with(|board| ClockState {
        now: running(board.clock, now),
        source: board.clock_source,
        record: board.clock_record.unwrap_or_default(),
    })
}

fn with<R>(use_board: impl FnOnce(&mut Board) -> R) -> R {
    BOARD.lock(|board| use_board(&mut board.borrow_mut()))
}

fn fresh<T>(stamped: Option<Stamped<T>>, now: Instant) -> Option<T> {
    stamped.filter(|stamped| now.saturating_duration_since(stamped.at) < STALE).map(|stamped| stamped.value)
}

fn running(clock: Option<Stamped<UtcSeconds>>, now: Instant) -> Option<UtcSeconds> {
    clock.map(|clock| {
        let since = now.saturating_duration_since(clock.at).as_secs();
        UtcSeconds(clock.value.0.saturating_add_unsigned(since))
    })
}
