//! The client against the simulated controller, over real TCP and over a pair of serial ports.

mod address;
mod client;
mod crowd;
mod discovery;
mod faults;
mod follow;
#[cfg(unix)]
mod serial;
mod update;

use vitrine_exhibit::{
    plan::{
        Calendar, Emphasis, LampCalibration, Limits, Plan, PresenceSettings, View, ViewerSettings,
        VolumeMetadata,
    },
    units::{CentiDegrees, Level, PerLamp, UtcSeconds},
};
use vitrine_protocol::plan_file::{self, MAX_PLAN_BYTES};

use super::{Address, Client};
use crate::controller::{Clock, FlashFile, Pace, Served, VirtualController, serve};

/// A plan with three views at -30, 0 and 30 degrees.
pub(crate) fn plan(name: &str) -> Plan {
    let view = |id: &str, horizontal, top, bottom| View {
        id: id.try_into().expect("short"),
        horizontal: CentiDegrees(horizontal),
        vertical: CentiDegrees(0),
        emphasis: Emphasis::new(Level(top), Level(bottom)),
    };
    Plan {
        name: name.try_into().expect("short"),
        volume: VolumeMetadata {
            films: 20,
            width_px: 512,
            height_px: 512,
            width_um: 35_000,
            film_pitch_um: 600,
            blake3: [7; 32],
        },
        views: [
            view("left", -3_000, 65_535, 10_000),
            view("front", 0, 30_000, 30_000),
            view("right", 3_000, 0, 65_535),
        ]
        .into_iter()
        .collect(),
        neutral: Emphasis::new(Level(30_000), Level(30_000)),
        shared: Default::default(),
        lamps: PerLamp::new(LampCalibration::default(), LampCalibration::default()),
        limits: Limits::default(),
        viewer: ViewerSettings::default(),
        presence: PresenceSettings::default(),
        calendar: Calendar::default(),
    }
}

pub(crate) fn plan_bytes(name: &str) -> Vec<u8> {
    let mut buffer = [0; MAX_PLAN_BYTES];
    plan_file::encode(&plan(name), &mut buffer).expect("fits").to_vec()
}

/// 2026-11-22T20:37:42Z.
const NOW: UtcSeconds = UtcSeconds(1_795_379_862);

fn controller(flash: FlashFile) -> VirtualController {
    VirtualController::new(flash, Clock::Simulated(NOW)).expect("readable flash")
}

/// A served controller whose time stands still, and its address.
fn served(flash: FlashFile) -> (Served, Address) {
    let served = serve(controller(flash), "127.0.0.1:0", Pace::Manual).expect("a free port");
    let address = Address::Tcp(served.address().to_string());
    (served, address)
}

fn connected() -> (Served, Client) {
    let (served, address) = served(FlashFile::in_memory());
    let client = Client::open(&address).expect("greeted");
    (served, client)
}
