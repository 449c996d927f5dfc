//! Rows of dots, compressed into strips as they come.

use rayon::prelude::*;

use super::write::PrintError;
use crate::deflate::{Deflater, Piece, Stream};

/// How a kind of file has its rows.
#[derive(Clone, Copy)]
pub(super) struct RowForm {
    /// Samples of a row.
    pub(super) samples: usize,
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

/// Rows that become strips.
pub(super) struct Strips {
    form: RowForm,
    most_rows: usize,
    stream: Stream,
    held: usize,
}

impl Strips {
    /// Begins; a strip has `most_rows` rows, but for the last.
    pub(super) fn new(form: RowForm, most_rows: usize) -> Self {
        Self { form, most_rows, stream: Stream::new(), held: 0 }
    }

    /// Goes on with `rows`, each of which `paint` paints and is there `repeat` times. A row that is there several times is
    /// compressed once. What is whole goes to `take`.
    ///
    /// # Errors
    /// Fails when `take` does.
    pub(super) fn push<R: Sync>(
        &mut self,
        rows: &[R],
        repeat: impl Fn(&R) -> usize,
        paint: impl Fn(&R, &mut [u16]) + Sync,
        mut take: impl FnMut(Strip) -> Result<(), PrintError>,
    ) -> Result<(), PrintError> {
        let form = self.form;
        let workspace = || (Deflater::new(), vec![0u16; form.samples], vec![0u8; form.bytes]);
        let pieces: Vec<Piece> = rows
            .par_iter()
            .map_init(workspace, |(deflater, dots, bytes), row| {
                paint(row, dots);
                (form.put)(dots, bytes);
                deflater.piece(bytes)
            })
            .collect();
        for (piece, row) in pieces.iter().zip(rows) {
            for _ in 0..repeat(row) {
                self.stream.push(piece);
                self.held += 1;
                if self.held == self.most_rows {
                    take(self.strip())?;
                }
            }
        }
        Ok(())
    }

    /// What is left, if anything is.
    pub(super) fn rest(&mut self) -> Option<Strip> {
        (self.held > 0).then(|| self.strip())
    }

    fn strip(&mut self) -> Strip {
        let bytes = std::mem::replace(&mut self.stream, Stream::new()).finish();
        Strip { rows: std::mem::take(&mut self.held), bytes }
    }
}
