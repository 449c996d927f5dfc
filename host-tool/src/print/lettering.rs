//! Text as outlines, so that sheets need no font where they are printed.
//!
//! The letters are those of DejaVu Sans Condensed, which may be used and passed on freely (Bitstream Vera licence).

use std::sync::OnceLock;

use kurbo::{Affine, BezPath};
use ttf_parser::{Face, OutlineBuilder};

/// How heavy letters are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weight {
    Regular,
    Bold,
}

/// A line of text as outlines in mm: its baseline starts at the origin, y runs down.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) outline: BezPath,
    pub(super) width_mm: f64,
}

/// Sets `text` in letters of `size_mm` to the em; letters that the font lacks become empty boxes.
pub(super) fn line(text: &str, size_mm: f64, weight: Weight) -> Line {
    let mut outline = BezPath::new();
    let mut at = 0.0;
    let Some(face) = face(weight) else { return Line { outline, width_mm: 0.0 } };
    let scale = size_mm / f64::from(face.units_per_em());
    for letter in text.chars() {
        let glyph = face.glyph_index(letter).unwrap_or_default();
        let mut pen = Pen(BezPath::new());
        face.outline_glyph(glyph, &mut pen);
        let place = Affine::translate((at, 0.0)) * Affine::scale_non_uniform(scale, -scale);
        outline.extend(place * pen.0);
        at += f64::from(face.glyph_hor_advance(glyph).unwrap_or_default()) * scale;
    }
    Line { outline, width_mm: at }
}

/// As [`line()`], in smaller letters where it would be longer than `most_mm`.
pub(super) fn fitted_line(text: &str, size_mm: f64, weight: Weight, most_mm: f64) -> Line {
    let full = line(text, size_mm, weight);
    if full.width_mm <= most_mm {
        return full;
    }
    line(text, size_mm * most_mm / full.width_mm, weight)
}

fn face(weight: Weight) -> Option<&'static Face<'static>> {
    static REGULAR: OnceLock<Option<Face<'static>>> = OnceLock::new();
    static BOLD: OnceLock<Option<Face<'static>>> = OnceLock::new();
    let (place, bytes): (_, fn() -> &'static [u8]) = match weight {
        Weight::Regular => (&REGULAR, dejavu::sans_condensed::regular),
        Weight::Bold => (&BOLD, dejavu::sans_condensed::bold),
    };
    place.get_or_init(|| Face::parse(bytes(), 0).ok()).as_ref()
}

/// Draws a glyph into a path.
struct Pen(BezPath);

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to((f64::from(x), f64::from(y)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to((f64::from(x), f64::from(y)));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to((f64::from(x1), f64::from(y1)), (f64::from(x), f64::from(y)));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let point = |x, y| (f64::from(x), f64::from(y));
        self.0.curve_to(point(x1, y1), point(x2, y2), point(x, y));
    }

    fn close(&mut self) {
        self.0.close_path();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kurbo::Shape;

    #[test]
    fn letters_stand_on_the_baseline_and_long_lines_shrink() {
        let set = line("H", 10.0, Weight::Regular);
        let bounds = set.outline.bounding_box();
        // The capitals of this font are 0.729 em high.
        assert!((bounds.y0 + 7.29).abs() < 0.02 && bounds.y1.abs() < 1e-9, "{bounds:?}");
        let long = fitted_line(&"M".repeat(48), 4.0, Weight::Bold, 35.0);
        assert!((long.width_mm - 35.0).abs() < 1e-6);
        assert!(long.outline.bounding_box().width() <= 35.0);
        assert!(line("Größe, Ωμέγα, Музей", 3.0, Weight::Regular).width_mm > 20.0);
    }
}
