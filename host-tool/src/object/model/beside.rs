//! Files that a model names: only those in its own folder or below are read.

use std::path::{Component, Path, PathBuf};

use super::error::ModelError;
use crate::object::texture::Texture;
use crate::picture::Picture;

/// The longest file that is read whole, in bytes.
pub(super) const LONGEST_FILE: u64 = 2 << 30;
/// The most pixels of a texture.
const MOST_TEXELS: u64 = 1 << 28;

/// The path of the file that `model` names as `name`, its folder and what is below being all that may be named.
pub(super) fn path_beside(model: &Path, name: &str) -> Result<PathBuf, ModelError> {
    // Models from elsewhere part folders by backslashes.
    let named = PathBuf::from(name.replace('\\', "/"));
    let leads_out = named.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir));
    // Drives have letters on other systems.
    if leads_out || name.as_bytes().get(1) == Some(&b':') {
        return Err(ModelError::OutOfFolder { path: model.to_owned(), named: name.to_owned() });
    }
    Ok(model.parent().unwrap_or(Path::new("")).join(named))
}

/// Reads a file whole, if it is not too long.
pub(super) fn read_whole(path: &Path) -> Result<Vec<u8>, ModelError> {
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    let length = std::fs::metadata(path).map_err(unreadable)?.len();
    if length > LONGEST_FILE {
        return Err(ModelError::TooLong { path: path.to_owned(), length });
    }
    std::fs::read(path).map_err(unreadable)
}

/// The texture in the file at `path`; where it is missing or damaged, a note says that the model goes without it.
pub(super) fn texture_at(path: &Path, name: &str, notes: &mut Vec<String>) -> Option<Texture> {
    match image::image_dimensions(path) {
        Ok(size) if u64::from(size.0) * u64::from(size.1) > MOST_TEXELS => {
            notes.push(format!("the texture {name} has too many pixels: its colours are left out"));
            return None;
        }
        _ => {}
    }
    match Picture::read(path) {
        Ok(picture) => Texture::new(&picture),
        Err(_) => {
            notes.push(format!("the texture {name} is missing or damaged: its colours are left out"));
            None
        }
    }
}

/// The texture in these bytes, as [`texture_at`].
pub(super) fn texture_of(bytes: &[u8], name: &str, notes: &mut Vec<String>) -> Option<Texture> {
    match Picture::from_bytes(bytes) {
        Ok(picture) => Texture::new(&picture),
        Err(_) => {
            notes.push(format!("the texture {name} is damaged: its colours are left out"));
            None
        }
    }
}
