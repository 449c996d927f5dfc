//! The data of a PLY file: element by element, or in blocks.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use super::header::{Element, Encoding, Header};
use crate::object::model::error::{ModelError, Place};
use crate::object::model::text::{Line, Lines, TextLines, read_blocks};
use crate::object::model::{POINTS_AT_ONCE, open};
use crate::object::shape::{Point, Sink};

/// Bytes of a block.
const BLOCK: usize = 8 << 20;

/// Where the data come from.
pub(super) enum Source<'a> {
    Ascii(AsciiSource),
    Binary(BinarySource<'a>),
}

/// A text with an element on each line.
pub(super) struct AsciiSource {
    lines: Lines,
    record: Record,
}

/// Bytes behind the header.
pub(super) struct BinarySource<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    /// Where the reader stands, and where the file ends.
    at: u64,
    length: u64,
    pub(super) big_endian: bool,
    record: Record,
}

/// The properties of one element.
#[derive(Default)]
pub(super) struct Record {
    /// Of each property its number; of a list the number of its items.
    pub(super) numbers: Vec<f64>,
    /// The items of the list that was asked for.
    pub(super) list: Vec<f64>,
}

impl<'a> Source<'a> {
    /// Reads on from `reader`, which stands behind the header of the file at `path` of `length` bytes.
    pub(super) fn new(path: &'a Path, header: &Header, reader: BufReader<File>, length: u64) -> Self {
        match header.encoding {
            Encoding::Ascii => Self::Ascii(AsciiSource {
                lines: Lines::new(path, reader, header.lines + 1),
                record: Record::default(),
            }),
            Encoding::Binary { big_endian } => Self::Binary(BinarySource {
                path,
                reader,
                at: header.bytes,
                length,
                big_endian,
                record: Record::default(),
            }),
        }
    }

    /// The next element's properties, with the items of the list of index `list`.
    pub(super) fn record(&mut self, element: &Element, list: usize) -> Result<&Record, ModelError> {
        match self {
            Self::Ascii(source) => source.record(element, list),
            Self::Binary(source) => source.record(element, list),
        }
    }

    /// Passes over all of an element.
    pub(super) fn pass(&mut self, element: &Element) -> Result<(), ModelError> {
        for _ in 0..element.count {
            self.record(element, usize::MAX)?;
        }
        Ok(())
    }

    /// An error at the element that was read last.
    pub(super) fn damaged(&self, what: impl Into<String>) -> ModelError {
        match self {
            Self::Ascii(source) => source.lines.damaged(what),
            Self::Binary(source) => ModelError::damaged(source.path, Place::Byte(source.at), what),
        }
    }
}

impl AsciiSource {
    /// Hands on what `point` makes of the numbers of the `element`s behind the header of the file at `path`, which are its
    /// last and have no lists, from all threads.
    pub(super) fn points(
        path: &Path,
        header: &Header,
        element: &Element,
        point: impl Fn(&[f64]) -> Point + Sync,
        sink: &dyn Sink,
    ) -> Result<(), ModelError> {
        let (mut file, _) = open(path)?;
        let sought = file.seek(SeekFrom::Start(header.bytes));
        sought.map_err(|source| ModelError::Unreadable { path: path.to_owned(), source })?;
        let first_line = header.lines + 1;
        let read = |lines: Range<u64>, part: &[u8]| {
            let mut numbers = vec![0.0; element.properties.len()];
            let (mut points, mut handed_on) = (Vec::with_capacity(POINTS_AT_ONCE), 0);
            // No line has more than one element: where all lines so far are not too many, no point is.
            let all_are_wanted = lines.end - first_line <= element.count;
            for (line, number) in TextLines::of(part).zip(lines.start..) {
                if line.bytes().trim_ascii_end().is_empty() {
                    continue;
                }
                match fill(&mut numbers, line, element) {
                    Ok(()) => points.push(point(&numbers)),
                    Err(what) => return (handed_on, points, Some((number, what))),
                }
                if all_are_wanted && points.len() == POINTS_AT_ONCE {
                    sink.points(&points);
                    handed_on += points.len() as u64;
                    points.clear();
                }
            }
            (handed_on, points, None)
        };
        let mut left = element.count;
        read_blocks(path, file, first_line, read, |parts| {
            for (handed_on, mut points, wrong) in parts {
                left -= handed_on;
                points.truncate(usize::try_from(left).unwrap_or(usize::MAX));
                left -= points.len() as u64;
                // What stands behind the last element is of no concern.
                if let (Some((number, what)), true) = (wrong, left > 0) {
                    return Err(ModelError::damaged(path, Place::Line(number), what));
                }
                sink.points(&points);
            }
            Ok(left > 0)
        })?;
        match left {
            0 => Ok(()),
            _ => {
                let what = format!("the file ends before its last {}", element.name);
                Err(ModelError::damaged(path, Place::Line(header.lines + element.count - left + 1), what))
            }
        }
    }

    fn record(&mut self, element: &Element, list: usize) -> Result<&Record, ModelError> {
        let Self { lines, record, .. } = self;
        let line = loop {
            match lines.next()? {
                Some([]) => {}
                Some(line) => break line,
                None => return Err(lines.damaged(format!("the file ends before its last {}", element.name))),
            }
        };
        match record.read_line(line.into(), element, list) {
            Ok(()) => Ok(record),
            Err(what) => Err(lines.damaged(what)),
        }
    }
}

/// Reads the numbers of an element without lists from its line.
#[inline]
fn fill(numbers: &mut [f64], line: Line<'_>, element: &Element) -> Result<(), String> {
    let mut found = line.numbers();
    for number in numbers {
        *number = found.next().unwrap_or_else(|| Err(too_few(element)))?;
    }
    Ok(())
}

fn too_few(element: &Element) -> String {
    format!("a {} has too few numbers", element.name)
}

impl Record {
    #[inline]
    fn read_line(&mut self, line: Line<'_>, element: &Element, list: usize) -> Result<(), String> {
        self.numbers.clear();
        self.list.clear();
        let mut numbers = line.numbers();
        let mut number = || numbers.next().unwrap_or_else(|| Err(too_few(element)));
        for (index, property) in element.properties.iter().enumerate() {
            let first = number()?;
            self.numbers.push(first);
            if property.list.is_some() {
                // A list longer than its line ends in an error there.
                for _ in 0..first.max(0.0) as u64 {
                    let item = number()?;
                    if index == list {
                        self.list.push(item);
                    }
                }
            }
        }
        Ok(())
    }
}

impl BinarySource<'_> {
    fn record(&mut self, element: &Element, list: usize) -> Result<&Record, ModelError> {
        self.record.numbers.clear();
        self.record.list.clear();
        for (index, property) in element.properties.iter().enumerate() {
            let first = self.number(property.list.unwrap_or(property.kind))?;
            self.record.numbers.push(first);
            if property.list.is_none() {
                continue;
            }
            let (items, bytes) = (first.max(0.0) as u64, property.kind.bytes() as u64);
            if items * bytes > self.length.saturating_sub(self.at) {
                let what = format!("a list of {items} items is longer than the rest of the file");
                return Err(ModelError::damaged(self.path, Place::Byte(self.at), what));
            }
            for _ in 0..items {
                let item = self.number(property.kind)?;
                if index == list {
                    self.record.list.push(item);
                }
            }
        }
        Ok(&self.record)
    }

    fn number(&mut self, kind: super::Kind) -> Result<f64, ModelError> {
        let mut bytes = [0; 8];
        let part = &mut bytes[..kind.bytes()];
        self.reader.read_exact(part).map_err(|error| self.ended(error))?;
        self.at += kind.bytes() as u64;
        Ok(kind.read(part, self.big_endian))
    }

    /// Reads `count` elements of `bytes` each and hands them on in blocks.
    pub(super) fn blocks(
        &mut self,
        count: u64,
        bytes: usize,
        mut take: impl FnMut(&[u8]),
    ) -> Result<(), ModelError> {
        let at_once = (BLOCK / bytes).max(1) as u64;
        let mut left = count;
        let mut block = Vec::new();
        while left > 0 {
            let now = left.min(at_once);
            block.resize(now as usize * bytes, 0);
            self.reader.read_exact(&mut block).map_err(|error| self.ended(error))?;
            take(&block);
            self.at += block.len() as u64;
            left -= now;
        }
        Ok(())
    }

    fn ended(&self, error: std::io::Error) -> ModelError {
        match error.kind() {
            std::io::ErrorKind::UnexpectedEof => ModelError::damaged(
                self.path,
                Place::Byte(self.length),
                "the file ends before its last element",
            ),
            _ => ModelError::Unreadable { path: self.path.to_owned(), source: error },
        }
    }
}
