//! The plan: everything about one exhibit that is uploaded to its controller.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::units::{CentiDegrees, Dose, Irradiance, Level, Milliseconds};

/// The most views a plan holds.
pub const MAX_VIEWS: usize = 16;

/// The pair of lamp levels that shows one view at its best.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Emphasis {
    /// Level of the lamp on the viewer's side.
    pub top: Level,
    /// Level of the lamp behind the stack.
    pub bottom: Level,
}

/// A direction with its pattern.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct View {
    /// The name that exhibit.toml gives it.
    pub id: String<24>,
    /// Angle to the right of the stack's normal.
    pub horizontal: CentiDegrees,
    /// Angle above the stack's normal.
    pub vertical: CentiDegrees,
    /// The lamp pair under which this view is shown.
    pub emphasis: Emphasis,
}

/// What the controller knows of the printed volume.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VolumeMetadata {
    /// Number of films.
    pub films: u16,
    /// Pixels of a film, left to right.
    pub width_px: u32,
    /// Pixels of a film, top to bottom.
    pub height_px: u32,
    /// Width of the picture on a film, in µm.
    pub width_um: u32,
    /// Distance from film to film, in µm.
    pub film_pitch_um: u32,
    /// BLAKE3 of all film values, to tell which stack belongs to this plan.
    pub blake3: [u8; 32],
}

/// What the plan allows; the firmware's own limits override these.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Irradiance of one lamp at full level on the nearest film, measured at commissioning.
    pub full_level: Irradiance,
    /// The most irradiance of one lamp.
    pub ceiling: Irradiance,
    /// The most dose of one lamp in a day.
    pub daily_dose: Dose,
    /// The most dose of one lamp in the stack's life.
    pub life_dose: Dose,
    /// The longest time lit without a rest.
    pub continuous: Milliseconds,
    /// The rest after it.
    pub rest: Milliseconds,
}

/// The plan of one exhibit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// The exhibit's name.
    pub name: String<48>,
    /// The printed volume.
    pub volume: VolumeMetadata,
    /// The views, in the order of exhibit.toml.
    pub views: Vec<View, MAX_VIEWS>,
    /// The pair for nobody in particular.
    pub neutral: Emphasis,
    /// Limits.
    pub limits: Limits,
}
