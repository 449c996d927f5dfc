//! Why a model cannot be used.

use std::fmt;
use std::path::PathBuf;

use miette::Diagnostic;
use thiserror::Error;

/// Where in a file something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The line of this number, from 1.
    Line(u64),
    /// The byte of this number, from 0.
    Byte(u64),
    /// A part of the file by its name, such as `accessors[3]`.
    Element(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Byte(number) => write!(f, "byte {number}"),
            Self::Element(name) => f.write_str(name),
        }
    }
}

/// Why a model cannot be used.
#[derive(Debug, Error, Diagnostic)]
pub enum ModelError {
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    #[diagnostic(code("vitrine::model::unreadable"), help("check that the file is there and may be read"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is not what it seems, or ends too early.
    #[error("{}, {place}: {what}", path.display())]
    #[diagnostic(code("vitrine::model::damaged"), help("{help}"))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong there.
        what: String,
        /// What to do.
        help: &'static str,
    },
    /// A file is of no kind that is read.
    #[error("{} is of no kind that is read", path.display())]
    #[diagnostic(
        code("vitrine::model::unknown_format"),
        help(
            "give a PLY, OBJ, glTF, GLB, STL, LAS or LAZ file, or a text with x y z r g b on each line (.xyz, .txt)"
        )
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A model names a file outside of its folder.
    #[error("{} names the file {named}, which is not in its folder", path.display())]
    #[diagnostic(
        code("vitrine::model::out_of_folder"),
        help("put the file beside the model, and let the model name it without a path")
    )]
    OutOfFolder {
        /// The model.
        path: PathBuf,
        /// What it names.
        named: String,
    },
    /// A file that has to be read whole is too long for that.
    #[error("{} has {length} bytes, and a model of its kind is read whole", path.display())]
    #[diagnostic(
        code("vitrine::model::too_long"),
        help("convert the model to binary PLY, or a cloud to LAS: these are read piece by piece")
    )]
    TooLong {
        /// The file.
        path: PathBuf,
        /// How long it is.
        length: u64,
    },
    /// A mesh has more vertices than are kept in memory.
    #[error("the mesh {} has more than {most} vertices, and these are kept in memory", path.display())]
    #[diagnostic(
        code("vitrine::model::too_many_vertices"),
        help("simplify the mesh, or convert it to STL, whose triangles are read piece by piece")
    )]
    TooManyVertices {
        /// The file.
        path: PathBuf,
        /// The most that a mesh may have.
        most: usize,
    },
    /// There is nothing in a model, or nothing of it lies in the stack.
    #[error("nothing of {} is on the films: {why}", path.display())]
    #[diagnostic(code("vitrine::model::empty"), help("{help}"))]
    Empty {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
        /// What to do.
        help: &'static str,
    },
}

/// What to do about a file that ends too early or holds garbage.
pub(super) const EXPORT_AGAIN: &str = "copy or export the model again: this file is cut short or damaged";

impl ModelError {
    /// A file that is cut short or holds garbage.
    pub(super) fn damaged(path: &std::path::Path, place: Place, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), place, what: what.into(), help: EXPORT_AGAIN }
    }
}
