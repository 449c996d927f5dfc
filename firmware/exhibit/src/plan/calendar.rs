//! The plan's times: schedule rules, closed days and the time zone with its daylight saving rule.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::units::Level;

/// The most schedule rules of a plan.
pub const MAX_RULES: usize = 32;
/// The most spans of closed days of a plan.
pub const MAX_CLOSED: usize = 64;

/// A date of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Date {
    /// The year, 1970 to 2199.
    pub year: u16,
    /// The month, 1 to 12.
    pub month: u8,
    /// The day of the month, from 1.
    pub day: u8,
}

/// A set of days of the week: bit 0 is Monday, bit 6 Sunday.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Weekdays(pub u8);

impl Weekdays {
    /// Every day.
    pub const ALL: Self = Self(0b111_1111);

    /// Tells whether a day is in the set; Monday is 0.
    pub const fn contains(self, weekday: u8) -> bool {
        weekday < 7 && self.0 >> weekday & 1 == 1
    }
}

/// A time of the local day in minutes after midnight, 0 to 1,440.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MinuteOfDay(pub u16);

/// When the exhibit is lit, and how much of each pair's light it gives.
///
/// Where several rules hold at one moment the last of them decides: a later rule makes an exception of an earlier
/// one. A rule belongs to the local day on which it begins, also where it runs over midnight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ScheduleRule {
    /// Days of the week on which it begins.
    pub days: Weekdays,
    /// Local time at which it begins.
    pub from: MinuteOfDay,
    /// Local time at which it ends; not later than `from` means on the next day.
    pub to: MinuteOfDay,
    /// The first date on which it begins.
    pub first: Option<Date>,
    /// The last date on which it begins.
    pub last: Option<Date>,
    /// Part of the pair's light; `OFF` is dark.
    pub level: Level,
}

/// Days on which no rule begins, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ClosedDays {
    /// The first closed date.
    pub first: Date,
    /// The last closed date.
    pub last: Date,
}

/// The moment of a year at which local time changes, as in POSIX's `Mm.w.d/time`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Transition {
    /// The month, 1 to 12.
    pub month: u8,
    /// The week of the month, 1 to 5; 5 is the last.
    pub week: u8,
    /// The day of the week; Monday is 0.
    pub weekday: u8,
    /// Minutes after midnight of that day in the local time that ends here, -10,020 to 10,020.
    pub minute: i16,
}

/// When and by how much a zone saves daylight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct DaylightRule {
    /// Local time minus UTC while daylight is saved, in minutes.
    pub offset_minutes: i16,
    /// When it begins.
    pub start: Transition,
    /// When it ends.
    pub end: Transition,
}

/// A time zone as a rule, so that the controller needs no table of zones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TimeZone {
    /// Local time minus UTC in minutes, outside daylight saving.
    pub offset_minutes: i16,
    /// The rule of daylight saving, where there is one.
    pub daylight: Option<DaylightRule>,
}

/// The times of an exhibit.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Calendar {
    /// The zone in which the rules are read.
    pub time_zone: TimeZone,
    /// When to be lit; without a rule the exhibit is always open.
    pub rules: Vec<ScheduleRule, MAX_RULES>,
    /// Closed days.
    pub closed: Vec<ClosedDays, MAX_CLOSED>,
}

impl Calendar {
    /// Tells whether these times cannot be kept without a valid clock.
    pub fn needs_clock(&self) -> bool {
        !self.rules.is_empty() || !self.closed.is_empty()
    }
}
