//! The governor: the one place that lets a lamp level through, or cuts it.
//!
//! # Purpose
//!
//! The rest of the controller only *wants* levels: it may be wrong, misled by a host, or full of bugs, and still no
//! lamp gives light that it should not. [`Governor::decide`] takes what is wanted and what is known, and makes the
//! [`LampCommand`] of the next step. Nothing else can make one that lights a lamp: its fields are private to this
//! module.
//!
//! # Terms
//!
//! - **Dark**: both lamps off and the drivers disabled, at once, without a fade; always with a [`DarkReason`].
//! - **Cut**: a lamp gives less than is wanted, for a [`Cut`]'s reason. A cut that begins slides in within two
//!   seconds, for sudden darkness startles people; ceilings alone hold at once.
//! - **Latched**: stays until a person re-arms, because its cause must be looked at first.
//! - **Idle floor**: the glow of 1 W/m² that remains where a rule asks for rest, not for darkness.
//!
//! # Order of the rules
//!
//! First what makes dark; the first that holds is the reason told (`dark_reason`):
//!
//! 1. faults and the interlock: watchdog resets, interlock open, disagreeing or not re-armed, no plan, supply, a
//!    lamp board's sensor or heat, the enclosure's air, ultraviolet that the model does not explain;
//! 2. doses that end in darkness: the stack's life, a ledger that is not stored;
//! 3. time: an invalid clock where the plan needs one, the dwell after a start;
//! 4. wishes of the rest of the controller: staff, hosts, schedule, nobody there.
//!
//! A supply or a lamp board's sensor that fails while the lamps are lit is dark for five seconds at least, and a loose wire or a
//! supply that gives way under their load does not have them flash.
//!
//! Then what cuts each lamp (`cut`), each rule lowering what the one before has left:
//!
//! 1. the temperature of its board: linear from 60 to 75 °C;
//! 2. the dose of the day: the idle floor; of the stack's life: a quarter less from 90 %;
//! 3. continuous time: the idle floor for the rest's length;
//! 4. the firmware's ceiling, then the plan's;
//! 5. slew: no faster than the whole range in 300 ms.
//!
//! Where the flash's owner asks for it, lamps that are lit stand still for a second at most, whatever moves or cuts them;
//! what makes dark and the ceilings hold at once all the same.
//!
//! Last, the driver's floor of 1 % duty: cut or dithered, as the lamp's calibration says.
//!
//! All arithmetic is of integers that saturate; irradiance and dose round up, levels and duty round down.

mod calm;
mod heat;
mod rest;
mod stillness;
mod supply;
mod ultraviolet;

use self::calm::Calm;
use self::heat::BoardHeat;
use self::rest::Rest;
use self::stillness::Stillness;
use self::supply::Supply;
use self::ultraviolet::UltravioletWatch;
use crate::duty::{FloorDither, PWM_FLOOR, counts};
use crate::events::{Cut, Cuts, DarkReason, Events};
use crate::inputs::TemperatureReading;
use crate::interlock::InterlockState;
use crate::ledger::LampAccount;
use crate::limits;
use crate::plan::{Emphasis, Plan};
use crate::units::{CentiCelsius, Dose, Irradiance, Lamp, Level, Milliseconds, Millivolts, PerLamp};

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
    /// A new reading of the ultraviolet sensor.
    pub ultraviolet: Option<Irradiance>,
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
    /// What both lamps have given.
    pub accounts: PerLamp<LampAccount>,
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
    heat: BoardHeat,
    supply: Supply,
    ultraviolet: UltravioletWatch,
    rest: Rest,
    calm: Calm,
    stillness: Stillness,
    stands_still: bool,
    dither: PerLamp<FloorDither>,
}

impl Governor {
    /// A governor at start: dark.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes note whether the lamps are asked to stand still in this step; tells whether they do. To be called before
    /// [`Governor::decide`].
    pub fn stand_still(&mut self, asked: bool, elapsed: Milliseconds) -> bool {
        let is_lit = self.last != Emphasis::default();
        self.stands_still = self.stillness.update(asked && is_lit, elapsed);
        self.stands_still
    }

    /// Decides what the lamps do until the next step.
    pub fn decide(
        &mut self,
        wanted: Emphasis,
        conditions: &Conditions<'_>,
        elapsed: Milliseconds,
        events: &mut Events,
    ) -> Verdict {
        self.heat.update(conditions.boards, conditions.enclosure, events);
        self.supply.update(conditions.supply, elapsed);
        self.ultraviolet.update(conditions.plan, self.last, conditions.ultraviolet, elapsed, events);
        self.rest.update(conditions.plan, self.last, elapsed);
        let reason = self.dark_reason(conditions);
        let was_lit = self.last != Emphasis::default();
        let reason = reason.or(self.calm.update(was_lit, reason, elapsed));
        match (conditions.plan, reason) {
            (Some(plan), None) => self.light(wanted, plan, conditions, elapsed),
            (_, reason) => self.go_dark(reason.unwrap_or(DarkReason::NoPlan)),
        }
    }

    /// What the ultraviolet sensor read last; none where it has been silent for a while.
    pub const fn ultraviolet(&self) -> Option<Irradiance> {
        self.ultraviolet.reading()
    }

    /// Tells whether the plan counts on an ultraviolet sensor that is silent.
    pub const fn is_ultraviolet_sensor_lost(&self) -> bool {
        self.ultraviolet.is_lost()
    }

    /// Forgets latched faults; those whose cause persists latch again.
    pub const fn rearm(&mut self) {
        self.ultraviolet.rearm();
    }

    /// The first reason for darkness, in the order that the module's text explains.
    fn dark_reason(&self, now: &Conditions<'_>) -> Option<DarkReason> {
        use DarkReason as Reason;
        let interlock_is = |state| now.interlock == state;
        let needs_clock = now.plan.is_some_and(|plan| plan.calendar.needs_clock());
        let rules = [
            (now.watchdog_latched, Reason::WatchdogResets),
            (interlock_is(InterlockState::Open), Reason::InterlockOpen),
            (interlock_is(InterlockState::Disagrees), Reason::InterlockDisagrees),
            (interlock_is(InterlockState::WaitsForRearm), Reason::InterlockNotArmed),
            (now.plan.is_none(), Reason::NoPlan),
            (!self.supply.is_sound(), Reason::Supply),
            (no_temperature(now.boards.top), Reason::TemperatureSensor(Lamp::Top)),
            (no_temperature(now.boards.bottom), Reason::TemperatureSensor(Lamp::Bottom)),
            (self.heat.is_too_hot(Lamp::Top), Reason::TooHot(Lamp::Top)),
            (self.heat.is_too_hot(Lamp::Bottom), Reason::TooHot(Lamp::Bottom)),
            (self.heat.is_enclosure_too_hot(), Reason::EnclosureTooHot),
            (self.ultraviolet.is_too_bright(), Reason::UltravioletTooBright),
            (self.ultraviolet.is_bright_while_dark(), Reason::UltravioletWhileDark),
            (life_is_over(now), Reason::LifeDose),
            (!now.reserved, Reason::LedgerNotStored),
            (needs_clock && !now.clock_is_valid, Reason::ClockInvalid),
            (now.uptime_ms < u64::from(limits::START_DWELL.0), Reason::Starting),
        ];
        let found = rules.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason);
        found.or(now.wants_dark)
    }

    fn light(
        &mut self,
        wanted: Emphasis,
        plan: &Plan,
        conditions: &Conditions<'_>,
        elapsed: Milliseconds,
    ) -> Verdict {
        let (top, top_cuts) = self.cut(Lamp::Top, wanted.top, plan, conditions, elapsed);
        let (bottom, bottom_cuts) = self.cut(Lamp::Bottom, wanted.bottom, plan, conditions, elapsed);
        let levels = PerLamp::new(top, bottom);
        let mut cuts = PerLamp::new(top_cuts, bottom_cuts);
        self.last = levels;
        if levels == Emphasis::default() {
            return Verdict { command: LampCommand::DARK, dark: Some(DarkReason::NothingToShow), cuts };
        }
        let (top, bottom) = (&plan.lamps.top, &plan.lamps.bottom);
        let raw = PerLamp::new(counts(top, levels.top), counts(bottom, levels.bottom));
        for (counts, cuts) in [(raw.top, &mut cuts.top), (raw.bottom, &mut cuts.bottom)] {
            if counts > 0 && counts < PWM_FLOOR {
                cuts.insert(Cut::BelowFloor);
            }
        }
        let command = LampCommand {
            levels,
            counts: PerLamp::new(
                self.dither.top.apply(top.below_floor, raw.top),
                self.dither.bottom.apply(bottom.below_floor, raw.bottom),
            ),
            irradiance: PerLamp::new(levels.top.of(top.full_level), levels.bottom.of(bottom.full_level)),
            enabled: true,
        };
        Verdict { command, dark: None, cuts }
    }

    /// Lowers one lamp's level by the rules in their order.
    fn cut(
        &self,
        lamp: Lamp,
        wanted: Level,
        plan: &Plan,
        conditions: &Conditions<'_>,
        elapsed: Milliseconds,
    ) -> (Level, Cuts) {
        let full = plan.lamps.get(lamp).full_level;
        let account = conditions.accounts.get(lamp);
        let idle = Level::not_above(limits::IDLE_FLOOR, full);
        let ceiling = Level::not_above(limits::CEILING, full);
        let plan_ceiling = Level::not_above(plan.limits.ceiling, full);
        let mut level = wanted;
        let mut cuts = Cuts::default();
        let mut lower = |cut: Cut, holds: bool, most: Level| {
            if holds && level > most {
                level = most;
                cuts.insert(cut);
            }
        };
        lower(Cut::Warm, true, heat::derated(*conditions.boards.get(lamp)));
        lower(Cut::DayDose, account.day >= plan.limits.daily_dose, idle);
        let aged = is_nine_tenths(account.life, plan.limits.life_dose);
        lower(Cut::LifeDose, aged, wanted.scaled(limits::AGED_LEVEL));
        lower(Cut::Resting, self.rest.is_resting(), idle);
        lower(Cut::FirmwareCeiling, true, ceiling);
        lower(Cut::PlanCeiling, true, plan_ceiling);
        let slewed = self.slew(lamp, level, cuts, elapsed);
        if slewed != level {
            cuts.insert(Cut::Slew);
        }
        // Where a new plan brings a lower ceiling it holds at once.
        (slewed.min(ceiling).min(plan_ceiling), cuts)
    }

    /// Brings a lamp towards a level no faster than it may change, and not at all while it is to stand still. A late step gets
    /// no longer stride than one of 100 ms.
    fn slew(&self, lamp: Lamp, level: Level, cuts: Cuts, elapsed: Milliseconds) -> Level {
        let stride = |fade: Milliseconds| (elapsed.0.min(100) * 65_535 / fade.0) as u16;
        let last = *self.last.get(lamp);
        if self.stands_still {
            return last;
        }
        let slides = cuts.contains(Cut::Resting) || cuts.contains(Cut::DayDose);
        let down = stride(if slides { limits::CUT_FADE } else { limits::FASTEST_FADE });
        let up = stride(limits::FASTEST_FADE);
        Level(level.0.clamp(last.0.saturating_sub(down), last.0.saturating_add(up)))
    }

    fn go_dark(&mut self, reason: DarkReason) -> Verdict {
        self.last = Emphasis::default();
        self.dither = PerLamp::default();
        Verdict { command: LampCommand::DARK, dark: Some(reason), cuts: PerLamp::default() }
    }
}

fn no_temperature(reading: Option<TemperatureReading>) -> bool {
    reading.and_then(TemperatureReading::celsius).is_none()
}

fn life_is_over(now: &Conditions<'_>) -> bool {
    let spent = now.accounts.top.life.max(now.accounts.bottom.life);
    now.plan.is_some_and(|plan| spent >= plan.limits.life_dose)
}

const fn is_nine_tenths(spent: Dose, whole: Dose) -> bool {
    spent.0.saturating_mul(10) >= whole.0.saturating_mul(9)
}
