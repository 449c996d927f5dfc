//! The slope that the solver follows is that of the loss, whatever the forward model reckons with: this holds only
//! where what goes back to the films is the exact transpose of what they show.

use super::*;
use crate::design::optimise::{Lighting, set_up};
use crate::design::{DesignRequest, DesignSettings, HandErrors, Stop, Tone, ViewRequest};
use crate::optics::{Direction, LampPair};
use crate::picture::Picture;
use crate::projection::{Rays, ViewerDistance};
use crate::stack::Stack;

const WIDTH: usize = 21;
const HEIGHT: usize = 18;

fn value(index: usize, factor: usize) -> f32 {
    (index * factor % 101) as f32 / 101.0
}

/// Two views of a small stack without any error or absorption.
fn plain() -> DesignRequest {
    let pattern = |factor: usize| {
        let values = (0..3 * WIDTH * HEIGHT).map(|index| 0.1 + 0.6 * value(index, factor)).collect();
        Picture::from_values(WIDTH, HEIGHT, values).unwrap()
    };
    let stack = Stack {
        films: 4,
        width_px: WIDTH,
        height_px: HEIGHT,
        width_mm: 2.1,
        tau_uv: 1.0,
        tau_visible: 1.0,
        ..Stack::default()
    };
    DesignRequest {
        stack,
        distance: ViewerDistance::Parallel,
        views: vec![
            ViewRequest::new("right", pattern(37), Direction::new(17.0, 5.0)),
            ViewRequest::new("left", pattern(53), Direction::new(-20.0, 0.0)),
        ],
        settings: DesignSettings { tone: Tone::Code, structure: Some(0.0), ..DesignSettings::default() }
            .expecting(HandErrors::misplaced(0.0)),
        stop: Stop::default(),
    }
}

/// The loss of `volume` (film, row, column), and half its slope along every voxel (row, film, column).
fn loss_and_slope(problem: &Problem, targets: &[&[f32]], volume: &[f32]) -> (f64, Vec<f32>) {
    let mut films = volume.to_vec();
    let mut work = Work::new(problem, targets, &mut films);
    let loss = work.look().sum();
    if let Some(blurred) = &mut work.blurred {
        blurred.turn(problem, work.answers.iter().map(|answer| &*answer.slopes).collect());
    }
    let mut rows = Rows {
        problem,
        answers: &work.answers,
        blurred: work.blurred.as_ref(),
        film_steps: &work.film_steps,
        first: 0,
        gradient: vec![0.0; WIDTH],
        scratch: vec![0.0; WIDTH],
        wide_steps: vec![0.0; WIDTH],
    };
    let mut slope = Vec::new();
    for (index, ahead) in work.ahead.chunks_exact(WIDTH).enumerate() {
        rows.pull_back(index % problem.films, index / problem.films, ahead);
        slope.extend_from_slice(&rows.gradient);
    }
    (loss, slope)
}

/// The loss is quadratic, so that its central difference along any line is its slope there.
fn assert_slope_is_the_losses(what: &str, request: &DesignRequest, ink_yield: f32) {
    let targets = request.targets();
    let lighting = Lighting::even(2, LampPair::new(1.0, 0.4));
    let problem = set_up(request, &targets, &lighting, None);
    let problem = problem.of_yield(ink_yield);
    let targets: Vec<&[f32]> = targets.iter().map(|target| target.channel(1)).collect();
    let len = problem.films * WIDTH * HEIGHT;
    let volume: Vec<f32> = (0..len).map(|index| value(index, 71)).collect();
    for factor in [13, 29] {
        let direction: Vec<f32> = (0..len).map(|index| value(index, factor) - 0.5).collect();
        let moved = |step: f32| -> f64 {
            let volume: Vec<f32> = volume.iter().zip(&direction).map(|(v, d)| v + step * d).collect();
            loss_and_slope(&problem, &targets, &volume).0
        };
        let wanted = (moved(0.5) - moved(-0.5)) / 2.0;
        let slope = loss_and_slope(&problem, &targets, &volume).1;
        let mut lines = direction.clone();
        by_row(&mut lines, &problem);
        let found: f64 = slope.iter().zip(&lines).map(|(slope, d)| f64::from(slope * d)).sum();
        let size: f64 = slope.iter().zip(&lines).map(|(slope, d)| f64::from((slope * d).abs())).sum();
        assert!((found - wanted).abs() < 1e-4 * size, "{what}: {found} {wanted} of {size}");
    }
}

#[test]
fn the_slope_is_the_losses_for_everything_the_forward_model_knows() {
    let mut request = plain();
    assert_slope_is_the_losses("nothing", &request, 1.0);
    type ReckonWith = fn(&mut DesignRequest);
    let everything: [(&str, ReckonWith); 9] = [
        ("absorption", |request| (request.stack.tau_uv, request.stack.tau_visible) = (0.82, 0.9)),
        ("refraction", |request| request.stack.index = 1.49),
        ("finite distance", |request| request.views[0].distance = Some(ViewerDistance::Millimetres(60.0))),
        ("misplacement", |request| request.settings.misplacement_um = 120.0),
        ("spacing", |request| request.settings.spacing_um = 200.0),
        ("viewers", |request| {
            (request.settings.direction_error_deg, request.settings.distance_error_part) = (5.0, 0.2);
        }),
        ("blur", |request| request.stack.blur_um = 90.0),
        ("a mask", |request| {
            request.views[1].mask = Some((0..WIDTH * HEIGHT).map(|index| value(index, 19)).collect());
        }),
        ("structure", |request| request.settings.structure = Some(3.0)),
    ];
    for (what, reckon_with) in &everything {
        let mut alone = plain();
        reckon_with(&mut alone);
        assert_slope_is_the_losses(what, &alone, 1.0);
        reckon_with(&mut request);
        assert_slope_is_the_losses(&format!("all up to {what}"), &request, 0.43);
    }
}

#[test]
fn the_loss_is_the_mean_over_where_a_misplaced_film_may_lie() {
    let mut request = plain();
    request.stack.films = 1;
    request.views.truncate(1);
    request.views[0].direction = Direction::default();
    request.settings.misplacement_um = 100.0;
    let targets = request.targets();
    let problem = set_up(&request, &targets, &Lighting::even(1, LampPair::FULL), None);
    let pictures = [targets[0].channel(0)];
    // A blot of noise in the middle of the film, so that no light leaves it.
    let volume: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|index| {
            let inside =
                (6..WIDTH - 6).contains(&(index % WIDTH)) && (6..HEIGHT - 6).contains(&(index / WIDTH));
            if inside { value(index, 71) } else { 0.0 }
        })
        .collect();
    let error = |rays: &Rays| -> f64 {
        let mut shown = vec![0.0; WIDTH * HEIGHT];
        rays.project(&volume, &problem.views[0].film_weights, &mut shown);
        shown.iter().zip(pictures[0]).map(|(shown, wanted)| f64::from(shown - wanted).powi(2)).sum()
    };
    // A pixel is 100 um wide: whole pixels with the parts of the spread as their odds.
    const REACH: usize = 5;
    let side = 2 * REACH + 1;
    let mut odds = vec![0.0; side * side];
    odds[REACH * side + REACH] = 1.0;
    let odds = problem.blurs[0].expected.of_film(&odds, side);
    let place = |index: usize| (index as f64 - REACH as f64) * 0.1;
    let mean: f64 = odds
        .iter()
        .enumerate()
        .map(|(index, odds)| {
            let shift = (place(index % side), place(index / side));
            f64::from(*odds) * error(&request.misplaced_rays(0, &[shift]))
        })
        .sum();
    let loss = loss_and_slope(&problem, &pictures, &volume).0;
    assert!((loss / mean - 1.0).abs() < 1e-4, "{loss} {mean}");
    let mut without_scatter = problem.clone();
    without_scatter.blurs[0].noise = 0.0;
    assert!(loss_and_slope(&without_scatter, &pictures, &volume).0 < 0.98 * mean);
}
