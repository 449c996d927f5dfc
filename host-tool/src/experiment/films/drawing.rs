//! The experiment as a picture.

use embedded_graphics::mono_font::iso_8859_1::{FONT_6X10, FONT_9X18_BOLD};
use image::{Rgb, RgbImage};

use super::{MOST_FILMS, SIDES, Side, Transmittance};
use crate::canvas::Canvas;
use crate::ink::YIELDS;
use crate::picture::srgb_encode;

const CELL: u32 = 44;
const GAP: u32 = 20;
const LINE: u32 = 24;
const DISC: u32 = 34;
const ROWS: u32 = YIELDS.len() as u32;
/// From a band's upper edge to its circles: its title and two lines above each column.
const HEAD: u32 = LINE + 28;
const BAND: u32 = HEAD + ROWS * CELL;

/// Draws the circles of the three inks behind 0 to 25 films, a band for each side, brightest ink as bright as can be.
pub fn draw(films: Transmittance) -> RgbImage {
    let width = 2 * GAP + CELL * (MOST_FILMS as u32 + 1);
    let mut canvas = Canvas::new(width, GAP + SIDES.len() as u32 * (BAND + GAP));
    for (index, side) in SIDES.into_iter().enumerate() {
        band(&mut canvas, films, side, GAP + index as u32 * (BAND + GAP), width / 2);
    }
    canvas.into_image()
}

fn band(canvas: &mut Canvas, films: Transmittance, side: Side, top: u32, middle: u32) {
    let place = match side {
        Side::Lamp => "films between lamp and circles",
        Side::Viewer => "films between circles and viewer",
        Side::Both => "films before the circles, lamp and viewer before the films",
    };
    let title = format!("{place}: {:.1} % a film", films.of(side) * 100.0);
    canvas.caption(&title, middle, top, &FONT_9X18_BOLD);
    // The circles lie on one dark film.
    let film = [CELL * (MOST_FILMS as u32 + 1), ROWS * CELL];
    canvas.picture(&RgbImage::new(film[0], film[1]), [GAP, top + HEAD - 5], film);
    for count in 0..=MOST_FILMS {
        let left = GAP + count as u32 * CELL;
        let part = films.behind(count, side);
        let percent = format!("{:.*} %", usize::from(part < 0.0995), part * 100.0);
        canvas.caption(&count.to_string(), left + CELL / 2, top + LINE, &FONT_6X10);
        canvas.caption(&percent, left + CELL / 2, top + LINE + 12, &FONT_6X10);
        for (ink, light) in YIELDS.iter().enumerate() {
            let above = top + HEAD + ink as u32 * CELL;
            let brightness = light * part / YIELDS[2];
            canvas.picture(&disc(ink, brightness as f32), [left + 5, above], [DISC, DISC]);
        }
    }
}

/// A disc that glows in one ink's colour on dark film.
fn disc(ink: usize, light: f32) -> RgbImage {
    RgbImage::from_fn(DISC, DISC, |x, y| {
        let middle = (f64::from(DISC) - 1.0) / 2.0;
        let distance = (f64::from(x) - middle).hypot(f64::from(y) - middle);
        // The rim takes up one pixel.
        let inside = (middle + 0.5 - distance).clamp(0.0, 1.0) as f32;
        let mut pixel = [0; 3];
        pixel[ink] = (srgb_encode(light * inside) * 255.0).round() as u8;
        Rgb(pixel)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_fade_with_the_films_before_them() {
        let picture = draw(Transmittance { tau_uv: 0.82, tau_visible: 0.90 });
        let middle = |count: u32, band: u32, ink: u32| {
            let x = GAP + count * CELL + 5 + DISC / 2;
            let y = GAP + band * (BAND + GAP) + HEAD + ink * CELL + DISC / 2;
            picture.get_pixel(x, y).0
        };
        assert_eq!(middle(0, 0, 2), [0, 0, 255]);
        for band in 0..3 {
            for ink in 0..3 {
                let glow = |count| middle(count, band, ink)[ink as usize];
                assert!((1..12).all(|count| glow(count) < glow(count - 1)), "band {band}, ink {ink}");
                assert!((12..26).all(|count| glow(count) <= glow(count - 1)), "band {band}, ink {ink}");
            }
        }
        // 0.82^20 of full light in sRGB.
        let wanted = (srgb_encode(0.82_f32.powi(20)) * 255.0).round() as u8;
        assert_eq!(middle(20, 0, 2)[2], wanted);
    }
}
