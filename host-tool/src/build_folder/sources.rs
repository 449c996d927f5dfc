//! The pictures that a user gives: whether they are there and whole.

use std::path::Path;

use thiserror::Error;

/// Why a picture cannot be used.
#[derive(Debug, Error)]
pub enum PictureProblem {
    /// It cannot be read.
    #[error("{0}")]
    Unreadable(#[from] std::io::Error),
    /// It is a folder.
    #[error("it is a folder")]
    Folder,
    /// It is of no known format.
    #[error("it is no PNG, JPEG, TIFF or WebP picture")]
    UnknownFormat,
    /// It ends too early.
    #[error("the file is cut short")]
    CutShort,
}

/// Looks whether the file at `path` is a picture by its first and last bytes, without decoding it.
///
/// # Errors
/// Fails when there is no such file, when it is no picture, and when it is a JPEG or PNG cut short: decoders fill in
/// the rest of such a JPEG with grey.
pub fn look_at_picture(path: &Path) -> Result<(), PictureProblem> {
    if path.is_dir() {
        return Err(PictureProblem::Folder);
    }
    let bytes = std::fs::read(path)?;
    let format = image::guess_format(&bytes).map_err(|_| PictureProblem::UnknownFormat)?;
    let whole = match format {
        image::ImageFormat::Jpeg => jpeg_has_end(&bytes),
        image::ImageFormat::Png => bytes.windows(4).any(|window| window == b"IEND"),
        image::ImageFormat::Tiff | image::ImageFormat::WebP => true,
        _ => return Err(PictureProblem::UnknownFormat),
    };
    if whole { Ok(()) } else { Err(PictureProblem::CutShort) }
}

/// Whether the end marker follows the last start of a scan. Within a scan, a byte FF is always followed by 00 or a
/// restart marker (ITU-T T.81, B.1.1.5), so that the marker cannot be part of the data.
fn jpeg_has_end(bytes: &[u8]) -> bool {
    let scan = bytes.windows(2).rposition(|window| window == [0xFF, 0xDA]);
    let end = bytes.windows(2).rposition(|window| window == [0xFF, 0xD9]);
    matches!((scan, end), (Some(scan), Some(end)) if end > scan)
}

#[cfg(test)]
mod tests {
    use super::*;

    const JPEG: &[u8] = include_bytes!("../../photos/rocket.jpg");

    #[test]
    fn a_whole_picture_passes_and_a_cut_one_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rocket.jpg");
        std::fs::write(&path, JPEG).unwrap();
        assert!(look_at_picture(&path).is_ok());
        for length in [JPEG.len() - 2, JPEG.len() / 2, 800] {
            std::fs::write(&path, &JPEG[..length]).unwrap();
            assert!(matches!(look_at_picture(&path), Err(PictureProblem::CutShort)), "{length}");
        }
        std::fs::write(&path, b"no picture").unwrap();
        assert!(matches!(look_at_picture(&path), Err(PictureProblem::UnknownFormat)));
        assert!(matches!(look_at_picture(folder.path()), Err(PictureProblem::Folder)));
        assert!(matches!(look_at_picture(&folder.path().join("none")), Err(PictureProblem::Unreadable(_))));
    }
}
