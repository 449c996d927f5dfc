//! The rows of a film as it lies on its sheet.

use std::vec::IntoIter;

use super::job::PrintJob;
use super::rows::OpenFilm;
use crate::build_folder::{FilmRows, OpenError};
use crate::volume::CHANNELS;

/// Gives a film's rows as they lie on its sheet, from the top.
pub(super) enum LaidRows {
    Upright(Box<FilmRows>),
    Turned(IntoIter<Vec<u16>>),
}

impl LaidRows {
    /// Opens film `film`, 0 on top.
    ///
    /// # Errors
    /// When it cannot be read: a turned one is read whole.
    pub(super) fn open(job: &PrintJob, film: usize, open: OpenFilm<'_>) -> Result<Self, OpenError> {
        let mut rows = open(film)?;
        if !job.turned {
            return Ok(Self::Upright(Box::new(rows)));
        }
        let rows =
            (0..job.request.stack.height_px).map(|_| rows.next_row()).collect::<Result<Vec<_>, _>>()?;
        Ok(Self::Turned(turned(&rows).into_iter()))
    }

    /// The next row: interleaved red, green and blue, 65,535 for full ink; nothing behind the last of a turned film.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(super) fn next_row(&mut self) -> Result<Vec<u16>, OpenError> {
        match self {
            Self::Upright(rows) => rows.next_row(),
            Self::Turned(rows) => Ok(rows.next().unwrap_or_default()),
        }
    }
}

/// Rows of pixels after a quarter turn clockwise: columns from left to right, each from its lowest pixel up.
fn turned(rows: &[Vec<u16>]) -> Vec<Vec<u16>> {
    let columns = rows.first().map_or(0, |row| row.len() / CHANNELS);
    let mut turned = vec![Vec::with_capacity(rows.len() * CHANNELS); columns];
    for row in rows.iter().rev() {
        let (pixels, _) = row.as_chunks::<CHANNELS>();
        turned.iter_mut().zip(pixels).for_each(|(column, pixel)| column.extend(pixel));
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_edge_goes_to_the_right_and_four_turns_change_nothing() {
        let row = |values: &[u16]| values.iter().flat_map(|&value| [value; CHANNELS]).collect::<Vec<u16>>();
        let rows = [row(&[1, 2, 3]), row(&[4, 5, 6])];
        assert_eq!(turned(&rows), [row(&[4, 1]), row(&[5, 2]), row(&[6, 3])]);
        assert_eq!((0..4).fold(rows.to_vec(), |rows, _| turned(&rows)), rows);
    }
}
