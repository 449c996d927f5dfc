//! Rows are solved to their optimum, along the exact transpose of what they show. What they are held to is worked out
//! here in double precision, from the geometry's formula and by another method.

use super::*;
use crate::design::optimise::{Lighting, set_up};
use crate::design::{DesignRequest, DesignSettings, HandErrors, Stop, Tone, ViewRequest};
use crate::optics::{Direction, LampPair};
use crate::picture::Picture;
use crate::projection::ViewerDistance;
use crate::stack::Stack;

const WIDTH: usize = 18;
const HEIGHT: usize = 3;
const FILMS: usize = 5;

fn value(index: usize, factor: usize) -> f32 {
    (index * factor % 101) as f32 / 101.0
}

/// Three views of films that absorb, one of which counts more; its rays leave the films at their edges.
fn request(structure: f64) -> DesignRequest {
    let pattern = |factor: usize| {
        let values = (0..3 * WIDTH * HEIGHT).map(|index| value(index, factor)).collect();
        Picture::from_values(WIDTH, HEIGHT, values).unwrap()
    };
    let stack = Stack { films: FILMS, width_px: WIDTH, height_px: HEIGHT, width_mm: 3.6, ..Stack::default() };
    let view =
        |id: &str, factor, degrees| ViewRequest::new(id, pattern(factor), Direction::new(degrees, 0.0));
    DesignRequest {
        stack,
        distance: ViewerDistance::Parallel,
        views: vec![
            ViewRequest { weight: 2.5, ..view("right", 37, 40.0) },
            view("middle", 53, 0.0),
            view("left", 29, -23.0),
        ],
        settings: DesignSettings { tone: Tone::Code, structure: Some(structure), ..Default::default() }
            .expecting(HandErrors::misplaced(0.0)),
        stop: Stop::default(),
    }
}

fn problem(request: &DesignRequest) -> Problem {
    let mut lighting = Lighting::even(3, LampPair::FULL);
    lighting.pairs = vec![LampPair::new(1.0, 0.3), LampPair::TOP, LampPair::BOTTOM];
    let problem = set_up(request, &request.targets(), &lighting, None);
    assert!(problem.rows_are_apart());
    problem
}

/// How much each voxel of a row (film, column) counts in each pixel of a view's row, by the architecture's formula.
fn matrix(request: &DesignRequest, problem: &Problem, view: usize) -> Vec<Vec<f64>> {
    let stack = &request.stack;
    let slope = request.views[view].direction.horizontal_deg.to_radians().tan();
    let mut rows = vec![vec![0.0; FILMS * WIDTH]; WIDTH];
    for (pixel, row) in rows.iter_mut().enumerate() {
        for film in 0..FILMS {
            let place = pixel as f64 + stack.film_z_mm(film) * slope / stack.pixel_mm();
            let lower = (place + 1e-9).floor();
            let part = (place - lower).max(0.0);
            if lower < 0.0 || lower + part > (WIDTH - 1) as f64 {
                continue;
            }
            let weight = f64::from(problem.views[view].film_weights[film]);
            let at = film * WIDTH + lower as usize;
            row[at] += weight * (1.0 - part);
            if part > 0.0 {
                row[at + 1] += weight * part;
            }
        }
    }
    rows
}

/// One row's problem in double precision.
struct Exact {
    views: Vec<ExactView>,
}

struct ExactView {
    matrix: Vec<Vec<f64>>,
    /// What the errors of each two pixels count together.
    counts: Vec<Vec<f64>>,
    wanted: Vec<f64>,
}

impl Exact {
    fn of(request: &DesignRequest, problem: &Problem, targets: &[&[f32]], row: usize) -> Self {
        let structures = structures(problem, targets);
        let views = (0..request.views.len()).map(|view| {
            let counts = (0..WIDTH).map(|pixel| {
                let mut answer = vec![0.0; WIDTH];
                answer[pixel] = 1.0;
                if let Some(structure) = structures.get(view) {
                    structure.answer_row(row, &mut answer, &mut RowScratch::new(WIDTH));
                }
                let weight = f64::from(problem.views[view].weight);
                answer.iter().map(|count| weight * f64::from(*count)).collect()
            });
            let wanted = &targets[view][row * WIDTH..(row + 1) * WIDTH];
            let wanted = wanted.iter().map(|value| f64::from(*value)).collect();
            ExactView { matrix: matrix(request, problem, view), counts: counts.collect(), wanted }
        });
        Self { views: views.collect() }
    }

    /// The loss of a row (film, column), and half its slope.
    fn loss(&self, voxels: &[f64]) -> (f64, Vec<f64>) {
        let (mut loss, mut slope) = (0.0, vec![0.0; voxels.len()]);
        for ExactView { matrix, counts, wanted } in &self.views {
            let errors: Vec<f64> =
                matrix.iter().zip(wanted).map(|(row, wanted)| dot(row, voxels) - wanted).collect();
            for ((row, counts), error) in matrix.iter().zip(counts).zip(&errors) {
                let answer = dot(counts, &errors);
                loss += error * answer;
                slope.iter_mut().zip(row).for_each(|(slope, part)| *slope += part * answer);
            }
        }
        (loss, slope)
    }

    /// The least loss within 0..=1: FISTA with the largest curvature's step (Beck and Teboulle 2009), for very long.
    fn least_loss(&self) -> f64 {
        let curved = |voxels: &[f64]| {
            let (at, nothing) = (self.loss(voxels).1, self.loss(&vec![0.0; voxels.len()]).1);
            at.iter().zip(nothing).map(|(at, nothing)| at - nothing).collect::<Vec<f64>>()
        };
        let mut steepest = vec![1.0; FILMS * WIDTH];
        let mut curvature = 0.0;
        for _ in 0..300 {
            steepest = curved(&steepest);
            curvature = dot(&steepest, &steepest).sqrt();
            steepest.iter_mut().for_each(|value| *value /= curvature);
        }
        let step = 0.99 / curvature;
        let mut now = vec![0.5; FILMS * WIDTH];
        let (mut ahead, mut inertia) = (now.clone(), 1.0f64);
        for _ in 0..20_000 {
            let slope = self.loss(&ahead).1;
            let reached: Vec<f64> =
                ahead.iter().zip(slope).map(|(at, slope)| (at - step * slope).clamp(0.0, 1.0)).collect();
            let next = (1.0 + (1.0 + 4.0 * inertia * inertia).sqrt()) / 2.0;
            let pull = (inertia - 1.0) / next;
            ahead = reached.iter().zip(&now).map(|(reached, now)| reached + pull * (reached - now)).collect();
            (now, inertia) = (reached, next);
        }
        self.loss(&now).0
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// By how much the loss of each row is above its least after so many iterations, as a part of that.
fn above_least(structure: f64, iterations: usize) -> Vec<f64> {
    let request = request(structure);
    let problem = problem(&request);
    let targets = request.targets();
    let targets: Vec<&[f32]> = targets.iter().map(|target| target.channel(1)).collect();
    let mut volume = vec![0.2; FILMS * WIDTH * HEIGHT];
    solve(&problem, &targets, &mut volume, Effort { iterations, tolerance: 1e-6 }, &mut |_, _| ());
    let row_of = |row: usize| {
        let lines = volume.chunks_exact(WIDTH).skip(row).step_by(HEIGHT);
        lines.flatten().map(|ink| f64::from(*ink)).collect::<Vec<f64>>()
    };
    let above = (0..HEIGHT).map(|row| {
        let exact = Exact::of(&request, &problem, &targets, row);
        let least = exact.least_loss();
        assert!(least > 0.05, "the patterns disagree, or nothing is shown: {least}");
        exact.loss(&row_of(row)).0 / least - 1.0
    });
    above.collect()
}

#[test]
fn every_row_ends_at_its_optimum() {
    for structure in [0.0, 1.5] {
        let found = above_least(structure, 600);
        assert!(found.iter().all(|above| (-1e-5..1e-3).contains(above)), "{structure}: {found:?}");
        let unfinished = above_least(structure, 10);
        assert!(unfinished.iter().all(|above| *above > 3e-3), "{structure}: {unfinished:?}");
    }
}

#[test]
fn what_comes_back_to_a_row_is_the_transpose_of_what_it_shows() {
    let request = request(0.0);
    let problem = problem(&request);
    let films: Vec<f32> = (0..FILMS * WIDTH).map(|index| value(index, 71)).collect();
    for (index, view) in problem.views.iter().enumerate() {
        let picture: Vec<f32> = (0..WIDTH).map(|pixel| value(pixel + 7, 43) - 0.5).collect();
        let mut shown = vec![0.0; WIDTH];
        let mut back = vec![0.0; FILMS * WIDTH];
        for (film, (line, back)) in films.chunks(WIDTH).zip(back.chunks_mut(WIDTH)).enumerate() {
            view.rays.project_film_line(film, line, view.film_weights[film], &mut shown);
            view.rays.back_project_line(film, &picture, view.film_weights[film], back);
        }
        let [shown, picture, films, back] = [&shown, &picture, &films, &back]
            .map(|values| values.iter().map(|value| f64::from(*value)).collect::<Vec<f64>>());
        let (one, other) = (dot(&shown, &picture), dot(&films, &back));
        let size = dot(&shown, &picture.iter().map(|value| value.abs()).collect::<Vec<f64>>());
        assert!((one - other).abs() < 1e-6 * size, "view {index}: {one} {other}");
        for (pixel, row) in matrix(&request, &problem, index).iter().enumerate() {
            assert!((dot(row, &films) - shown[pixel]).abs() < 1e-5 * shown[pixel].abs().max(0.1), "{pixel}");
        }
    }
}
