//! The battery clock's error: when it was last set, and how fast it drifts.
//!
//! A clock that is set again tells by how much it was wrong. The rate is kept in flash, the time that the
//! clock shows is corrected by it, and a clock whose crystal is far off is told before it misleads the schedule.

use serde::{Deserialize, Serialize};

use crate::schedule;
use crate::units::UtcSeconds;

/// A rate is only learnt over at least this long: a second in a day is 11.6 millionths.
const SHORTEST: i64 = 86_400;
/// No crystal drifts faster than this, in thousandths of a millionth: such an error was a wrong setting.
const FASTEST_PPB: i64 = 500_000;
/// A drift beyond this, in thousandths of a millionth, is told: 26 s in a month.
pub const NOTABLE_PPB: i32 = 10_000;

/// What is known of the battery clock; kept in flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClockRecord {
    /// When a host set it last.
    pub set_at: Option<UtcSeconds>,
    /// How much faster it runs than it should, in thousandths of a millionth.
    pub drift_ppb: i32,
    /// By how many seconds it was ahead when it was set last; none where it showed no time until then.
    pub last_error_s: Option<i32>,
}

impl ClockRecord {
    /// Takes note that a host has set the clock, which showed another time, or none, until then.
    #[must_use]
    pub fn set(self, shown: Option<UtcSeconds>, truth: UtcSeconds) -> Self {
        let shown = shown.and_then(schedule::plausible);
        let error = shown.map(|shown| shown.0.saturating_sub(truth.0));
        let last_error_s = error.map(|error| error.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32);
        let (Some(error), Some(set_at)) = (error, self.set_at) else {
            return Self { set_at: Some(truth), last_error_s, ..self };
        };
        let gone = truth.0.saturating_sub(set_at.0);
        let drift = error.saturating_mul(1_000_000_000).checked_div(gone).unwrap_or(i64::MAX);
        let learnt = gone >= SHORTEST && drift.abs() <= FASTEST_PPB;
        Self {
            set_at: Some(truth),
            last_error_s,
            drift_ppb: if learnt { drift as i32 } else { self.drift_ppb },
        }
    }

    /// Gives the time that the clock means by what it shows; none where that cannot be right.
    pub fn corrected(self, shown: UtcSeconds) -> Option<UtcSeconds> {
        let shown = schedule::plausible(shown)?;
        let gone = self.set_at.map_or(0, |set_at| shown.0.saturating_sub(set_at.0).max(0));
        let ahead = gone
            .saturating_mul(i64::from(self.drift_ppb))
            .saturating_add(500_000_000)
            .div_euclid(1_000_000_000);
        schedule::plausible(UtcSeconds(shown.0.saturating_sub(ahead)))
    }

    /// Tells whether the clock drifts enough to be told.
    pub const fn drifts(self) -> bool {
        self.drift_ppb.unsigned_abs() > NOTABLE_PPB.unsigned_abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const START: UtcSeconds = UtcSeconds(1_777_629_600);

    fn after(days: i64) -> UtcSeconds {
        UtcSeconds(START.0 + days * 86_400)
    }

    #[test]
    fn the_drift_is_learnt_at_the_second_setting_and_corrected_from_then_on() {
        let record = ClockRecord::default().set(None, START);
        let shown = UtcSeconds(after(30).0 + 52);
        let record = record.set(Some(shown), after(30));
        assert_eq!((record.last_error_s, record.drift_ppb / 1_000), (Some(52), 20));
        assert!(record.drifts());
        let shown = UtcSeconds(after(60).0 + 52);
        assert_eq!(record.corrected(shown), Some(after(60)));
    }

    #[test]
    fn a_wrong_setting_is_no_drift() {
        let record = ClockRecord::default().set(None, START);
        let record = record.set(Some(UtcSeconds(after(30).0 + 3_600)), after(30));
        assert_eq!((record.last_error_s, record.drift_ppb), (Some(3_600), 0));
        assert!(!record.drifts());
    }

    #[test]
    fn a_second_within_a_minute_tells_nothing() {
        let record = ClockRecord::default().set(None, START);
        let minute = UtcSeconds(START.0 + 60);
        assert_eq!(record.set(Some(UtcSeconds(minute.0 + 1)), minute).drift_ppb, 0);
    }

    proptest! {
        #[test]
        fn any_clock_is_taken(set_at: i64, shown: i64, truth: i64, drift_ppb: i32) {
            let record = ClockRecord { set_at: Some(UtcSeconds(set_at)), drift_ppb, last_error_s: None };
            let next = record.set(Some(UtcSeconds(shown)), UtcSeconds(truth));
            prop_assert!(next.corrected(UtcSeconds(shown)).is_none_or(|now| schedule::plausible(now).is_some()));
        }
    }
}
