//! Printed charts that are measured by a photograph: what lies where on them, and finding it again.
//!
//! A chart has a ring with a dot in it at each corner, so that a photograph from any side, turned, or of the film's
//! back can be set straight, and one more dot beside the upper left ring that tells which way up it is. All else are
//! patches of known coverage. Lengths are mm from the chart's upper left corner, x to the right, y down.

mod field;
mod find;
mod measure;
mod overlay;
mod perspective;
mod solve;

pub use field::{Field, Sample, plane};
pub use find::{ChartError, Found, find, find_rather_than};
pub use measure::{Reading, read_patches};
pub use overlay::overlay;
pub use perspective::Perspective;

use crate::volume::CHANNELS;

/// From a chart's edges to the middles of its corner marks.
const MARK_INSET_MM: f64 = 6.0;
/// A corner mark's ring.
const RING_MM: std::ops::Range<f64> = 2.6..4.0;
/// A corner mark's dot.
const DOT_RADIUS_MM: f64 = 1.4;
/// From the upper left mark to the dot beside it, to the right.
const UPRIGHT_MM: f64 = 8.0;
/// Room at a chart's edges that its patches leave to the marks.
pub const MARGIN_MM: f64 = 12.0;
/// The ink of all marks: green, the channel in which cameras see best.
const MARK: [f32; CHANNELS] = [0.0, 1.0, 0.0];

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Width in mm.
    pub width_mm: f64,
    /// Height in mm.
    pub height_mm: f64,
    /// What is measured; patches lie apart from each other and within the margin.
    pub patches: Vec<Patch>,
}

/// A patch of one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Its middle, from the left.
    pub x_mm: f64,
    /// Its middle, from above.
    pub y_mm: f64,
    /// Width and height, or diameter.
    pub size_mm: f64,
    /// Its outline.
    pub shape: Shape,
    /// Coverage of each ink, 0..=1.
    pub coverages: [f32; CHANNELS],
}

/// A patch's outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A square.
    Square,
    /// A disc.
    Disc,
}

impl Patch {
    fn holds(&self, x_mm: f64, y_mm: f64) -> bool {
        let (x, y, half) = (x_mm - self.x_mm, y_mm - self.y_mm, self.size_mm / 2.0);
        match self.shape {
            Shape::Square => x.abs() <= half && y.abs() <= half,
            Shape::Disc => x.hypot(y) <= half,
        }
    }
}

impl Chart {
    /// The middles of the corner marks: upper left, upper right, lower right, lower left.
    fn marks(&self) -> [[f64; 2]; 4] {
        let (left, right) = (MARK_INSET_MM, self.width_mm - MARK_INSET_MM);
        let (top, bottom) = (MARK_INSET_MM, self.height_mm - MARK_INSET_MM);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    /// The middle of the dot that tells which way up the chart is.
    fn upright(&self) -> [f64; 2] {
        [MARK_INSET_MM + UPRIGHT_MM, MARK_INSET_MM]
    }

    /// The chart with those patches alone that reach the height `y_mm`: quicker to ask there.
    pub fn at_height(&self, y_mm: f64) -> Self {
        let reaches = |patch: &&Patch| (patch.y_mm - y_mm).abs() <= patch.size_mm / 2.0;
        Self { patches: self.patches.iter().filter(reaches).copied().collect(), ..*self }
    }

    /// The coverage of each ink at a point.
    pub fn coverages_at(&self, x_mm: f64, y_mm: f64) -> [f32; CHANNELS] {
        let distance = |[x, y]: [f64; 2]| (x_mm - x).hypot(y_mm - y);
        let marked =
            self.marks().into_iter().map(distance).any(|d| d <= DOT_RADIUS_MM || RING_MM.contains(&d));
        if marked || distance(self.upright()) <= DOT_RADIUS_MM {
            return MARK;
        }
        let patch = self.patches.iter().find(|patch| patch.holds(x_mm, y_mm));
        patch.map_or([0.0; CHANNELS], |patch| patch.coverages)
    }
}

#[cfg(test)]
pub(crate) mod photograph;
#[cfg(test)]
mod tests;
