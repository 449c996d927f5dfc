//! The simulated controller's time: its battery clock, and what is known of that clock's drift.

use std::time::{SystemTime, UNIX_EPOCH};

use vitrine_exhibit::{clock::ClockRecord, units::UtcSeconds};
use vitrine_protocol::status::{ClockSource, ClockState};

/// Where the controller's time comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The computer's clock.
    Computer,
    /// A battery clock that showed this time at the start, and goes with the simulated time.
    Simulated(UtcSeconds),
    /// Nobody has set it.
    Unset,
}

/// The clock since the start. Times since the start are in ms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Time {
    clock: Clock,
    set: Option<(UtcSeconds, u64)>,
    record: ClockRecord,
}

impl Time {
    /// A clock of which this much is known.
    pub(super) const fn new(clock: Clock, record: ClockRecord) -> Self {
        Self { clock, set: None, record }
    }

    /// The time, corrected by the drift where a battery clock keeps it.
    pub(super) fn now(&self, time_ms: u64) -> Option<UtcSeconds> {
        let shown = self.shown(time_ms)?;
        if self.is_kept_by_battery() { self.record.corrected(shown) } else { Some(shown) }
    }

    /// What is told of the clock.
    pub(super) fn state(&self, time_ms: u64) -> ClockState {
        let source = match (self.set, self.clock) {
            (_, Clock::Simulated(_)) => ClockSource::Battery,
            (Some(_), _) => ClockSource::Host,
            (None, Clock::Unset) => ClockSource::Nothing,
            (None, Clock::Computer) => ClockSource::Computer,
        };
        ClockState { now: self.now(time_ms), source, record: self.record }
    }

    /// The clock as a controller finds it that starts anew now: a battery clock has gone on, what a host has set without one is
    /// lost.
    pub(super) fn clock_after(&self, time_ms: u64) -> Clock {
        match self.clock {
            Clock::Simulated(_) => self.shown(time_ms).map_or(self.clock, Clock::Simulated),
            clock => clock,
        }
    }

    /// What will be known of the clock once it is set to this time.
    pub(super) fn record_of(&self, now: UtcSeconds, time_ms: u64) -> ClockRecord {
        self.record.set(self.shown(time_ms), now)
    }

    /// Sets the clock.
    pub(super) const fn set(&mut self, now: UtcSeconds, time_ms: u64, record: ClockRecord) {
        self.set = Some((now, time_ms));
        self.record = record;
    }

    const fn is_kept_by_battery(&self) -> bool {
        matches!(self.clock, Clock::Simulated(_))
    }

    /// What the clock shows, whether right or wrong.
    fn shown(&self, time_ms: u64) -> Option<UtcSeconds> {
        let passed = |since_ms: u64| i64::try_from((time_ms - since_ms) / 1_000).unwrap_or(i64::MAX);
        if let Some((set_to, at_ms)) = self.set {
            return Some(UtcSeconds(set_to.0 + passed(at_ms)));
        }
        match self.clock {
            Clock::Computer => Some(computer_time()),
            Clock::Simulated(start) => Some(UtcSeconds(start.0 + passed(0))),
            Clock::Unset => None,
        }
    }
}

fn computer_time() -> UtcSeconds {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    UtcSeconds(i64::try_from(since.as_secs()).unwrap_or(i64::MAX))
}
