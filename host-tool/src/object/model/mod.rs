//! Models in files, read piece by piece.
//!
//! Point formats are read in blocks of a few MiB whatever their length. Nothing that a header claims is believed before
//! the file's own length bears it out.

mod beside;
mod error;
mod gltf;
pub(super) mod las;
mod obj;
mod ply;
mod stl;
mod text;
mod xyz;

#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::shape::{Box3, Corner, Point, Sink, Triangle};
use super::texture::Texture;

use gltf::Gltf;
use obj::Obj;

pub use error::{ModelError, Place};

/// Vertices of a mesh that are kept in memory at most: 2 GiB of them.
const MOST_VERTICES: usize = 1 << 26;
/// Points that are handed on at once.
const POINTS_AT_ONCE: usize = 1024;
/// Triangles that are handed on at once, and those that one task of the thread pool takes.
const TRIANGLES_AT_ONCE: usize = 1 << 14;
const TRIANGLES_A_TASK: usize = 64;

/// A model in a file.
#[derive(Clone, Debug)]
pub struct Model {
    path: PathBuf,
    content: Content,
}

/// What has been read of a model when it was opened.
#[derive(Clone, Debug)]
enum Content {
    Ply,
    Text,
    Stl,
    Las,
    Obj(Obj),
    Gltf(Box<Gltf>),
}

/// The formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ply,
    Text,
    Stl,
    Las,
    Obj,
    Gltf,
}

/// The endings of files and their formats.
const ENDINGS: [(&str, Format); 14] = [
    ("las", Format::Las),
    ("laz", Format::Las),
    ("stl", Format::Stl),
    ("obj", Format::Obj),
    ("gltf", Format::Gltf),
    ("glb", Format::Gltf),
    ("ply", Format::Ply),
    ("xyz", Format::Text),
    ("xyzrgb", Format::Text),
    ("txt", Format::Text),
    ("asc", Format::Text),
    ("csv", Format::Text),
    ("pts", Format::Text),
    ("tsv", Format::Text),
];

/// What files of a format begin with.
const BEGINNINGS: [(&[u8], Format); 4] =
    [(b"ply\n", Format::Ply), (b"ply\r", Format::Ply), (b"glTF", Format::Gltf), (b"LASF", Format::Las)];

impl Model {
    /// Finds out what the model at `path` is: by what it begins with, or else by its ending.
    ///
    /// # Errors
    /// Fails when the file cannot be read or is of no kind that is known.
    pub fn open(path: &Path) -> Result<Self, ModelError> {
        let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
        let mut first = Vec::new();
        let file = File::open(path).map_err(unreadable)?;
        file.take(16).read_to_end(&mut first).map_err(unreadable)?;
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let by_beginning =
            BEGINNINGS.iter().find(|(beginning, _)| first.starts_with(beginning)).map(|known| known.1);
        let by_ending =
            || ENDINGS.iter().find(|(known, _)| ending.as_deref() == Some(*known)).map(|known| known.1);
        match by_beginning.or_else(by_ending) {
            Some(format) => Ok(Self { path: path.to_owned(), content: Content::open(format, path)? }),
            None => Err(ModelError::UnknownFormat { path: path.to_owned() }),
        }
    }

    /// Where the model is.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The box around the model, where its file tells of it and what it is made of are points.
    pub(super) fn told_box(&self) -> Option<Box3> {
        match &self.content {
            Content::Las => las::told_box(&self.path),
            _ => None,
        }
    }

    /// The files that the model is made of.
    pub fn files(&self) -> Vec<PathBuf> {
        let beside = match &self.content {
            Content::Obj(model) => model.files.as_slice(),
            Content::Gltf(model) => model.files.as_slice(),
            Content::Ply | Content::Text | Content::Stl | Content::Las => &[],
        };
        std::iter::once(&self.path).chain(beside).cloned().collect()
    }

    /// Reads the whole model into `sink`; returns what had to be mended or guessed, in words.
    ///
    /// # Errors
    /// Fails at the first place that cannot be read.
    pub(super) fn read(&self, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
        match &self.content {
            Content::Ply => ply::read(&self.path, sink),
            Content::Text => xyz::read(&self.path, sink),
            Content::Las => las::read(&self.path, sink),
            Content::Stl => stl::read(&self.path, sink),
            Content::Obj(model) => model.read(sink),
            Content::Gltf(model) => model.read(sink),
        }
    }
}

impl Content {
    fn open(format: Format, path: &Path) -> Result<Self, ModelError> {
        Ok(match format {
            Format::Ply => Self::Ply,
            Format::Text => Self::Text,
            Format::Las => Self::Las,
            Format::Stl => Self::Stl,
            Format::Gltf => Self::Gltf(Box::new(Gltf::open(path)?)),
            Format::Obj => Self::Obj(Obj::open(path)?),
        })
    }
}

/// Opens the file at `path` and tells its length in bytes.
fn open(path: &Path) -> Result<(File, u64), ModelError> {
    let opened = File::open(path).and_then(|file| {
        let length = file.metadata()?.len();
        Ok((file, length))
    });
    opened.map_err(|source| ModelError::Unreadable { path: path.to_owned(), source })
}

/// The code value nearest to a colour of 0 to 255; what lies beyond counts as these, and no number as 0.
#[inline]
fn nearest_code(value: f64) -> u8 {
    // This cuts what is behind the point off, and does not call for a rounding function.
    (value + 0.5) as u8
}

/// Hands the points of a block of records of `bytes` each to `sink`, from all threads.
fn block_points(block: &[u8], bytes: usize, point: &(impl Fn(&[u8]) -> Point + Sync), sink: &dyn Sink) {
    block.par_chunks(bytes * POINTS_AT_ONCE).for_each_init(
        || Vec::with_capacity(POINTS_AT_ONCE),
        |points, part| {
            points.clear();
            points.extend(part.chunks_exact(bytes).map(point));
            sink.points(points);
        },
    );
}

/// Triangles on their way, handed on some at once.
struct TriangleBatch<'a> {
    sink: &'a dyn Sink,
    texture: Option<&'a Texture>,
    waiting: Vec<Triangle>,
}

impl<'a> TriangleBatch<'a> {
    /// Hands triangles with this texture to `sink`.
    fn new(sink: &'a dyn Sink, texture: Option<&'a Texture>) -> Self {
        Self { sink, texture, waiting: Vec::with_capacity(TRIANGLES_AT_ONCE) }
    }

    /// Lays `texture` over the triangles that follow.
    fn paint(&mut self, texture: Option<&'a Texture>) {
        self.flush();
        self.texture = texture;
    }

    /// Hands on one triangle, soon.
    fn push(&mut self, triangle: Triangle) {
        self.waiting.push(triangle);
        if self.waiting.len() == TRIANGLES_AT_ONCE {
            self.flush();
        }
    }

    /// Hands on a convex polygon as a fan of triangles; fewer than three corners are nothing.
    fn fan(&mut self, corners: &[Corner]) {
        if let [first, rest @ ..] = corners {
            rest.array_windows().for_each(|[second, third]| self.push([*first, *second, *third]));
        }
    }

    /// Hands on what is left.
    fn flush(&mut self) {
        let (sink, texture) = (self.sink, self.texture);
        self.waiting.par_chunks(TRIANGLES_A_TASK).for_each(|triangles| sink.triangles(triangles, texture));
        self.waiting.clear();
    }
}
