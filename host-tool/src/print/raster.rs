//! A drawing in printer dots, row by row.

use kurbo::{BezPath, PathEl, Point};

use super::dots::{INCH_MM, Resolution};
use super::drawing::{Drawing, Ink};

/// Dots `start..end` of one row with the same ink.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Span {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) ink: Ink,
}

/// A drawing cut into the edges of its shapes.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    shapes: Vec<Edges>,
    width: usize,
}

#[derive(Clone, Debug)]
struct Edges {
    top: f64,
    bottom: f64,
    /// From and to, in dots.
    edges: Vec<(Point, Point)>,
    ink: Ink,
}

/// How far a flattened curve may be off, in dots.
const TOLERANCE: f64 = 0.1;

impl Raster {
    /// Cuts `drawing` for a sheet of `width` dots.
    pub(super) fn new(drawing: &Drawing, resolution: Resolution, width: usize) -> Self {
        let shapes = drawing.shapes.iter().map(|shape| Edges::new(&shape.path, shape.ink, resolution));
        Self { shapes: shapes.filter(|shape| !shape.edges.is_empty()).collect(), width }
    }

    /// What is drawn in the row: a dot is inked where its centre lies inside a shape. Later spans lie over earlier ones.
    pub(super) fn row(&self, row: usize) -> Vec<Span> {
        let y = row as f64 + 0.5;
        let mut spans = Vec::new();
        for shape in self.shapes.iter().filter(|shape| shape.top <= y && y < shape.bottom) {
            shape.cut(y, self.width, &mut spans);
        }
        spans
    }
}

impl Edges {
    fn new(path: &BezPath, ink: Ink, resolution: Resolution) -> Self {
        let scale = kurbo::Affine::scale_non_uniform(resolution.dpi_x / INCH_MM, resolution.dpi_y / INCH_MM);
        let mut edges = Vec::new();
        let (mut start, mut at) = (Point::ZERO, Point::ZERO);
        kurbo::flatten(scale * path, TOLERANCE, |element| match element {
            PathEl::MoveTo(point) => (start, at) = (point, point),
            PathEl::LineTo(point) => {
                edges.push((at, point));
                at = point;
            }
            _ => {
                edges.push((at, start));
                at = start;
            }
        });
        edges.retain(|(from, to)| from.y != to.y);
        let ys = edges.iter().flat_map(|(from, to)| [from.y, to.y]);
        let top = ys.clone().fold(f64::INFINITY, f64::min);
        let bottom = ys.fold(f64::NEG_INFINITY, f64::max);
        Self { top, bottom, edges, ink }
    }

    /// Adds the spans along the line at `y`.
    fn cut(&self, y: f64, width: usize, spans: &mut Vec<Span>) {
        let mut crossings: Vec<(f64, i32)> = self
            .edges
            .iter()
            .filter(|(from, to)| (from.y <= y) != (to.y <= y))
            .map(|(from, to)| {
                let x = from.x + (y - from.y) / (to.y - from.y) * (to.x - from.x);
                (x, if from.y < to.y { 1 } else { -1 })
            })
            .collect();
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        let mut left = 0.0;
        for (x, turn) in crossings {
            if winding == 0 {
                left = x;
            }
            winding += turn;
            if winding == 0 {
                // A centre lies at a whole number and a half.
                let dot = |x: f64| ((x - 0.5).ceil().max(0.0) as usize).min(width);
                let (start, end) = (dot(left), dot(x));
                if start < end {
                    spans.push(Span { start, end, ink: self.ink });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::print::drawing::ALL;

    #[test]
    fn dots_are_inked_where_their_centres_lie_inside() {
        let mut drawing = Drawing::new(1.0);
        // One dot is 1 mm wide and 2 mm high.
        let resolution = Resolution { dpi_x: INCH_MM, dpi_y: INCH_MM / 2.0 };
        drawing.rectangle(1.0, 1.5, 2.6, 4.0, ALL);
        let raster = Raster::new(&drawing, resolution, 10);
        let inked = Span { start: 1, end: 4, ink: ALL };
        let rows: Vec<Vec<Span>> = (0..4).map(|row| raster.row(row)).collect();
        assert_eq!(rows, [vec![], vec![inked.clone()], vec![inked], vec![]]);
    }

    #[test]
    fn a_ring_is_hollow_and_covers_its_area() {
        let mut drawing = Drawing::new(2.0);
        let resolution = Resolution { dpi_x: 10.0 * INCH_MM, dpi_y: 10.0 * INCH_MM };
        drawing.ring(20.0, 20.0, 10.0);
        let raster = Raster::new(&drawing, resolution, 400);
        assert_eq!(raster.row(200).len(), 2);
        let dots: usize = (0..400).flat_map(|row| raster.row(row)).map(|span| span.end - span.start).sum();
        let wanted = std::f64::consts::PI * (110.0f64.powi(2) - 90.0f64.powi(2));
        assert!((dots as f64 / wanted - 1.0).abs() < 0.01, "{dots} {wanted}");
    }
}
