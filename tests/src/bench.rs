//! A controller with everything around it: contacts, sensors, supply, clock and flash, all in order until told
//! otherwise. It watches over what must hold in every step of whatever happens.

use std::collections::BTreeMap;

use vitrine_exhibit::clock::ClockRecord;
use vitrine_exhibit::events::Event;
use vitrine_exhibit::governor::LampCommand;
use vitrine_exhibit::inputs::{Contact, Inputs, InterlockLoops, Request, TemperatureReading};
use vitrine_exhibit::ledger::{LedgerRecord, StoredReservation};
use vitrine_exhibit::limits;
use vitrine_exhibit::plan::{Plan, ValidPlan, View};
use vitrine_exhibit::testing;
use vitrine_exhibit::units::{
    CentiCelsius, CentiDegrees, Irradiance, Level, Milliseconds, Millivolts, PerLamp, UtcSeconds,
};
use vitrine_exhibit::viewer::{COLUMNS, RadarFrame, ThermalFrame};
use vitrine_exhibit::{Snapshot, State, step};

use crate::room::{Room, Side};

/// The time of one step.
pub const TICK: Milliseconds = Milliseconds(10);
/// Steps from one picture of the sensors to the next.
pub const PICTURE_STEPS: u64 = 10;

/// How a thermal sensor behaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EyeHealth {
    /// As it should.
    #[default]
    Sound,
    /// It sends nothing.
    Dead,
    /// It sends the same picture again and again.
    Frozen,
    /// It sends temperatures that no room has.
    Garbage,
    /// Some of its pixels, at the height of heads, read 1 °C more in every other picture.
    Flickers,
}

/// The controller and its surroundings.
#[derive(Debug)]
pub struct Bench {
    /// The controller's state.
    pub state: State,
    /// The plan; none where there is none.
    pub plan: Option<ValidPlan>,
    /// The room before the stack.
    pub room: Room,
    /// Both thermal sensors, left and right.
    pub eyes: [EyeHealth; 2],
    /// The radar's report, where one is fitted that always says the same.
    pub radar: Option<RadarFrame>,
    /// A radar is fitted that sees the room.
    pub radar_sees_room: bool,
    /// The interlock's contacts.
    pub loops: InterlockLoops,
    /// The lamp boards.
    pub boards: PerLamp<Option<TemperatureReading>>,
    /// The enclosure's air.
    pub enclosure: Option<CentiCelsius>,
    /// The lamp supply.
    pub supply: Option<Millivolts>,
    /// What the ultraviolet sensor reads over what the lamps give, in hundredths; none where no sensor is fitted.
    pub ultraviolet_percent: Option<u32>,
    /// What the ultraviolet sensor reads besides, in mW/m².
    pub stray: Irradiance,
    /// The clock at the beginning; none while it is invalid.
    pub clock: Option<UtcSeconds>,
    /// A host sets the clock before the next step.
    pub clock_was_set: bool,
    /// What is known of the clock's drift, in flash.
    pub clock_record: ClockRecord,
    /// The staff key is pressed.
    pub staff_key: bool,
    /// Requests for the next step.
    pub requests: Vec<Request>,
    /// The flash's owner asks the lamps to stand still.
    pub stand_still: bool,
    /// The flash takes what it is given.
    pub flash_works: bool,
    /// The newest ledger record in flash.
    pub flash: LedgerRecord,
    /// The command of the last step.
    pub command: LampCommand,
    steps: u64,
    frozen: [Option<ThermalFrame>; 2],
    /// What was given to each stack, by how many had been declared.
    given_uj: BTreeMap<u16, PerLamp<u64>>,
}

impl Bench {
    /// Everything in order: an empty room and the standard plan of three views.
    pub fn new() -> Self {
        let warm = Some(TemperatureReading::Celsius(CentiCelsius(3_000)));
        Self {
            state: State::new(LedgerRecord::default(), false),
            plan: Some(ValidPlan::new(standard_plan()).expect("the standard plan is valid")),
            room: Room::new(1),
            eyes: [EyeHealth::Sound; 2],
            radar: None,
            radar_sees_room: false,
            loops: InterlockLoops { a: Contact::Closed, b: Contact::Closed },
            boards: PerLamp::new(warm, warm),
            enclosure: Some(CentiCelsius(2_500)),
            supply: Some(Millivolts(24_000)),
            ultraviolet_percent: None,
            stray: Irradiance(0),
            clock: Some(UtcSeconds(1_777_629_600)),
            clock_was_set: false,
            clock_record: ClockRecord::default(),
            staff_key: false,
            requests: Vec::new(),
            stand_still: false,
            flash_works: true,
            flash: LedgerRecord::default(),
            command: LampCommand::DARK,
            steps: 0,
            frozen: [None, None],
            given_uj: BTreeMap::new(),
        }
    }

    /// Time since the beginning in seconds.
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * f64::from(TICK.0) / 1_000.0
    }

    /// What the controller tells of itself.
    pub const fn snapshot(&self) -> &Snapshot {
        self.state.snapshot()
    }

    /// Cuts the power and lets the controller start again with what is in flash.
    pub fn restart(&mut self, after_fault: bool) {
        self.state = State::new(self.flash, after_fault);
        self.command = LampCommand::DARK;
    }

    /// What the clock shows, whether right or wrong.
    fn shown(&self) -> Option<UtcSeconds> {
        let elapsed_s = (self.steps * u64::from(TICK.0) / 1_000) as i64;
        self.clock.map(|clock| UtcSeconds(clock.0.saturating_add(elapsed_s)))
    }

    /// A host sets the clock, to what it would have shown at the beginning.
    pub fn set_clock(&mut self, clock: UtcSeconds) {
        let before = self.shown();
        self.clock = Some(clock);
        self.clock_was_set = true;
        if let Some(truth) = self.shown() {
            self.clock_record = self.clock_record.set(before, truth);
        }
    }

    /// One step.
    ///
    /// # Errors
    /// What must hold in every step and did not.
    pub fn step(&mut self) -> Result<Vec<Event>, String> {
        let frames = if self.steps.is_multiple_of(PICTURE_STEPS) { self.frames() } else { [None, None] };
        let picture = frames[0].is_some() || self.steps.is_multiple_of(PICTURE_STEPS);
        let radar = if self.radar_sees_room && picture {
            Some(self.room.radar(self.time_s()))
        } else {
            self.radar.clone()
        };
        let stored = self.write_flash();
        let requests = std::mem::take(&mut self.requests);
        let inputs = Inputs {
            plan: self.plan.as_ref(),
            thermal: [frames[0].as_ref(), frames[1].as_ref()],
            radar: radar.as_ref().filter(|_| picture),
            interlock: self.loops,
            boards: self.boards,
            enclosure: self.enclosure,
            supply: self.supply,
            ultraviolet: self.ultraviolet().filter(|_| picture),
            now: self.shown().and_then(|shown| self.clock_record.corrected(shown)),
            clock_was_set: std::mem::take(&mut self.clock_was_set),
            requests: &requests,
            staff_key: self.staff_key,
            stored,
            stand_still: self.stand_still,
        };
        let before = self.command;
        let (command, events) = step(&mut self.state, &inputs, TICK);
        self.command = command;
        self.steps += 1;
        self.watch(before)?;
        Ok(events.iter().collect())
    }

    fn frames(&mut self) -> [Option<ThermalFrame>; 2] {
        let time_s = self.time_s();
        let mut frames = [None, None];
        for (index, side) in [Side::Left, Side::Right].into_iter().enumerate() {
            let fresh = self.room.frame(side, time_s);
            frames[index] = match self.eyes[index] {
                EyeHealth::Sound => Some(fresh),
                EyeHealth::Dead => None,
                EyeHealth::Frozen => self.frozen[index],
                EyeHealth::Garbage => {
                    Some(ThermalFrame { pixels: fresh.pixels.map(|pixel| 2_000 + pixel), ..fresh })
                }
                EyeHealth::Flickers => Some(flickering(fresh, self.steps / PICTURE_STEPS)),
            };
            self.frozen[index] = frames[index].or(self.frozen[index]);
        }
        frames
    }

    fn write_flash(&mut self) -> Option<StoredReservation> {
        let record = *self.state.ledger().to_store()?;
        self.flash_works.then(|| {
            self.flash = record;
            StoredReservation { sequence: record.sequence }
        })
    }

    fn ultraviolet(&self) -> Option<Irradiance> {
        let plan = self.plan.as_ref()?;
        let percent = self.ultraviolet_percent?;
        let part = |level: Level, full: Irradiance| level.of(full).0;
        let levels = self.command.levels();
        let given = part(levels.top, plan.lamps.top.ultraviolet_at_full)
            + part(levels.bottom, plan.lamps.bottom.ultraviolet_at_full);
        Some(Irradiance(given * percent / 100 + self.stray.0))
    }

    /// Tells whether a lamp gives what the plan or the firmware allows at most, but for one level.
    fn is_at_ceiling(&self, given: PerLamp<Irradiance>) -> bool {
        let Some(plan) = &self.plan else { return false };
        let most = plan.limits.ceiling.min(limits::CEILING);
        given
            .zip(plan.lamps.clone())
            .map(|(given, lamp)| given.0 + lamp.full_level.0.div_ceil(65_535) >= most.0)
            != PerLamp::new(false, false)
    }

    /// What must hold in every step.
    fn watch(&mut self, before: LampCommand) -> Result<(), String> {
        let time_s = self.time_s();
        let levels = self.command.levels().zip(before.levels());
        let irradiance = self.command.irradiance();
        let counts = self.command.counts();
        let most = irradiance.top.max(irradiance.bottom);
        let stride = (TICK.0 * 65_535 / limits::FASTEST_FADE.0) as u16 + 1;
        let lit = levels.top.0.0 > 0 || levels.bottom.0.0 > 0 || counts.top > 0 || counts.bottom > 0;
        if lit != self.command.is_enabled() {
            return Err(format!("{time_s:.2} s: lamps lit {lit}, enabled {}", self.command.is_enabled()));
        }
        if lit && self.snapshot().dark.is_some() {
            return Err(format!("{time_s:.2} s: light with a reason for darkness"));
        }
        if most > limits::CEILING || self.plan.as_ref().is_some_and(|plan| most > plan.limits.ceiling) {
            return Err(format!("{time_s:.2} s: {} mW/m2 are above the ceiling", most.0));
        }
        for (now, before) in [levels.top, levels.bottom] {
            if now.0 > before.0.saturating_add(stride) {
                return Err(format!("{time_s:.2} s: level {} to {} is too fast", before.0, now.0));
            }
            // What is lit still may only fall at once to a new plan's ceiling.
            let falls = lit && now.0.saturating_add(stride) < before.0;
            if falls && !self.is_at_ceiling(irradiance) {
                return Err(format!("{time_s:.2} s: level {} falls to {} too fast", before.0, now.0));
            }
        }
        self.count_dose(irradiance)
    }

    /// Holds the record in flash against what the stack that it is about has really been given.
    fn count_dose(&mut self, irradiance: PerLamp<Irradiance>) -> Result<(), String> {
        let stack = self.state.ledger().spent().stacks;
        let given = self.given_uj.entry(stack).or_default();
        given.top += u64::from(irradiance.top.0) * u64::from(TICK.0);
        given.bottom += u64::from(irradiance.bottom.0) * u64::from(TICK.0);
        let given = self.given_uj.get(&self.flash.stacks).copied().unwrap_or_default();
        let booked = self.flash.lamps.map(|account| account.life.0);
        if booked.top < given.top || booked.bottom < given.bottom {
            return Err(format!("{:.2} s: {given:?} uJ/m2 given, {booked:?} in flash", self.time_s()));
        }
        Ok(())
    }
}

/// A frame whose pixels in two rows of three columns read a degree more in every other picture.
fn flickering(mut frame: ThermalFrame, picture: u64) -> ThermalFrame {
    for row in [2, 3] {
        for pixel in frame.pixels.iter_mut().skip(row * COLUMNS + 3).take(3) {
            *pixel += 4 * (picture % 2) as i16;
        }
    }
    frame
}

impl Default for Bench {
    fn default() -> Self {
        Self::new()
    }
}

/// The plan of the tests, with lamps that an ultraviolet sensor watches.
pub fn standard_plan() -> Plan {
    let mut plan = testing::plan();
    plan.lamps.top.ultraviolet_at_full = Irradiance(200);
    plan.lamps.bottom.ultraviolet_at_full = Irradiance(100);
    plan
}

/// A view with its direction in degrees and its pair as parts of full level.
pub fn view(id: &str, horizontal_deg: f64, vertical_deg: f64, top: f64, bottom: f64) -> View {
    let angle = |degrees: f64| CentiDegrees((degrees * 100.0).round() as i16);
    View {
        id: id.try_into().expect("a short id"),
        horizontal: angle(horizontal_deg),
        vertical: angle(vertical_deg),
        emphasis: PerLamp::new(level(top), level(bottom)),
    }
}

/// A level as a part of full level.
pub fn level(part: f64) -> Level {
    Level((part * 65_535.0).round() as u16)
}
