//! What changed in a step, for the log and the hosts, and why lamps are dark or dimmed.

use core::fmt;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::units::{Lamp, UtcSeconds};

/// The most events of one step; more are counted, not kept.
pub const MAX_EVENTS: usize = 16;

/// Why both lamps are off. Where several reasons hold, the first in this order is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum DarkReason {
    /// Three watchdog resets came within ten minutes; a re-arm clears it.
    WatchdogResets,
    /// The interlock is open.
    InterlockOpen,
    /// The interlock's loops differed for too long; a re-arm clears it.
    InterlockDisagrees,
    /// The interlock is closed again and waits for a re-arm.
    InterlockNotArmed,
    /// There is no valid plan.
    NoPlan,
    /// The lamp supply is not within its bounds, or not measured.
    Supply,
    /// A lamp board's sensor is open, shorted or silent.
    TemperatureSensor(Lamp),
    /// A lamp board is too hot.
    TooHot(Lamp),
    /// The enclosure's air is too hot.
    EnclosureTooHot,
    /// More ultraviolet is measured than the lamps should give; a re-arm clears it.
    UltravioletTooBright,
    /// Ultraviolet is measured while the lamps should be dark; a re-arm clears it.
    UltravioletWhileDark,
    /// The stack has had the dose of its life; a new stack clears it.
    LifeDose,
    /// The dose ledger has not yet been written to flash.
    LedgerNotStored,
    /// The time is not known and the plan needs it.
    ClockInvalid,
    /// The controller has just started.
    Starting,
    /// The staff key has been pressed.
    StaffKey,
    /// A host asked for dark.
    HostRequest,
    /// The schedule says closed.
    Closed,
    /// Nobody has been there for a while.
    NobodyThere,
    /// The chosen pair and its level come to nothing.
    NothingToShow,
}

impl fmt::Display for DarkReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lamp = |lamp: &Lamp| if *lamp == Lamp::Top { "top" } else { "bottom" };
        match self {
            Self::WatchdogResets => f.write_str("three watchdog resets in ten minutes; re-arm needed"),
            Self::InterlockOpen => f.write_str("the interlock is open"),
            Self::InterlockDisagrees => f.write_str("the interlock's two loops disagree; re-arm needed"),
            Self::InterlockNotArmed => f.write_str("the interlock is closed again; re-arm needed"),
            Self::NoPlan => f.write_str("there is no valid plan"),
            Self::Supply => f.write_str("the lamp supply is out of bounds or not measured"),
            Self::TemperatureSensor(l) => write!(f, "the {} lamp board's temperature sensor fails", lamp(l)),
            Self::TooHot(l) => write!(f, "the {} lamp board is too hot", lamp(l)),
            Self::EnclosureTooHot => f.write_str("the air in the enclosure is too hot"),
            Self::UltravioletTooBright => {
                f.write_str("more ultraviolet than the lamps should give; re-arm needed")
            }
            Self::UltravioletWhileDark => {
                f.write_str("ultraviolet while the lamps should be dark; re-arm needed")
            }
            Self::LifeDose => f.write_str("the stack has had its life's dose; declare a new stack"),
            Self::LedgerNotStored => f.write_str("the dose ledger is not yet stored"),
            Self::ClockInvalid => f.write_str("the time is not known and the plan has a schedule"),
            Self::Starting => f.write_str("the controller has just started"),
            Self::StaffKey => f.write_str("the staff key was pressed"),
            Self::HostRequest => f.write_str("a host asked for dark"),
            Self::Closed => f.write_str("the schedule says closed"),
            Self::NobodyThere => f.write_str("nobody has been there for a while"),
            Self::NothingToShow => f.write_str("the chosen pair has no light"),
        }
    }
}

/// Why a lamp gives less than was wanted, without being dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Cut {
    /// The lamp board is warm.
    Warm = 0,
    /// The day's dose is used up: the idle glow.
    DayDose = 1,
    /// Nine tenths of the stack's life are used up: a quarter less light.
    LifeDose = 2,
    /// Resting after a long time lit: the idle glow.
    Resting = 3,
    /// The firmware's ceiling.
    FirmwareCeiling = 4,
    /// The plan's ceiling.
    PlanCeiling = 5,
    /// Not faster than the slew allows.
    Slew = 6,
    /// Below the driver's floor.
    BelowFloor = 7,
}

/// The set of cuts at work on a lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cuts(u16);

impl Cuts {
    /// All cuts, in the order in which the governor applies them.
    pub const ALL: [Cut; 8] = [
        Cut::Warm,
        Cut::DayDose,
        Cut::LifeDose,
        Cut::Resting,
        Cut::FirmwareCeiling,
        Cut::PlanCeiling,
        Cut::Slew,
        Cut::BelowFloor,
    ];

    /// Adds a cut to the set.
    pub const fn insert(&mut self, cut: Cut) {
        self.0 |= 1 << cut as u8;
    }

    /// Tells whether a cut is in the set.
    pub const fn contains(self, cut: Cut) -> bool {
        self.0 >> cut as u8 & 1 == 1
    }

    /// Gives the cuts in the set in the governor's order.
    pub fn iter(self) -> impl Iterator<Item = Cut> {
        Self::ALL.into_iter().filter(move |cut| self.contains(*cut))
    }

    /// The cuts that are in either set.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Something that changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// The lamps went dark, or are dark for another reason.
    Dark(DarkReason),
    /// The lamps are let through again.
    Lit,
    /// This view was chosen.
    ViewChosen(u8),
    /// Somebody has come.
    ViewerCame,
    /// Nobody is left.
    ViewersGone,
    /// The viewer sensors give nothing credible: the neutral pair is shown.
    ViewerSensorLost,
    /// The viewer sensors are back.
    ViewerSensorBack,
    /// A cut began on a lamp.
    CutBegan(Lamp, Cut),
    /// A cut ended on a lamp.
    CutEnded(Lamp, Cut),
    /// The interlock was re-armed.
    Rearmed,
    /// A re-arm was refused because its cause persists.
    RearmRefused,
    /// Another plan is active.
    PlanChanged,
    /// The plan is gone or was refused.
    PlanLost,
    /// A request named a view that the plan does not have.
    NoSuchView(u8),
    /// A host's lease ran out.
    LeaseLapsed,
    /// A new day of the dose ledger began.
    DayBegan,
    /// This part of the stack's life dose is used, in percent.
    LifeDoseUsed(Lamp, u8),
    /// The measured ultraviolet is well below what the lamps should give: they or the sensor have aged.
    UltravioletLow,
    /// The air in the enclosure is warm.
    EnclosureWarm,
    /// A lamp has burnt for this many hours at its full level's equivalent.
    LampHours(Lamp, u16),
    /// A fresh stack was declared.
    NewStack,
    /// What a lamp had given in a day of the ledger when that day ended.
    DayDose {
        /// Which lamp.
        lamp: Lamp,
        /// The local day since 1970-01-01.
        day: u32,
        /// The dose on its nearest film in that day, in J/m², rounded up.
        joules_m2: u32,
        /// The hours that it had burnt in all by then.
        lit_hours: u32,
    },
    /// The ultraviolet sensor on which the plan counts is silent.
    UltravioletSensorLost,
    /// The ultraviolet sensor is back.
    UltravioletSensorBack,
    /// The clock was set, or jumped: the dose of the day stays with the day that the ledger is in.
    ClockJumped {
        /// By how many seconds it was put forward, or back where negative.
        seconds: i32,
    },
    /// The program before this one ended badly.
    ProgramEnded {
        /// How.
        end: ProgramEnd,
        /// Where: the faulting instruction's address, or the source line of a panic; 0 where it is not known.
        at: u32,
    },
    /// So many events found no room while the log had to wait for steady lamps.
    EventsLost(u32),
}

/// How a program ended that did not end by the power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProgramEnd {
    /// It found a fault in itself.
    Panic,
    /// The processor found one.
    HardFault,
    /// A task hung, and the watchdog bit.
    Hang,
}

impl fmt::Display for ProgramEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Panic => "it panicked",
            Self::HardFault => "the processor met a hard fault",
            Self::Hang => "a task hung, and the watchdog bit",
        })
    }
}

impl Event {
    /// Tells whether the log keeps this event. What comes and goes with every visitor and every fade is not kept: it
    /// would push out what a technician looks for.
    pub const fn is_kept(self) -> bool {
        !matches!(
            self,
            Self::ViewChosen(_)
                | Self::ViewerCame
                | Self::ViewersGone
                | Self::CutBegan(_, Cut::Slew | Cut::BelowFloor)
                | Self::CutEnded(_, Cut::Slew | Cut::BelowFloor)
        )
    }
}

/// An event as the log keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogEntry {
    /// Its place in the log, from 1; gapless.
    pub sequence: u32,
    /// When, if the clock was valid.
    pub time: Option<UtcSeconds>,
    /// Seconds since the controller's last start.
    pub uptime_s: u32,
    /// What happened.
    pub event: Event,
}

/// What changed in one step.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Events {
    kept: Vec<Event, MAX_EVENTS>,
    lost: u16,
}

impl Events {
    /// Adds an event; beyond [`MAX_EVENTS`] it is only counted.
    pub fn push(&mut self, event: Event) {
        if self.kept.push(event).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// The events in their order.
    pub fn iter(&self) -> impl Iterator<Item = Event> {
        self.kept.iter().copied()
    }

    /// How many events found no room.
    pub const fn lost(&self) -> u16 {
        self.lost
    }

    /// Tells whether an event happened.
    pub fn contains(&self, event: Event) -> bool {
        self.kept.contains(&event)
    }

    /// Tells whether nothing happened.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }
}
