//! Text files: in blocks that many threads read at once, or line by line. No line is read without a limit.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::error::{ModelError, Place};

/// Bytes read at once.
const BLOCK: usize = 8 << 20;
/// Parts of a block, each for one task of the thread pool.
const PARTS: usize = 32;
/// The longest line, in bytes.
pub(super) const LONGEST_LINE: usize = 1 << 20;

/// Reads `file`, the one at `path`, in blocks of whole lines, the first of which has the number `line`. What `read` makes
/// of the parts of a block, of which it is given the numbers of the lines, goes to `take` in the file's order; that says
/// whether more is wanted. Parts of a block are read at once.
pub(super) fn read_blocks<T: Send>(
    path: &Path,
    mut file: File,
    mut line: u64,
    read: impl Fn(Range<u64>, &[u8]) -> T + Sync,
    mut take: impl FnMut(Vec<T>) -> Result<bool, ModelError>,
) -> Result<(), ModelError> {
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    let mut block = Vec::with_capacity(BLOCK);
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
        let lines = counts.iter().map(|count| {
            line += count;
            line - count..line
        });
        let work: Vec<(Range<u64>, &[u8])> = lines.zip(parts.iter().copied()).collect();
        if !take(work.into_par_iter().map(|(lines, part)| read(lines, part)).collect())? {
            return Ok(());
        }
        block.drain(..whole);
    }
}

fn too_long(path: &Path, line: u64) -> ModelError {
    ModelError::damaged(path, Place::Line(line), format!("is longer than {LONGEST_LINE} bytes"))
}

/// The lines of a part; one without an end, which only the file's last can be, counts as well.
fn lines_in(part: &[u8]) -> u64 {
    let ends = part.iter().filter(|byte| **byte == b'\n').count() as u64;
    ends + u64::from(part.last().is_some_and(|byte| *byte != b'\n'))
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

/// The numbers of a line, parted by blanks, commas or semicolons; an error names the word that is none.
pub(super) struct Numbers<'a>(&'a [u8]);

impl<'a> Numbers<'a> {
    pub(super) fn of(line: &'a [u8]) -> Self {
        Self(line)
    }
}

impl Iterator for Numbers<'_> {
    type Item = Result<f64, String>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let begin = self.0.iter().position(|byte| !parts_numbers(byte))?;
        let rest = &self.0[begin..];
        if let Some((number, length)) = plain_number(rest)
            && rest.get(length).is_none_or(parts_numbers)
        {
            self.0 = &rest[length..];
            return Some(Ok(number));
        }
        match fast_float2::parse_partial::<f64, _>(rest) {
            Ok((number, length)) if rest.get(length).is_none_or(parts_numbers) => {
                self.0 = &rest[length..];
                Some(Ok(number))
            }
            _ => {
                let end = rest.iter().position(parts_numbers).unwrap_or(rest.len());
                let word = String::from_utf8_lossy(&rest[..end]);
                self.0 = &rest[end..];
                Some(Err(format!("\"{}\" is no number", word.chars().take(24).collect::<String>())))
            }
        }
    }
}

/// Reads a number of few digits without an exponent, as most are, and tells its length. Its digits and the power of ten are
/// whole numbers below 2^53, so that the one division rounds as it should (Clinger 1990, "How to read floating point
/// numbers accurately").
#[inline]
fn plain_number(text: &[u8]) -> Option<(f64, usize)> {
    const MOST_DIGITS: usize = 15;
    const POWERS: [f64; MOST_DIGITS + 1] =
        [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let begin = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let (mut digits, mut count, mut fraction, mut point) = (0_u64, 0, 0, 0);
    for byte in &text[begin..] {
        match byte {
            b'0'..=b'9' if count < MOST_DIGITS => {
                digits = digits * 10 + u64::from(byte - b'0');
                count += 1;
                fraction += point;
            }
            b'.' if point == 0 => point = 1,
            _ => break,
        }
    }
    let number = digits as f64 / POWERS[fraction];
    let signed = if text.first() == Some(&b'-') { -number } else { number };
    (count > 0).then_some((signed, begin + count + point))
}

#[inline]
fn parts_numbers(byte: &u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b',' | b';')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn numbers(line: &str) -> Result<Vec<f64>, String> {
        Numbers::of(line.as_bytes()).collect()
    }

    proptest! {
        #[test]
        fn numbers_are_those_that_the_language_reads(values in proptest::collection::vec(any::<f64>(), 0..6)) {
            let line: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let known: Vec<f64> = line.iter().map(|word| word.parse().unwrap()).collect();
            prop_assert_eq!(bits(&numbers(&line.join(" ;, ")).unwrap()), bits(&known));
        }
    }

    #[test]
    fn what_is_no_number_is_named() {
        assert_eq!(numbers(" +1.5,.5;-2e3\t7 \r").unwrap(), [1.5, 0.5, -2000.0, 7.0]);
        assert!(numbers("inf NaN").unwrap()[1].is_nan());
        for (line, word) in
            [("1 2x 3", "2x"), ("1 - 2", "-"), ("1e", "1e"), ("0x10", "0x10"), ("1.2.3", "1.2.3")]
        {
            assert_eq!(numbers(line).unwrap_err(), format!("\"{word}\" is no number"));
        }
    }
}
