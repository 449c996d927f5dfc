//! Films kept as row, film, column, so that what one ray meets lies together.

use rayon::prelude::*;

use super::Problem;

/// Brings the volume from film, row, column to row, film, column; returns a copy of it.
pub(super) fn by_row(volume: &mut [f32], problem: &Problem) -> Vec<f32> {
    let (width, films) = (problem.width, problem.films);
    let mut lines = vec![0.0; volume.len()];
    lines.par_chunks_mut(films * width).enumerate().for_each(|(row, lines)| {
        for (film, line) in lines.chunks_exact_mut(width).enumerate() {
            let start = (film * problem.height + row) * width;
            line.copy_from_slice(&volume[start..start + width]);
        }
    });
    volume.copy_from_slice(&lines);
    lines
}

/// Brings the volume back from row, film, column to film, row, column; `lines` lends its memory.
pub(super) fn by_film(volume: &mut [f32], lines: &mut [f32], problem: &Problem) {
    let (width, films) = (problem.width, problem.films);
    lines.copy_from_slice(volume);
    volume.par_chunks_mut(problem.height * width).enumerate().for_each(|(film, plane)| {
        for (row, line) in plane.chunks_exact_mut(width).enumerate() {
            let start = (row * films + film) * width;
            line.copy_from_slice(&lines[start..start + width]);
        }
    });
}
