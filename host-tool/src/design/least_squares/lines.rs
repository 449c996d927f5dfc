//! Films kept as row, film, column, so that what one ray meets lies together.

use rayon::prelude::*;

use super::Problem;
use crate::design::sixteen::from_sixteen_bits;

/// Brings the films from film, row, column to row, film, column.
pub(super) fn by_row(films: &mut [f32], problem: &Problem) {
    let (width, count) = (problem.width, problem.films);
    let mut lines = vec![0.0; films.len()];
    lines.par_chunks_mut(count * width).enumerate().for_each(|(row, lines)| {
        for (film, line) in lines.chunks_exact_mut(width).enumerate() {
            let start = (film * problem.height + row) * width;
            line.copy_from_slice(&films[start..start + width]);
        }
    });
    films.copy_from_slice(&lines);
}

/// Writes `lines`, the ink of row, film, column in 16 bits, as film, row, column.
pub(super) fn by_film(lines: &[u16], films: &mut [f32], problem: &Problem) {
    let (width, count) = (problem.width, problem.films);
    films.par_chunks_mut(problem.height * width).enumerate().for_each(|(film, plane)| {
        for (row, line) in plane.chunks_exact_mut(width).enumerate() {
            let start = (row * count + film) * width;
            let inks = line.iter_mut().zip(&lines[start..start + width]);
            inks.for_each(|(ink, bits)| *ink = from_sixteen_bits(*bits));
        }
    });
}
