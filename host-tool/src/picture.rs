//! Pictures: planar RGB in 0..=1, read from and written to files.

mod colour;
mod decode;
mod fitted;
mod jpeg;
mod photograph;
mod srgb;

use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageEncoder};
use rayon::prelude::*;
use thiserror::Error;

use crate::simd::vectorised;
use crate::volume::CHANNELS;

use decode::{Fault, MOST_PIXELS, decode, open};
pub use fitted::Fitted;
pub use photograph::{Photograph, Tones};
pub(crate) use srgb::{STEEPEST, srgb_encode_with_slope};
pub use srgb::{srgb_decode, srgb_encode};

/// A picture that is to be resized is first averaged to no less than so many times the pixels in either direction.
const SPARE: u32 = 4;
/// Values that one task of the thread pool converts.
const VALUES_AT_ONCE: usize = 1 << 14;

/// A picture of red, green and blue values, planar: channel, row, column.
///
/// Values read from files are sRGB code values in 0..=1; projections may exceed 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

/// Why a picture cannot be read or written.
#[derive(Debug, Error)]
pub enum PictureError {
    /// The file cannot be opened or read.
    #[error("cannot read the picture {}: {cause}; check that the file is there and may be read", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
    /// The file is no picture, or it is damaged.
    #[error("{} is not a whole picture: {cause}; give a complete JPEG, PNG, TIFF or WebP file (copy or export it again)", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        cause: String,
    },
    /// It has more pixels than are read.
    #[error("{} has {width} x {height} pixels, more than the {} million that are read; scale it down", path.display(), MOST_PIXELS / 1_000_000)]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {cause}; check that the folder is there, may be written and has room", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
}

impl Picture {
    /// Makes a black picture.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, values: vec![0.0; CHANNELS * width * height] }
    }

    /// Makes a picture from planar values, or `None` when their number is not `3 * width * height`.
    pub fn from_values(width: usize, height: usize, values: Vec<f32>) -> Option<Self> {
        (values.len() == CHANNELS * width * height).then_some(Self { width, height, values })
    }

    /// Reads a JPEG, PNG, TIFF or WebP file: its EXIF orientation is applied, transparent parts lie over
    /// black, 16-bit values keep their precision, and colours of an RGB or grey ICC profile become sRGB.
    ///
    /// # Errors
    /// When the file cannot be read, is no picture, or ends before its last pixel.
    pub fn read(path: &Path) -> Result<Self, PictureError> {
        Ok(Self::from_image(&open(path)?, 1))
    }

    /// Looks whether [`Picture::read`] would read a file, and gives its columns and rows.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub fn check(path: &Path) -> Result<[usize; 2], PictureError> {
        let image = open(path)?;
        Ok([image.width() as usize, image.height() as usize])
    }

    /// Reads the bytes of a file as [`Picture::read`].
    ///
    /// # Errors
    /// Says what the decoder says when the bytes are no picture, or end before its last pixel.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        match decode(bytes) {
            Ok(image) => Ok(Self::from_image(&image, 1)),
            Err(Fault::Damaged(cause)) => Err(cause),
            Err(Fault::TooLarge(width, height)) => Err(format!("{width} x {height} pixels are too many")),
        }
    }

    /// Reads a file as [`Picture::read`], crops it about its centre to the shape of `width` x `height` and
    /// resizes it. A picture that already has this size passes unchanged.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub fn read_fitted(path: &Path, width: usize, height: usize) -> Result<Self, PictureError> {
        Self::read_for(path, width, height)?
            .fitted(width, height)
            .map_err(|cause| PictureError::Damaged { path: path.to_owned(), cause })
    }

    /// As [`Picture::read_fitted`], to be given some rows at a time.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub fn read_rows(path: &Path, width: usize, height: usize) -> Result<Fitted, PictureError> {
        Fitted::new(Self::read_for(path, width, height)?, width, height)
            .map_err(|cause| PictureError::Damaged { path: path.to_owned(), cause })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values: channel, row, column.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All values, to write: channel, row, column.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// The values of one channel, row by row.
    pub fn channel(&self, channel: usize) -> &[f32] {
        let size = self.width * self.height;
        &self.values[channel * size..(channel + 1) * size]
    }

    /// The values of one channel, row by row, to write.
    pub fn channel_mut(&mut self, channel: usize) -> &mut [f32] {
        let size = self.width * self.height;
        &mut self.values[channel * size..(channel + 1) * size]
    }

    /// Returns some of its rows.
    pub fn rows(&self, rows: std::ops::Range<usize>) -> Self {
        let place = rows.start * self.width..rows.end * self.width;
        let values = (0..CHANNELS).flat_map(|channel| &self.channel(channel)[place.clone()]);
        Self { width: self.width, height: rows.len(), values: values.copied().collect() }
    }

    /// Returns the picture with `convert` applied to every value.
    pub fn map(&self, convert: impl Fn(f32) -> f32 + Sync) -> Self {
        let mut values = self.values.clone();
        values.par_chunks_mut(VALUES_AT_ONCE).for_each(|values| {
            vectorised(
                #[inline(always)]
                || values.iter_mut().for_each(|value| *value = convert(*value)),
            );
        });
        Self { values, ..*self }
    }

    /// Returns the light that the code values stand for.
    pub fn decoded(&self) -> Self {
        self.map(srgb_decode)
    }

    /// Returns the code values that stand for this light.
    pub fn encoded(&self) -> Self {
        self.map(srgb_encode)
    }

    /// Returns how far each value is from that of `other`, which is of the same size.
    pub fn difference(&self, other: &Self) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| (a - b).abs()).collect();
        Self { values, ..*self }
    }

    /// Returns the picture as interleaved 8-bit RGB, rounded to the nearest value.
    pub fn rgb8(&self) -> Vec<u8> {
        let [red, green, blue] = [0, 1, 2].map(|channel| self.channel(channel));
        let mut pixels = Vec::with_capacity(self.values.len());
        for ((&r, &g), &b) in red.iter().zip(green).zip(blue) {
            pixels.extend([r, g, b].map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
        pixels
    }

    /// Writes the picture as an 8-bit RGB PNG, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<(), PictureError> {
        write_png_rgb8(path, &self.rgb8(), self.width, self.height)
    }

    /// Returns the picture drawn out about its centre: the new picture shows at (x, y) what this one shows at
    /// (x * `scale_x`, y * `scale_y`), interpolated linearly; what lies outside this picture is black.
    pub fn drawn_out(&self, scale_x: f64, scale_y: f64) -> Self {
        let columns: Vec<_> = (0..self.width).map(|column| neighbours(column, self.width, scale_x)).collect();
        let rows: Vec<_> = (0..self.height).map(|row| neighbours(row, self.height, scale_y)).collect();
        let mut drawn = Self::new(self.width, self.height);
        for channel in 0..CHANNELS {
            let source = self.channel(channel);
            let target = drawn.channel_mut(channel);
            for (line, row) in target.chunks_exact_mut(self.width).zip(&rows) {
                for (value, column) in line.iter_mut().zip(&columns) {
                    let (Some((top, bottom, below)), Some((left, right, beside))) = (*row, *column) else {
                        continue;
                    };
                    let across = |row: usize| {
                        let line = row * self.width;
                        source[line + left] * (1.0 - beside) + source[line + right] * beside
                    };
                    *value = across(top) * (1.0 - below) + across(bottom) * below;
                }
            }
        }
        drawn
    }

    /// Reads a picture to be resized to `width` x `height`; one that is many times larger is averaged before it takes
    /// the memory of floating point.
    fn read_for(path: &Path, width: usize, height: usize) -> Result<Self, PictureError> {
        let image = open(path)?;
        let times = |have: u32, wanted: usize| have / (SPARE * wanted.max(1) as u32);
        let reduction = times(image.width(), width).min(times(image.height(), height));
        Ok(Self::from_image(&image, reduction.max(1)))
    }

    /// The picture, in pixels that are the average light of `reduction` x `reduction` of the image's. What is left over
    /// at the right and below is cut off.
    fn from_image(image: &DynamicImage, reduction: u32) -> Self {
        if reduction > 1 {
            return Self::averaged(image, reduction);
        }
        let (width, height) = (image.width() as usize, image.height() as usize);
        let mut picture = Self::new(width, height);
        let eight_bits = image.color().bytes_per_pixel() == image.color().channel_count();
        let mut put = |index: usize, [r, g, b, alpha]: [f32; 4]| {
            for (channel, value) in [r, g, b].into_iter().enumerate() {
                picture.values[channel * width * height + index] = (value * alpha).clamp(0.0, 1.0);
            }
        };
        if eight_bits {
            for (index, pixel) in image.to_rgba8().pixels().enumerate() {
                put(index, pixel.0.map(|value| f32::from(value) / 255.0));
            }
        } else {
            for (index, pixel) in image.to_rgba32f().pixels().enumerate() {
                put(index, pixel.0);
            }
        }
        picture
    }

    fn averaged(image: &DynamicImage, reduction: u32) -> Self {
        let (columns, rows) = (image.width() / reduction, image.height() / reduction);
        let (width, height) = (columns as usize, rows as usize);
        let side = reduction as usize;
        let share = 1.0 / (side * side) as f32;
        let row = |row: u32| {
            let band = image.crop_imm(0, row * reduction, columns * reduction, reduction).to_rgba32f();
            let mut light = vec![[0.0; CHANNELS]; width];
            for (index, pixel) in band.pixels().enumerate() {
                let [r, g, b, alpha] = pixel.0;
                let sum = &mut light[index % (width * side) / side];
                for (sum, value) in sum.iter_mut().zip([r, g, b]) {
                    *sum += share * srgb_decode((value * alpha).clamp(0.0, 1.0));
                }
            }
            light
        };
        let lines: Vec<Vec<[f32; CHANNELS]>> = (0..rows).into_par_iter().map(row).collect();
        let mut picture = Self::new(width, height);
        for channel in 0..CHANNELS {
            let light = lines.iter().flatten().map(|light| srgb_encode(light[channel]));
            picture.channel_mut(channel).iter_mut().zip(light).for_each(|(value, code)| *value = code);
        }
        picture
    }

    /// Crops about the centre to the shape of `width` x `height` and resizes in linear light.
    fn fitted(self, width: usize, height: usize) -> Result<Self, String> {
        Fitted::new(self, width, height)?.whole()
    }
}

/// The two pixels of `count` between which the point lies that pixel `index` shows at `scale`, and the part of the
/// second; `None` outside.
fn neighbours(index: usize, count: usize, scale: f64) -> Option<(usize, usize, f32)> {
    let middle = (count as f64 - 1.0) / 2.0;
    let place = middle + (index as f64 - middle) * scale;
    if !(0.0..=count as f64 - 1.0).contains(&place) {
        return None;
    }
    let first = place.floor();
    Some((first as usize, (first as usize + 1).min(count - 1), (place - first) as f32))
}

/// Writes interleaved 8-bit RGB as a PNG file, whole or not at all: to a temporary file beside it, then renamed.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png_rgb8(path: &Path, pixels: &[u8], width: usize, height: usize) -> Result<(), PictureError> {
    let fail = |cause| PictureError::Unwritable { path: path.to_owned(), cause };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(fail)?;
    image::codecs::png::PngEncoder::new(std::io::BufWriter::new(&mut file))
        .write_image(pixels, width as u32, height as u32, image::ExtendedColorType::Rgb8)
        .map_err(|error| match error {
            image::ImageError::IoError(cause) => fail(cause),
            other => fail(std::io::Error::other(other)),
        })?;
    file.persist(path).map_err(|error| fail(error.error))?;
    Ok(())
}

#[cfg(test)]
mod tests;
