//! What is drawn beside the films: filled shapes in mm, x to the right, y down from the sheet's upper left corner.

use kurbo::{Affine, BezPath, Circle, Rect, Shape as _};

use super::lettering::{Line, Weight, fitted_line};

/// Full ink in all three channels.
pub(super) const ALL: Ink = [u16::MAX; 3];

/// Ink of the three channels, 65,535 for full.
pub(super) type Ink = [u16; 3];

/// How far curves may be off, in mm: less than any dot.
const TOLERANCE_MM: f64 = 0.002;

/// A filled shape (non-zero winding).
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) path: BezPath,
    pub(super) ink: Ink,
}

/// Shapes, later ones over earlier ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawing {
    pub(super) shapes: Vec<Shape>,
    /// The thinnest line that the printer lays without gaps.
    hairline_mm: f64,
}

/// Where a text stands beside its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
}

impl Drawing {
    /// An empty drawing whose thinnest lines are `hairline_mm` thick.
    pub(super) fn new(hairline_mm: f64) -> Self {
        Self { shapes: Vec::new(), hairline_mm }
    }

    pub(super) fn hairline_mm(&self) -> f64 {
        self.hairline_mm
    }

    /// Adds all shapes of another drawing, moved or turned.
    pub(super) fn add(&mut self, other: Self, place: Affine) {
        self.shapes.extend(other.shapes.into_iter().map(|shape| Shape { path: place * shape.path, ..shape }));
    }

    pub(super) fn fill(&mut self, path: BezPath, ink: Ink) {
        self.shapes.push(Shape { path, ink });
    }

    pub(super) fn rectangle(&mut self, x: f64, y: f64, width: f64, height: f64, ink: Ink) {
        self.fill(Rect::new(x, y, x + width, y + height).to_path(TOLERANCE_MM), ink);
    }

    /// A hairline around a rectangle, inside of it.
    pub(super) fn frame(&mut self, x: f64, y: f64, width: f64, height: f64) {
        let line = self.hairline_mm;
        self.rectangle(x, y, width, line, ALL);
        self.rectangle(x, y + height - line, width, line, ALL);
        self.rectangle(x, y, line, height, ALL);
        self.rectangle(x + width - line, y, line, height, ALL);
    }

    /// A hairline to the right from (x, y).
    pub(super) fn across(&mut self, x: f64, y: f64, length: f64) {
        self.rectangle(x, y - self.hairline_mm / 2.0, length, self.hairline_mm, ALL);
    }

    /// A hairline down from (x, y).
    pub(super) fn down(&mut self, x: f64, y: f64, length: f64) {
        self.rectangle(x - self.hairline_mm / 2.0, y, self.hairline_mm, length, ALL);
    }

    /// Two hairlines that cross at (x, y), each `reach` long to either side.
    pub(super) fn cross(&mut self, x: f64, y: f64, reach: f64) {
        self.across(x - reach, y, 2.0 * reach);
        self.down(x, y - reach, 2.0 * reach);
    }

    /// A circle of hairline about (x, y).
    pub(super) fn ring(&mut self, x: f64, y: f64, radius: f64) {
        let half = self.hairline_mm / 2.0;
        let mut path = Circle::new((x, y), radius + half).to_path(TOLERANCE_MM);
        path.extend(Circle::new((x, y), radius - half).to_path(TOLERANCE_MM).reverse_subpaths());
        self.fill(path, ALL);
    }

    /// A mark by which films are laid upon each other.
    pub(super) fn target(&mut self, x: f64, y: f64, radius: f64) {
        self.ring(x, y, radius * 0.6);
        self.cross(x, y, radius);
    }

    /// An arrow that points up, its tip at (x, y).
    pub(super) fn arrow_up(&mut self, x: f64, y: f64, height: f64) {
        let (half, shaft) = (height * 0.45, height * 0.14);
        let mut path = BezPath::new();
        path.move_to((x, y));
        for (dx, dy) in
            [(half, 0.55), (shaft, 0.55), (shaft, 1.0), (-shaft, 1.0), (-shaft, 0.55), (-half, 0.55)]
        {
            path.line_to((x + dx, y + dy * height));
        }
        path.close_path();
        self.fill(path, ALL);
    }

    /// A line of text with its baseline at y, in smaller letters where it would be longer than `most_mm`; returns its
    /// width.
    pub(super) fn text(&mut self, x: f64, y: f64, text: &str, style: Style) -> f64 {
        let Line { outline, width_mm } = fitted_line(text, style.size_mm, style.weight, style.most_mm);
        let left = match style.align {
            Align::Left => x,
            Align::Middle => x - width_mm / 2.0,
            Align::Right => x - width_mm,
        };
        self.fill(Affine::translate((left, y)) * outline, ALL);
        width_mm
    }

    /// Turns the drawing as a mirror does that stands on a sheet of this width.
    pub(super) fn mirror(&mut self, width_mm: f64) {
        let mirror = Affine::new([-1.0, 0.0, 0.0, 1.0, width_mm, 0.0]);
        for shape in &mut self.shapes {
            shape.path.apply_affine(mirror);
        }
    }
}

/// How a text is set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    pub(super) size_mm: f64,
    pub(super) weight: Weight,
    pub(super) align: Align,
    pub(super) most_mm: f64,
}

impl Style {
    pub(super) fn plain(size_mm: f64) -> Self {
        Self { size_mm, weight: Weight::Regular, align: Align::Left, most_mm: f64::INFINITY }
    }

    pub(super) fn bold(size_mm: f64) -> Self {
        Self { weight: Weight::Bold, ..Self::plain(size_mm) }
    }

    pub(super) fn aligned(self, align: Align) -> Self {
        Self { align, ..self }
    }

    pub(super) fn within(self, most_mm: f64) -> Self {
        Self { most_mm, ..self }
    }
}
