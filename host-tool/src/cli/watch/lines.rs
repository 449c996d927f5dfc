//! The exhibit as it goes, a line or a JSON object for each look.

use std::time::Duration;

use miette::Report;
use vitrine::link::Client;
use vitrine_exhibit::units::Level;
use vitrine_protocol::Status;

use crate::cli::output::Output;
use crate::cli::{status, words};

/// Looks again and again: `count` times, or until it is interrupted.
pub(super) fn follow(
    client: &mut Client,
    every: Duration,
    count: Option<u64>,
    output: Output,
) -> Result<(), Report> {
    let mut looks = 0;
    while count.is_none_or(|count| looks < count) {
        if looks > 0 {
            std::thread::sleep(every);
        }
        let told = client.status()?;
        output.line(&status::as_json(client.address(), client.hello(), &told, None), || line(client, &told));
        looks += 1;
    }
    Ok(())
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
