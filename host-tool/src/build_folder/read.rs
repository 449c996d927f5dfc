//! Opens a build folder.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

use super::films::{FilmError, FilmRows, film_name, read_film};
use super::manifest::{FORMAT, LAYOUT, Manifest};
use crate::plain;
use crate::volume::Volume;
use vitrine_exhibit::plan::Plan;

/// Why a build cannot be used.
#[derive(Debug, Error, Diagnostic)]
pub enum OpenError {
    /// The folder has no readable manifest.
    #[error("{} is no build: its manifest.json cannot be read", folder.display())]
    #[diagnostic(
        code("vitrine::build::no_manifest"),
        help("name a folder that `vitrine design ... -o BUILD` has written")
    )]
    NoManifest {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The manifest is not one of a build.
    #[error("{} is not the manifest of a build: {cause}", path.display())]
    #[diagnostic(code("vitrine::build::bad_manifest"), help("design the exhibit again into this folder"))]
    BadManifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// A film cannot be read.
    #[error("cannot use the film {}: {source}", path.display())]
    #[diagnostic(code("vitrine::build::bad_film"), help("design the exhibit again into this folder"))]
    BadFilm {
        /// The film.
        path: PathBuf,
        /// What is wrong with it.
        source: FilmError,
    },
    /// The films are too large to be held in memory.
    #[error("the films of {} are too large to be looked at together", folder.display())]
    #[diagnostic(
        code("vitrine::build::too_large"),
        help("`vitrine print` reads them row by row; for a view, design the exhibit with fewer `pixels`")
    )]
    TooLarge {
        /// The folder.
        folder: PathBuf,
    },
    /// A picture cannot be read.
    #[error("cannot use the picture {}: {cause}", path.display())]
    #[diagnostic(code("vitrine::build::bad_picture"), help("design the exhibit again into this folder"))]
    BadPicture {
        /// The picture.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// The plan cannot be read.
    #[error("cannot read the plan {}", path.display())]
    #[diagnostic(code("vitrine::build::no_plan"), help("design the exhibit again into this folder"))]
    NoPlan {
        /// The plan.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// A build folder whose manifest has been read.
#[derive(Clone, Debug)]
pub struct BuildFolder {
    path: PathBuf,
    manifest: Manifest,
}

/// The films of a build.
#[derive(Clone, Debug)]
pub struct Films {
    /// Their ink.
    pub volume: Volume,
    /// The names of those that are not as they were written.
    pub changed: Vec<String>,
}

impl BuildFolder {
    /// Opens the build at `path`.
    ///
    /// # Errors
    /// Fails when there is no manifest of a build that this version reads.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let manifest_path = path.join("manifest.json");
        let text = std::fs::read_to_string(&manifest_path)
            .map_err(|source| OpenError::NoManifest { folder: path.to_owned(), source })?;
        let bad = |cause: String| OpenError::BadManifest { path: manifest_path.clone(), cause };
        let marks: Marks = serde_json::from_str(&text).map_err(|error| bad(error.to_string()))?;
        if marks.format != FORMAT {
            return Err(bad(format!("its format is \"{}\", not \"{FORMAT}\"", marks.format)));
        }
        if marks.layout != LAYOUT {
            return Err(bad(format!("its layout is {}, and this version reads {LAYOUT}", marks.layout)));
        }
        let manifest: Manifest = serde_json::from_str(&text).map_err(|error| bad(error.to_string()))?;
        let exhibit = &manifest.exhibit;
        let names = std::iter::once(&exhibit.name).chain(exhibit.views.iter().map(|view| &view.id));
        if !names.chain(manifest.outputs.keys()).all(|name| plain::is_plain(name)) {
            return Err(bad("a name in it holds a control character".to_owned()));
        }
        let stack = manifest.exhibit.film_stack();
        stack.checked().map_err(|error| bad(error.to_string()))?;
        Ok(Self { path: path.to_owned(), manifest })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What went in and what came out.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Reads all films.
    ///
    /// # Errors
    /// Fails at the first film that cannot be read or has another size than the stack.
    pub fn films(&self) -> Result<Films, OpenError> {
        let stack = self.manifest.exhibit.film_stack();
        if stack.is_too_large_for_memory() {
            return Err(OpenError::TooLarge { folder: self.path.clone() });
        }
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        let mut changed = Vec::new();
        for film in 0..stack.films {
            let name = film_name(film);
            let path = self.path.join(&name);
            let hash =
                read_film(&mut volume, film, &path).map_err(|source| OpenError::BadFilm { path, source })?;
            if self.manifest.outputs.get(&name).is_none_or(|written| *written != hash.to_hex().as_str()) {
                changed.push(name);
            }
        }
        Ok(Films { volume, changed })
    }

    /// Opens film `film` (0 on top) to read it row by row.
    ///
    /// # Errors
    /// Fails when it cannot be read or has another size than the stack.
    pub fn film_rows(&self, film: usize) -> Result<FilmRows, OpenError> {
        let stack = self.manifest.exhibit.film_stack();
        let path = self.path.join(film_name(film));
        FilmRows::open(&path, stack.width_px, stack.height_px)
            .map_err(|source| OpenError::BadFilm { path, source })
    }

    /// Reads a picture of the build, `name` being its path within it.
    ///
    /// # Errors
    /// Fails when the picture cannot be read.
    pub fn picture(&self, name: &str) -> Result<image::RgbImage, OpenError> {
        let path = self.path.join(name);
        match image::open(&path) {
            Ok(picture) => Ok(picture.to_rgb8()),
            Err(error) => Err(OpenError::BadPicture { path, cause: error.to_string() }),
        }
    }

    /// BLAKE3 of the volume in hexadecimal digits, as the plan has it.
    ///
    /// # Errors
    /// Fails when the plan cannot be read.
    pub fn volume_blake3(&self) -> Result<String, OpenError> {
        let path = self.path.join("plan.json");
        let text = std::fs::read_to_string(&path)
            .map_err(|source| OpenError::NoPlan { path: path.clone(), source })?;
        let plan: Result<Plan, _> = serde_json::from_str(&text);
        let plan = plan.map_err(|error| OpenError::NoPlan { path, source: error.into() })?;
        Ok(blake3::Hash::from_bytes(plan.volume.blake3).to_hex().to_string())
    }

    /// Reads the plan as it is uploaded.
    ///
    /// # Errors
    /// Fails when the file cannot be read.
    pub fn plan_file(&self) -> Result<Vec<u8>, OpenError> {
        let path = self.path.join("plan.bin");
        std::fs::read(&path).map_err(|source| OpenError::NoPlan { path, source })
    }
}

/// What tells whether the rest of a manifest can be read.
#[derive(serde::Deserialize)]
struct Marks {
    format: String,
    layout: u32,
}
