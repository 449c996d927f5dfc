//! When the ledger's days begin, and what a clock proves.

use super::{DoseLedger, LedgerRecord};
use crate::events::{Event, Events};
use crate::units::{Dose, Lamp, Milliseconds, PerLamp, UtcSeconds};

const DAY_MS: u32 = 86_400_000;
/// By how much days may begin early in sum.
const MOST_EARLY_MS: u32 = DAY_MS + 2 * 3_600_000;
/// A clock that is this far from where it should be by now was set; less is its drift ...
const JUMP_S: u64 = 60;
/// ... within this time.
const DRIFTS_FOR: Milliseconds = Milliseconds(3_600_000);

/// Where the clock should be by now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    expected: Option<UtcSeconds>,
    /// Time since `expected`.
    since: Milliseconds,
    /// The time away before this start is still to be told by the clock's first showing.
    was_away: bool,
}

impl Clock {
    pub(super) const fn new() -> Self {
        Self { expected: None, since: Milliseconds(0), was_away: true }
    }
}

impl DoseLedger {
    /// Takes the clock as it shows now. `set`: a host has set it since the call before.
    ///
    /// A showing that did not come by itself proves no time; it is written to flash at once, so that a power cut does not
    /// make it one that did.
    pub fn clock(&mut self, now: Option<UtcSeconds>, set: bool, elapsed: Milliseconds, events: &mut Events) {
        self.clock.since = self.clock.since.plus(elapsed);
        let Some(now) = now else { return };
        let since_s = i64::from(self.clock.since.0 / 1_000);
        let expected = self.clock.expected.map(|expected| expected.0.saturating_add(since_s));
        let jump = expected.map_or(0, |expected| now.0.saturating_sub(expected));
        let jumped = jump.unsigned_abs() > JUMP_S;
        if self.clock.was_away && !set {
            self.prove_away(now);
        }
        self.clock.was_away = false;
        if jumped || expected.is_none() || self.clock.since >= DRIFTS_FOR {
            (self.clock.expected, self.clock.since) = (Some(now), Milliseconds(0));
        }
        self.spent.clock_s = u32::try_from(now.0).unwrap_or(u32::MAX);
        if jumped {
            let seconds = i32::try_from(jump).unwrap_or(if jump < 0 { i32::MIN } else { i32::MAX });
            events.push(Event::ClockJumped { seconds });
        }
        if jumped || set {
            self.want(self.left(Lamp::Top), self.left(Lamp::Bottom));
        }
    }

    /// Counts the time between the last record and this start.
    fn prove_away(&mut self, now: UtcSeconds) {
        if self.spent.clock_s == 0 {
            return;
        }
        let away_s = now.0.saturating_sub(i64::from(self.spent.clock_s)).max(0);
        let away_ms = u32::try_from(away_s.saturating_mul(1_000)).unwrap_or(u32::MAX);
        self.spent.day_ms = self.spent.day_ms.saturating_add(away_ms);
    }

    /// Asks for the ledger's next day when the local day has changed and the day is not too early, or 24 proven hours have
    /// gone: the day begins when its first record is in flash, so that a power cut cannot take the new day's dose with
    /// it. A clock that was set back waits for those 24 hours.
    pub fn day(&mut self, local_day: Option<u32>) {
        let is_full = self.spent.day_ms >= DAY_MS;
        let changed = local_day.is_some_and(|day| day > self.spent.day);
        let early_ms = self.early_by_then();
        if self.wanted.is_some() || !(is_full || changed && early_ms <= MOST_EARLY_MS) {
            return;
        }
        let reserved = PerLamp::new(self.left(Lamp::Top), self.left(Lamp::Bottom));
        self.want(reserved.top, reserved.bottom);
        if let Some(record) = &mut self.wanted {
            record.day = local_day.filter(|day| *day != record.day).unwrap_or(record.day.saturating_add(1));
            record.day_ms = 0;
            record.early_ms = early_ms;
            record.lamps.top.day = reserved.top;
            record.lamps.bottom.day = reserved.bottom;
        }
    }

    /// Takes over the day of a record that is in flash; tells whether it is another one.
    pub(super) const fn begin_day_of(&mut self, record: &LedgerRecord) -> bool {
        let begins = record.day != self.spent.day;
        if begins {
            self.spent.day = record.day;
            self.spent.day_ms = 0;
            self.spent.early_ms = record.early_ms;
            self.spent.lamps.top.day = Dose(0);
            self.spent.lamps.bottom.day = Dose(0);
        }
        begins
    }

    /// By how much days will have begun early in sum if the next begins now. The first of all is never early.
    const fn early_by_then(&self) -> u32 {
        if self.spent.day == 0 {
            return 0;
        }
        let before = self.spent.early_ms.saturating_add(DAY_MS);
        before.saturating_sub(self.spent.day_ms)
    }
}
