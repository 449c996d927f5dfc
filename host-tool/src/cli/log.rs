//! `vitrine log`: what has happened.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use jiff::Timestamp;
use miette::Report;
use serde_json::{Value, json};
use vitrine_exhibit::events::Event;
use vitrine_protocol::message::LogEntry;

use super::clock::{date_text, time_text};
use super::connect::To;
use super::output::Output;
use super::{live, words};

/// Read the controller's event log, oldest entry first.
///
/// At the end of each day the log keeps what each lamp gave in it, and the hours it had burnt by then.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine log
  vitrine log --since 2026-05-01 --csv > may.csv
  vitrine log --since 2026-05-01T09:00:00+02:00
  vitrine log --from 120 --json
  vitrine log --live target/firmware/vitrine-pico.elf
  vitrine log --live target/firmware/vitrine-pico.elf --rtt localhost:9090")]
pub(super) struct Log {
    /// Begin at this entry's number.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    from: u32,
    /// Leave out entries before this time or day (ISO 8601; a day begins in UTC), and those without a time.
    #[arg(long, value_name = "TIME", value_parser = moment)]
    since: Option<Timestamp>,
    /// As comma-separated values.
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Instead, print what the firmware tells as it runs, decoded with this ELF file of the image that the board runs.
    #[arg(long, value_name = "ELF", conflicts_with_all = ["from", "since", "csv"])]
    live: Option<PathBuf>,
    /// With --live: stop after this many seconds.
    #[arg(long = "for", value_name = "SECONDS", requires = "live")]
    lasts: Option<u64>,
    /// With --live: from a probe instead of over the link, by the RTT server (of OpenOCD, for example) at this address.
    #[arg(long, value_name = "HOST:PORT", requires = "live", conflicts_with = "address")]
    rtt: Option<String>,
    #[command(flatten)]
    to: To,
}

impl Log {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        if let Some(image) = &self.live {
            let source = match self.rtt {
                Some(address) => live::Source::probe(address)?,
                None => live::Source::link(self.to.open()?),
            };
            return live::follow(source, image, self.lasts.map(Duration::from_secs), output);
        }
        let mut client = self.to.open()?;
        let mut entries = client.log(self.from)?;
        if let Some(since) = self.since {
            entries.retain(|entry| entry.time.is_some_and(|time| time.0 >= since.as_second()));
        }
        if entries.is_empty() {
            output.note("no entries");
        }
        let values: Vec<Value> = entries.iter().map(as_json).collect();
        let line = if self.csv { as_csv } else { as_text };
        let header = if self.csv { "number,time,uptime_s,event,day,lamp,dose_j_m2,lamp_hours\n" } else { "" };
        output.result(&values, || {
            format!("{header}{}", entries.iter().map(line).collect::<Vec<_>>().join("\n"))
        });
        Ok(())
    }
}

/// Reads a time with its zone, or a day.
fn moment(text: &str) -> Result<Timestamp, String> {
    let time = text.parse().or_else(|_| format!("{text}T00:00:00Z").parse());
    time.map_err(|_| "give a day such as 2026-05-01, or a time such as 2026-05-01T09:00:00+02:00".to_owned())
}

fn time(entry: &LogEntry) -> String {
    entry.time.map(time_text).unwrap_or_default()
}

fn as_text(entry: &LogEntry) -> String {
    let when =
        if entry.time.is_some() { time(entry) } else { format!("{} s after the start", entry.uptime_s) };
    format!("{:>6}  {when:<22}  {}", entry.sequence, words::event(entry.event))
}

fn as_csv(entry: &LogEntry) -> String {
    // A quotation mark within a quoted field is doubled (RFC 4180).
    let event = words::event(entry.event).replace('"', "\"\"");
    let dose = match entry.event {
        Event::DayDose { lamp, day, joules_m2, lit_hours } => {
            format!("{},{},{joules_m2},{lit_hours}", date_text(day), words::lamp(lamp))
        }
        _ => ",,,".to_owned(),
    };
    format!("{},{},{},\"{event}\",{dose}", entry.sequence, time(entry), entry.uptime_s)
}

pub(super) fn as_json(entry: &LogEntry) -> Value {
    let dose = match entry.event {
        Event::DayDose { lamp, day, joules_m2, lit_hours } => json!({
            "day": date_text(day),
            "lamp": words::lamp(lamp),
            "dose_j_m2": joules_m2,
            "lamp_hours": lit_hours,
        }),
        _ => Value::Null,
    };
    json!({
        "number": entry.sequence,
        "time": entry.time.map(time_text),
        "uptime_s": entry.uptime_s,
        "event": words::event(entry.event),
        "day_dose": dose,
    })
}

#[cfg(test)]
mod tests {
    use super::moment;

    #[test]
    fn a_day_and_a_time_are_moments() {
        let midnight = moment("2026-05-01T00:00:00Z").unwrap();
        assert_eq!(moment("2026-05-01").unwrap(), midnight);
        assert_eq!(moment("2026-05-01T02:00:00+02:00").unwrap(), midnight);
        for wrong in ["", "yesterday", "2026-02-30", "2026-05-01T09:00:00"] {
            assert!(moment(wrong).is_err(), "{wrong}");
        }
    }
}
