//! STL, binary or text: triangles without colours, read piece by piece.
//!
//! A file is binary where its length is that of the number of triangles that it tells of, whatever it begins with; else
//! it is text where it begins with `solid`.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::error::{ModelError, Place};
use super::text::Lines;
use super::{TriangleBatch, open};
use crate::object::shape::{Corner, Sink, UNCOLOURED};

/// Bytes before the first triangle of a binary file, and of a triangle.
const HEADER: u64 = 84;
const TRIANGLE: usize = 50;
/// Triangles that are read at once.
const AT_ONCE: usize = 1 << 14;

/// Reads the model at `path` into `sink`.
pub(super) fn read(path: &Path, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
    let (mut file, length) = open(path)?;
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    let mut header = Vec::new();
    file.by_ref().take(HEADER).read_to_end(&mut header).map_err(unreadable)?;
    let claimed =
        header.get(80..84).and_then(|count| count.first_chunk()).map(|count| u32::from_le_bytes(*count));
    let needed = claimed.map(|count| HEADER + u64::from(count) * TRIANGLE as u64);
    if needed == Some(length) {
        read_binary(path, file, claimed.unwrap_or_default(), sink)?;
    } else if header.trim_ascii_start().starts_with(b"solid") {
        file.seek(SeekFrom::Start(0)).map_err(unreadable)?;
        read_text(path, file, sink)?;
    } else {
        let what = match claimed {
            Some(count) => format!("the header tells of {count} triangles, which {length} bytes do not hold"),
            None => "the file ends within its header".to_owned(),
        };
        return Err(ModelError::damaged(path, Place::Byte(80), what));
    }
    Ok(vec!["STL has no colours: the model is white".to_owned()])
}

fn read_binary(path: &Path, mut file: File, count: u32, sink: &dyn Sink) -> Result<(), ModelError> {
    let mut batch = TriangleBatch::new(sink, None);
    let mut left = count as usize;
    let mut block = Vec::new();
    while left > 0 {
        let now = left.min(AT_ONCE);
        block.resize(now * TRIANGLE, 0);
        file.read_exact(&mut block)
            .map_err(|source| ModelError::Unreadable { path: path.to_owned(), source })?;
        for triangle in block.as_chunks::<TRIANGLE>().0 {
            let number = |index: usize| {
                let bytes = triangle[12 + 4 * index..].first_chunk().copied().unwrap_or_default();
                f64::from(f32::from_le_bytes(bytes))
            };
            batch.push(
                [0, 3, 6].map(|at| Corner::of([number(at), number(at + 1), number(at + 2)], UNCOLOURED)),
            );
        }
        left -= now;
    }
    batch.flush();
    Ok(())
}

fn read_text(path: &Path, file: File, sink: &dyn Sink) -> Result<(), ModelError> {
    let mut lines = Lines::new(path, BufReader::new(file), 1);
    let mut batch = TriangleBatch::new(sink, None);
    let mut corners: Vec<Corner> = Vec::new();
    let mut ended = false;
    while let Some(line) = lines.next()? {
        let text = std::str::from_utf8(line).unwrap_or_default().trim().to_ascii_lowercase();
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["vertex", x, y, z] => {
                let numbers: Vec<f64> = [x, y, z].iter().filter_map(|word| word.parse().ok()).collect();
                match <[f64; 3]>::try_from(numbers) {
                    Ok(position) if corners.len() < 3 => corners.push(Corner::of(position, UNCOLOURED)),
                    Ok(_) => return Err(lines.damaged("a facet has more than three vertices")),
                    Err(_) => return Err(lines.damaged("a vertex wants three numbers")),
                }
            }
            ["endfacet", ..] => {
                let Ok(triangle) = <[Corner; 3]>::try_from(std::mem::take(&mut corners)) else {
                    return Err(lines.damaged("a facet has fewer than three vertices"));
                };
                batch.push(triangle);
            }
            ["endsolid", ..] => ended = true,
            [] | ["facet" | "outer" | "endloop", ..] => {}
            ["solid", ..] => ended = false,
            _ => return Err(lines.damaged("this line belongs into no STL text")),
        }
    }
    batch.flush();
    if ended { Ok(()) } else { Err(lines.damaged("the file ends without endsolid")) }
}
