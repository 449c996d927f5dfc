//! What a design shows when it is built by human hands: films lie beside their places.

use rayon::prelude::*;

use super::request::DesignRequest;
use crate::measure::{fit, psnr_db, structural_similarity};
use crate::optics::{LampPair, film_weights};
use crate::projection::project_along;
use crate::volume::Volume;

/// Random stacks that are looked at.
pub const STACKS: usize = 16;

/// Seed from which the stacks' errors follow.
pub const SEED: u64 = 11;

/// Quality over all random stacks, behind the stack's own films and under each view's own lamps.
#[derive(Clone, Debug, PartialEq)]
pub struct AsBuilt {
    /// The views, in the order of the request.
    pub views: Vec<ViewAsBuilt>,
}

/// Quality of one view over all random stacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewAsBuilt {
    /// Mean PSNR in dB.
    pub mean_psnr_db: f64,
    /// PSNR in dB in the worst stack.
    pub worst_psnr_db: f64,
    /// Mean SSIM.
    pub mean_ssim: f64,
    /// SSIM in the worst stack.
    pub worst_ssim: f64,
}

impl AsBuilt {
    /// Mean PSNR of all views in dB.
    pub fn mean_psnr_db(&self) -> f64 {
        self.mean(|view| view.mean_psnr_db)
    }

    /// Mean PSNR of the view that fares worst, in dB.
    pub fn least_psnr_db(&self) -> f64 {
        self.views.iter().map(|view| view.mean_psnr_db).fold(f64::INFINITY, f64::min)
    }

    /// Mean SSIM of all views.
    pub fn mean_ssim(&self) -> f64 {
        self.mean(|view| view.mean_ssim)
    }

    fn mean(&self, measure: impl Fn(&ViewAsBuilt) -> f64) -> f64 {
        self.views.iter().map(measure).sum::<f64>() / self.views.len().max(1) as f64
    }
}

/// Looks at `stacks` stacks whose films are misplaced along each axis by normal errors of the request's
/// `misplacement_um`; the errors follow from `seed` alone. `pairs` are the views' lamp pairs.
pub fn as_built(
    request: &DesignRequest,
    volume: &Volume,
    pairs: &[LampPair],
    stacks: usize,
    seed: u64,
) -> AsBuilt {
    let sigma_mm = request.settings.misplacement_um / 1000.0;
    let looks: Vec<Vec<(f64, f64)>> = (0..stacks)
        .into_par_iter()
        .map(|stack| {
            let shifts = misplacements(request.stack.films, sigma_mm, seed.wrapping_add(stack as u64));
            let views = request.views.iter().zip(pairs).enumerate();
            views
                .map(|(index, (view, &pair))| {
                    let rays = request.misplaced_rays(index, &shifts);
                    let weights = film_weights(&request.stack, view.direction, pair);
                    let shown = project_along(volume, &rays, &weights);
                    let fitted = fit(&shown, &view.pattern, request.settings.tone);
                    let ssim = structural_similarity(&fitted.picture, &view.pattern);
                    (psnr_db(&fitted.picture, &view.pattern), ssim)
                })
                .collect()
        })
        .collect();
    let count = looks.len().max(1) as f64;
    let views = (0..request.views.len()).map(|view| {
        let of_view = || looks.iter().map(move |look| look[view]);
        ViewAsBuilt {
            mean_psnr_db: of_view().map(|look| look.0).sum::<f64>() / count,
            worst_psnr_db: of_view().map(|look| look.0).fold(f64::INFINITY, f64::min),
            mean_ssim: of_view().map(|look| look.1).sum::<f64>() / count,
            worst_ssim: of_view().map(|look| look.1).fold(f64::INFINITY, f64::min),
        }
    });
    AsBuilt { views: views.collect() }
}

/// Returns for each film a normal error along each axis, in mm.
pub fn misplacements(films: usize, sigma_mm: f64, seed: u64) -> Vec<(f64, f64)> {
    let mut random = SplitMix(seed);
    (0..films)
        .map(|_| {
            // Box and Muller's transform gives two normal numbers from two even ones.
            let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt() * sigma_mm;
            let (sine, cosine) = (random.unit() * std::f64::consts::TAU).sin_cos();
            (radius * cosine, radius * sine)
        })
        .collect()
}

/// Steele, Lea and Flood's SplitMix64: a small generator with 64 bits of state.
struct SplitMix(u64);

impl SplitMix {
    /// An even number in 0..1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misplacements_are_normal_and_follow_from_the_seed() {
        let shifts = misplacements(20_000, 0.068, 11);
        assert_eq!(shifts, misplacements(20_000, 0.068, 11));
        assert_ne!(shifts[0], misplacements(1, 0.068, 12)[0]);
        let values: Vec<f64> = shifts.iter().flat_map(|&(x, y)| [x, y]).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.002, "{mean}");
        assert!((variance.sqrt() - 0.068).abs() < 0.001, "{}", variance.sqrt());
        let within = values.iter().filter(|v| v.abs() < 0.068).count() as f64 / values.len() as f64;
        assert!((within - 0.6827).abs() < 0.01, "{within}");
    }
}
