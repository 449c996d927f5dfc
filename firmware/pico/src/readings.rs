//! What the slow sensors said last, for the owner of the state: written by their owners, read once a step.
//!
//! A reading grows old: a sensor's owner that stops writing is a sensor that says nothing.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time::{Duration, Instant};
use vitrine_exhibit::inputs::TemperatureReading;
use vitrine_exhibit::units::{Irradiance, Millivolts, PerLamp, UtcSeconds};
use vitrine_exhibit::viewer::PIXELS;
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
    clock: Option<Stamped<UtcSeconds>>,
    clock_source: ClockSource,
    last_correction_s: Option<i32>,
}

static BOARD: CriticalSectionMutex<RefCell<Board>> = CriticalSectionMutex::new(RefCell::new(Board {
    thermal: [None, None],
    lamp_boards: None,
    supply: None,
    ultraviolet: None,
    clock: None,
    clock_source: ClockSource::Nothing,
    last_correction_s: None,
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
    /// The time.
    pub(crate) now: Option<UtcSeconds>,
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
        now: running(board.clock, now),
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

/// Leaves a reading of the ultraviolet sensor.
pub(crate) fn ultraviolet(irradiance: Irradiance) {
    with(|board| board.ultraviolet = Some(irradiance));
}

/// Takes over what the battery clock says.
pub(crate) fn clock_from_battery(time: UtcSeconds) {
    let at = Instant::now();
    with(|board| {
        board.clock = Some(Stamped { value: time, at });
        board.clock_source = ClockSource::Battery;
    });
}

/// Takes over what a host says; whether the battery clock keeps it will be seen.
pub(crate) fn clock_set_by_host(time: UtcSeconds) {
    let at = Instant::now();
    with(|board| {
        board.last_correction_s = running(board.clock, at)
            .map(|before| i32::try_from(before.0.saturating_sub(time.0)).unwrap_or(i32::MAX));
        board.clock = Some(Stamped { value: time, at });
        board.clock_source = ClockSource::Host;
    });
}

/// The clock.
pub(crate) fn clock() -> ClockState {
    let now = Instant::now();
    with(|board| ClockState {
        now: running(board.clock, now),
        source: board.clock_source,
        last_correction_s: board.last_correction_s,
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
