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
    /// What the view shows, times the gain that fits its pattern, as sRGB code values.
    pub shown: Picture,
    /// Measures of what it shows in the optics of the design.
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
        let emission = Emission::of(&request.stack);
        let light = emission.light(&volume);
        let mut lit: Vec<LitView> =
            (0..request.views.len()).map(|index| LitView::of(request, &light, index)).collect();
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
            .map(|(index, lit)| lit.measured(request, (&volume, ink), (&light, full_light), index, neutral))
            .collect();
        drop(light);
        Self { volume, views, neutral, shared }
    }

    /// What the view of this index shows in the optics of the design: the weighted sum over films.
    pub fn projection(&self, request: &DesignRequest, view: usize) -> Picture {
        let rays = request.rays(view);
        match request.settings.optics {
            OpticsModel::Stack => {
                let direction = request.views[view].direction;
                let weights = film_weights(&request.stack, direction, self.views[view].emphasis);
                project_along(&Emission::of(&request.stack).light(&self.volume), &rays, &weights)
            }
            OpticsModel::Ideal => project_along(&self.volume, &rays, &ideal_weights(&request.stack)),
        }
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

/// A view, and the lamps that show it.
struct LitView {
    rays: Rays,
    sums: LampSums,
    emphasis: LampPair,
    /// The light that is seen as white under `emphasis`.
    white: f64,
}

/// What a view shows under either lamp alone.
struct EitherLamp {
    top: Picture,
    bottom: Picture,
}

impl EitherLamp {
    fn of(request: &DesignRequest, view: &ViewRequest, light: &Volume, rays: &Rays) -> Self {
        let under = |lamps| project_along(light, rays, &film_weights(&request.stack, view.direction, lamps));
        Self { top: under(LampPair::TOP), bottom: under(LampPair::BOTTOM) }
    }

    fn under(&self, lamps: LampPair) -> Picture {
        let mut picture = self.top.clone();
        for (value, &bottom) in picture.values_mut().iter_mut().zip(self.bottom.values()) {
            *value = lamps.top as f32 * *value + lamps.bottom as f32 * bottom;
        }
        picture
    }
}

impl LitView {
    /// Finds the lamps. What they show is projected again when it is measured: as many pictures for every view at once
    /// would be the most that a design holds.
    fn of(request: &DesignRequest, light: &Volume, index: usize) -> Self {
        let view = &request.views[index];
        let rays = request.rays(index);
        let lamps = EitherLamp::of(request, view, light, &rays);
        let target = request.target(view);
        let tone = request.settings.tone;
        let sums = LampSums::of(lamps.top.values(), lamps.bottom.values(), target.values(), tone);
        drop(target);
        let emphasis = view.held_pair().unwrap_or_else(|| sums.best_pair());
        let gain = fit(&lamps.under(emphasis), &view.pattern, tone).gain;
        let weights = film_weights(&request.stack, view.direction, LampPair::FULL);
        let full = Emission::of(&request.stack).white() * weights.iter().sum::<f64>();
        let white = if gain > 0.0 { 1.0 / (gain * full) } else { 0.0 };
        Self { rays, sums, emphasis, white }
    }

    fn measured(
        self,
        request: &DesignRequest,
        (volume, ink): (&Volume, f64),
        (light, full_light): (&Volume, f64),
        index: usize,
        neutral: LampPair,
    ) -> ViewDesign {
        let view = &request.views[index];
        let patterns: Vec<&Picture> = request.views.iter().map(|view| &view.pattern).collect();
        let judge = |projection: &Picture, weights: &[f64], full_light: f64| {
            let light = full_light * weights.iter().sum::<f64>();
            measure(projection, &patterns, index, request.settings.tone, light)
        };
        let lamps = EitherLamp::of(request, view, light, &self.rays);
        let lit = |pair: LampPair| {
            let projection = lamps.under(pair);
            let weights = film_weights(&request.stack, view.direction, pair);
            judge(&projection, &weights, full_light)
        };
        let under_neutral_lamps = lit(neutral).0;
        let under_full_lamps = lit(LampPair::FULL).0;
        let own = lit(self.emphasis);
        drop(lamps);
        let under_own_lamps = own.0;
        let (quality, shown) = match request.settings.optics {
            OpticsModel::Stack => own,
            OpticsModel::Ideal => {
                drop(own);
                let weights = ideal_weights(&request.stack);
                let projection = project_along(volume, &self.rays, &weights);
                judge(&projection, &weights, ink)
            }
        };
        ViewDesign {
            id: view.id.clone(),
            emphasis: self.emphasis,
            white: self.white,
            shown,
            quality,
            under_own_lamps,
            under_neutral_lamps,
            under_full_lamps,
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
