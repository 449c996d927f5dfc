//! What viewer sensors deliver.

use heapless::Vec;

use crate::units::CentiDegrees;

/// Rows of a thermal sensor.
pub const ROWS: usize = 8;
/// Columns of a thermal sensor.
pub const COLUMNS: usize = 8;
/// Pixels of a thermal sensor.
pub const PIXELS: usize = ROWS * COLUMNS;

/// One picture of a Grid-EYE thermal sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThermalFrame {
    /// Temperatures in quarters of a degree Celsius, row by row. Row 0 looks highest; column 0 looks furthest to
    /// the negative horizontal side, that is, to the left as a viewer facing the stack sees it.
    pub pixels: [i16; PIXELS],
    /// Where the middle of the sensor looks, to the right of the stack's normal.
    pub yaw: CentiDegrees,
    /// How far the sensor stands to the right of the stack's middle, in mm.
    pub right_mm: i16,
    /// How far the middle of the sensor looks above the horizontal.
    pub pitch: CentiDegrees,
}

impl ThermalFrame {
    /// The yaw of the two sensors: 25 degrees to either side.
    pub const YAW: CentiDegrees = CentiDegrees(2_500);
    /// The sensors' distance from the stack's middle in mm.
    pub const RIGHT_MM: i16 = 20;

    /// A picture of the sensor that looks to the left.
    pub const fn left(pixels: [i16; PIXELS]) -> Self {
        Self { pixels, yaw: CentiDegrees(-Self::YAW.0), right_mm: -Self::RIGHT_MM, pitch: CentiDegrees(0) }
    }

    /// A picture of the sensor that looks to the right.
    pub const fn right(pixels: [i16; PIXELS]) -> Self {
        Self { pixels, yaw: Self::YAW, right_mm: Self::RIGHT_MM, pitch: CentiDegrees(0) }
    }
}

/// One target of the radar sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RadarTarget {
    /// To the right of the stack's middle in mm.
    pub x_mm: i16,
    /// Before the stack in mm.
    pub y_mm: i16,
}

/// One report of the LD2450 radar sensor: up to three targets.
pub type RadarFrame = Vec<RadarTarget, 3>;
