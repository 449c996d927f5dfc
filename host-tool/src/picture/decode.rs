//! Files as pictures: PNG, JPEG, TIFF and WebP.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader};

use super::{PictureError, colour, jpeg};

/// Pixels that a picture has at most: 16,384 x 16,384. More would take gigabytes, and no film shows them.
pub(super) const MOST_PIXELS: u64 = 1 << 28;

/// Why bytes are no picture that is read.
pub(super) enum Fault {
    Damaged(String),
    TooLarge(u32, u32),
}

/// A file's values, turned by its EXIF orientation, and the ICC profile that says what they stand for.
pub(super) struct Undecoded {
    pub(super) image: DynamicImage,
    pub(super) profile: Option<Vec<u8>>,
}

impl Fault {
    /// The fault of the file at `path`.
    pub(super) fn at(self, path: &Path) -> PictureError {
        let path = path.to_owned();
        match self {
            Self::Damaged(cause) => PictureError::Damaged { path, cause },
            Self::TooLarge(width, height) => PictureError::TooLarge { path, width, height },
        }
    }
}

impl Undecoded {
    fn from_bytes(bytes: &[u8]) -> Result<Self, Fault> {
        let damaged = |error: image::ImageError| Fault::Damaged(error.to_string());
        if jpeg::is_jpeg(bytes) && !jpeg::is_whole(bytes) {
            return Err(Fault::Damaged("the JPEG data end too early".into()));
        }
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        let reader = reader.map_err(|error| Fault::Damaged(error.to_string()))?;
        let mut decoder = reader.into_decoder().map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(Fault::TooLarge(width, height));
        }
        let orientation = decoder.orientation().map_err(damaged)?;
        let profile = decoder.icc_profile().map_err(damaged)?;
        let mut image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
        image.apply_orientation(orientation);
        Ok(Self { image, profile })
    }

    /// In the colours of sRGB.
    fn in_srgb(self) -> Result<DynamicImage, Fault> {
        match self.profile {
            Some(profile) => colour::to_srgb(self.image, &profile).map_err(Fault::Damaged),
            None => Ok(self.image),
        }
    }
}

/// Reads a file.
///
/// # Errors
/// When it cannot be read, is no picture, ends before its last pixel, or has too many.
pub(super) fn read(path: &Path) -> Result<Undecoded, PictureError> {
    let unreadable = |cause| PictureError::Unreadable { path: path.to_owned(), cause };
    let bytes = std::fs::read(path).map_err(unreadable)?;
    Undecoded::from_bytes(&bytes).map_err(|fault| fault.at(path))
}

/// Reads a file in the colours of sRGB.
///
/// # Errors
/// As [`read`], and when its profile cannot be used.
pub(super) fn open(path: &Path) -> Result<DynamicImage, PictureError> {
    read(path)?.in_srgb().map_err(|fault| fault.at(path))
}

/// Reads the bytes of a file in the colours of sRGB.
///
/// # Errors
/// As [`open()`].
pub(super) fn decode(bytes: &[u8]) -> Result<DynamicImage, Fault> {
    Undecoded::from_bytes(bytes)?.in_srgb()
}
