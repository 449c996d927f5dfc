//! `report.json`: all figures of a design.

use serde::{Deserialize, Serialize};

use crate::config::Exhibit;
use crate::design::{Design, ViewDesign};
use crate::measure::Quality;
use crate::optics::LampPair;

/// All figures of a design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The exhibit's name.
    pub name: String,
    /// The version of the program.
    pub vitrine: String,
    /// Mean over the views of the peak signal-to-noise ratio, in the optics of the design.
    pub mean_psnr_db: f64,
    /// The least view's.
    pub least_psnr_db: f64,
    /// Mean over the views of the structural similarity.
    pub mean_ssim: f64,
    /// The least view's.
    pub least_ssim: f64,
    /// The lamp pair for nobody in particular.
    pub neutral: Pair,
    /// The views, in the order of exhibit.toml.
    pub views: Vec<ViewReport>,
}

/// A lamp pair, levels 0..=1, linear in irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// The lamp on the viewer's side.
    pub top: f64,
    /// The lamp behind the stack.
    pub bottom: f64,
}

/// The figures of one view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewReport {
    /// The view's id.
    pub id: String,
    /// Angle to the right of the stack's normal.
    pub horizontal_deg: f64,
    /// Angle above the stack's normal.
    pub vertical_deg: f64,
    /// The lamp pair that shows this view at its best; the larger level is 1.
    pub emphasis: Pair,
    /// Structural similarity of the pattern to the given picture, where it was adapted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub similarity_to_given: Option<f64>,
    /// In the optics of the design.
    pub quality: Figures,
    /// Behind the stack's own films, under this view's emphasis.
    pub under_own_lamps: Figures,
    /// Behind the stack's own films, under the neutral pair.
    pub under_neutral_lamps: Figures,
    /// Behind the stack's own films, with both lamps full.
    pub under_full_lamps: Figures,
}

/// Measures of one projection against its pattern.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// The gain that fits the projection to the pattern.
    pub gain: f64,
    /// Peak signal-to-noise ratio.
    pub psnr_db: f64,
    /// Structural similarity, mean over channels.
    pub ssim: f64,
    /// Brightness as a part of what the brightest ink on every film would give.
    pub efficiency: f64,
    /// 99th percentile of the light over its 1st.
    pub contrast: f64,
    /// The largest correlation of this view's error with another view's pattern, -1..=1.
    pub cross_talk: f64,
}

impl Report {
    /// Gathers the figures of `design`, which was made for `exhibit`.
    pub fn new(exhibit: &Exhibit, design: &Design) -> Self {
        let views: Vec<ViewReport> = exhibit
            .views
            .iter()
            .zip(&design.views)
            .map(|(view, designed)| ViewReport::new(view.horizontal_deg, view.vertical_deg, designed))
            .collect();
        Self {
            name: exhibit.name.clone(),
            vitrine: env!("CARGO_PKG_VERSION").to_owned(),
            mean_psnr_db: design.mean_psnr_db(),
            least_psnr_db: design.least_psnr_db(),
            mean_ssim: design.mean_ssim(),
            least_ssim: views.iter().map(|view| view.quality.ssim).fold(f64::INFINITY, f64::min),
            neutral: design.neutral.into(),
            views,
        }
    }

    /// The figures as lines to read.
    pub fn summary(&self) -> String {
        let mut lines = Vec::new();
        for view in &self.views {
            let Figures { psnr_db, ssim, .. } = view.quality;
            let Pair { top, bottom } = view.emphasis;
            lines.push(format!(
                "{:<16} {:>6.1} deg {:>6.1} deg   {psnr_db:>5.1} dB  SSIM {ssim:.2}   lamps top {top:.2} bottom {bottom:.2}",
                view.id, view.horizontal_deg, view.vertical_deg
            ));
        }
        lines.push(format!(
            "{:<16} {:>23}   {:>5.1} dB  SSIM {:.2}   least view {:.1} dB  SSIM {:.2}",
            "mean", "", self.mean_psnr_db, self.mean_ssim, self.least_psnr_db, self.least_ssim
        ));
        lines.join("\n")
    }
}

impl ViewReport {
    fn new(horizontal_deg: f64, vertical_deg: f64, designed: &ViewDesign) -> Self {
        Self {
            id: designed.id.clone(),
            horizontal_deg,
            vertical_deg,
            emphasis: designed.emphasis.into(),
            similarity_to_given: None,
            quality: designed.quality.into(),
            under_own_lamps: designed.under_own_lamps.into(),
            under_neutral_lamps: designed.under_neutral_lamps.into(),
            under_full_lamps: designed.under_full_lamps.into(),
        }
    }
}

impl From<LampPair> for Pair {
    fn from(LampPair { top, bottom }: LampPair) -> Self {
        Self { top, bottom }
    }
}

impl From<Quality> for Figures {
    fn from(quality: Quality) -> Self {
        let Quality { gain, psnr_db, ssim, efficiency, contrast, cross_talk } = quality;
        Self { gain, psnr_db, ssim, efficiency, contrast, cross_talk }
    }
}
