//! A sheet's rows of dots, compressed into strips.

use rayon::prelude::*;

use super::job::{PrintJob, Sheet};
use super::rows::{OpenFilm, SheetRows};
use super::separation::Separation;
use super::write::PrintError;
use crate::deflate::{Deflater, Piece, Stream};
use crate::volume::CHANNELS;

/// How a kind of file has its rows.
#[derive(Clone, Copy)]
pub(super) struct RowForm {
    /// Bytes of a row.
    pub(super) bytes: usize,
    /// Puts a row of dots into its bytes before compression.
    pub(super) put: fn(&[u16], &mut [u8]),
}

/// Some rows as a zlib stream of their own.
pub(super) struct Strip {
    pub(super) rows: usize,
    pub(super) bytes: Vec<u8>,
}

/// Gives all rows of `sheet` to `take`, from the top, `most_rows` in a strip but for the last. A row that is there
/// several times is compressed once.
///
/// # Errors
/// Fails when a film cannot be read, and when `take` does.
pub(super) fn strips(
    (job, sheet): (&PrintJob, &Sheet),
    open: OpenFilm<'_>,
    separation: &dyn Separation,
    form: RowForm,
    most_rows: usize,
    take: &mut dyn FnMut(Strip) -> Result<(), PrintError>,
) -> Result<(), PrintError> {
    let rows = SheetRows::new(job, sheet);
    let samples = sheet.width * CHANNELS;
    let (mut stream, mut held) = (Stream::new(), 0);
    rows.each(open, separation, &mut |batch| {
        let workspace = || (Deflater::new(), vec![0u16; samples], vec![0u8; form.bytes]);
        let pieces: Vec<Piece> = batch
            .par_iter()
            .map_init(workspace, |(deflater, dots, bytes), row| {
                rows.paint(row, dots);
                (form.put)(dots, bytes);
                deflater.piece(bytes)
            })
            .collect();
        for (piece, row) in pieces.iter().zip(batch) {
            for _ in 0..row.repeat {
                stream.push(piece);
                held += 1;
                if held == most_rows {
                    let bytes = std::mem::replace(&mut stream, Stream::new()).finish();
                    take(Strip { rows: std::mem::take(&mut held), bytes })?;
                }
            }
        }
        Ok::<(), PrintError>(())
    })?;
    match held {
        0 => Ok(()),
        rows => take(Strip { rows, bytes: stream.finish() }),
    }
}
