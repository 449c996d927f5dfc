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

/// Reads a file.
///
/// # Errors
/// When it cannot be read, is no picture, ends before its last pixel, or has too many.
pub(super) fn open(path: &Path) -> Result<DynamicImage, PictureError> {
    let path = || path.to_owned();
    let bytes = std::fs::read(path()).map_err(|cause| PictureError::Unreadable { path: path(), cause })?;
    decode(&bytes).map_err(|fault| match fault {
        Fault::Damaged(cause) => PictureError::Damaged { path: path(), cause },
        Fault::TooLarge(width, height) => PictureError::TooLarge { path: path(), width, height },
    })
}

/// Reads the bytes of a file: turned by its EXIF orientation, in the colours of sRGB.
///
/// # Errors
/// As [`open()`].
pub(super) fn decode(bytes: &[u8]) -> Result<DynamicImage, Fault> {
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
    match profile {
        Some(profile) => colour::to_srgb(image, &profile).map_err(Fault::Damaged),
        None => Ok(image),
    }
}
