//! What the errors of hands and viewers do to a film, on the average.
//!
//! To first order every such error moves a film beside where a view's rays look for it. Film k at the height z moves by
//!
//! - its misplacement, sigma along each axis;
//! - the gaps' errors: heights are sums of the gaps' errors about their mean, and a film that is dz too high moves
//!   by dz times the ray's slope;
//! - z times the change of slope of a viewer who stands beside the view's direction, `d tan(h) = dh / cos^2(h)`;
//! - z u / D times the viewer's error of distance as a part of it, u being the picture's place: on the average over
//!   the film, its square is a twelfth of the film's size squared.
//!
//! The variances add. The film's expected light is its light spread by them, and what it scatter about that counts by
//! its squared weights (see [`super::least_squares`]). Errors of the viewer move all films together, by their
//! heights; the scatter is reckoned as if each film moved by itself, which is what remains where the films' details
//! have nothing to do with each other.

use super::emphasis::importance;
use super::least_squares::{FilmBlur, SolverView};
use super::request::{DesignRequest, OpticsModel};
use crate::picture::Picture;
use crate::projection::ViewerDistance;
use crate::spread::Spread;

/// How the light of every film spreads on the average, and how much its scatter counts; nothing where no film's does.
/// `counts` are those of [`counts`].
pub(super) fn blurs(request: &DesignRequest, views: &[SolverView], counts: &[f32]) -> Vec<FilmBlur> {
    let stack = &request.stack;
    if request.settings.optics == OpticsModel::Ideal {
        return Vec::new();
    }
    let variances: Vec<[f64; 2]> = (0..stack.films).map(|film| variances_px(request, film)).collect();
    let print = stack.blur_variance_px();
    if print == 0.0 && variances.iter().all(|variance| *variance == [0.0; 2]) {
        return Vec::new();
    }
    let blur = |(film, errors): (usize, [f64; 2])| {
        let noise = views
            .iter()
            .zip(counts)
            .map(|(view, count)| count * view.weight * view.film_weights[film].powi(2));
        FilmBlur {
            expected: Spread::of_variances(errors.map(|error| error + print)),
            print_twice: Spread::of_variance(2.0 * print),
            noise: if errors == [0.0; 2] { 0.0 } else { noise.sum() },
        }
    };
    variances.into_iter().enumerate().map(blur).collect()
}

/// How much a squared error of light counts in each view, for patterns in the values in which films add up.
pub(super) fn counts(request: &DesignRequest, targets: &[Picture]) -> Vec<f32> {
    targets.iter().map(|target| count(request, target)).collect()
}

/// The least and the greatest standard deviation of where a film lies, along either axis, in pixels.
pub(super) fn errors_px(request: &DesignRequest) -> (f64, f64) {
    if request.settings.optics == OpticsModel::Ideal {
        return (0.0, 0.0);
    }
    let errors = (0..request.stack.films).flat_map(|film| variances_px(request, film)).map(f64::sqrt);
    errors.fold((f64::INFINITY, 0.0), |(least, most), error| (error.min(least), error.max(most)))
}

/// How much a squared error of light counts in a view: as its codes do, where there is light that can scatter.
fn count(request: &DesignRequest, target: &Picture) -> f32 {
    let (mut counts, mut light) = (0.0, 0.0);
    for &wanted in target.values() {
        counts += f64::from(wanted * importance(request.settings.tone, wanted));
        light += f64::from(wanted);
    }
    if light > 0.0 { (counts / light) as f32 } else { 1.0 }
}

/// Variance of a film's place along its rows and its columns, in square pixels, as a mean over the views.
fn variances_px(request: &DesignRequest, film: usize) -> [f64; 2] {
    let (stack, settings) = (&request.stack, &request.settings);
    let z = stack.film_z_mm(film);
    let height = height_variance(stack.films, film) * (settings.spacing_um / 1000.0).powi(2);
    let turn = settings.direction_error_deg.to_radians();
    // Mean squares of the picture's places about the middle of the whole films.
    let below = stack.below_middle_mm();
    let places = [stack.width_mm.powi(2) / 12.0, stack.height_mm().powi(2) / 12.0 + below * below];
    let count = request.views.len() as f64;
    let mut variances = [(settings.misplacement_um / 1000.0).powi(2); 2];
    for view in &request.views {
        let (x, y) = view.direction.slope(stack.index);
        for ((variance, slope), place) in variances.iter_mut().zip([x, y]).zip(places) {
            let nearer = match view.distance.unwrap_or(request.distance) {
                ViewerDistance::Parallel => 0.0,
                ViewerDistance::Millimetres(distance) => z * settings.distance_error_part / distance,
            };
            let turned = z * turn * (1.0 + slope * slope) / stack.index;
            *variance += (height * slope * slope + turned * turned + nearer * nearer * place) / count;
        }
    }
    variances.map(|variance| variance / stack.pixel_mm().powi(2))
}

/// Variance of a film's height about the films' mean, for gaps whose errors have the variance 1.
fn height_variance(films: usize, film: usize) -> f64 {
    let count = films as f64;
    // The film's height less the mean is the sum over gaps of the gap's error times the part of the films on the
    // gap's other side.
    let below = |gap: usize| (count - 1.0 - gap as f64) / count;
    (0..films.saturating_sub(1))
        .map(|gap| if gap < film { 1.0 - below(gap) } else { below(gap) }.powi(2))
        .sum()
}
