//! Text files: in blocks that many threads read at once, or line by line. No line is read without a limit.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::error::{ModelError, Place};

/// Bytes read at once.
const BLOCK: usize = 8 << 20;
/// Parts of a block, each for one task of the thread pool.
const PARTS: usize = 32;
/// The longest line, in bytes.
pub(super) const LONGEST_LINE: usize = 1 << 20;

/// Reads the file at `path` in blocks of whole lines; `read` is given the number of the first line of its part, from 1,
/// and the part. Parts of a block are read at once, and the first error in the file is the one that is told.
pub(super) fn read_blocks(
    path: &Path,
    mut file: File,
    read: impl Fn(u64, &[u8]) -> Result<(), ModelError> + Sync,
) -> Result<(), ModelError> {
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    let mut block = Vec::with_capacity(BLOCK);
    let mut line = 1;
    loop {
        let room = (BLOCK - block.len()) as u64;
        let got = file.by_ref().take(room).read_to_end(&mut block).map_err(unreadable)?;
        let ended = got == 0;
        let whole = if ended {
            block.len()
        } else {
            block.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1)
        };
        if whole == 0 {
            if ended {
                return Ok(());
            }
            if block.len() > LONGEST_LINE {
                return Err(too_long(path, line));
            }
            continue;
        }
        let parts = parts(&block[..whole]);
        let counts: Vec<u64> = parts.par_iter().map(|part| lines_in(part)).collect();
        let firsts = counts.iter().scan(line, |next, count| Some(std::mem::replace(next, *next + count)));
        let work: Vec<(u64, &[u8])> = firsts.zip(parts.iter().copied()).collect();
        let results: Vec<Result<(), ModelError>> =
            work.par_iter().map(|(first, part)| read(*first, part)).collect();
        results.into_iter().collect::<Result<(), _>>()?;
        line += counts.iter().sum::<u64>();
        block.drain(..whole);
    }
}

fn too_long(path: &Path, line: u64) -> ModelError {
    ModelError::damaged(path, Place::Line(line), format!("is longer than {LONGEST_LINE} bytes"))
}

fn lines_in(part: &[u8]) -> u64 {
    part.iter().filter(|byte| **byte == b'\n').count() as u64
}

/// Cuts a block behind line ends into about [`PARTS`] parts.
fn parts(mut block: &[u8]) -> Vec<&[u8]> {
    let size = block.len().div_ceil(PARTS);
    let mut parts = Vec::new();
    while !block.is_empty() {
        let behind = block.iter().skip(size).position(|byte| *byte == b'\n').map(|at| size + at + 1);
        let (part, rest) = block.split_at(behind.unwrap_or(block.len()));
        parts.push(part);
        block = rest;
    }
    parts
}

/// A text read line by line.
pub(super) struct Lines {
    path: PathBuf,
    reader: BufReader<File>,
    line: Vec<u8>,
    number: u64,
}

impl Lines {
    /// Reads `reader`, of the file at `path`, from where it stands; the next line has the number `next`.
    pub(super) fn new(path: &Path, reader: BufReader<File>, next: u64) -> Self {
        Self { path: path.to_owned(), reader, line: Vec::new(), number: next - 1 }
    }

    /// The next line without its end, or `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<&[u8]>, ModelError> {
        self.line.clear();
        self.number += 1;
        let limit = LONGEST_LINE as u64 + 1;
        let got = self.reader.by_ref().take(limit).read_until(b'\n', &mut self.line);
        let got = got.map_err(|source| ModelError::Unreadable { path: self.path.clone(), source })?;
        if got == 0 {
            return Ok(None);
        }
        if self.line.len() > LONGEST_LINE {
            return Err(too_long(&self.path, self.number));
        }
        Ok(Some(self.line.trim_ascii_end()))
    }

    /// An error in the line that was read last.
    pub(super) fn damaged(&self, what: impl Into<String>) -> ModelError {
        ModelError::damaged(&self.path, Place::Line(self.number), what)
    }
}

/// The words of a line, parted by blanks, commas or semicolons.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &str> {
    let parted = |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, b',' | b';');
    line.split(parted).filter(|word| !word.is_empty()).map(|word| std::str::from_utf8(word).unwrap_or("?"))
}
