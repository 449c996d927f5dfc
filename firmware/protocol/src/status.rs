//! What `vitrine status` shows: the controller's own snapshot, and what surrounds it.

use heapless::String;
use serde::{Deserialize, Serialize};
use vitrine_exhibit::{Snapshot, clock::ClockRecord, units::UtcSeconds};

/// Where the time comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ClockSource {
    /// Nothing has set the clock since the power came.
    #[default]
    Nothing,
    /// The battery clock.
    Battery,
    /// A host set it, and there is no battery clock to keep it.
    Host,
    /// The clock of the computer that simulates the controller.
    Computer,
}

/// The clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClockState {
    /// The time; none while it is not known.
    pub now: Option<UtcSeconds>,
    /// Where it comes from.
    pub source: ClockSource,
    /// What is known of its error: when a host set it last, by how much it was wrong, how fast it drifts.
    pub record: ClockRecord,
}

/// The active plan.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlanState {
    /// CRC-32 of its bytes as uploaded.
    pub crc: u32,
    /// Its length in bytes.
    pub length: u32,
    /// The exhibit's name.
    pub name: String<48>,
    /// How many views it has.
    pub views: u8,
    /// The id of the view that is shown; empty if none is.
    pub view_id: String<24>,
}

/// The state of the exhibit.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// What the controller tells of itself.
    pub snapshot: Snapshot,
    /// The clock.
    pub clock: ClockState,
    /// The active plan.
    pub plan: Option<PlanState>,
    /// The number that the next log entry gets.
    pub log_next: u32,
    /// Frames that came damaged, over all links.
    pub damaged_frames: u32,
}
