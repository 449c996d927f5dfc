//! `manifest.json`: what went into a build and what came out of it, without times and places.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::config::Exhibit;

/// What marks a folder as a build.
pub const FORMAT: &str = "vitrine-build";
/// The version of the build folder's layout.
pub const LAYOUT: u32 = 3;

/// What went into a build and what came out of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`LAYOUT`].
    pub layout: u32,
    /// The version of the program that made the build.
    pub vitrine: String,
    /// Bits of an ink value: 8 or 16.
    pub ink_bits: u8,
    /// The exhibit with every default filled in.
    pub exhibit: Exhibit,
    /// BLAKE3 of the files read, by their path relative to exhibit.toml.
    pub inputs: BTreeMap<String, String>,
    /// BLAKE3 of the files written, by their path in the build.
    pub outputs: BTreeMap<String, String>,
}

impl Manifest {
    /// A manifest that names neither inputs nor outputs yet.
    pub(super) fn new(exhibit: &Exhibit, ink_bits: u8) -> Self {
        let mut exhibit = exhibit.clone();
        for view in &mut exhibit.views {
            view.pattern = view.pattern.as_deref().map(|pattern| PathBuf::from(portable_name(pattern)));
            view.mask = view.mask.as_deref().map(|mask| PathBuf::from(portable_name(mask)));
        }
        if let Some(object) = &mut exhibit.object {
            object.model = PathBuf::from(portable_name(&object.model));
        }
        Self {
            format: FORMAT.to_owned(),
            layout: LAYOUT,
            vitrine: env!("CARGO_PKG_VERSION").to_owned(),
            ink_bits,
            exhibit,
            inputs: BTreeMap::new(),
            outputs: BTreeMap::new(),
        }
    }
}

/// A path that says nothing about this computer: forward slashes, and of an absolute path only the file's name.
pub(crate) fn portable_name(path: &Path) -> String {
    let path = if path.is_absolute() { path.file_name().map_or(path, Path::new) } else { path };
    path.to_string_lossy().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_paths_lose_their_folders() {
        assert_eq!(portable_name(Path::new("/home/somebody/cat.jpg")), "cat.jpg");
        assert_eq!(portable_name(Path::new("pictures/cat.jpg")), "pictures/cat.jpg");
    }
}
