//! A picture cropped and resized to a film, some rows at a time.

use std::ops::Range;

use fast_image_resize::images::TypedImage;
use fast_image_resize::pixels::F32;
use fast_image_resize::{FilterType, ImageView, ResizeAlg, ResizeOptions, Resizer};

use super::{Picture, srgb_encode};
use crate::volume::CHANNELS;

/// Rows that are resized together. The whole is resized in the same pieces, so that rows are the same either way.
const ROWS_AT_ONCE: usize = 256;

/// How far the filter looks, in pixels of the coarser of the two.
const FILTER_REACH: f64 = 3.0;

/// A picture that is cropped about its centre to the shape of `width` x `height` and resized in linear light.
pub struct Fitted {
    width: usize,
    height: usize,
    source: Source,
}

enum Source {
    /// It has this size already: code values.
    Same(Picture),
    /// Light, by channel, and the crop: left, top, width, height.
    Light(Box<[TypedImage<'static, F32>; CHANNELS]>, [f64; 4]),
}

impl Fitted {
    /// Prepares `picture`, of sRGB code values.
    pub(super) fn new(picture: Picture, width: usize, height: usize) -> Result<Self, String> {
        if (picture.width, picture.height) == (width, height) {
            return Ok(Self { width, height, source: Source::Same(picture) });
        }
        let scale = (picture.width as f64 / width as f64).min(picture.height as f64 / height as f64);
        let (crop_width, crop_height) = (scale * width as f64, scale * height as f64);
        let (left, top) =
            ((picture.width as f64 - crop_width) / 2.0, (picture.height as f64 - crop_height) / 2.0);
        let channels = light_of(&picture)?;
        let crop = [left.max(0.0), top.max(0.0), crop_width, crop_height];
        let fitted = Self { width, height, source: Source::Light(channels, crop) };
        fitted.resized_rows((width, height), 0..1)?;
        fitted.resized_rows((width, height), height - 1..height)?;
        Ok(fitted)
    }

    /// The whole picture.
    pub(super) fn whole(self) -> Result<Picture, String> {
        match self.source {
            Source::Same(picture) => Ok(picture),
            Source::Light(..) => self.resized_rows((self.width, self.height), 0..self.height),
        }
    }

    /// Some rows of it when it has `size` columns and rows: sRGB code values.
    pub fn rows(&self, size: (usize, usize), rows: Range<usize>) -> Picture {
        let count = rows.len();
        // What can be resized was found out when the picture was prepared.
        self.resized_rows(size, rows).unwrap_or_else(|_| Picture::new(size.0, count))
    }

    /// Bytes of the picture that is held.
    pub fn held_bytes(&self) -> usize {
        let values = match &self.source {
            Source::Same(picture) => picture.values().len(),
            Source::Light(light, _) => light.iter().map(|light| light.pixels().len()).sum(),
        };
        values * size_of::<f32>()
    }

    fn resized_rows(&self, size: (usize, usize), rows: Range<usize>) -> Result<Picture, String> {
        match &self.source {
            Source::Same(whole) if size == (self.width, self.height) => Ok(whole.rows(rows)),
            Source::Same(whole) => {
                // As many of its rows as the filter looks at.
                let row = self.height as f64 / size.1 as f64;
                let reach = FILTER_REACH * row.max(1.0) + 1.0;
                let first = (rows.start as f64 * row - reach).max(0.0) as usize;
                let last = ((rows.end as f64 * row + reach) as usize).min(self.height);
                let light = light_of(&whole.rows(first..last))?;
                let crop = [0.0, -(first as f64), self.width as f64, self.height as f64];
                let mut picture = Picture::new(size.0, rows.len());
                for (channel, light) in light.iter().enumerate() {
                    let resized = resized(light, crop, size, rows.clone())?;
                    encode(resized.pixels(), picture.channel_mut(channel));
                }
                Ok(picture)
            }
            Source::Light(light, crop) => {
                let mut picture = Picture::new(size.0, rows.len());
                let line = |row: usize| row * size.0;
                for piece in rows.start / ROWS_AT_ONCE..rows.end.div_ceil(ROWS_AT_ONCE) {
                    let first = piece * ROWS_AT_ONCE;
                    let piece = first..(first + ROWS_AT_ONCE).min(size.1);
                    let wanted = piece.start.max(rows.start)..piece.end.min(rows.end);
                    for (channel, light) in light.iter().enumerate() {
                        let resized = resized(light, *crop, size, piece.clone())?;
                        let source = &resized.pixels()[line(wanted.start - first)..line(wanted.end - first)];
                        let place = line(wanted.start - rows.start)..line(wanted.end - rows.start);
                        encode(source, &mut picture.channel_mut(channel)[place]);
                    }
                }
                Ok(picture)
            }
        }
    }
}

/// The light of a picture, by channel.
fn light_of(picture: &Picture) -> Result<Box<[TypedImage<'static, F32>; CHANNELS]>, String> {
    let light = picture.decoded();
    let channel = |channel: usize| {
        let pixels = light.channel(channel).iter().map(|&value| F32::new(value)).collect();
        TypedImage::from_pixels(picture.width as u32, picture.height as u32, pixels)
            .map_err(|error| error.to_string())
    };
    Ok(Box::new([channel(0)?, channel(1)?, channel(2)?]))
}

/// Turns light into code values.
fn encode(light: &[F32], codes: &mut [f32]) {
    codes.iter_mut().zip(light).for_each(|(code, light)| *code = srgb_encode(light.0.clamp(0.0, 1.0)));
}

/// Some rows of one channel, cropped (left, top, width, height) and brought to `size` columns and rows.
fn resized(
    light: &TypedImage<'static, F32>,
    [left, top, width, height]: [f64; 4],
    size: (usize, usize),
    rows: Range<usize>,
) -> Result<TypedImage<'static, F32>, String> {
    let row = height / size.1 as f64;
    let first = top + rows.start as f64 * row;
    let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(FilterType::Lanczos3)).crop(
        left,
        first,
        width,
        (rows.len() as f64 * row).min(f64::from(light.height()) - first),
    );
    let mut target = TypedImage::new(size.0 as u32, rows.len() as u32);
    Resizer::new().resize_typed(light, &mut target, &options).map_err(|error| error.to_string())?;
    Ok(target)
}
