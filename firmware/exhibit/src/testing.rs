//! A plan for the tests, here and elsewhere.

use crate::plan::{Calendar, Limits, Plan, PresenceSettings, View, ViewerSettings, VolumeMetadata};
use crate::units::{CentiDegrees, Level, PerLamp};

/// Three views at -30, 0 and 30 degrees: top lamp, half of it and the bottom lamp, bottom lamp.
pub fn plan() -> Plan {
    let views =
        [view("left", -3_000, 65_535, 0), view("middle", 0, 32_768, 65_535), view("right", 3_000, 0, 65_535)];
    Plan {
        name: "Three photographs".try_into().unwrap_or_default(),
        volume: VolumeMetadata {
            films: 20,
            width_px: 512,
            height_px: 512,
            width_um: 35_000,
            film_pitch_um: 600,
            blake3: [7; 32],
        },
        views: views.into_iter().collect(),
        neutral: PerLamp::new(Level(39_321), Level(39_321)),
        shared: Default::default(),
        lamps: PerLamp::default(),
        limits: Limits::default(),
        viewer: ViewerSettings::default(),
        presence: PresenceSettings::default(),
        calendar: Calendar::default(),
    }
}

/// A view at this horizontal angle, in hundredths of a degree, with the levels of both lamps.
pub fn view(id: &str, horizontal: i16, top: u16, bottom: u16) -> View {
    View {
        id: id.try_into().unwrap_or_default(),
        horizontal: CentiDegrees(horizontal),
        vertical: CentiDegrees(0),
        emphasis: PerLamp::new(Level(top), Level(bottom)),
    }
}
