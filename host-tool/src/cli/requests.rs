//! `vitrine hold`, `dark`, `open`, `release`, `rearm` and `new-stack`: what a person asks of the exhibit.

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine_exhibit::limits;
use vitrine_exhibit::units::Milliseconds;

use super::connect::{Sending, Sent};
use super::output::Output;

/// Show one view, whoever stands where, until the time is over.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine hold coffee
  vitrine hold coffee --for 2h --to tcp:127.0.0.1:7470
  vitrine release                     ends it early")]
pub(super) struct Hold {
    /// The view's id.
    view: String,
    /// For how long: such as 90s, 10m or 2h, at most 24h.
    #[arg(long = "for", value_name = "TIME", default_value = "10m", value_parser = lease)]
    lease: Milliseconds,
    #[command(flatten)]
    sending: Sending,
}

/// Keep both lamps off until the time is over.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine dark
  vitrine dark --for 8h
  vitrine release                     ends it early")]
pub(super) struct Dark {
    /// For how long: such as 90s, 10m or 2h, at most 24h.
    #[arg(long = "for", value_name = "TIME", default_value = "1h", value_parser = lease)]
    lease: Milliseconds,
    #[command(flatten)]
    sending: Sending,
}

/// Light the exhibit outside the schedule's hours until the time is over.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine open
  vitrine open --for 3h               for an evening's guests
  vitrine release                     ends it early")]
pub(super) struct Open {
    /// For how long: such as 90s, 10m or 2h, at most 24h.
    #[arg(long = "for", value_name = "TIME", default_value = "1h", value_parser = lease)]
    lease: Milliseconds,
    #[command(flatten)]
    sending: Sending,
}

/// End what `hold`, `dark` or `open` asked for.
#[derive(Args)]
#[command(after_help = "Examples:\n  vitrine release\n  vitrine release --to /dev/ttyACM0")]
pub(super) struct Release {
    #[command(flatten)]
    sending: Sending,
}

/// Let the lamps light again after an opened door or a fault that is mended.
#[derive(Args)]
#[command(after_help = "Examples:\n  vitrine rearm\n  vitrine rearm --to /dev/ttyACM0")]
pub(super) struct Rearm {
    #[command(flatten)]
    sending: Sending,
}

/// Declare that a fresh stack of films stands in the exhibit: its life's dose begins at zero.
#[derive(Args)]
#[command(after_help = "Examples:\n  vitrine new-stack --yes\n  vitrine new-stack --yes --to /dev/ttyACM0")]
pub(super) struct NewStack {
    /// Confirm that the films have really been replaced.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    sending: Sending,
}

#[derive(Debug, Error, Diagnostic)]
enum RequestFailure {
    #[error("the controller has no view \"{id}\"")]
    #[diagnostic(code(vitrine::hold::no_such_view), help("{help}"))]
    NoSuchView { id: String, help: String },
}

impl Hold {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let Self { view, lease, sending } = self;
        let Sending { to, dry_run } = sending;
        let mut client = to.open()?;
        let plan = client.active_plan()?;
        let ids: Vec<&str> =
            plan.iter().flat_map(|plan| plan.views.iter().map(|view| view.id.as_str())).collect();
        let Some(index) = ids.iter().position(|id| *id == view) else {
            let help = if ids.is_empty() {
                "it has no plan: `vitrine upload BUILD` gives it one".to_owned()
            } else {
                format!("it has {}", ids.join(", "))
            };
            return Err(RequestFailure::NoSuchView { id: view, help }.into());
        };
        let sent = if dry_run { Sent::NotSent } else { Sent::Sent };
        if sent.is_sent() {
            client.hold(index as u8, lease)?;
        }
        let done = serde_json::json!({ "view": view, "lease_s": lease.0 / 1000, "sent": sent.is_sent() });
        output.result(&done, || sent.in_words(format!("{view} is held for {}", in_words(lease))));
        Ok(())
    }
}

impl Dark {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let lease = self.lease;
        let sent = self.sending.send(|client| client.dark(lease))?;
        let done = serde_json::json!({ "dark": true, "lease_s": lease.0 / 1000, "sent": sent.is_sent() });
        output.result(&done, || sent.in_words(format!("dark for {}", in_words(lease))));
        Ok(())
    }
}

impl Open {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let lease = self.lease;
        let sent = self.sending.send(|client| client.open_outside_hours(lease))?;
        let done = serde_json::json!({ "open": true, "lease_s": lease.0 / 1000, "sent": sent.is_sent() });
        output.result(&done, || {
            sent.in_words(format!("open for {}, whatever the schedule says", in_words(lease)))
        });
        Ok(())
    }
}

impl Release {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let sent = self.sending.send(vitrine::link::Client::release)?;
        output.result(&serde_json::json!({ "released": true, "sent": sent.is_sent() }), || {
            sent.in_words("the exhibit follows its viewers again".to_owned())
        });
        Ok(())
    }
}

impl Rearm {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let sent = self.sending.send(vitrine::link::Client::rearm)?;
        output.result(&serde_json::json!({ "rearm": "asked", "sent": sent.is_sent() }), || {
            sent.in_words(
                "re-arm asked for; `vitrine status` tells whether anything stands against it".to_owned(),
            )
        });
        Ok(())
    }
}

impl NewStack {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let confirmed = self.yes;
        let sent = self.sending.send(|client| {
            if confirmed {
                client.confirm_more();
            }
            client.new_stack()
        })?;
        output.result(&serde_json::json!({ "new_stack": true, "sent": sent.is_sent() }), || {
            sent.in_words("a fresh stack is declared".to_owned())
        });
        Ok(())
    }
}

/// Reads a time such as `90s`, `10m` or `2h`; a number alone is seconds.
fn lease(text: &str) -> Result<Milliseconds, String> {
    let (number, unit_s) = match text.chars().last() {
        Some('h') => (&text[..text.len() - 1], 3600),
        Some('m') => (&text[..text.len() - 1], 60),
        Some('s') => (&text[..text.len() - 1], 1),
        _ => (text, 1),
    };
    let seconds = number.parse::<u32>().ok().and_then(|number| number.checked_mul(unit_s));
    let lease = seconds.and_then(|seconds| seconds.checked_mul(1000)).map(Milliseconds);
    lease
        .filter(|lease| lease.0 > 0 && *lease <= limits::LONGEST_LEASE)
        .ok_or_else(|| "give a time such as 90s, 10m or 2h, at most 24h".to_owned())
}

fn in_words(lease: Milliseconds) -> String {
    match lease.0 / 1000 {
        seconds if seconds % 3600 == 0 => format!("{} h", seconds / 3600),
        seconds if seconds % 60 == 0 => format!("{} min", seconds / 60),
        seconds => format!("{seconds} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leases_are_told_and_read_in_words() {
        for (text, seconds, words) in
            [("90s", 90, "90 s"), ("10m", 600, "10 min"), ("24h", 86_400, "24 h"), ("5", 5, "5 s")]
        {
            let read = lease(text).unwrap();
            assert_eq!((read, in_words(read).as_str()), (Milliseconds(seconds * 1000), words));
        }
        for wrong in ["", "0", "25h", "-1m", "1.5h", "h", "99999999999h", "1ü"] {
            assert!(lease(wrong).is_err(), "{wrong}");
        }
    }
}
