//! The governor: the one place that lets a lamp level through, or cuts it.
//!
//! The rest of the controller only *wants* levels. The governor alone makes a [`LampCommand`], from what is wanted
//! and from the conditions it watches; every path to the lamps leads through [`Governor::decide`].

use crate::duty::{FloorDither, counts};
use crate::events::{Cut, Cuts, DarkReason};
use crate::inputs::TemperatureReading;
use crate::interlock::InterlockState;
use crate::limits;
use crate::plan::{Emphasis, LampCalibration, Plan};
use crate::units::{CentiCelsius, Irradiance, Lamp, Level, Milliseconds, Millivolts, PerLamp};

/// What the lamps are to do until the next step. Only the governor makes one that lights a lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LampCommand {
    levels: PerLamp<Level>,
    counts: PerLamp<u16>,
    irradiance: PerLamp<Irradiance>,
    enabled: bool,
}

impl LampCommand {
    /// Both lamps off and their drivers disabled.
    pub const DARK: Self = Self {
        levels: PerLamp::new(Level::OFF, Level::OFF),
        counts: PerLamp::new(0, 0),
        irradiance: PerLamp::new(Irradiance(0), Irradiance(0)),
        enabled: false,
    };

    /// The levels, linear in irradiance.
    pub const fn levels(&self) -> PerLamp<Level> {
        self.levels
    }

    /// The PWM counts of both lamps, 0 to [`crate::duty::PWM_FULL`].
    pub const fn counts(&self) -> PerLamp<u16> {
        self.counts
    }

    /// The irradiance that both lamps give on their nearest films.
    pub const fn irradiance(&self) -> PerLamp<Irradiance> {
        self.irradiance
    }

    /// Whether the lamps' drivers are enabled.
    pub const fn is_enabled(&self) -> bool {
        self.enabled
    }
}

/// What the governor watches.
#[derive(Clone, Copy, Debug)]
pub struct Conditions<'a> {
    /// The active plan.
    pub plan: Option<&'a Plan>,
    /// The interlock.
    pub interlock: InterlockState,
    /// The lamp boards' temperatures.
    pub boards: PerLamp<Option<TemperatureReading>>,
    /// The enclosure's air.
    pub enclosure: Option<CentiCelsius>,
    /// The lamp supply.
    pub supply: Option<Millivolts>,
    /// The clock is valid.
    pub clock_is_valid: bool,
    /// Time since the start.
    pub uptime_ms: u64,
    /// Three watchdog resets came within ten minutes.
    pub watchdog_latched: bool,
    /// Why the rest of the controller wants dark.
    pub wants_dark: Option<DarkReason>,
    /// The ledger holds a reservation that covers the lamps.
    pub reserved: bool,
    /// Both lamps' dose in the ledger's day and in the stack's life.
    pub dose: PerLamp<crate::ledger::LampAccount>,
}

/// What the governor decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// What the lamps are to do.
    pub command: LampCommand,
    /// Why they are dark, where they are.
    pub dark: Option<DarkReason>,
    /// Which cuts are at work.
    pub cuts: PerLamp<Cuts>,
}

/// Lets levels through, or cuts them.
#[derive(Clone, Debug, Default)]
pub struct Governor {
    last: Emphasis,
    too_hot: PerLamp<bool>,
    lit_for: Milliseconds,
    rest_left: Milliseconds,
    dither: PerLamp<FloorDither>,
}

impl Governor {
    /// A governor at start: dark.
    pub fn new() -> Self {
        Self::default()
    }

    /// Decides what the lamps do until the next step.
    pub fn decide(
        &mut self,
        wanted: Emphasis,
        conditions: &Conditions<'_>,
        elapsed: Milliseconds,
    ) -> Verdict {
        self.watch_temperatures(conditions);
        let reason = self.dark_reason(conditions);
        let (Some(plan), None) = (conditions.plan, reason) else {
            return self.go_dark(reason.unwrap_or(DarkReason::NoPlan), elapsed);
        };
        let mut cuts = PerLamp::new(Cuts::default(), Cuts::default());
        let resting = self.rest(plan, elapsed);
        let levels = PerLamp::new(
            self.cut(Lamp::Top, wanted.top, plan, conditions, resting, elapsed, &mut cuts.top),
            self.cut(Lamp::Bottom, wanted.bottom, plan, conditions, resting, elapsed, &mut cuts.bottom),
        );
        self.light(levels, plan, cuts)
    }

    fn watch_temperatures(&mut self, conditions: &Conditions<'_>) {
        let hot = |was: bool, reading: Option<TemperatureReading>| {
            let limit = if was { limits::BOARD_BACK } else { limits::BOARD_CUT };
            reading.and_then(TemperatureReading::celsius).is_none_or(|t| t >= limit)
                && (was || reading.is_some())
        };
        self.too_hot = PerLamp::new(
            hot(self.too_hot.top, conditions.boards.top),
            hot(self.too_hot.bottom, conditions.boards.bottom),
        );
    }

    fn dark_reason(&self, conditions: &Conditions<'_>) -> Option<DarkReason> {
        let sensor_fails =
            |reading: Option<TemperatureReading>| reading.and_then(TemperatureReading::celsius).is_none();
        let life_over = |account: &crate::ledger::LampAccount| {
            conditions.plan.is_some_and(|plan| account.life >= plan.limits.life_dose)
        };
        let needs_clock = conditions.plan.is_some_and(|plan| plan.calendar.needs_clock());
        let supply_is_sound = conditions
            .supply
            .is_some_and(|supply| (limits::SUPPLY_LEAST..=limits::SUPPLY_MOST).contains(&supply));
        let rules = [
            (conditions.watchdog_latched, DarkReason::WatchdogResets),
            (conditions.interlock == InterlockState::Open, DarkReason::InterlockOpen),
            (conditions.interlock == InterlockState::Disagrees, DarkReason::InterlockDisagrees),
            (conditions.interlock == InterlockState::WaitsForRearm, DarkReason::InterlockNotArmed),
            (conditions.plan.is_none(), DarkReason::NoPlan),
            (!supply_is_sound, DarkReason::Supply),
            (sensor_fails(conditions.boards.top), DarkReason::TemperatureSensor(Lamp::Top)),
            (sensor_fails(conditions.boards.bottom), DarkReason::TemperatureSensor(Lamp::Bottom)),
            (self.too_hot.top, DarkReason::TooHot(Lamp::Top)),
            (self.too_hot.bottom, DarkReason::TooHot(Lamp::Bottom)),
            (
                conditions.enclosure.is_some_and(|air| air >= limits::ENCLOSURE_CUT),
                DarkReason::EnclosureTooHot,
            ),
            (life_over(&conditions.dose.top) || life_over(&conditions.dose.bottom), DarkReason::LifeDose),
            (!conditions.reserved, DarkReason::LedgerNotStored),
            (needs_clock && !conditions.clock_is_valid, DarkReason::ClockInvalid),
            (conditions.uptime_ms < u64::from(limits::START_DWELL.0), DarkReason::Starting),
        ];
        let found = rules.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason);
        found.or(conditions.wants_dark)
    }

    fn rest(&mut self, plan: &Plan, elapsed: Milliseconds) -> bool {
        let above_idle =
            |level: Level, lamp: &LampCalibration| level.of(lamp.full_level) > limits::IDLE_FLOOR;
        if self.rest_left.0 > 0 {
            self.rest_left = self.rest_left.minus(elapsed);
        } else if above_idle(self.last.top, &plan.lamps.top)
            || above_idle(self.last.bottom, &plan.lamps.bottom)
        {
            self.lit_for = self.lit_for.plus(elapsed);
        }
        if self.lit_for >= plan.limits.continuous {
            self.lit_for = Milliseconds(0);
            self.rest_left = plan.limits.rest;
        }
        self.rest_left.0 > 0
    }

    #[expect(clippy::too_many_arguments, reason = "each is a rule's own")]
    fn cut(
        &self,
        lamp: Lamp,
        wanted: Level,
        plan: &Plan,
        conditions: &Conditions<'_>,
        resting: bool,
        elapsed: Milliseconds,
        cuts: &mut Cuts,
    ) -> Level {
        let full = plan.lamps.get(lamp).full_level;
        let account = conditions.dose.get(lamp);
        let idle = Level::not_above(limits::IDLE_FLOOR, full);
        let firmware = Level::not_above(limits::CEILING, full);
        let allowed = Level::not_above(plan.limits.ceiling, full);
        let mut level = wanted;
        let mut lower = |cut: Cut, most: Level| {
            if level > most {
                level = most;
                cuts.insert(cut);
            }
        };
        lower(Cut::Warm, derated(conditions.boards.get(lamp).and_then(TemperatureReading::celsius)));
        if account.day >= plan.limits.daily_dose {
            lower(Cut::DayDose, idle);
        }
        if resting {
            lower(Cut::Resting, idle);
        }
        lower(Cut::FirmwareCeiling, firmware);
        lower(Cut::PlanCeiling, allowed);
        let stride = u64::from(elapsed.0) * 65_535 / u64::from(limits::FASTEST_FADE.0);
        let stride = stride.min(65_535) as u16;
        let last = *self.last.get(lamp);
        let slewed = level.0.clamp(last.0.saturating_sub(stride), last.0.saturating_add(stride));
        if slewed != level.0 {
            cuts.insert(Cut::Slew);
        }
        Level(slewed).min(firmware).min(allowed)
    }

    fn light(&mut self, levels: Emphasis, plan: &Plan, cuts: PerLamp<Cuts>) -> Verdict {
        self.last = levels;
        let counts = PerLamp::new(
            self.dither.top.apply(plan.lamps.top.below_floor, counts(&plan.lamps.top, levels.top)),
            self.dither
                .bottom
                .apply(plan.lamps.bottom.below_floor, counts(&plan.lamps.bottom, levels.bottom)),
        );
        let command = LampCommand {
            levels,
            counts,
            irradiance: PerLamp::new(
                levels.top.of(plan.lamps.top.full_level),
                levels.bottom.of(plan.lamps.bottom.full_level),
            ),
            enabled: true,
        };
        let lit = levels.top.0 > 0 || levels.bottom.0 > 0;
        if !lit {
            return Verdict { dark: Some(DarkReason::NothingToShow), cuts, ..Verdict::default() };
        }
        Verdict { command, dark: None, cuts }
    }

    fn go_dark(&mut self, reason: DarkReason, elapsed: Milliseconds) -> Verdict {
        self.last = Emphasis::default();
        self.dither = PerLamp::default();
        self.rest_left = self.rest_left.minus(elapsed);
        Verdict { command: LampCommand::DARK, dark: Some(reason), cuts: PerLamp::default() }
    }
}

/// The most level of a lamp whose board has this temperature.
fn derated(board: Option<CentiCelsius>) -> Level {
    let Some(board) = board else { return Level::OFF };
    let (from, to) = (i32::from(limits::DERATE_FROM.0), i32::from(limits::DERATE_TO.0));
    let above = (i32::from(board.0) - from).clamp(0, to - from);
    Level((65_535 - above * 65_535 / (to - from)) as u16)
}
