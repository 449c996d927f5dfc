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
    read: impl Fn(Range<u64>, &[u8]) -> T + Send + Sync,
    mut take: impl FnMut(Vec<T>) -> Result<bool, ModelError>,
) -> Result<(), ModelError> {
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    let mut fill = |block: &mut Vec<u8>| {
        let room = (BLOCK - block.len()) as u64;
        file.by_ref().take(room).read_to_end(block)
    };
    let (mut block, mut next) = (Vec::with_capacity(BLOCK), Vec::with_capacity(BLOCK));
    let mut ended = fill(&mut block).map_err(unreadable)? == 0;
    loop {
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
            ended = fill(&mut block).map_err(unreadable)? == 0;
            continue;
        }
        next.clear();
        next.extend_from_slice(&block[whole..]);
        let parts = parts(&block[..whole]);
        let counts: Vec<u64> = parts.par_iter().map(|part| lines_in(part)).collect();
        let lines = counts.iter().map(|count| {
            line += count;
            line - count..line
        });
        let work: Vec<(Range<u64>, &[u8])> = lines.zip(parts.iter().copied()).collect();
        // The next block comes while this one is read.
        let (made, got) = rayon::join(
            || work.into_par_iter().map(|(lines, part)| read(lines, part)).collect(),
            || fill(&mut next),
        );
        if !take(made)? {
            return Ok(());
        }
        ended = got.map_err(unreadable)? == 0;
        std::mem::swap(&mut block, &mut next);
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

/// The lines of a text, each with all that follows it.
pub(super) struct TextLines<'a>(&'a [u8]);

/// A line of a text, and how long it is without its end; the text goes on behind it.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    text: &'a [u8],
    length: usize,
}

impl<'a> TextLines<'a> {
    pub(super) fn of(text: &'a [u8]) -> Self {
        Self(text)
    }
}

impl<'a> Iterator for TextLines<'a> {
    type Item = Line<'a>;

    #[inline]
    fn next(&mut self) -> Option<Line<'a>> {
        let text = self.0;
        let end = text.iter().position(|byte| *byte == b'\n');
        self.0 = text.get(end.map_or(text.len(), |end| end + 1)..)?;
        (!text.is_empty()).then_some(Line { text, length: end.unwrap_or(text.len()) })
    }
}

impl<'a> Line<'a> {
    /// The line alone.
    pub(super) fn bytes(self) -> &'a [u8] {
        &self.text[..self.length]
    }

    /// The numbers of the line.
    #[inline]
    pub(super) fn numbers(self) -> Numbers<'a> {
        Numbers { text: self.text, left: self.length }
    }
}

impl<'a> From<&'a [u8]> for Line<'a> {
    fn from(line: &'a [u8]) -> Self {
        Self { text: line, length: line.len() }
    }
}

/// The numbers of a line, parted by blanks, commas or semicolons; an error names the word that is none.
pub(super) struct Numbers<'a> {
    text: &'a [u8],
    /// Bytes of the line that are left.
    left: usize,
}

impl<'a> Numbers<'a> {
    /// Goes on behind the next bytes.
    #[inline]
    fn pass(&mut self, bytes: usize) {
        self.text = &self.text[bytes..];
        self.left -= bytes;
    }
}

impl Iterator for Numbers<'_> {
    type Item = Result<f64, String>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        // The end of a line parts numbers, too: no number goes beyond it.
        let begin = self.text[..self.left].iter().position(|byte| !parts_numbers(byte))?;
        self.pass(begin);
        let is_whole = |number: &(f64, usize)| self.text.get(number.1).is_none_or(parts_numbers);
        let known = short_number(self.text).filter(is_whole);
        let known = known.or_else(|| plain_number(self.text).filter(is_whole));
        if let Some((number, length)) = known {
            self.pass(length);
            return Some(Ok(number));
        }
        match fast_float2::parse_partial::<f64, _>(self.text) {
            Ok(number) if is_whole(&number) => {
                self.pass(number.1);
                Some(Ok(number.0))
            }
            _ => {
                let end = self.text.iter().position(parts_numbers).unwrap_or(self.text.len());
                let word = String::from_utf8_lossy(&self.text[..end]);
                let wrong = format!("\"{}\" is no number", word.chars().take(24).collect::<String>());
                self.pass(end);
                Some(Err(wrong))
            }
        }
    }
}

/// The most digits of a number that is a whole number below 2^53 over a power of ten.
const MOST_DIGITS: usize = 15;
const POWERS: [f64; MOST_DIGITS + 1] =
    [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// As [`plain_number`], all digits at once: where the number and what ends it are seven bytes with a point, or eight
/// without, behind a sign.
#[inline]
fn short_number(text: &[u8]) -> Option<(f64, usize)> {
    const ZEROS: u64 = u64::from_le_bytes([b'0'; 8]);
    /// Of eight bytes, how many before the first that is above 9.
    fn digits_before_other(bytes: u64) -> usize {
        const ABOVE_NINE: u64 = u64::from_le_bytes([0x80 - 10; 8]);
        const HIGHEST_BITS: u64 = u64::from_le_bytes([0x80; 8]);
        // What a byte above 9 carries over only reaches those behind it.
        ((bytes.wrapping_add(ABOVE_NINE) | bytes) & HIGHEST_BITS).trailing_zeros() as usize / 8
    }
    let is_negative = text.first() == Some(&b'-');
    let sign = usize::from(is_negative);
    let digits = u64::from_le_bytes(*text.get(sign..)?.first_chunk()?) ^ ZEROS;
    let whole = digits_before_other(digits);
    if whole == 8 {
        return None;
    }
    let has_point = (digits >> (8 * whole)) as u8 == b'.' ^ b'0';
    let below = (1 << (8 * whole)) - 1;
    let joined = if has_point { (digits & below) | ((digits >> 8) & !below) } else { digits };
    let count = digits_before_other(joined);
    if count == 0 || count == 8 {
        return None;
    }
    // The first digit is the lowest byte: pairs, then fours, then all eight are put together.
    let eight = joined << (64 - 8 * count);
    let pairs = (eight.wrapping_mul(10 << 8 | 1) >> 8) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul(100 << 16 | 1) >> 16) & 0x0000_ffff_0000_ffff;
    let number = (fours.wrapping_mul(10_000 << 32 | 1) >> 32) as u32;
    let number = f64::from(number) / POWERS[count - whole];
    Some((if is_negative { -number } else { number }, sign + count + usize::from(has_point)))
}

/// Reads a number of few digits without an exponent, as most are, and tells its length. Its digits and the power of ten are
/// whole numbers below 2^53, so that the one division rounds as it should (Clinger 1990, "How to read floating point
/// numbers accurately").
#[inline]
fn plain_number(text: &[u8]) -> Option<(f64, usize)> {
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
        Line::from(line.as_bytes()).numbers().collect()
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

    proptest! {
        #[test]
        fn decimals_are_those_that_the_language_reads_whatever_stands_behind(
            words in proptest::collection::vec("[-+]?([0-9]{1,9}[.]?[0-9]{0,8}|[.][0-9]{1,8})", 1..5),
            behind in "( ?[0-9.,;e]{0,3}\n)?[0-9.\n ]{0,9}",
        ) {
            let line = words.join(" ");
            let text = format!("{line}\n{behind}");
            let known: Vec<u64> = words.iter().map(|word| word.parse::<f64>().unwrap().to_bits()).collect();
            let bits = |line: Line<'_>| -> Vec<u64> {
                line.numbers().map(|number| number.unwrap().to_bits()).collect()
            };
            prop_assert_eq!(bits(TextLines::of(text.as_bytes()).next().unwrap()), known.clone());
            prop_assert_eq!(bits(Line::from(line.as_bytes())), known);
        }
    }

    #[test]
    fn lines_are_those_of_the_text() {
        for text in ["", "\n", "a", "a\n", "a\n\nb", "a\r\nb\n\n"] {
            let wanted: Vec<&[u8]> =
                text.split_inclusive('\n').map(|line| line.trim_end_matches('\n').as_bytes()).collect();
            assert_eq!(
                TextLines::of(text.as_bytes()).map(Line::bytes).collect::<Vec<_>>(),
                wanted,
                "{text:?}"
            );
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
