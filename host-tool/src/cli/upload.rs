//! `vitrine upload`: gives a controller the plan of a build.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, IntoDiagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::BuildFolder;
use vitrine_exhibit::plan::{Bounds, PlanError, ValidPlan};
use vitrine_protocol::plan_file::{self, PlanFileError};

use super::changes::changes;
use super::connect::To;
use super::output::Output;

/// Send the plan of a build to a controller, and read it back.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine upload build
  vitrine upload build --to /dev/ttyACM0
  vitrine upload build --to tcp:127.0.0.1:7470 --dry-run

It asks before it replaces another plan; where there is no terminal to ask, and with --json, it does so only with --yes. The \
controller keeps its plan until it has verified the new one.")]
pub(super) struct Upload {
    /// The build folder.
    build: PathBuf,
    #[command(flatten)]
    to: To,
    /// Confirm a plan that asks for more than the active one: higher limits, or lamps measured weaker.
    #[arg(long)]
    allow_more: bool,
    /// Only tell what would change.
    #[arg(long)]
    dry_run: bool,
    /// Replace another plan without being asked.
    #[arg(long)]
    yes: bool,
}

/// Why a plan is not sent.
#[derive(Debug, Error, Diagnostic)]
enum UploadFailure {
    #[error("{}: {source}", path.display())]
    #[diagnostic(code(vitrine::upload::plan_file), help("design the exhibit again into this folder"))]
    PlanFile { path: PathBuf, source: PlanFileError },
    #[error("{}: a controller would refuse it: {source}", path.display())]
    #[diagnostic(code(vitrine::upload::plan), help("mend exhibit.toml and design it again"))]
    Plan { path: PathBuf, source: PlanError },
    #[error("the plan was not sent: the question was not answered with yes")]
    #[diagnostic(code(vitrine::upload::declined), help("answer y, or give --yes to be asked nothing"))]
    Declined,
    #[error(
        "the plan was not sent: another is active, and there is no terminal to ask whether it may be replaced"
    )]
    #[diagnostic(
        code(vitrine::upload::unasked),
        help("give --yes to replace it; --dry-run tells what would change")
    )]
    Unasked,
}

impl Upload {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let build = BuildFolder::open(&self.build)?;
        let path = build.path().join("plan.bin");
        let bytes = build.plan_file()?;
        let plan = plan_file::decode(&bytes)
            .map_err(|source| UploadFailure::PlanFile { path: path.clone(), source })?;
        ValidPlan::new(plan.clone()).map_err(|source| UploadFailure::Plan { path, source })?;
        let mut client = self.to.open()?;
        let before = client.active_plan()?;
        let changes = changes(before.as_ref(), &plan);
        output.note(&changes.join("\n"));
        let same = before.as_ref() == Some(&plan);
        let more = before.as_ref().map(Bounds::of).unwrap_or_default().are_exceeded_by(&plan);
        if more && !self.allow_more {
            output.note("it asks for more than the controller allows now: --allow-more confirms that");
        }
        let wanted = !self.dry_run && !same;
        if wanted && before.is_some() && !self.yes {
            match output.asks("Send it?").into_diagnostic()? {
                Some(true) => {}
                Some(false) => return Err(UploadFailure::Declined.into()),
                None => return Err(UploadFailure::Unasked.into()),
            }
        }
        if wanted {
            if self.allow_more {
                client.confirm_more();
            }
            client.upload(&bytes, &mut |_| {})?;
        }
        let active_since = wanted.then(|| jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string());
        let sent = wanted;
        let port = client.address().to_string();
        let result = serde_json::json!({
            "port": port,
            "serial_number": client.hello().serial_number.as_str(),
            "exhibit": plan.name.as_str(),
            "views": plan.views.len(),
            "bytes": bytes.len(),
            "crc": format!("{:08x}", plan_file::crc(&bytes)),
            "change": changes.join("; "),
            "asks_for_more": more,
            "sent": sent,
            "active_since": active_since,
        });
        output.result(&result, || {
            let done = match (sent, same) {
                (true, _) => "is active, verified and read back",
                (false, true) => "is active already",
                (false, false) => "was not sent",
            };
            let since = active_since.map(|since| format!(" since {since}")).unwrap_or_default();
            format!(
                "{}: plan {:08x} of {} bytes {done} at {port}{since}",
                plan.name,
                plan_file::crc(&bytes),
                bytes.len()
            )
        });
        if sent {
            output.note("Next: vitrine watch, or vitrine serve for the same in a browser");
        }
        Ok(())
    }
}
