//! `vitrine clock`: the controller's time.

use clap::Args;
use jiff::Timestamp;
use miette::Report;
use vitrine_exhibit::clock::ClockRecord;
use vitrine_exhibit::units::UtcSeconds;
use vitrine_protocol::status::{ClockSource, ClockState};

use super::connect::To;
use super::output::Output;

/// Tell the controller's time, or set it from this computer's.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  vitrine clock\n  vitrine clock --set --to /dev/ttyACM0\n  vitrine clock --set --dry-run"
)]
pub(super) struct Clock {
    /// Set it to this computer's time.
    #[arg(long)]
    set: bool,
    /// With --set: only tell what would be set.
    #[arg(long, requires = "set")]
    dry_run: bool,
    #[command(flatten)]
    to: To,
}

impl Clock {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let mut client = self.to.open()?;
        let set = self.set && !self.dry_run;
        let clock =
            if set { client.set_clock(UtcSeconds(Timestamp::now().as_second()))? } else { client.clock()? };
        let ahead_s = clock.now.map(|now| now.0 - Timestamp::now().as_second());
        let told = serde_json::json!({
            "now": clock.now.map(time_text),
            "source": source_text(clock.source),
            "ahead_of_this_computer_s": ahead_s,
            "last_correction_s": clock.record.last_error_s,
            "last_set": clock.record.set_at.map(time_text),
            "drift_s_per_day": seconds_a_day(clock.record),
            "set": set,
        });
        output.result(&told, || text(&clock, ahead_s, set));
        Ok(())
    }
}

fn text(clock: &ClockState, ahead_s: Option<i64>, set: bool) -> String {
    let Some(now) = clock.now else {
        return "the controller does not know the time: set it with `vitrine clock --set`".to_owned();
    };
    let correction = match clock.record.last_error_s {
        Some(0) if set => "; it was right".to_owned(),
        Some(correction) if set => format!("; it was {}", apart(i64::from(correction))),
        _ => {
            ahead_s.filter(|ahead| *ahead != 0).map(|ahead| format!("; {}", apart(ahead))).unwrap_or_default()
        }
    };
    let mut lines = vec![format!("{} from {}{correction}", time_text(now), source_text(clock.source))];
    lines.extend(clock.record.set_at.map(|at| format!("last set {}", time_text(at))));
    lines.extend(drift_text(clock.record));
    lines.join("\n")
}

/// How far the controller's time is from this computer's.
fn apart(ahead_s: i64) -> String {
    let side = if ahead_s < 0 { "behind" } else { "ahead of" };
    format!("{} s {side} this computer", ahead_s.unsigned_abs())
}

/// What is known of the battery clock's drift; none while nothing is.
pub(super) fn drift_text(record: ClockRecord) -> Option<String> {
    let seconds = seconds_a_day(record);
    let advice =
        if record.drifts() { ", more than a sound crystal does: have the clock looked at" } else { "" };
    let way = if seconds < 0.0 { "loses" } else { "gains" };
    (record.drift_ppb != 0)
        .then(|| format!("it {way} {:.1} s a day, which is corrected{advice}", seconds.abs()))
}

fn seconds_a_day(record: ClockRecord) -> f64 {
    f64::from(record.drift_ppb) * 86_400.0 / 1e9
}

/// A time as ISO 8601 in UTC.
pub(super) fn time_text(time: UtcSeconds) -> String {
    Timestamp::from_second(time.0)
        .map_or_else(|_| format!("{} s since 1970", time.0), |time| time.to_string())
}

/// A day since 1970-01-01 as ISO 8601.
pub(super) fn date_text(day: u32) -> String {
    Timestamp::from_second(i64::from(day) * 86_400)
        .map_or_else(|_| format!("day {day}"), |time| time.strftime("%Y-%m-%d").to_string())
}

pub(super) fn source_text(source: ClockSource) -> &'static str {
    match source {
        ClockSource::Nothing => "nothing",
        ClockSource::Battery => "the battery clock",
        ClockSource::Host => "a host",
        ClockSource::Computer => "the computer that simulates it",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_behind_or_ahead_by_no_negative_number() {
        let at = |last_error_s| ClockState {
            now: Some(UtcSeconds(1_795_379_862)),
            source: ClockSource::Host,
            record: ClockRecord { last_error_s: Some(last_error_s), ..ClockRecord::default() },
        };
        let slow = text(&at(-90), Some(0), true);
        assert!(slow.contains("; it was 90 s behind this computer"), "{slow}");
        assert!(text(&at(0), Some(0), true).contains("; it was right"), "no 0 s ahead");
        let fast = text(&at(7), Some(7), false);
        assert!(fast.contains("; 7 s ahead of this computer"), "{fast}");
        assert!(!text(&at(7), Some(0), false).contains(" s "), "nothing to say");
    }
}
