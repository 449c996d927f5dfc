//! `vitrine watch`: the exhibit as it goes, a line a second.

use std::time::Duration;

use clap::Args;
use miette::Report;
use vitrine::link::Client;
use vitrine_exhibit::units::Level;
use vitrine_protocol::Status;

use super::connect::To;
use super::output::Output;
use super::{status, words};

/// Follow the exhibit: a line for each look, until it is interrupted.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine watch
  vitrine watch --every 0.2 --to tcp:127.0.0.1:7470
  vitrine watch --count 10 --json")]
pub(super) struct Watch {
    /// Seconds from one look to the next.
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = seconds)]
    every: Duration,
    /// End after so many looks.
    #[arg(long, value_name = "LOOKS")]
    count: Option<u64>,
    #[command(flatten)]
    to: To,
}

impl Watch {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let mut client = self.to.open()?;
        let mut looks = 0;
        while self.count.is_none_or(|count| looks < count) {
            if looks > 0 {
                std::thread::sleep(self.every);
            }
            let told = client.status()?;
            output.line(&status::as_json(&client, &told, None), || line(&client, &told));
            looks += 1;
        }
        Ok(())
    }
}

fn line(client: &Client, told: &Status) -> String {
    let snapshot = &told.snapshot;
    let percent = |level: Level| 100.0 * f64::from(level.0) / f64::from(Level::FULL.0);
    let place =
        snapshot.bearing.map_or_else(|| words::presence(snapshot.presence).to_owned(), words::bearing);
    let view =
        told.plan.as_ref().map(|plan| plan.view_id.as_str()).filter(|id| !id.is_empty()).unwrap_or("-");
    let dark = snapshot.dark.map(|reason| format!("  dark: {reason}")).unwrap_or_default();
    format!(
        "{:<12} {view:<16} top {:>3.0} %  bottom {:>3.0} %  {place}{dark}",
        client.hello().serial_number,
        percent(snapshot.levels.top),
        percent(snapshot.levels.bottom)
    )
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "give a number of seconds".to_owned())?;
    if (0.05..=3600.0).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("give 0.05 to 3600 seconds".to_owned())
    }
}
