//! PLY: points or meshes, ASCII or binary of either byte order (Turk 1994).
//!
//! Vertices of fixed size are read in blocks by all threads. A file with faces keeps its vertices in memory; their number
//! is borne out by the file's own length. Faces that stand before the vertices are passed over, and read when these are
//! known.

mod header;
mod source;

#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::error::{ModelError, Place};
use super::{MOST_VERTICES, POINTS_AT_ONCE, TriangleBatch, block_points, nearest_code, open};
use crate::object::shape::{Corner, Point, Sink, UNCOLOURED};
use header::{Element, Encoding, Header, Kind};
use source::{AsciiSource, Source};

/// Names under which the indices of a face's corners go.
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Names under which a vertex's colour goes.
const COLOURS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

/// What the elements are called that are read.
const VERTEX: &str = "vertex";
const FACE: &str = "face";

/// Reads the model at `path` into `sink`.
pub(super) fn read(path: &Path, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
    let (header, reader, length) = open_data(path)?;
    if header.encoding != Encoding::Ascii {
        header.check_length(path, length)?;
    }
    let vertices = VertexColumns::of(path, &header)?;
    let has_faces = header.elements.iter().any(|element| element.is_filled(FACE));
    let vertex_count = |element: &Element| if element.name == VERTEX { element.count } else { 0 };
    if has_faces && header.elements.iter().map(vertex_count).any(|count| count > MOST_VERTICES as u64) {
        return Err(ModelError::TooManyVertices { path: path.to_owned(), most: MOST_VERTICES });
    }
    let last_vertices = header.elements.iter().rposition(|element| element.name == VERTEX).unwrap_or(0);
    let mut mesh = has_faces.then(Vec::new);
    let mut source = Source::new(path, &header, reader, length);
    for (at, element) in header.elements.iter().enumerate() {
        match element.name.as_str() {
            VERTEX if header.is_text_cloud() => {
                let point = |numbers: &[f64]| vertices.point(|index| numbers[index]);
                AsciiSource::points(path, &header, element, point, sink)?;
            }
            VERTEX => read_vertices(&mut source, element, &vertices, mesh.as_mut(), sink)?,
            FACE if at > last_vertices => {
                read_faces(&mut source, element, mesh.as_deref().unwrap_or_default(), sink)?;
            }
            _ => source.pass(element)?,
        }
    }
    let (before, _) = header.elements.split_at(last_vertices);
    if before.iter().any(|element| element.is_filled(FACE)) {
        let (_, reader, _) = open_data(path)?;
        let mut source = Source::new(path, &header, reader, length);
        for element in before {
            match element.name.as_str() {
                FACE => read_faces(&mut source, element, mesh.as_deref().unwrap_or_default(), sink)?,
                _ => source.pass(element)?,
            }
        }
    }
    let mut notes = Vec::new();
    if vertices.colour.is_none() {
        notes.push("the model has no colours of its own: it is white".to_owned());
    }
    if !has_faces && header.elements.iter().any(|element| element.name == FACE) {
        notes.push("the model has no faces: its vertices are taken as points".to_owned());
    }
    Ok(notes)
}

/// The header of the file at `path`, a reader that stands behind it, and the file's length in bytes.
fn open_data(path: &Path) -> Result<(Header, BufReader<File>, u64), ModelError> {
    let (file, length) = open(path)?;
    let mut reader = BufReader::new(file);
    Ok((Header::read(path, &mut reader)?, reader, length))
}

/// In which properties of a vertex its place and its colour are.
#[derive(Clone, Debug)]
struct VertexColumns {
    position: [usize; 3],
    colour: Option<[usize; 3]>,
    /// What a channel has at full.
    full: f64,
}

impl VertexColumns {
    fn of(path: &Path, header: &Header) -> Result<Self, ModelError> {
        let fail = |what: &str| Err(ModelError::damaged(path, Place::Line(header.lines), what));
        let Some(vertex) = header.elements.iter().find(|element| element.name == VERTEX) else {
            return fail("the header tells of no vertex element");
        };
        let find = |names: &[&str; 3]| -> Option<[usize; 3]> {
            let index = |name: &str| {
                vertex.properties.iter().position(|property| property.name == name && property.list.is_none())
            };
            let found: Vec<usize> = names.iter().filter_map(|name| index(name)).collect();
            found.try_into().ok()
        };
        let Some(position) = find(&["x", "y", "z"]) else { return fail("a vertex has no x, y and z") };
        let colour = COLOURS.iter().find_map(find);
        let full = colour.map_or(1.0, |[red, ..]| vertex.properties[red].kind.full());
        Ok(Self { position, colour, full })
    }

    /// The point of a vertex whose properties `value` gives.
    #[inline]
    fn point(&self, value: impl Fn(usize) -> f64) -> Point {
        let code = |index: usize| nearest_code(value(index) / self.full * 255.0);
        let [x, y, z] = self.position;
        Point {
            position: [value(x), value(y), value(z)],
            colour: self.colour.map_or(UNCOLOURED, |[red, green, blue]| [code(red), code(green), code(blue)]),
        }
    }
}

/// Hands on the vertices as points, or keeps them for faces.
fn read_vertices(
    source: &mut Source<'_>,
    element: &Element,
    columns: &VertexColumns,
    mut mesh: Option<&mut Vec<Point>>,
    sink: &dyn Sink,
) -> Result<(), ModelError> {
    if let (Some(bytes), Source::Binary(binary)) = (element.fixed_bytes(), &mut *source) {
        let offsets: Vec<(usize, Kind)> = element
            .properties
            .iter()
            .enumerate()
            .map(|(at, property)| (element.offset(at), property.kind))
            .collect();
        let big_endian = binary.big_endian;
        let point = |record: &[u8]| {
            columns.point(|index| {
                let (offset, kind) = offsets[index];
                kind.read(&record[offset..], big_endian)
            })
        };
        return binary.blocks(element.count, bytes, |block| match &mut mesh {
            Some(vertices) => vertices.extend(block.chunks_exact(bytes).map(point)),
            None => block_points(block, bytes, &point, sink),
        });
    }
    let mut points = Vec::with_capacity(POINTS_AT_ONCE);
    for _ in 0..element.count {
        let record = source.record(element, usize::MAX)?;
        let point = columns.point(|index| record.numbers[index]);
        match &mut mesh {
            Some(vertices) => vertices.push(point),
            None => points.push(point),
        }
        if points.len() == POINTS_AT_ONCE {
            sink.points(&points);
            points.clear();
        }
    }
    sink.points(&points);
    Ok(())
}

/// Hands on the faces as fans of triangles.
fn read_faces(
    source: &mut Source<'_>,
    element: &Element,
    vertices: &[Point],
    sink: &dyn Sink,
) -> Result<(), ModelError> {
    let list = element
        .properties
        .iter()
        .position(|property| property.list.is_some() && INDICES.contains(&property.name.as_str()));
    let Some(list) = list else {
        return Err(source.damaged("a face has no list vertex_indices"));
    };
    let mut batch = TriangleBatch::new(sink, None);
    for _ in 0..element.count {
        let record = source.record(element, list)?;
        let corner = |index: &f64| {
            let found = (*index >= 0.0).then(|| vertices.get(*index as usize)).flatten();
            found.map(|vertex| Corner::of(vertex.position, vertex.colour)).ok_or(*index)
        };
        match record.list.iter().map(corner).collect::<Result<Vec<_>, _>>() {
            Ok(corners) => batch.fan(&corners),
            Err(index) => {
                let what = format!("a face names vertex {index}, but there are {}", vertices.len());
                return Err(source.damaged(what));
            }
        }
    }
    batch.flush();
    Ok(())
}
