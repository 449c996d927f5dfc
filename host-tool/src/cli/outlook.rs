//! What a design will reach and what would be better, for `vitrine check`.

use std::path::Path;

use miette::Report;
use serde::Serialize;
use vitrine::config::Exhibit;
use vitrine::design::{Advice, FrontierPoint, Prediction, advise, frontier, predict};
use vitrine::volume::InkDepth;

use super::design::{DesignFailure, stoppable};
use super::progress::Progress;

/// What the design of an exhibit will reach, and what would be better.
#[derive(Serialize)]
pub(super) struct Outlook {
    prediction: Prediction,
    advice: Vec<Advice>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frontier: Option<Vec<FrontierPoint>>,
}

impl Outlook {
    /// Tries the exhibit.toml at `path` in small; with its frontier where that is asked for.
    pub(super) fn of(
        exhibit: &Exhibit,
        path: &Path,
        with_frontier: bool,
        progress: &mut Progress,
    ) -> Result<Self, Report> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let request =
            exhibit.in_memory().design_request(folder, InkDepth::Eight, None).map_err(DesignFailure::from)?;
        Ok(stoppable(path, &request.stop, || {
            let points = with_frontier.then(|| frontier(&request, &mut |step| progress.report(step)));
            Ok(Self {
                frontier: points.transpose()?,
                prediction: predict(&request, &mut |step| progress.report(step))?,
                advice: advise(&request, &mut |step| progress.report(step))?,
            })
        })?)
    }

    /// What quality costs in brightness and contrast, where that was asked for.
    pub(super) fn frontier(&self) -> Option<&[FrontierPoint]> {
        self.frontier.as_deref()
    }

    /// The outlook as lines to read.
    pub(super) fn summary(&self) -> String {
        let Prediction { mean_psnr_db, least_psnr_db, mean_ssim, views } = &self.prediction;
        let mut lines = vec![format!(
            "expect  {mean_psnr_db:.1} dB, SSIM {mean_ssim:.2} in the mean; {least_psnr_db:.1} dB in the least view"
        )];
        let wide = views.iter().map(|view| view.id.len()).max().unwrap_or(0).max(20);
        for view in views {
            lines.push(format!("  {:<wide$} {:>5.1} dB  SSIM {:.2}", view.id, view.psnr_db, view.ssim));
            lines.extend(view.reasons.iter().map(|reason| format!("    {reason}")));
        }
        if !self.advice.is_empty() {
            lines.push("would gain (mean, and least view)".to_owned());
        }
        for Advice { change, gain_db, least_gain_db } in &self.advice {
            lines.push(format!("  {gain_db:>+5.1} dB {least_gain_db:>+5.1} dB  {change}"));
        }
        lines.join("\n")
    }
}
