//! The exhibit as it goes, a line or a JSON object for each look.

use std::time::Duration;

use miette::Report;
use vitrine::link::{Client, LinkError};
use vitrine_exhibit::units::Level;
use vitrine_protocol::Status;

use crate::cli::connect::To;
use crate::cli::output::Output;
use crate::cli::{status, words};

/// Looks again and again: `count` times, or until it is interrupted. Without a count, a controller that has gone away is
/// waited for.
pub(super) fn follow(to: &To, every: Duration, count: Option<u64>, output: Output) -> Result<(), Report> {
    let mut connected = Some(Client::open(&to.find()?)?);
    let mut looks = 0;
    while count.is_none_or(|count| looks < count) {
        if looks > 0 {
            std::thread::sleep(every);
        }
        looks += 1;
        match look(to, connected.take()) {
            Ok((client, told)) => {
                let value = status::as_json(client.address(), client.hello(), &told, None);
                output.line(&value, || line(&client, &told));
                connected = Some(client);
            }
            Err(error) if count.is_none() && may_come_back(&error) => {
                output.note(&format!("away: {error}; waiting for it"));
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// Asks a controller how it is, connecting anew where the connection is lost.
fn look(to: &To, connected: Option<Client>) -> Result<(Client, Status), LinkError> {
    let mut client = match connected {
        Some(client) => client,
        None => Client::open(&to.find()?)?,
    };
    let told = client.status()?;
    Ok((client, told))
}

/// A controller that is unplugged is none that is found, until it is back.
fn may_come_back(error: &LinkError) -> bool {
    error.is_passing() || matches!(error, LinkError::NoneFound | LinkError::NoSuchSerialNumber { .. })
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
