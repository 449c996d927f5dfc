//! Films kept as row, film, column, so that what one ray meets lies together.

use rayon::prelude::*;

use super::Problem;

/// Returns the volume (film, row, column) as row, film, column.
pub(super) fn by_row(volume: &[f32], problem: &Problem) -> Vec<f32> {
    let (width, films) = (problem.width, problem.films());
    let mut lines = vec![0.0; volume.len()];
    lines.par_chunks_mut(films * width).enumerate().for_each(|(row, lines)| {
        for (film, line) in lines.chunks_exact_mut(width).enumerate() {
            let start = (film * problem.height + row) * width;
            line.copy_from_slice(&volume[start..start + width]);
        }
    });
    lines
}

/// Writes what is kept as row, film, column into the volume.
pub(super) fn by_film(lines: &[f32], volume: &mut [f32], problem: &Problem) {
    let (width, films) = (problem.width, problem.films());
    volume.par_chunks_mut(problem.height * width).enumerate().for_each(|(film, plane)| {
        for (row, line) in plane.chunks_exact_mut(width).enumerate() {
            let start = (row * films + film) * width;
            line.copy_from_slice(&lines[start..start + width]);
        }
    });
}
