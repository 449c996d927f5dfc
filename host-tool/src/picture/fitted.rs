//! A picture cropped and resized to a film, some rows at a time.

use std::ops::Range;

use fast_image_resize::images::TypedImage;
use fast_image_resize::pixels::F32;
use fast_image_resize::{FilterType, ImageView, ResizeAlg, ResizeOptions, Resizer};

use super::{Picture, srgb_encode};
use crate::volume::CHANNELS;

/// Rows that are resized together. The whole is resized in the same pieces, so that rows are the same either way.
const ROWS_AT_ONCE: usize = 256;

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
        let light = picture.decoded();
        let channel = |channel: usize| {
            let pixels = light.channel(channel).iter().map(|&value| F32::new(value)).collect();
            TypedImage::from_pixels(picture.width as u32, picture.height as u32, pixels)
                .map_err(|error| error.to_string())
        };
        let channels = Box::new([channel(0)?, channel(1)?, channel(2)?]);
        let crop = [left.max(0.0), top.max(0.0), crop_width, crop_height];
        let fitted = Self { width, height, source: Source::Light(channels, crop) };
        fitted.resized_rows(0..1)?;
        fitted.resized_rows(height - 1..height)?;
        Ok(fitted)
    }

    /// The whole picture.
    pub(super) fn whole(self) -> Result<Picture, String> {
        match self.source {
            Source::Same(picture) => Ok(picture),
            Source::Light(..) => self.resized_rows(0..self.height),
        }
    }

    /// Some rows of it: sRGB code values.
    pub fn rows(&self, rows: Range<usize>) -> Picture {
        let count = rows.len();
        // What can be resized was found out when the picture was prepared.
        self.resized_rows(rows).unwrap_or_else(|_| Picture::new(self.width, count))
    }

    /// Bytes of the picture that is held.
    pub fn held_bytes(&self) -> usize {
        let values = match &self.source {
            Source::Same(picture) => picture.values().len(),
            Source::Light(light, _) => light.iter().map(|light| light.pixels().len()).sum(),
        };
        values * size_of::<f32>()
    }

    fn resized_rows(&self, rows: Range<usize>) -> Result<Picture, String> {
        let mut picture = Picture::new(self.width, rows.len());
        let width = self.width;
        match &self.source {
            Source::Same(whole) => {
                for channel in 0..CHANNELS {
                    let source = &whole.channel(channel)[rows.start * width..rows.end * width];
                    picture.channel_mut(channel).copy_from_slice(source);
                }
            }
            Source::Light(light, crop) => {
                let pieces = rows.start / ROWS_AT_ONCE..rows.end.div_ceil(ROWS_AT_ONCE);
                for piece in pieces {
                    let first = piece * ROWS_AT_ONCE;
                    let piece = first..(first + ROWS_AT_ONCE).min(self.height);
                    let wanted = piece.start.max(rows.start)..piece.end.min(rows.end);
                    for (channel, light) in light.iter().enumerate() {
                        let resized = self.resized(light, *crop, piece.clone())?;
                        let source =
                            &resized.pixels()[(wanted.start - first) * width..(wanted.end - first) * width];
                        let place = (wanted.start - rows.start) * width..(wanted.end - rows.start) * width;
                        let target = &mut picture.channel_mut(channel)[place];
                        for (value, pixel) in target.iter_mut().zip(source) {
                            *value = srgb_encode(pixel.0.clamp(0.0, 1.0));
                        }
                    }
                }
            }
        }
        Ok(picture)
    }

    /// One piece of one channel.
    fn resized(
        &self,
        light: &TypedImage<'static, F32>,
        [left, top, width, height]: [f64; 4],
        rows: Range<usize>,
    ) -> Result<TypedImage<'static, F32>, String> {
        let row = height / self.height as f64;
        let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(FilterType::Lanczos3)).crop(
            left,
            top + rows.start as f64 * row,
            width,
            (rows.len() as f64 * row).min(f64::from(light.height()) - (top + rows.start as f64 * row)),
        );
        let mut target = TypedImage::new(self.width as u32, rows.len() as u32);
        Resizer::new().resize_typed(light, &mut target, &options).map_err(|error| error.to_string())?;
        Ok(target)
    }
}
