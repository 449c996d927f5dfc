//! A picture to put other pictures and captions on.

use std::convert::Infallible;

use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};
use image::imageops::{FilterType, overlay, resize};
use image::{Rgb, RgbImage};

/// What captions are written in.
pub(crate) const INK: Rgb888 = Rgb888::new(0xDD, 0xDD, 0xDD);
const GROUND: Rgb<u8> = Rgb([0x16, 0x16, 0x18]);

/// A picture to put other pictures and captions on.
pub(crate) struct Canvas(RgbImage);

impl Canvas {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self(RgbImage::from_pixel(width, height, GROUND))
    }

    pub(crate) fn into_image(self) -> RgbImage {
        self.0
    }

    /// Puts `picture` with its upper left corner at `left` and `top`, as wide and high as said.
    pub(crate) fn picture(&mut self, picture: &RgbImage, [left, top]: [u32; 2], [width, height]: [u32; 2]) {
        let fitted = resize(picture, width, height, FilterType::CatmullRom);
        overlay(&mut self.0, &fitted, i64::from(left), i64::from(top));
    }

    /// Writes a line whose upper edge is at `top` around `middle`.
    pub(crate) fn caption(&mut self, text: &str, middle: u32, top: u32, font: &MonoFont<'_>) {
        let style = TextStyleBuilder::new().alignment(Alignment::Center).baseline(Baseline::Top).build();
        let at = Point::new(middle as i32, top as i32);
        // Drawing on a picture in memory cannot fail.
        let Ok(_) = Text::with_text_style(text, at, MonoTextStyle::new(font, INK), style).draw(self);
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            let place = u32::try_from(at.x).ok().zip(u32::try_from(at.y).ok());
            if let Some(pixel) = place.and_then(|(x, y)| self.0.get_pixel_mut_checked(x, y)) {
                *pixel = Rgb([color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}
