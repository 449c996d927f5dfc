//! What the controller tells of itself.

use serde::{Deserialize, Serialize};

use crate::events::{Cuts, DarkReason};
use crate::interlock::InterlockState;
use crate::units::{CentiCelsius, Dose, Irradiance, Level, Milliseconds, Millivolts, PerLamp, UtcSeconds};
use crate::viewer::Bearing;

/// Whether somebody is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Presence {
    /// Somebody is there.
    Somebody,
    /// The last viewer has just gone; the view is kept.
    JustGone,
    /// Nobody is there: the idle glow.
    Idle,
    /// Nobody has been there for a while: dark.
    #[default]
    Empty,
    /// The viewer sensors give nothing credible: the neutral pair.
    Unknown,
}

/// What the controller tells of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Time since the start in ms.
    pub uptime_ms: u64,
    /// The clock.
    pub now: Option<UtcSeconds>,
    /// Whether somebody is there.
    pub presence: Presence,
    /// Where the viewer stands who decides.
    pub bearing: Option<Bearing>,
    /// How many viewers are followed.
    pub viewers: u8,
    /// The index of the view that is shown.
    pub view: Option<u8>,
    /// Both lamps' levels.
    pub levels: PerLamp<Level>,
    /// Both lamps' irradiance on their nearest films.
    pub irradiance: PerLamp<Irradiance>,
    /// Whether the lamps' drivers are enabled.
    pub enabled: bool,
    /// Why the lamps are dark, where they are.
    pub dark: Option<DarkReason>,
    /// The cuts at work.
    pub cuts: PerLamp<Cuts>,
    /// Both lamp boards' temperatures, where their sensors give one.
    pub boards: PerLamp<Option<CentiCelsius>>,
    /// The enclosure's air.
    pub enclosure: Option<CentiCelsius>,
    /// The lamp supply.
    pub supply: Option<Millivolts>,
    /// What the ultraviolet sensor read last; none where it has been silent for a while.
    pub ultraviolet: Option<Irradiance>,
    /// The interlock.
    pub interlock: InterlockState,
    /// Both lamps' dose in the ledger's day.
    pub day_dose: PerLamp<Dose>,
    /// Both lamps' dose in the stack's life.
    pub life_dose: PerLamp<Dose>,
    /// Both lamps' time lit in seconds.
    pub lit_s: PerLamp<u32>,
    /// Both lamps' time lit in seconds, as if at full level.
    pub full_s: PerLamp<u32>,
    /// Starts of the controller.
    pub power_cycles: u32,
    /// Starts after the watchdog or a fault.
    pub watchdog_resets: u32,
    /// What is left of a host's hold, dark or open.
    pub lease: Milliseconds,
    /// The plan counts on an ultraviolet sensor, and it is silent.
    pub ultraviolet_lost: bool,
    /// The viewer sensors give nothing credible.
    pub viewer_sensor_lost: bool,
}

impl Default for Snapshot {
    /// What is told before the first step.
    fn default() -> Self {
        Self {
            uptime_ms: 0,
            now: None,
            presence: Presence::Unknown,
            bearing: None,
            viewers: 0,
            view: None,
            levels: PerLamp::default(),
            irradiance: PerLamp::default(),
            enabled: false,
            dark: Some(DarkReason::Starting),
            cuts: PerLamp::default(),
            boards: PerLamp::default(),
            enclosure: None,
            supply: None,
            ultraviolet: None,
            interlock: InterlockState::Open,
            day_dose: PerLamp::default(),
            life_dose: PerLamp::default(),
            lit_s: PerLamp::default(),
            full_s: PerLamp::default(),
            power_cycles: 0,
            watchdog_resets: 0,
            lease: Milliseconds(0),
            ultraviolet_lost: false,
            viewer_sensor_lost: false,
        }
    }
}
