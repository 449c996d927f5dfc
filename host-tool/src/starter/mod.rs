//! What an exhibit starts from: a commented exhibit.toml and the bundled photographs.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

use crate::build_folder::WholeFolder;

/// The commented exhibit.toml; every key is in it with its default.
pub const EXHIBIT_TOML: &str = include_str!("exhibit.toml");

/// The bundled photographs by file name; their terms are in `photos/README.md`.
pub const PHOTOGRAPHS: [(&str, &[u8]); 4] = [
    ("astronaut.jpg", include_bytes!("../../photos/astronaut.jpg")),
    ("coffee.jpg", include_bytes!("../../photos/coffee.jpg")),
    ("cat.jpg", include_bytes!("../../photos/cat.jpg")),
    ("rocket.jpg", include_bytes!("../../photos/rocket.jpg")),
];

/// Why an exhibit cannot be started.
#[derive(Debug, Error, Diagnostic)]
pub enum StarterError {
    /// There is something in the folder.
    #[error("{} is there already and is not empty", .0.display())]
    #[diagnostic(code("vitrine::new::not_empty"), help("name a folder that does not exist yet"))]
    NotEmpty(PathBuf),
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code("vitrine::new::write"),
        help("look at the disk's free space and the folder's permissions")
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Writes the exhibit into `folder`, whole or not at all, and gives the names of its files.
///
/// # Errors
/// Fails when the folder is not empty or cannot be written.
pub fn write(folder: &Path) -> Result<Vec<&'static str>, StarterError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| StarterError::Write { path, source }
    };
    if std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) || folder.is_file() {
        return Err(StarterError::NotEmpty(folder.to_owned()));
    }
    let beside = WholeFolder::beside(folder).map_err(at(folder))?;
    let mut names = vec!["exhibit.toml"];
    beside.write("exhibit.toml", EXHIBIT_TOML.as_bytes()).map_err(at(&folder.join("exhibit.toml")))?;
    for (name, bytes) in PHOTOGRAPHS {
        beside.write(name, bytes).map_err(at(&folder.join(name)))?;
        names.push(name);
    }
    beside.commit().map_err(at(folder))?;
    Ok(names)
}
