//! What the design engine returns.

use super::emphasis::{LampSums, pair_for_all};
use super::request::{DesignRequest, OpticsModel, ViewRequest};
use crate::emission::Emission;
use crate::measure::{Quality, brightest_ink, fit, measure};
use crate::optics::{LampPair, film_weights, ideal_weights};
use crate::picture::Picture;
use crate::projection::{Rays, project_along};
use crate::volume::Volume;

/// A volume with the lamps that show it, and its measures.
#[derive(Clone, Debug)]
pub struct Design {
    /// The volume, rounded to the values that will be written.
    pub volume: Volume,
    /// The views, in the order of the request.
    pub views: Vec<ViewDesign>,
    /// The lamp pair for nobody in particular: the best for all views at once; its larger level is 1.
    pub neutral: LampPair,
    /// For each two views, the pair that is best for both at once.
    pub shared: Vec<SharedPair>,
}

/// The lamp pair that is best for two views at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedPair {
    /// Index of a view.
    pub first: usize,
    /// Index of a later view.
    pub second: usize,
    /// The pair; its larger level is 1.
    pub pair: LampPair,
}

/// One view of a design.
#[derive(Clone, Debug)]
pub struct ViewDesign {
    /// The view's name.
    pub id: String,
    /// The lamp pair that shows this view at its best behind the real films. Its larger level is 1, or less where
    /// the view would be brighter than the others by more than the settings' white ratio.
    pub emphasis: LampPair,
    /// The light that is seen as white under the view's own pair: 1 is what full ink on every film would give
    /// under both lamps full.
    pub white: f64,
    /// What the view shows in the optics of the design: the weighted sum over films.
    pub projection: Picture,
    /// The projection times the gain that fits its pattern, as sRGB code values.
    pub shown: Picture,
    /// Measures of the projection.
    pub quality: Quality,
    /// Measures behind the stack's own films, under this view's emphasis.
    pub under_own_lamps: Quality,
    /// Measures behind the stack's own films, under the neutral pair.
    pub under_neutral_lamps: Quality,
    /// Measures behind the stack's own films, with both lamps full.
    pub under_full_lamps: Quality,
}

impl Design {
    /// Finds the lamps for a volume and measures what it shows.
    pub fn of(request: &DesignRequest, volume: Volume) -> Self {
        let targets = request.targets();
        let emission = Emission::of(&request.stack);
        let light = emission.light(&volume);
        let mut lit: Vec<LitView> = targets
            .iter()
            .enumerate()
            .map(|(index, target)| LitView::of(request, &light, index, target))
            .collect();
        keep_whites_together(&mut lit, request.settings.white_ratio);
        let sums = |index: usize| (lit[index].sums, request.views[index].weight);
        let neutral = pair_for_all(&(0..lit.len()).map(sums).collect::<Vec<_>>());
        let shared = (0..lit.len())
            .flat_map(|first| (first + 1..lit.len()).map(move |second| (first, second)))
            .map(|(first, second)| SharedPair {
                first,
                second,
                pair: pair_for_all(&[(lit[first].sums, 1.0), (lit[second].sums, 1.0)]),
            })
            .collect();
        let ink = brightest_ink(&volume);
        let full_light = emission.glow(ink) * emission.white();
        let views = lit
            .into_iter()
            .enumerate()
            .map(|(index, lit)| lit.measured(request, (&volume, ink), index, neutral, full_light))
            .collect();
        Self { volume, views, neutral, shared }
    }

    /// Mean PSNR of the views in dB, in the optics of the design.
    pub fn mean_psnr_db(&self) -> f64 {
        self.mean(|view| view.quality.psnr_db)
    }

    /// PSNR of the worst view in dB, in the optics of the design.
    pub fn least_psnr_db(&self) -> f64 {
        self.views.iter().map(|view| view.quality.psnr_db).fold(f64::INFINITY, f64::min)
    }

    /// Mean SSIM of the views, in the optics of the design.
    pub fn mean_ssim(&self) -> f64 {
        self.mean(|view| view.quality.ssim)
    }

    fn mean(&self, measure: impl Fn(&ViewDesign) -> f64) -> f64 {
        self.views.iter().map(measure).sum::<f64>() / self.views.len().max(1) as f64
    }
}

/// A view under either lamp alone.
struct LitView {
    rays: Rays,
    top: Picture,
    bottom: Picture,
    sums: LampSums,
    emphasis: LampPair,
    /// The light that is seen as white under `emphasis`.
    white: f64,
}

impl LitView {
    fn of(request: &DesignRequest, light: &Volume, index: usize, target: &Picture) -> Self {
        let view = &request.views[index];
        let rays = request.rays(index);
        let under = |lamps| project_along(light, &rays, &film_weights(&request.stack, view.direction, lamps));
        let (top, bottom) = (under(LampPair::TOP), under(LampPair::BOTTOM));
        let sums = LampSums::of(top.values(), bottom.values(), target.values(), request.settings.tone);
        let emphasis = view.held_pair().unwrap_or_else(|| sums.best_pair());
        let mut lit = Self { rays, top, bottom, sums, emphasis, white: 0.0 };
        lit.white = lit.white_of(request, view);
        lit
    }

    fn white_of(&self, request: &DesignRequest, view: &ViewRequest) -> f64 {
        let gain = fit(&self.under(self.emphasis), &view.pattern, request.settings.tone).gain;
        let weights = film_weights(&request.stack, view.direction, LampPair::FULL);
        let full = Emission::of(&request.stack).white() * weights.iter().sum::<f64>();
        if gain > 0.0 { 1.0 / (gain * full) } else { 0.0 }
    }

    fn under(&self, lamps: LampPair) -> Picture {
        let mut picture = self.top.clone();
        for (value, &bottom) in picture.values_mut().iter_mut().zip(self.bottom.values()) {
            *value = lamps.top as f32 * *value + lamps.bottom as f32 * bottom;
        }
        picture
    }

    fn measured(
        self,
        request: &DesignRequest,
        (volume, ink): (&Volume, f64),
        index: usize,
        neutral: LampPair,
        full_light: f64,
    ) -> ViewDesign {
        let view = &request.views[index];
        let patterns: Vec<&Picture> = request.views.iter().map(|view| &view.pattern).collect();
        let judge = |projection: &Picture, weights: &[f64], full_light: f64| {
            let light = full_light * weights.iter().sum::<f64>();
            measure(projection, &patterns, index, request.settings.tone, light)
        };
        let lit = |lamps: LampPair| {
            let projection = self.under(lamps);
            let weights = film_weights(&request.stack, view.direction, lamps);
            let (quality, shown) = judge(&projection, &weights, full_light);
            (quality, shown, projection)
        };
        let own = lit(self.emphasis);
        let under_own_lamps = own.0;
        let (quality, shown, projection) = match request.settings.optics {
            OpticsModel::Stack => own,
            OpticsModel::Ideal => {
                let weights = ideal_weights(&request.stack);
                let projection = project_along(volume, &self.rays, &weights);
                let (quality, shown) = judge(&projection, &weights, ink);
                (quality, shown, projection)
            }
        };
        ViewDesign {
            id: view.id.clone(),
            emphasis: self.emphasis,
            white: self.white,
            projection,
            shown,
            quality,
            under_own_lamps,
            under_neutral_lamps: lit(neutral).0,
            under_full_lamps: lit(LampPair::FULL).0,
        }
    }
}

/// Dims the pairs of the brighter views until no view's white is more than `ratio` times another's. Views that show
/// nothing at all do not count.
fn keep_whites_together(views: &mut [LitView], ratio: f64) {
    let least =
        views.iter().map(|view| view.white).filter(|white| *white > 0.0).fold(f64::INFINITY, f64::min);
    for view in views {
        let level = (ratio * least / view.white.max(f64::MIN_POSITIVE)).min(1.0);
        view.emphasis = view.emphasis.scaled(level);
        view.white *= level;
    }
}
