//! What a design shows when it is built by human hands and looked at by people: films lie beside their places, gaps
//! are not quite as thick as they should be, viewers stand a little to the side, nearer or further.

use serde::{Deserialize, Serialize};

use super::request::{DesignRequest, ViewRequest};
use crate::emission::Emission;
use crate::measure::{fit, psnr_db, structural_similarity};
use crate::optics::{Direction, LampPair, film_weights};
use crate::projection::{Rays, ViewerDistance, project_along};
use crate::volume::Volume;

/// Random stacks that are looked at.
pub const STACKS: usize = 16;

/// Seed from which the stacks' errors follow.
pub const SEED: u64 = 11;

/// Normal errors of a stack made by hand and of the people before it, by their standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandErrors {
    /// Of each film's place along each axis.
    pub misplacement_um: f64,
    /// Of each gap between two films.
    pub spacing_um: f64,
    /// Of the viewer's direction along each axis.
    pub direction_deg: f64,
    /// Of the viewer's distance, as a part of it; nothing for parallel rays.
    pub distance_part: f64,
}

impl HandErrors {
    /// The errors that `request` expects.
    pub fn expected(request: &DesignRequest) -> Self {
        let settings = &request.settings;
        Self {
            misplacement_um: settings.misplacement_um,
            spacing_um: settings.spacing_um,
            direction_deg: settings.direction_error_deg,
            distance_part: settings.distance_error_part,
        }
    }

    /// Misplaced films and nothing else.
    pub fn misplaced(misplacement_um: f64) -> Self {
        Self { misplacement_um, spacing_um: 0.0, direction_deg: 0.0, distance_part: 0.0 }
    }
}

/// Quality over all random stacks, behind the stack's own films and under each view's own lamps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AsBuilt {
    /// The errors of the stacks and their viewers.
    pub errors: HandErrors,
    /// How many stacks were looked at.
    pub stacks: usize,
    /// What their errors follow from.
    pub seed: u64,
    /// The views, in the order of the request.
    pub views: Vec<ViewAsBuilt>,
}

/// Quality of one view over all random stacks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewAsBuilt {
    /// Mean PSNR in dB.
    pub mean_psnr_db: f64,
    /// Standard deviation of the PSNR over the stacks, in dB.
    pub spread_psnr_db: f64,
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

    /// PSNR in dB of the worst view in its worst stack.
    pub fn worst_psnr_db(&self) -> f64 {
        self.views.iter().map(|view| view.worst_psnr_db).fold(f64::INFINITY, f64::min)
    }

    /// SSIM of the worst view in its worst stack.
    pub fn worst_ssim(&self) -> f64 {
        self.views.iter().map(|view| view.worst_ssim).fold(f64::INFINITY, f64::min)
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
    let errors = HandErrors::misplaced(request.settings.misplacement_um);
    built_by_hand(request, volume, pairs, errors, stacks, seed)
}

/// As [`as_built`], with all errors of human hands and of viewers.
pub fn built_by_hand(
    request: &DesignRequest,
    volume: &Volume,
    pairs: &[LampPair],
    errors: HandErrors,
    stacks: usize,
    seed: u64,
) -> AsBuilt {
    let light = Emission::of(&request.stack).light(volume);
    // One stack after the other, each on all threads: as many at once as there are threads would need their pictures.
    let looks: Vec<Vec<(f64, f64)>> = (0..stacks)
        .map(|stack| {
            let built = Built::at_random(request, errors, seed.wrapping_add(stack as u64));
            let views = request.views.iter().zip(pairs);
            views.map(|(view, &pair)| built.look(request, &light, view, pair)).collect()
        })
        .collect();
    let count = looks.len().max(1) as f64;
    let views = (0..request.views.len()).map(|view| {
        let of_view = || looks.iter().map(move |look| look[view]);
        let mean_psnr_db = of_view().map(|look| look.0).sum::<f64>() / count;
        let squares = of_view().map(|look| (look.0 - mean_psnr_db).powi(2)).sum::<f64>();
        ViewAsBuilt {
            mean_psnr_db,
            spread_psnr_db: (squares / count).sqrt(),
            worst_psnr_db: of_view().map(|look| look.0).fold(f64::INFINITY, f64::min),
            mean_ssim: of_view().map(|look| look.1).sum::<f64>() / count,
            worst_ssim: of_view().map(|look| look.1).fold(f64::INFINITY, f64::min),
        }
    });
    AsBuilt { errors, stacks, seed, views: views.collect() }
}

/// One stack with its errors, and where its viewers really stand.
struct Built {
    shifts_mm: Vec<(f64, f64)>,
    heights_mm: Vec<f64>,
    /// Added to every view's direction.
    astray_deg: (f64, f64),
    /// What every viewer's distance is multiplied by.
    distance_factor: f64,
}

impl Built {
    fn at_random(request: &DesignRequest, errors: HandErrors, seed: u64) -> Self {
        let stack = &request.stack;
        // Other numbers than the films' shifts, which do not change when other errors come or go.
        let others = misplacements(stack.films + 2, 1.0, !seed);
        let mut heights_mm = Vec::with_capacity(stack.films);
        let mut sunk = 0.0;
        for (film, (error, _)) in others.iter().enumerate().take(stack.films) {
            heights_mm.push(stack.film_z_mm(film) - sunk);
            sunk += errors.spacing_um / 1000.0 * error;
        }
        let middle = heights_mm.iter().sum::<f64>() / stack.films as f64;
        heights_mm.iter_mut().for_each(|height| *height -= middle);
        let (astray, distance) = (others[stack.films], others[stack.films + 1].0);
        Self {
            shifts_mm: misplacements(stack.films, errors.misplacement_um / 1000.0, seed),
            heights_mm,
            astray_deg: (errors.direction_deg * astray.0, errors.direction_deg * astray.1),
            // Nobody stands within the stack.
            distance_factor: (1.0 + errors.distance_part * distance).max(0.5),
        }
    }

    /// PSNR in dB and SSIM of one view.
    fn look(
        &self,
        request: &DesignRequest,
        light: &Volume,
        view: &ViewRequest,
        pair: LampPair,
    ) -> (f64, f64) {
        let (horizontal, vertical) = self.astray_deg;
        let Direction { horizontal_deg, vertical_deg } = view.direction;
        let direction = Direction::new(horizontal_deg + horizontal, vertical_deg + vertical);
        let distance = match view.distance.unwrap_or(request.distance) {
            ViewerDistance::Parallel => ViewerDistance::Parallel,
            ViewerDistance::Millimetres(distance) => {
                let nearest = request.stack.depth_mm() + request.stack.film_pitch_mm();
                ViewerDistance::Millimetres((distance * self.distance_factor).max(nearest))
            }
        };
        let stack = &request.stack;
        let rays = Rays::at_heights(stack, direction, distance, &self.shifts_mm, &self.heights_mm);
        let shown = project_along(light, &rays, &film_weights(stack, direction, pair));
        let fitted = fit(&shown, &view.pattern, request.settings.tone);
        (psnr_db(&fitted.picture, &view.pattern), structural_similarity(&fitted.picture, &view.pattern))
    }
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

    #[test]
    fn errors_of_other_kinds_leave_the_films_where_they_are_and_keep_the_middle() {
        let request = DesignRequest {
            stack: crate::stack::Stack::default(),
            distance: ViewerDistance::Millimetres(600.0),
            views: Vec::new(),
            settings: super::super::DesignSettings::default(),
            stop: super::super::Stop::default(),
        };
        let expected = HandErrors::expected(&request);
        assert_eq!(expected.spacing_um, 25.0);
        let alone = Built::at_random(&request, HandErrors::misplaced(68.0), 5);
        let all = Built::at_random(&request, expected, 5);
        assert_eq!(alone.shifts_mm, all.shifts_mm);
        assert_eq!((alone.astray_deg, alone.distance_factor), ((0.0, 0.0), 1.0));
        assert!(all.heights_mm.iter().sum::<f64>().abs() < 1e-9);
        let gaps: Vec<f64> = all.heights_mm.windows(2).map(|pair| pair[0] - pair[1] - 0.6).collect();
        let spread = (gaps.iter().map(|gap| gap * gap).sum::<f64>() / gaps.len() as f64).sqrt();
        assert!((0.012..0.04).contains(&spread), "{spread}");
        assert!(all.astray_deg.0 != 0.0 && all.distance_factor != 1.0);
    }
}
