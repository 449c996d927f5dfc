//! LAS and LAZ: clouds from laser scanners (ASPRS LAS 1.0 to 1.4), read piece by piece whatever their length.
//!
//! The crate `las` reads the header, `laz` decompresses. Records are taken apart here, by all threads at once: of each only
//! its place and its colour are needed. Colours have 16 bits; where those of the first points all are below 256 the file
//! was written with 8 bits, as many are, and they are taken so.

mod caught;
mod compressed;
#[cfg(test)]
pub(in crate::object) mod tests;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use las::raw::Header;

use super::error::{ModelError, Place};
use super::{block_points, open};
use crate::object::shape::{Box3, Point, Sink, UNCOLOURED};

/// Bytes of points that are read at once.
const BLOCK: usize = 8 << 20;
/// Bit of the format's number that tells of compression.
const COMPRESSED: u8 = 0x80;
/// Of each point format: the bytes of its record, and where red stands in it.
const FORMATS: [(u16, Option<usize>); 11] = [
    (20, None),
    (28, None),
    (26, Some(20)),
    (34, Some(28)),
    (57, None),
    (63, Some(28)),
    (30, None),
    (36, Some(30)),
    (38, Some(30)),
    (59, None),
    (67, Some(30)),
];

/// How the records of a file are made.
struct Records {
    format: u8,
    bytes: usize,
    count: u64,
    scale: [f64; 3],
    offset: [f64; 3],
    red: Option<usize>,
}

/// What is made of colours.
#[derive(Clone, Copy, PartialEq)]
enum Colours {
    None,
    EightBits,
    SixteenBits,
}

/// Reads the cloud at `path` into `sink`.
pub(super) fn read(path: &Path, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
    let (file, length) = open(path)?;
    let mut reader = BufReader::new(file);
    let header = Header::read_from(&mut reader).map_err(|error| {
        ModelError::damaged(path, Place::Byte(0), format!("the header cannot be read: {error}"))
    })?;
    let records = Records::of(path, &header)?;
    let notes = Mutex::new(Vec::new());
    let colours = OnceLock::new();
    let take = |block: &[u8]| {
        let colours = *colours.get_or_init(|| {
            let mut notes = notes.lock().unwrap_or_else(PoisonError::into_inner);
            records.colours(block, &mut notes)
        });
        block_points(block, records.bytes, &|record| records.point(record, colours), sink);
    };
    match header.point_data_record_format & COMPRESSED {
        0 => read_plain(path, (reader.into_inner(), length), &header, &records, take)?,
        _ => compressed::read(path, &header, &records, length, take)?,
    }
    Ok(notes.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Hands blocks of the records of a file that is not compressed to `take`.
fn read_plain(
    path: &Path,
    (mut file, length): (File, u64),
    header: &Header,
    records: &Records,
    take: impl Fn(&[u8]),
) -> Result<(), ModelError> {
    let start = u64::from(header.offset_to_point_data);
    let needed = records.count.checked_mul(records.bytes as u64).and_then(|bytes| bytes.checked_add(start));
    if needed.is_none_or(|needed| needed > length) {
        let what = format!(
            "the header tells of {} points of {} bytes, which the {length} bytes of the file cannot hold",
            records.count, records.bytes
        );
        return Err(ModelError::damaged(path, Place::Byte(107), what));
    }
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    file.seek(SeekFrom::Start(start)).map_err(unreadable)?;
    records.blocks(path, |block| file.read_exact(block).map_err(|error| error.to_string()), take)
}

/// The box around the points that the header of the file at `path` tells of, if it can be read.
pub(super) fn told_box(path: &Path) -> Option<Box3> {
    let header = Header::read_from(&mut BufReader::new(File::open(path).ok()?)).ok()?;
    let around = Box3 {
        least: [header.min_x, header.min_y, header.min_z],
        most: [header.max_x, header.max_y, header.max_z],
    };
    let is_finite = around.least.iter().chain(&around.most).all(|value| value.is_finite());
    (is_finite && !around.is_empty()).then_some(around)
}

impl Records {
    fn of(path: &Path, header: &Header) -> Result<Self, ModelError> {
        let fail = |at: u64, what: String| Err(ModelError::damaged(path, Place::Byte(at), what));
        let format = header.point_data_record_format & 0x3f;
        let Some(&(least, red)) = FORMATS.get(usize::from(format)) else {
            return fail(104, format!("there is no point format {format}"));
        };
        let bytes = header.point_data_record_length;
        if bytes < least {
            return fail(105, format!("points of format {format} have {least} bytes, not {bytes}"));
        }
        let scale = [header.x_scale_factor, header.y_scale_factor, header.z_scale_factor];
        let offset = [header.x_offset, header.y_offset, header.z_offset];
        if !scale.iter().chain(&offset).all(|value| value.is_finite()) || scale.contains(&0.0) {
            return fail(131, "the scales and offsets of the coordinates are no finite numbers".to_owned());
        }
        Ok(Self { format, bytes: usize::from(bytes), count: point_count(header), scale, offset, red })
    }

    /// Hands blocks of records, which `fill` fills, to `take`.
    fn blocks(
        &self,
        path: &Path,
        mut fill: impl FnMut(&mut [u8]) -> Result<(), String>,
        take: impl Fn(&[u8]),
    ) -> Result<(), ModelError> {
        let at_once = (BLOCK / self.bytes).max(1) as u64;
        let mut done = 0;
        let mut block = Vec::new();
        while done < self.count {
            let now = (self.count - done).min(at_once);
            block.resize(now as usize * self.bytes, 0);
            fill(&mut block).map_err(|what| {
                let place = Place::Element(format!("point {}", done + 1));
                ModelError::damaged(path, place, what)
            })?;
            take(&block);
            done += now;
        }
        Ok(())
    }

    /// Looks at the colours of the first points.
    fn colours(&self, block: &[u8], notes: &mut Vec<String>) -> Colours {
        let Some(red) = self.red else {
            notes.push("the points have no colours: they are white".to_owned());
            return Colours::None;
        };
        let records = block.chunks_exact(self.bytes);
        let largest = records.flat_map(|record| [0, 2, 4].map(|at| short(record, red + at))).max();
        match largest {
            None | Some(0) => {
                notes.push("the colours of the first points are all black: the points are white".to_owned());
                Colours::None
            }
            Some(1..=255) => {
                notes.push("the colours have 8 bits instead of 16, as the first points show".to_owned());
                Colours::EightBits
            }
            Some(_) => Colours::SixteenBits,
        }
    }

    #[inline]
    fn point(&self, record: &[u8], colours: Colours) -> Point {
        let position = [0, 1, 2].map(|axis| {
            let number =
                record.get(4 * axis..).and_then(|bytes| bytes.first_chunk()).copied().unwrap_or_default();
            f64::from(i32::from_le_bytes(number)) * self.scale[axis] + self.offset[axis]
        });
        let red = self.red.unwrap_or_default();
        let colour = match colours {
            Colours::None => UNCOLOURED,
            Colours::EightBits => [0, 2, 4].map(|at| short(record, red + at) as u8),
            Colours::SixteenBits => [0, 2, 4].map(|at| (short(record, red + at) >> 8) as u8),
        };
        Point { position, colour }
    }
}

/// The number of points: LAS 1.4 has it in 64 bits as well, and in 32 bits where it fits or for older readers.
fn point_count(header: &Header) -> u64 {
    match (header.number_of_point_records, header.large_file) {
        (0, Some(large)) => large.number_of_point_records,
        (count, _) => u64::from(count),
    }
}

#[inline]
fn short(record: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(record.get(at..).and_then(|bytes| bytes.first_chunk()).copied().unwrap_or_default())
}
