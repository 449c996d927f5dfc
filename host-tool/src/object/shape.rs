//! What models are made of.

use super::texture::Texture;
use crate::picture::srgb_decode;

/// A point in space, or a direction.
pub(super) type Vector = [f64; 3];

/// The colour of what has none: white.
pub(super) const UNCOLOURED: [u8; 3] = [255; 3];

/// A point of a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// In the model's units.
    pub(super) position: Vector,
    /// sRGB code values.
    pub(super) colour: [u8; 3],
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Corner {
    /// In the model's units.
    pub(super) position: Vector,
    /// Light of each channel, 0..=1.
    pub(super) light: [f32; 3],
    /// Where in the texture the corner lies: (0, 0) is its upper left, (1, 1) its lower right corner.
    pub(super) texture: [f32; 2],
}

impl Corner {
    /// A corner of this colour in sRGB code values.
    pub(super) fn of(position: Vector, colour: [u8; 3]) -> Self {
        Self { position, light: colour.map(|code| srgb_decode(f32::from(code) / 255.0)), texture: [0.0; 2] }
    }
}

/// Three corners.
pub(super) type Triangle = [Corner; 3];

/// Takes the pieces of a model, from any thread and in any order.
pub(super) trait Sink: Sync {
    /// Takes some points.
    fn points(&self, points: &[Point]);

    /// Takes some triangles of one material; its texture's light is multiplied with that of the corners.
    fn triangles(&self, triangles: &[Triangle], texture: Option<&Texture>);
}

/// The smallest box around what has been seen of a model, in its own units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Box3 {
    /// The least coordinates.
    pub least: [f64; 3],
    /// The largest coordinates.
    pub most: [f64; 3],
}

impl Box3 {
    /// A box around nothing.
    pub const EMPTY: Self = Self { least: [f64::INFINITY; 3], most: [f64::NEG_INFINITY; 3] };

    /// Widens the box so that it holds `position`, if that is finite.
    pub fn hold(&mut self, position: [f64; 3]) {
        if position.iter().all(|value| value.is_finite()) {
            *self = self.with(Self { least: position, most: position });
        }
    }

    /// The box around both.
    pub fn with(self, other: Self) -> Self {
        Self {
            least: [0, 1, 2].map(|axis| self.least[axis].min(other.least[axis])),
            most: [0, 1, 2].map(|axis| self.most[axis].max(other.most[axis])),
        }
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.least[axis] > self.most[axis])
    }

    /// Its length along each axis.
    pub fn size(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.most[axis] - self.least[axis])
    }

    /// Its middle.
    pub fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.least[axis] + (self.most[axis] - self.least[axis]) / 2.0)
    }
}
