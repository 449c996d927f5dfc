//! What one step of the controller is told.

use serde::{Deserialize, Serialize};

use crate::ledger::StoredReservation;
use crate::plan::ValidPlan;
use crate::units::{CentiCelsius, Irradiance, Milliseconds, Millivolts, PerLamp, UtcSeconds};
use crate::viewer::{RadarFrame, ThermalFrame};

/// One contact of the door interlock as the pin reads it; a broken wire reads open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Contact {
    /// Open, or broken.
    #[default]
    Open,
    /// Closed.
    Closed,
}

/// The two contacts of the door interlock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InterlockLoops {
    /// Loop A.
    pub a: Contact,
    /// Loop B.
    pub b: Contact,
}

/// What a temperature sensor says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TemperatureReading {
    /// A temperature.
    Celsius(CentiCelsius),
    /// The sensor or its wire is open.
    OpenCircuit,
    /// The sensor or its wire is shorted.
    Shorted,
}

impl TemperatureReading {
    /// The temperature, where the sensor gives one.
    pub const fn celsius(self) -> Option<CentiCelsius> {
        match self {
            Self::Celsius(temperature) => Some(temperature),
            Self::OpenCircuit | Self::Shorted => None,
        }
    }
}

/// What a person at a host asks for. Every request that lights, holds or darkens carries a lease and lapses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Show the view of this index, whoever stands where.
    Hold {
        /// The view's index in the plan.
        view: u8,
        /// For how long.
        lease: Milliseconds,
    },
    /// Go dark.
    Dark {
        /// For how long.
        lease: Milliseconds,
    },
    /// Light up outside the schedule's hours.
    Open {
        /// For how long.
        lease: Milliseconds,
    },
    /// End hold, dark and open.
    Release,
    /// Re-arm after the interlock has been open or disagreed, or after a latched fault.
    Rearm,
    /// Declare that a fresh stack stands in the exhibit: its life's dose begins at zero.
    NewStack,
}

/// Everything that one step is told, as read since the step before.
#[derive(Clone, Debug, Default)]
pub struct Inputs<'a> {
    /// The active plan; none, or one that fails its check, is dark.
    pub plan: Option<&'a ValidPlan>,
    /// New frames of the two thermal sensors, left and right; none where none has come since the last step.
    pub thermal: [Option<&'a ThermalFrame>; 2],
    /// A new frame of the radar sensor.
    pub radar: Option<&'a RadarFrame>,
    /// The door interlock, read in this very step.
    pub interlock: InterlockLoops,
    /// The lamp boards' temperatures; none while no reading has come, which is dark.
    pub boards: PerLamp<Option<TemperatureReading>>,
    /// The air in the enclosure, where a sensor is fitted.
    pub enclosure: Option<CentiCelsius>,
    /// The lamp supply; none while no reading has come, which is dark.
    pub supply: Option<Millivolts>,
    /// A new reading of the ultraviolet sensor, where one is fitted.
    pub ultraviolet: Option<Irradiance>,
    /// The clock, where it is valid.
    pub now: Option<UtcSeconds>,
    /// A host has set the clock since the step before.
    pub clock_was_set: bool,
    /// New requests of hosts, in their order.
    pub requests: &'a [Request],
    /// The staff key is pressed.
    pub staff_key: bool,
    /// The last ledger record known to be in flash.
    pub stored: Option<StoredReservation>,
    /// The flash's owner asks the lamps to stand still for a moment: it erases only while they are steady, and has waited.
    pub stand_still: bool,
}
