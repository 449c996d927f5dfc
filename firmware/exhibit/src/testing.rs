//! A plan for the tests.

use crate::plan::{Calendar, Limits, Plan, PresenceSettings, View, ViewerSettings, VolumeMetadata};
use crate::units::{CentiDegrees, Level, PerLamp};

/// Three views at -30, 0 and 30 degrees: top lamp, both, bottom lamp.
pub(crate) fn plan() -> Plan {
    let volume = VolumeMetadata {
        films: 20,
        width_px: 512,
        height_px: 512,
        width_um: 35_000,
        film_pitch_um: 600,
        blake3: [7; 32],
    };
    let views =
        [view("left", -3_000, 65_535, 0), view("middle", 0, 30_000, 65_535), view("right", 3_000, 0, 65_535)];
    Plan {
        name: "Three photographs".try_into().unwrap(),
        volume,
        views: views.into_iter().collect(),
        neutral: PerLamp::new(Level(40_000), Level(40_000)),
        shared: Default::default(),
        lamps: PerLamp::default(),
        limits: Limits::default(),
        viewer: ViewerSettings::default(),
        presence: PresenceSettings::default(),
        calendar: Calendar::default(),
    }
}

fn view(id: &str, horizontal: i16, top: u16, bottom: u16) -> View {
    View {
        id: id.try_into().unwrap(),
        horizontal: CentiDegrees(horizontal),
        vertical: CentiDegrees(0),
        emphasis: PerLamp::new(Level(top), Level(bottom)),
    }
}
