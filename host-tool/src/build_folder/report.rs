//! `report.json`: all figures of a design.

use serde::{Deserialize, Serialize};

use crate::config::{Exhibit, Hold, LampSetting, ViewSettings};
use crate::design::{AsBuilt, Design, SharedPair, ViewAsBuilt, ViewDesign};
use crate::measure::Quality;
use crate::object::ObjectReport;
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
    /// For each two views, the pair that is best for both at once.
    pub shared: Vec<SharedReport>,
    /// What becomes of the views in human hands, where that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_built: Option<AsBuilt>,
    /// What became of the object's model, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<ObjectReport>,
    /// Where the films were designed by strips: of what all figures, pictures and lamps were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_small: Option<InSmall>,
    /// The views, in the order of exhibit.toml.
    pub views: Vec<ViewReport>,
}

/// The same exhibit with fewer pixels, which stands for one whose films are too large to be looked at together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InSmall {
    /// Width and height of its films in pixels.
    pub pixels: [usize; 2],
    /// Width and height of the films in the build.
    pub film_pixels: [usize; 2],
}

impl InSmall {
    /// What is in small, and what is not.
    pub fn in_words(self) -> String {
        let Self { pixels: [width, height], film_pixels: [film_width, film_height] } = self;
        format!(
            "All pictures and figures are of this exhibit in small, with films of {width} x {height} pixels; the films in \
             the folder have {film_width} x {film_height} and hold finer detail."
        )
    }
}

/// The lamp pair that is best for two views at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SharedReport {
    /// The two views' ids.
    pub views: [String; 2],
    /// The pair.
    pub pair: Pair,
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
    /// Distance of the view's eye; none for parallel rays.
    pub distance_mm: Option<f64>,
    /// The only lamp under which the view is shown, where two views share its direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lamp: Option<LampSetting>,
    /// The lamp pair that shows this view at its best; the larger level is 1, or less where the view would be too
    /// bright beside the others.
    pub emphasis: Pair,
    /// The light that is seen as white under this pair; 1 is what full ink gives under both lamps full.
    pub white: f64,
    /// How long the pair can be held in a day.
    pub hold: Hold,
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
            .map(|(view, designed)| ViewReport::new(exhibit, view, designed))
            .collect();
        Self {
            name: exhibit.name.clone(),
            vitrine: env!("CARGO_PKG_VERSION").to_owned(),
            mean_psnr_db: design.mean_psnr_db(),
            least_psnr_db: design.least_psnr_db(),
            mean_ssim: design.mean_ssim(),
            least_ssim: views.iter().map(|view| view.quality.ssim).fold(f64::INFINITY, f64::min),
            neutral: design.neutral.into(),
            shared: design.shared.iter().map(|shared| SharedReport::new(shared, design)).collect(),
            as_built: None,
            object: None,
            in_small: None,
            views,
        }
    }

    /// The figures as lines to read.
    pub fn summary(&self) -> String {
        let mut lines: Vec<String> = self.object.iter().map(ObjectReport::summary).collect();
        let wide = self.name_width();
        for view in &self.views {
            let Figures { psnr_db, ssim, .. } = view.quality;
            let Pair { top, bottom } = view.emphasis;
            lines.push(format!(
                "{:<wide$} {:>6.1} deg {:>6.1} deg   {psnr_db:>5.1} dB  SSIM {ssim:.2}   lamps top {top:.2} bottom {bottom:.2}",
                view.id, view.horizontal_deg, view.vertical_deg
            ));
        }
        lines.push(format!(
            "{:<wide$} {:>23}   {:>5.1} dB  SSIM {:.2}   least view {:.1} dB  SSIM {:.2}",
            "mean", "", self.mean_psnr_db, self.mean_ssim, self.least_psnr_db, self.least_ssim
        ));
        lines.push(format!(
            "{:<wide$} {:<16} {:<16} both lamps full",
            "what lamps do", "own pair", "neutral pair"
        ));
        for (id, under) in self
            .views
            .iter()
            .map(|view| (view.id.as_str(), view.under_lamps()))
            .chain([self.mean_under_lamps()])
        {
            let cells = under.map(|(psnr_db, ssim)| format!("{psnr_db:>5.1} dB {ssim:.2}   "));
            lines.push(format!("{id:<wide$} {}", cells.join(" ").trim_end()));
        }
        lines.extend(self.as_built.iter().flat_map(|built| self.as_built_lines(built)));
        lines.extend(self.hold_in_words());
        lines.extend(self.in_small.map(InSmall::in_words));
        lines.join("\n")
    }

    // The columns stand below each other however long the views' names are.
    fn name_width(&self) -> usize {
        self.views.iter().map(|view| view.id.len()).fold(16, usize::max)
    }

    fn as_built_lines(&self, built: &AsBuilt) -> Vec<String> {
        let wide = self.name_width();
        let heading = format!("{:<wide$} mean of {} stacks   worst stack", "as built", built.stacks);
        let views = self.views.iter().zip(&built.views).map(|(view, of)| {
            let ViewAsBuilt { mean_psnr_db, worst_psnr_db, mean_ssim, worst_ssim, .. } = of;
            (view.id.as_str(), [*mean_psnr_db, *mean_ssim, *worst_psnr_db, *worst_ssim])
        });
        let all = [built.mean_psnr_db(), built.mean_ssim(), built.worst_psnr_db(), built.worst_ssim()];
        let line = |(id, [mean_db, mean, worst_db, worst]): (&str, [f64; 4])| {
            format!("{id:<wide$} {mean_db:>5.1} dB  SSIM {mean:.2}   {worst_db:>5.1} dB  SSIM {worst:.2}")
        };
        std::iter::once(heading).chain(views.chain([("all", all)]).map(line)).collect()
    }

    /// Mean PSNR in dB and SSIM of the views behind the stack's own films: each under its own pair, under the neutral
    /// one, and with both lamps full.
    pub fn mean_under_lamps(&self) -> (&'static str, [(f64, f64); 3]) {
        let count = self.views.len().max(1) as f64;
        let mean = |column: usize| {
            let cells = || self.views.iter().map(|view| view.under_lamps()[column]);
            (cells().map(|cell| cell.0).sum::<f64>() / count, cells().map(|cell| cell.1).sum::<f64>() / count)
        };
        ("mean", [mean(0), mean(1), mean(2)])
    }

    /// Says so where a view's pair cannot be held all day.
    pub fn hold_in_words(&self) -> Option<String> {
        let short = self.views.iter().filter(|view| !view.hold.is_whole());
        let view = short.min_by(|a, b| a.hold.held_h.total_cmp(&b.hold.held_h))?;
        Some(view.hold.in_words(&view.id))
    }
}

impl SharedReport {
    fn new(shared: &SharedPair, design: &Design) -> Self {
        let id = |view: usize| design.views[view].id.clone();
        Self { views: [id(shared.first), id(shared.second)], pair: shared.pair.into() }
    }
}

impl ViewReport {
    fn new(exhibit: &Exhibit, view: &ViewSettings, designed: &ViewDesign) -> Self {
        let ViewSettings { horizontal_deg, vertical_deg, distance_mm, lamp, .. } = *view;
        Self {
            id: designed.id.clone(),
            horizontal_deg,
            vertical_deg,
            distance_mm,
            lamp,
            emphasis: designed.emphasis.into(),
            white: designed.white,
            hold: exhibit.hold(designed.emphasis),
            similarity_to_given: None,
            quality: designed.quality.into(),
            under_own_lamps: designed.under_own_lamps.into(),
            under_neutral_lamps: designed.under_neutral_lamps.into(),
            under_full_lamps: designed.under_full_lamps.into(),
        }
    }
}

impl ViewReport {
    /// PSNR in dB and SSIM behind the stack's own films: under the view's own pair, the neutral one, both lamps full.
    pub fn under_lamps(&self) -> [(f64, f64); 3] {
        [self.under_own_lamps, self.under_neutral_lamps, self.under_full_lamps]
            .map(|figures| (figures.psnr_db, figures.ssim))
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
