//! `vitrine advise`: what each view will reach, and what to change.

use std::path::{Path, PathBuf};

use clap::Args;
use miette::Report;
use serde_json::json;
use vitrine::config;
use vitrine::design::{Advice, Change, Placement, Prediction, advise, predict};
use vitrine::volume::InkDepth;

use super::design::{impossible, pictures};
use super::output::Output;

/// Predict what each view will reach, and say what to change to reach more.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine advise exhibit.toml
  vitrine advise exhibit.toml --json | jq '.advice[0]'

Every change is tried on a small design; its gain is what the views' mean gains.")]
pub(super) struct Advise {
    /// The exhibit.
    exhibit: PathBuf,
}

impl Advise {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let exhibit = config::load(&self.exhibit)?;
        let folder = self.exhibit.parent().unwrap_or(Path::new(""));
        let request = exhibit.design_request(folder, InkDepth::Eight).map_err(pictures)?;
        let failed = |error| impossible(&self.exhibit, error);
        output.note("trying changes on small designs");
        let prediction = predict(&request).map_err(failed)?;
        let advice = advise(&request).map_err(failed)?;
        let told = json!({ "prediction": prediction, "advice": advice });
        output.result(&told, || format!("{}\n\n{}", predicted(&prediction), advised(&advice)));
        Ok(())
    }
}

fn predicted(prediction: &Prediction) -> String {
    let mut lines = vec![format!(
        "expected: mean {:.1} dB, least {:.1} dB, SSIM {:.2}",
        prediction.mean_psnr_db, prediction.least_psnr_db, prediction.mean_ssim
    )];
    for view in &prediction.views {
        lines.push(format!("{:<16} {:.1} dB, SSIM {:.2}", view.id, view.psnr_db, view.ssim));
        lines.extend(view.reasons.iter().map(|reason| format!("    {reason}")));
    }
    lines.join("\n")
}

fn advised(advice: &[Advice]) -> String {
    if advice.is_empty() {
        return "no change was found that gains".to_owned();
    }
    let line = |advice: &Advice| {
        format!(
            "{:+.1} dB (least view {:+.1} dB): {}",
            advice.gain_db,
            advice.least_gain_db,
            in_words(&advice.change)
        )
    };
    advice.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn in_words(change: &Change) -> String {
    match change {
        Change::Directions { views } => format!("show the pictures in other directions: {}", placed(views)),
        Change::Angles { views } => format!("take other angles: {}", placed(views)),
        Change::Adapt { similarity } => {
            format!("let the pictures be adapted: [design] adapt = 0.9 (they stay {similarity:.2} similar)")
        }
        Change::Exposure { views } => {
            let exposed = views.iter().map(|view| format!("{} x {}", view.id, view.factor));
            format!("expose pictures anew: {}", exposed.collect::<Vec<_>>().join(", "))
        }
        Change::Spacer { spacer_mm } => format!("use thicker spacers: [stack] spacer_mm = {spacer_mm}"),
        Change::Brightness { brightness } => format!("want less light: [design] brightness = {brightness}"),
        Change::LeaveOut { id } => format!("leave {id} out (the gain is the others')"),
    }
}

fn placed(views: &[Placement]) -> String {
    let place =
        |view: &Placement| format!("{} at {:.1}, {:.1} deg", view.id, view.horizontal_deg, view.vertical_deg);
    views.iter().map(place).collect::<Vec<_>>().join("; ")
}
