//! `vitrine upload`: gives a controller the plan of a build.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, IntoDiagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::BuildFolder;
use vitrine::link::{Client, LinkError};
use vitrine_exhibit::plan::{Bounds, Plan, PlanError, ValidPlan};
use vitrine_protocol::Refusal;
use vitrine_protocol::plan_file::{self, PlanFileError};

use super::connect::To;
use super::output::Output;

/// Send the plan of a build to a controller, and read it back.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine upload build
  vitrine upload build --to /dev/ttyACM0
  vitrine upload build --to tcp:127.0.0.1:7470 --dry-run

On a terminal it asks before it replaces another plan. The controller keeps its plan until it has verified the new one.")]
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
    /// Do not ask. Without a terminal nobody is asked either.
    #[arg(long, conflicts_with = "dry_run")]
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
        let before = active_plan(&mut client)?;
        let change = changes(before.as_ref(), &plan);
        output.note(&change);
        let same = before.as_ref() == Some(&plan);
        let more = before.as_ref().map(Bounds::of).unwrap_or_default().are_exceeded_by(&plan);
        if more && !self.allow_more {
            output.note("it asks for more than the controller allows now: --allow-more confirms that");
        }
        let wanted = !self.dry_run && !same;
        if wanted && before.is_some() && !self.yes && !output.asks("Send it?").into_diagnostic()? {
            return Err(UploadFailure::Declined.into());
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
            "change": change,
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

/// The controller's plan, if it has one that this version reads.
pub(super) fn active_plan(client: &mut Client) -> Result<Option<Plan>, LinkError> {
    match client.read_plan() {
        Ok(bytes) => Ok(plan_file::decode(&bytes).ok()),
        Err(LinkError::Refused { refusal: Refusal::NoPlan, .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// What changes from the plan `before` to the plan `after`, in words.
fn changes(before: Option<&Plan>, after: &Plan) -> String {
    let Some(before) = before else { return format!("\"{}\" is the controller's first plan", after.name) };
    if before == after {
        return format!("\"{}\" is the same as the controller's plan", after.name);
    }
    let mut parts = Vec::new();
    if before.name != after.name {
        parts.push(format!("name \"{}\" becomes \"{}\"", before.name, after.name));
    }
    if before.volume.blake3 != after.volume.blake3 {
        parts.push("it belongs to other films".to_owned());
    }
    if before.views != after.views {
        parts.push(view_changes(before, after));
    }
    for (what, differs) in [
        ("neutral pair", before.neutral != after.neutral),
        ("lamps", before.lamps != after.lamps),
        ("limits", before.limits != after.limits),
        ("viewer settings", before.viewer != after.viewer || before.presence != after.presence),
        ("schedule and calendar", before.calendar != after.calendar),
    ] {
        if differs {
            parts.push(format!("{what} change"));
        }
    }
    parts.join("; ")
}

fn view_changes(before: &Plan, after: &Plan) -> String {
    let ids = |plan: &Plan| plan.views.iter().map(|view| view.id.to_string()).collect::<Vec<_>>();
    let (old, new) = (ids(before), ids(after));
    let missing = |from: &[String], of: &[String]| -> Vec<String> {
        of.iter().filter(|id| !from.contains(id)).cloned().collect()
    };
    let (added, removed) = (missing(&old, &new), missing(&new, &old));
    let mut parts = Vec::new();
    if !added.is_empty() {
        parts.push(format!("views added: {}", added.join(", ")));
    }
    if !removed.is_empty() {
        parts.push(format!("views removed: {}", removed.join(", ")));
    }
    if parts.is_empty() {
        parts.push("directions or lamp pairs of views change".to_owned());
    }
    parts.join("; ")
}
