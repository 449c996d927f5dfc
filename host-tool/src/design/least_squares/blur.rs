//! Films whose light spreads, by their print or because nobody knows quite where they lie.
//!
//! A film that lies astray by a random shift shows its light spread on the average: with B the print's own spread and
//! S that of the shifts, `G = S B`. What its pixels scatter about that average is `w^2 (|B V|^2 - |G V|^2)` summed
//! over them, with w the film's weight in the view. For normal shifts of each film by itself both are exact to all
//! orders, but for what leaves the film at its edges.

use rayon::prelude::*;

use super::Problem;
use super::kernel::sum_of_products;
use crate::simd::vectorised;
use crate::spread::Spread;

/// How one film's light spreads.
#[derive(Clone, Debug)]
pub(in crate::design) struct FilmBlur {
    /// By the print and by the film's errors together: G.
    pub(in crate::design) expected: Spread,
    /// By the print, twice in turn: B^T B.
    pub(in crate::design) print_twice: Spread,
    /// How much counts what the film's errors scatter: its squared weights summed over the views.
    pub(in crate::design) noise: f32,
}

/// Rows that one task spreads.
const ROWS_AT_ONCE: usize = 16;

/// The light of all films (row, film, column) and what comes back to them.
pub(super) struct Blurred {
    /// The expected light; after [`Blurred::turn`], what comes back to it.
    light: Vec<f32>,
    /// The volume after twice the print's spread, where that is not the volume itself.
    crisp: Vec<f32>,
}

impl Blurred {
    /// Memory for the light of the problem's films, where it spreads.
    pub(super) fn new(problem: &Problem) -> Option<Self> {
        if problem.blurs.is_empty() {
            return None;
        }
        let len = problem.films * problem.height * problem.width;
        let prints_spread = problem.blurs.iter().any(|blur| blur.noise > 0.0 && !blur.print_twice.is_none());
        Some(Self { light: vec![0.0; len], crisp: vec![0.0; if prints_spread { len } else { 0 }] })
    }

    /// The expected light of all films.
    pub(super) fn light(&self) -> &[f32] {
        &self.light
    }

    /// Spreads the light of `volume`; returns what it scatters.
    pub(super) fn renew(&mut self, problem: &Problem, volume: &[f32]) -> f64 {
        let size = problem.films * problem.width * ROWS_AT_ONCE;
        let mut crisp: Vec<&mut [f32]> = self.crisp.chunks_mut(size).collect();
        crisp.resize_with(self.light.len().div_ceil(size), Default::default);
        let tasks = self.light.par_chunks_mut(size).zip(crisp).enumerate();
        let scattered: Vec<f64> = tasks
            .map(|(chunk, (light, crisp))| {
                vectorised(
                    #[inline(always)]
                    || spread_rows(problem, volume, chunk * ROWS_AT_ONCE, light, crisp),
                )
            })
            .collect();
        scattered.iter().sum()
    }

    /// Spreads a picture as the film does whose light spreads most.
    pub(super) fn spread(&self, problem: &Problem, picture: &mut [f32]) {
        let widest = problem.blurs.iter().map(|blur| &blur.expected).max_by_key(|spread| spread.pixels());
        if let Some(widest) = widest {
            picture.copy_from_slice(&widest.of_film(picture, problem.width));
        }
    }

    /// Turns the expected light into half the loss's slope along it; `slopes` are the views' answers.
    pub(super) fn turn(&mut self, problem: &Problem, slopes: Vec<&[f32]>) {
        let (width, films) = (problem.width, problem.films);
        let size = films * width * ROWS_AT_ONCE;
        self.light.par_chunks_mut(size).enumerate().for_each(|(chunk, lines)| {
            let mut scratch = vec![0.0; width];
            vectorised(
                #[inline(always)]
                || {
                    for (index, line) in lines.chunks_exact_mut(width).enumerate() {
                        let (row, film) = (chunk * ROWS_AT_ONCE + index / films, index % films);
                        let noise = problem.noise(film);
                        line.iter_mut().for_each(|light| *light *= -noise);
                        for (view, slopes) in problem.views.iter().zip(&slopes) {
                            let weight = view.film_weights[film];
                            view.rays.back_project_row(film, row, slopes, weight, line, &mut scratch);
                        }
                    }
                },
            );
        });
    }

    /// After [`Blurred::turn`]: writes half the loss's slope along one line of one film, which is `ahead`.
    #[inline(always)]
    pub(super) fn pull_back(
        &self,
        problem: &Problem,
        film: usize,
        row: usize,
        ahead: &[f32],
        gradient: &mut [f32],
        scratch: &mut [f32],
    ) {
        let place = |row: usize| line_of(problem, film, row);
        let blur = &problem.blurs[film];
        blur.expected.write_row(row, problem.height, |row| &self.light[place(row)], gradient, scratch);
        let crisp = self.crisp.get(place(row)).unwrap_or(ahead);
        gradient.iter_mut().zip(crisp).for_each(|(slope, crisp)| *slope += blur.noise * crisp);
    }
}

fn line_of(problem: &Problem, film: usize, row: usize) -> std::ops::Range<usize> {
    let start = (row * problem.films + film) * problem.width;
    start..start + problem.width
}

#[inline(always)]
fn spread_rows(problem: &Problem, volume: &[f32], first: usize, light: &mut [f32], crisp: &mut [f32]) -> f64 {
    let width = problem.width;
    let mut scratch = vec![0.0; width];
    let mut scattered = 0.0;
    for (index, light) in light.chunks_exact_mut(width).enumerate() {
        let (row, film) = (first + index / problem.films, index % problem.films);
        let blur = &problem.blurs[film];
        let line = |row: usize| &volume[line_of(problem, film, row)];
        blur.expected.write_row(row, problem.height, line, light, &mut scratch);
        let volume = line(row);
        let crisp = match crisp.get_mut(index * width..(index + 1) * width) {
            Some(crisp) => {
                blur.print_twice.write_row(row, problem.height, line, crisp, &mut scratch);
                &*crisp
            }
            None => volume,
        };
        scattered += f64::from(blur.noise) * (sum_of_products(volume, crisp) - sum_of_products(light, light));
    }
    scattered
}
