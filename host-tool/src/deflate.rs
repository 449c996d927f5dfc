//! Zlib streams put together from rows that were compressed by themselves.
//!
//! A film's pixel is several dots high, so many rows of dots are the same. Each is compressed once, to a piece that ends
//! at a whole byte and refers to nothing before it; a stream repeats pieces as often as their row is there. Pieces are
//! also compressed side by side.

mod dots;
mod huffman;

use flate2::{Compress, Compression, FlushCompress};

pub(crate) use dots::{DotDeflater, FullDots};

/// A row, compressed so that it can stand anywhere in a stream.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    bytes: Vec<u8>,
    adler: u32,
    len: usize,
}

/// Compresses rows, one after the other.
pub(crate) struct Deflater(Compress);

impl Deflater {
    pub(crate) fn new() -> Self {
        // The least level with codes of its own for each row: fixed codes make a blank row nine times as long.
        Self(Compress::new(Compression::new(2), false))
    }

    pub(crate) fn piece(&mut self, row: &[u8]) -> Piece {
        self.0.reset();
        let mut bytes = Vec::with_capacity(row.len() / 64 + 128);
        loop {
            let read = self.0.total_in() as usize;
            // It fails on a stream that was ended, and this one never is.
            let done = self.0.compress_vec(&row[read..], &mut bytes, FlushCompress::Sync);
            let all_read = self.0.total_in() as usize == row.len();
            if done.is_err() || (all_read && bytes.len() < bytes.capacity()) {
                break;
            }
            bytes.reserve(bytes.capacity());
        }
        bytes.shrink_to_fit();
        Piece { bytes, adler: simd_adler32::adler32(&row), len: row.len() }
    }
}

impl Piece {
    /// Nothing.
    pub(crate) fn empty() -> Self {
        Self { bytes: Vec::new(), adler: 1, len: 0 }
    }

    /// Goes on with another.
    pub(crate) fn push(&mut self, other: &Self) {
        self.bytes.extend_from_slice(&other.bytes);
        self.adler = combined(self.adler, other.adler, other.len);
        self.len += other.len;
    }

    /// Bytes that the piece takes.
    pub(crate) fn compressed_len(&self) -> usize {
        self.bytes.len()
    }
}

/// A zlib stream (RFC 1950) of pieces.
#[derive(Clone, Debug)]
pub(crate) struct Stream {
    bytes: Vec<u8>,
    adler: u32,
}

impl Stream {
    pub(crate) fn new() -> Self {
        // A window of 32 KiB, a fast algorithm.
        Self { bytes: vec![0x78, 0x01], adler: 1 }
    }

    /// Goes on with a stream whose pieces so far have this checksum and are elsewhere.
    pub(crate) fn following(adler: u32) -> Self {
        Self { bytes: Vec::new(), adler }
    }

    /// The checksum of the pieces so far.
    pub(crate) fn adler(&self) -> u32 {
        self.adler
    }

    /// The bytes so far, without an end.
    pub(crate) fn so_far(&self) -> &[u8] {
        &self.bytes
    }

    pub(crate) fn push(&mut self, piece: &Piece) {
        self.bytes.extend_from_slice(&piece.bytes);
        self.adler = combined(self.adler, piece.adler, piece.len);
    }

    /// Ends the stream.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        // An empty block that says it is the last.
        self.bytes.extend([0x03, 0x00]);
        self.bytes.extend(self.adler.to_be_bytes());
        self.bytes
    }
}

/// The Adler-32 of two byte strings after each other, from that of each and the length of the second.
fn combined(first: u32, second: u32, second_len: usize) -> u32 {
    const BASE: u64 = 65_521;
    let halves = |sum: u32| (u64::from(sum & 0xffff), u64::from(sum >> 16));
    let ((first_low, first_high), (second_low, second_high)) = (halves(first), halves(second));
    let len = second_len as u64 % BASE;
    // Each sum began at 1 and goes on from the first's end instead.
    let low = (first_low + second_low + BASE - 1) % BASE;
    let high = (first_high + second_high + len * (first_low + BASE - 1)) % BASE;
    (high << 16 | low) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Read;

    proptest! {
        #[test]
        fn a_stream_of_pieces_is_the_rows_as_often_as_they_were_pushed(
            rows in proptest::collection::vec((proptest::collection::vec(any::<u8>(), 0..3000), 1..4usize), 0..8)
        ) {
            let mut deflater = Deflater::new();
            let mut stream = Stream::new();
            let mut wanted = Vec::new();
            for (row, times) in &rows {
                let piece = deflater.piece(row);
                for _ in 0..*times {
                    stream.push(&piece);
                    wanted.extend_from_slice(row);
                }
            }
            let mut read = Vec::new();
            flate2::read::ZlibDecoder::new(stream.finish().as_slice()).read_to_end(&mut read).unwrap();
            prop_assert_eq!(read, wanted);
        }
    }

    #[test]
    fn a_long_even_row_is_small() {
        let piece = Deflater::new().piece(&vec![7; 300_000]);
        assert!(piece.compressed_len() < 1000, "{}", piece.compressed_len());
    }
}
