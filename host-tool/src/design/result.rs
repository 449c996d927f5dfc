//! What the design engine returns.

use super::emphasis::{best_pair, neutral_pair};
use super::request::{DesignRequest, OpticsModel};
use crate::measure::{Quality, brightest_ink, measure};
use crate::optics::{Direction, LampPair, film_weights, ideal_weights};
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
    /// The lamp pair for nobody in particular.
    pub neutral: LampPair,
}

/// One view of a design.
#[derive(Clone, Debug)]
pub struct ViewDesign {
    /// The view's name.
    pub id: String,
    /// The lamp pair that shows this view at its best behind the real films; its larger level is 1.
    pub emphasis: LampPair,
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
        let lit: Vec<LitView> = request
            .views
            .iter()
            .zip(&targets)
            .map(|(view, target)| LitView::of(request, &volume, view.direction, target))
            .collect();
        let neutral = neutral_pair(&lit.iter().map(|view| view.emphasis).collect::<Vec<_>>());
        let ink = brightest_ink(&volume);
        let views = lit
            .into_iter()
            .enumerate()
            .map(|(index, lit)| lit.measured(request, &volume, index, neutral, ink))
            .collect();
        Self { volume, views, neutral }
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
    emphasis: LampPair,
}

impl LitView {
    fn of(request: &DesignRequest, volume: &Volume, direction: Direction, target: &Picture) -> Self {
        let rays = Rays::new(&request.stack, direction, request.distance);
        let under = |lamps| project_along(volume, &rays, &film_weights(&request.stack, direction, lamps));
        let (top, bottom) = (under(LampPair::TOP), under(LampPair::BOTTOM));
        let emphasis = best_pair(top.values(), bottom.values(), target.values());
        Self { rays, top, bottom, emphasis }
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
        volume: &Volume,
        index: usize,
        neutral: LampPair,
        ink: f64,
    ) -> ViewDesign {
        let view = &request.views[index];
        let patterns: Vec<&Picture> = request.views.iter().map(|view| &view.pattern).collect();
        let judge = |projection: &Picture, weights: &[f64]| {
            let light = ink * weights.iter().sum::<f64>();
            measure(projection, &patterns, index, request.settings.tone, light)
        };
        let lit = |lamps: LampPair| {
            let projection = self.under(lamps);
            let (quality, shown) = judge(&projection, &film_weights(&request.stack, view.direction, lamps));
            (quality, shown, projection)
        };
        let own = lit(self.emphasis);
        let under_own_lamps = own.0;
        let (quality, shown, projection) = match request.settings.optics {
            OpticsModel::Stack => own,
            OpticsModel::Ideal => {
                let weights = ideal_weights(&request.stack);
                let projection = project_along(volume, &self.rays, &weights);
                let (quality, shown) = judge(&projection, &weights);
                (quality, shown, projection)
            }
        };
        ViewDesign {
            id: view.id.clone(),
            emphasis: self.emphasis,
            projection,
            shown,
            quality,
            under_own_lamps,
            under_neutral_lamps: lit(neutral).0,
            under_full_lamps: lit(LampPair::FULL).0,
        }
    }
}
