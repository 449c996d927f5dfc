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
    plan::{Emphasis, Plan},
    testing,
    units::{Level, UtcSeconds},
};
use vitrine_protocol::plan_file::{self, MAX_PLAN_BYTES};

use super::{Address, Client};
use crate::controller::{Clock, FlashFile, Pace, Served, VirtualController, serve};

/// A plan with three views at -30, 0 and 30 degrees.
pub(crate) fn plan(name: &str) -> Plan {
    let views = [
        testing::view("left", -3_000, 65_535, 10_000),
        testing::view("front", 0, 30_000, 30_000),
        testing::view("right", 3_000, 0, 65_535),
    ];
    Plan {
        name: name.try_into().expect("short"),
        views: views.into_iter().collect(),
        neutral: Emphasis::new(Level(30_000), Level(30_000)),
        ..testing::plan()
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
