//! Rows of dots, compressed into strips as they come.

use rayon::prelude::*;

use super::write::PrintError;
use crate::deflate::{Deflater, DotDeflater, Piece, Stream};

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

/// Compresses rows of a form, one after the other.
pub(super) struct RowCoder {
    put: fn(&[u16], &mut [u8]),
    samples: Vec<u16>,
    /// A row before compression.
    pub(super) bytes: Vec<u8>,
    pub(super) deflater: Deflater,
    pub(super) dot_deflater: DotDeflater,
}

impl RowCoder {
    pub(super) fn new(form: RowForm) -> Self {
        Self {
            put: form.put,
            samples: vec![0; form.samples],
            bytes: vec![0; form.bytes],
            deflater: Deflater::new(),
            dot_deflater: DotDeflater::new(),
        }
    }

    /// Compresses the row of dots that `paint` paints.
    pub(super) fn painted(&mut self, paint: impl FnOnce(&mut [u16])) -> Piece {
        paint(&mut self.samples);
        (self.put)(&self.samples, &mut self.bytes);
        self.deflater.piece(&self.bytes)
    }
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

    /// Goes on with `rows`, each of which `compress` makes a piece of and is there `repeat` times: that is compressed once.
    /// What is whole goes to `take`.
    ///
    /// # Errors
    /// Fails when `take` does.
    pub(super) fn push<R: Sync>(
        &mut self,
        rows: &[R],
        repeat: impl Fn(&R) -> usize,
        compress: impl Fn(&mut RowCoder, &R) -> Piece + Sync + Send,
        mut take: impl FnMut(Strip) -> Result<(), PrintError>,
    ) -> Result<(), PrintError> {
        let form = self.form;
        let pieces: Vec<Piece> = rows.par_iter().map_init(|| RowCoder::new(form), compress).collect();
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
