//! What surrounds the simulated controller: interlock, supply, temperatures, ultraviolet.

use vitrine_exhibit::{
    governor::LampCommand,
    inputs::{Contact, InterlockLoops, TemperatureReading},
    plan::ValidPlan,
    units::{CentiCelsius, Irradiance, Level, Millivolts, PerLamp},
};

/// The room's temperature.
const ROOM: f64 = 22.0;
/// How much a lamp board warms up at full level, in degrees.
const RISE: f64 = 28.0;
/// Time constant of a lamp board and its heat sink, in ms.
const BOARD_TIME_MS: f64 = 180_000.0;

/// What surrounds the controller; tests and demonstrations change it.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// The door interlock.
    pub interlock: InterlockLoops,
    /// The lamp supply.
    pub supply: Option<Millivolts>,
    /// Fixed readings of the lamp boards' sensors, in place of the simulated temperatures.
    pub board_faults: PerLamp<Option<TemperatureReading>>,
    /// The air in the enclosure.
    pub enclosure: Option<CentiCelsius>,
    /// What the ultraviolet sensor reads of what the lamps should give, in percent; none where none is fitted.
    pub ultraviolet_percent: Option<u32>,
    /// The staff key is pressed.
    pub staff_key: bool,
    boards: PerLamp<f64>,
}

impl Surroundings {
    /// A closed door, 24 V, and boards at the room's temperature.
    pub fn new() -> Self {
        Self {
            interlock: InterlockLoops { a: Contact::Closed, b: Contact::Closed },
            supply: Some(Millivolts(24_000)),
            board_faults: PerLamp::default(),
            enclosure: Some(CentiCelsius(2_450)),
            ultraviolet_percent: Some(100),
            staff_key: false,
            boards: PerLamp::new(ROOM, ROOM),
        }
    }

    /// Opens or closes both loops of the interlock.
    pub fn set_door(&mut self, closed: bool) {
        let contact = if closed { Contact::Closed } else { Contact::Open };
        self.interlock = InterlockLoops { a: contact, b: contact };
    }

    /// What the lamp boards' sensors say.
    pub fn boards(&self) -> PerLamp<Option<TemperatureReading>> {
        self.board_faults.zip(self.boards).map(|(fault, degrees)| {
            let measured = TemperatureReading::Celsius(CentiCelsius((degrees * 100.0).round() as i16));
            Some(fault.unwrap_or(measured))
        })
    }

    /// What the ultraviolet sensor reads under these levels, where the plan says what it should.
    pub(super) fn ultraviolet(&self, plan: Option<&ValidPlan>, levels: PerLamp<Level>) -> Option<Irradiance> {
        let percent = self.ultraviolet_percent?;
        let lamps = &plan?.lamps;
        let given = levels.top.of(lamps.top.ultraviolet_at_full).0
            + levels.bottom.of(lamps.bottom.ultraviolet_at_full).0;
        Some(Irradiance(given * percent / 100))
    }

    /// Lets the boards warm up or cool down under the lamps.
    pub(super) fn advance(&mut self, command: &LampCommand, elapsed_ms: u32) {
        let share = 1.0 - (-f64::from(elapsed_ms) / BOARD_TIME_MS).exp();
        let towards = |(degrees, level): (f64, Level)| {
            let rise = RISE * f64::from(level.0) / f64::from(Level::FULL.0);
            degrees + (ROOM + rise - degrees) * share
        };
        self.boards = self.boards.zip(command.levels()).map(towards);
    }
}

impl Default for Surroundings {
    fn default() -> Self {
        Self::new()
    }
}
