//! `vitrine firmware update`: installs signed firmware on a controller.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::design;
use vitrine::firmware::SignedImage;
use vitrine::link::{Client, Installed, Stage, update};
use vitrine_protocol::firmware::{FirmwareState, Outcome};

use super::DEVELOPMENT_WARNING;
use crate::cli::connect::To;
use crate::cli::output::Output;
use crate::cli::progress::Progress;

/// Install signed firmware on a controller, and wait until it has shown that it works.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine firmware update firmware/firmware.signed
  vitrine firmware update firmware/firmware.signed --to /dev/ttyACM0 --dry-run

The lamps go dark while the controller restarts. New firmware has a minute to show that it works, \
dark and with the lamps' supply on; otherwise the controller goes back to what ran before. The power \
may go at any moment. An older version is installed like a newer one.")]
pub(super) struct Update {
    /// The signed image.
    image: PathBuf,
    #[command(flatten)]
    to: To,
    /// Only tell what would change.
    #[arg(long)]
    dry_run: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum UpdateFailure {
    #[error("the new firmware {version} did not confirm itself, and the controller runs {running} again")]
    #[diagnostic(
        code(vitrine::firmware::went_back),
        help(
            "is the lamps' supply on, and are they dark for a moment after a start? `vitrine log --live` tells what the new firmware said"
        )
    )]
    WentBack { version: String, running: String },
    #[error("the boot loader has refused the firmware {version}; the controller runs {running} as before")]
    #[diagnostic(
        code(vitrine::firmware::boot_refused),
        help("send it again; if it happens again, the controller's flash memory is failing")
    )]
    Refused { version: String, running: String },
    #[error("the firmware {version} runs but did not confirm itself, and there is no other to go back to")]
    #[diagnostic(
        code(vitrine::firmware::unconfirmed),
        help("is the lamps' supply on? Send it again when it is, so that it can confirm itself")
    )]
    Unconfirmed { version: String },
}

impl Update {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let image = SignedImage::read(&self.image)?;
        if image.is_of_development_key() {
            output.note(DEVELOPMENT_WARNING);
        }
        let address = self.to.find()?;
        let mut client = Client::open_for_update(&address)?;
        let before = client.firmware()?;
        let same = before.digest == image.header.digest && before.version == image.header.version;
        let after = if self.dry_run || same {
            None
        } else {
            let mut shown = Progress::new(output.is_json());
            let find = || self.to.find();
            let installed = update(client, &image, &find, &mut |progress| {
                shown.report(design::Progress::at(stage(progress.stage), progress.done, progress.total));
            })?;
            drop(shown);
            Some(confirmed(installed, &image)?)
        };
        let told = serde_json::json!({
            "port": address.to_string(),
            "version_before": before.version.as_str(),
            "version": image.header.version.as_str(),
            "bytes": image.bytes.len(),
            "blake3": image.digest(),
            "key": image.key_fingerprint(),
            "sent": after.is_some(),
            "confirmed": after.is_some(),
        });
        output.result(&told, || {
            let done = match (&after, same) {
                (Some(_), _) => "runs, and has confirmed itself",
                (None, true) => "runs already",
                (None, false) => "would be installed",
            };
            format!("firmware {} {done} at {address}; before: {}", image.header.version, before.version)
        });
        Ok(())
    }
}

fn confirmed(installed: Installed, image: &SignedImage) -> Result<FirmwareState, UpdateFailure> {
    let version = image.header.version.to_string();
    match installed {
        Installed::Confirmed(state) => Ok(state),
        Installed::Not(outcome, state) => {
            let running = state.version.to_string();
            Err(match outcome {
                Outcome::Refused => UpdateFailure::Refused { version, running },
                Outcome::NothingToGoBackTo => UpdateFailure::Unconfirmed { version },
                _ => UpdateFailure::WentBack { version, running },
            })
        }
    }
}

const fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Sending => "sending",
        Stage::Committing | Stage::ReadingBack => "the controller verifies what it has written",
        Stage::Installing => "the boot loader installs it",
        Stage::OnTrial => "the new firmware runs and is to confirm itself",
    }
}
