//! What an exhibit starts from: a commented exhibit.toml with its schema, and the bundled photographs or one's own.

mod own;

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

pub use own::{OwnPicture, OwnPictures, own_pictures};

use crate::build_folder::WholeFolder;
use crate::config;
use crate::picture::PictureError;

/// The commented exhibit.toml; every key is in it with its default.
pub const EXHIBIT_TOML: &str = include_str!("exhibit.toml");

/// The name of the schema that exhibit.toml's first line points editors to.
pub const SCHEMA_NAME: &str = "exhibit.schema.json";

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
    /// The folder of pictures cannot be read.
    #[error("cannot read the folder {}", path.display())]
    #[diagnostic(code("vitrine::new::unreadable"), help("name a folder with the pictures to be shown"))]
    Unreadable {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The folder holds no picture, or more than a plan holds views.
    #[error("{} holds {found} pictures{left_out}, but an exhibit shows 1 to {most}", path.display())]
    #[diagnostic(
        code("vitrine::new::picture_count"),
        help(
            "put the PNG, JPEG, TIFF or WebP files that are to be shown into the folder, and no others; two to four show best"
        )
    )]
    PictureCount {
        /// The folder.
        path: PathBuf,
        /// Pictures in it.
        found: usize,
        /// What else is in it, in words.
        left_out: String,
        /// The most views of a plan.
        most: usize,
    },
    /// One of the pictures has a name that exhibit.toml cannot hold.
    #[error("the name of {} holds a control character", .0.display())]
    #[diagnostic(
        code("vitrine::new::name"),
        help(
            "give the file a name of letters, digits and signs; the message shows what is none of them as \\u and its number"
        )
    )]
    Name(PathBuf),
    /// One of the pictures cannot be used.
    #[error(transparent)]
    #[diagnostic(code("vitrine::new::picture"), help("mend the file or take it out of the folder"))]
    Picture(#[from] PictureError),
}

/// Writes an exhibit with the bundled photographs into `folder`, whole or not at all, and gives the names of its files.
///
/// # Errors
/// Fails when the folder is not empty or cannot be written.
pub fn write(folder: &Path) -> Result<Vec<String>, StarterError> {
    let pictures = PHOTOGRAPHS.map(|(name, bytes)| (name.to_owned(), bytes.to_owned()));
    write_with(folder, EXHIBIT_TOML, &pictures)
}

/// Writes an exhibit that shows `pictures` to directions spread evenly from left to right into `folder`, whole or not at
/// all, and gives the names of its files.
///
/// # Errors
/// Fails when the folder is not empty or cannot be written.
pub fn write_own(folder: &Path, pictures: Vec<OwnPicture>) -> Result<Vec<String>, StarterError> {
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let text = own::exhibit_toml(&name, &pictures);
    let files: Vec<_> = pictures.into_iter().map(|picture| (picture.file_name, picture.bytes)).collect();
    write_with(folder, &text, &files)
}

/// Looks whether an exhibit may be put into `folder`.
///
/// # Errors
/// Fails when something is there.
pub fn check_place(folder: &Path) -> Result<(), StarterError> {
    if std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) || folder.is_file() {
        return Err(StarterError::NotEmpty(folder.to_owned()));
    }
    Ok(())
}

fn write_with(
    folder: &Path,
    exhibit_toml: &str,
    pictures: &[(String, Vec<u8>)],
) -> Result<Vec<String>, StarterError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| StarterError::Write { path, source }
    };
    check_place(folder)?;
    let schema = serde_json::to_vec_pretty(&config::schema()).unwrap_or_default();
    let beside = WholeFolder::beside(folder).map_err(at(folder))?;
    let mut names = Vec::new();
    let texts = [("exhibit.toml", exhibit_toml.as_bytes()), (SCHEMA_NAME, &schema)];
    let pictures = pictures.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    for (name, bytes) in texts.into_iter().chain(pictures) {
        beside.write(name, bytes).map_err(at(&folder.join(name)))?;
        names.push(name.to_owned());
    }
    beside.commit().map_err(at(folder))?;
    Ok(names)
}
