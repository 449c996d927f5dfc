//! Text with a point on each line: `x y z`, `x y z grey`, `x y z r g b`, `x y z r g b` with a normal behind, or
//! `x y z intensity r g b` as scanners write it.
//!
//! Numbers are parted by blanks, commas or semicolons. Lines that begin with `#` or `//`, empty lines, a first line of
//! names and a first line with the number of points are passed over. Colours are 0 to 255, or 0 to 1 where all of the
//! first lines' are.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use super::error::{ModelError, Place};
use super::text::{Line, TextLines, read_blocks};
use super::{POINTS_AT_ONCE, nearest_code, open};
use crate::object::shape::{Point, Sink, UNCOLOURED};

/// Bytes from which the columns are made out.
const SAMPLE: u64 = 1 << 16;
/// The most numbers on a line that are looked at.
const MOST_NUMBERS: usize = 10;
/// Numbers on a line of a scanner that writes the intensity before the colour.
const WITH_INTENSITY: usize = 7;

const HELP: &str = "write a point on each line: x y z r g b";

/// What stands in the columns.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Columns {
    /// Numbers on a line.
    count: usize,
    /// The first line with a point, from 1.
    first_line: u64,
    /// What colours are multiplied by to become 0 to 255.
    full: f64,
}

/// Reads the points at `path` into `sink`.
pub(super) fn read(path: &Path, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
    let (file, _) = open(path)?;
    let columns = columns(path, &file)?;
    let read = |lines: Range<u64>, part: &[u8]| {
        let mut points = Vec::with_capacity(POINTS_AT_ONCE);
        for (line, number) in TextLines::of(part).zip(lines.start..) {
            if number < columns.first_line || is_comment(line.bytes()) {
                continue;
            }
            points.push(columns.point(line).map_err(|what| damaged(path, number, what))?);
            if points.len() == POINTS_AT_ONCE {
                sink.points(&points);
                points.clear();
            }
        }
        sink.points(&points);
        Ok(())
    };
    read_blocks(path, open(path)?.0, 1, read, |parts| {
        parts.into_iter().collect::<Result<(), ModelError>>()?;
        Ok(true)
    })?;
    Ok(match columns.count {
        3 => vec!["the text has no colours: its points are white".to_owned()],
        _ if columns.full == 1.0 => Vec::new(),
        _ => vec!["the text's colours go from 0 to 1, as its first lines show".to_owned()],
    })
}

fn damaged(path: &Path, line: u64, what: String) -> ModelError {
    ModelError::Damaged { path: path.to_owned(), place: Place::Line(line), what, help: HELP }
}

fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    line.is_empty() || line.starts_with(b"#") || line.starts_with(b"//")
}

/// Makes out the columns from the first lines.
fn columns(path: &Path, file: &File) -> Result<Columns, ModelError> {
    let mut sample = Vec::new();
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    file.take(SAMPLE).read_to_end(&mut sample).map_err(unreadable)?;
    if sample.len() as u64 == SAMPLE {
        let whole = sample.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        sample.truncate(whole);
    }
    let lines = sample.split(|byte| *byte == b'\n').zip(1..).filter(|(line, _)| !is_comment(line));
    let mut found: Option<Columns> = None;
    let mut largest: f64 = 0.0;
    for (index, (line, number)) in lines.enumerate() {
        let mut numbers = [0.0; MOST_NUMBERS];
        let count = match numbers_of(line.into(), &mut numbers) {
            // A first line of names, or with the number of points.
            Err(_) | Ok(1) if index == 0 => continue,
            Err(what) => return Err(damaged(path, number, what)),
            Ok(count) => count,
        };
        if found.is_none() && has_decimal_commas(line) {
            let what =
                "has commas within or between numbers that blanks part as well: write 0.5 instead of 0,5";
            return Err(damaged(path, number, what.to_owned()));
        }
        let columns = *found.get_or_insert(Columns { count, first_line: number, full: 1.0 });
        let colours = numbers.iter().take(count.min(columns.colours() + 3)).skip(columns.colours());
        largest = colours.copied().fold(largest, f64::max);
    }
    let Some(columns) = found else {
        return Err(damaged(path, 1, "there is no point in the text".to_owned()));
    };
    if !matches!(columns.count, 3 | 4 | 6 | 7 | 9) {
        let what = format!("has {} numbers, not 3, 4, 6, 7 or 9", columns.count);
        return Err(damaged(path, columns.first_line, what));
    }
    let full = if largest > 0.0 && largest <= 1.0 { 255.0 } else { 1.0 };
    Ok(Columns { full, ..columns })
}

/// Whether commas stand between digits although blanks or semicolons part numbers.
fn has_decimal_commas(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    let within = |three: &[u8; 3]| three[0].is_ascii_digit() && three[1] == b',' && three[2].is_ascii_digit();
    let parts = |two: &[u8; 2]| two[0].is_ascii_digit() && (two[1] == b';' || two[1].is_ascii_whitespace());
    line.array_windows().any(within) && line.array_windows().any(parts)
}

/// Reads the numbers of a line; returns how many there are, at most [`MOST_NUMBERS`] being looked at.
#[inline]
fn numbers_of(line: Line<'_>, numbers: &mut [f64; MOST_NUMBERS]) -> Result<usize, String> {
    let mut count = 0;
    for (found, number) in line.numbers().zip(numbers.iter_mut()) {
        *number = found?;
        count += 1;
    }
    Ok(count)
}

impl Columns {
    /// The index of the first number of a colour.
    fn colours(self) -> usize {
        if self.count == WITH_INTENSITY { 4 } else { 3 }
    }

    fn point(self, line: Line<'_>) -> Result<Point, String> {
        let mut numbers = [0.0; MOST_NUMBERS];
        let count = numbers_of(line, &mut numbers)?;
        if count != self.count {
            return Err(format!("has {count} numbers, but the first point has {}", self.count));
        }
        let code = |value: f64| nearest_code(value * self.full);
        let [x, y, z, grey, ..] = numbers;
        let colour = match self.count {
            3 => UNCOLOURED,
            4 => [code(grey); 3],
            _ => [0, 1, 2].map(|channel| code(numbers[self.colours() + channel])),
        };
        Ok(Point { position: [x, y, z], colour })
    }
}
