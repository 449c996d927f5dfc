//! Where viewers stand: sensors give sightings, the tracker follows them, the selector chooses a view.
//!
//! Numbers in here that name no source are this design's own: what serves best in the simulated room of the tests, with
//! people of many heights, paces and distances. A real room may want others.

mod axis;
mod eye;
mod frame;
mod radar;
mod selector;
mod thermal;
mod tracker;

use heapless::Vec;
use serde::{Deserialize, Serialize};

pub use self::frame::{COLUMNS, PIXELS, ROWS, RadarFrame, RadarTarget, ThermalFrame};
pub use self::radar::{REPORT_BYTES, Radar, parse_report};
pub use self::selector::{Selector, nearest_view};
pub use self::thermal::ThermalPair;
pub use self::tracker::{MAX_TRACKS, Track, Tracker};
use crate::units::{CentiDegrees, Milliseconds};

/// The most sightings of one frame.
pub const MAX_SIGHTINGS: usize = 6;

/// Where a viewer stands, in the views' angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Bearing {
    /// Angle to the right of the stack's normal.
    pub horizontal: CentiDegrees,
    /// Angle above the stack's normal.
    pub vertical: CentiDegrees,
}

impl Bearing {
    /// A bearing of hundredths of a degree.
    pub const fn new(horizontal: i16, vertical: i16) -> Self {
        Self { horizontal: CentiDegrees(horizontal), vertical: CentiDegrees(vertical) }
    }

    /// A distance between bearings in hundredths of a degree: the longer leg and three eighths of the shorter,
    /// within 7 % of the length of their difference.
    pub fn distance(self, other: Self) -> u32 {
        let legs = |a: CentiDegrees, b: CentiDegrees| (i32::from(a.0) - i32::from(b.0)).unsigned_abs();
        let (h, v) = (legs(self.horizontal, other.horizontal), legs(self.vertical, other.vertical));
        h.max(v) + h.min(v) * 3 / 8
    }
}

/// Somebody seen in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sighting {
    /// Where.
    pub bearing: Bearing,
    /// How strong the signal is; nearer viewers are stronger. The unit is the source's own.
    pub strength: u16,
    /// Something in it has changed since the picture before: it lives.
    pub moves: bool,
}

/// Everybody seen in one frame.
pub type Sightings = Vec<Sighting, MAX_SIGHTINGS>;

/// A sensor that sees viewers.
pub trait BearingSource {
    /// What it is fed with, as read since the last step.
    type Reading<'a>;

    /// Takes new readings; gives everybody seen where they make up a new picture, and none where they do not.
    fn take(&mut self, reading: Self::Reading<'_>, elapsed: Milliseconds) -> Option<Sightings>;

    /// Tells whether the sensor's readings are fresh and credible.
    fn is_sound(&self) -> bool;
}
