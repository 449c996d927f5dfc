//! When the exhibit is open: a pure function of the calendar and of now.
//!
//! Dates are counted in days since 1970-01-01 by Howard Hinnant's `chrono`-compatible algorithms
//! (<https://howardhinnant.github.io/date_algorithms.html>), which are exact over the whole range.

mod posix;

pub use self::posix::ZoneError;
use crate::plan::calendar::{Calendar, Date, ScheduleRule, TimeZone, Transition};
use crate::units::{Level, UtcSeconds};

const DAY: i64 = 86_400;

/// Times before 2025-01-01 come from a clock that was never set.
pub const EARLIEST: UtcSeconds = UtcSeconds(1_735_689_600);
/// Times from 2200-01-01 on come from a clock that is out of order.
pub const LATEST: UtcSeconds = UtcSeconds(7_258_118_400);

/// A moment as the clock on the wall tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LocalTime {
    /// Days since 1970-01-01.
    pub day: u32,
    /// The date.
    pub date: Date,
    /// The day of the week; Monday is 0.
    pub weekday: u8,
    /// Minutes since midnight, 0 to 1,439.
    pub minute: u16,
    /// Daylight is being saved.
    pub daylight: bool,
}

/// Takes a time from a clock; gives none where it cannot be right.
pub fn plausible(now: UtcSeconds) -> Option<UtcSeconds> {
    (EARLIEST <= now && now < LATEST).then_some(now)
}

/// Gives the part of each pair's light that the calendar wants now; `OFF` is closed.
pub fn level_at(calendar: &Calendar, now: UtcSeconds) -> Level {
    let now = local_time(&calendar.time_zone, now);
    if calendar.rules.is_empty() {
        return if is_closed(calendar, now.date) { Level::OFF } else { Level::FULL };
    }
    calendar.rules.iter().rev().find(|rule| holds(calendar, rule, now)).map_or(Level::OFF, |rule| rule.level)
}

/// Tells whether a rule of the calendar holds at a moment, whatever later rules say.
pub fn holds(calendar: &Calendar, rule: &ScheduleRule, now: LocalTime) -> bool {
    let over_midnight = rule.to <= rule.from;
    let since_today = now.minute >= rule.from.0 && (over_midnight || now.minute < rule.to.0);
    let since_yesterday = over_midnight && now.minute < rule.to.0;
    since_today && begins_on(calendar, rule, now)
        || since_yesterday && begins_on(calendar, rule, day_before(now))
}

/// Gives the local time of a moment; moments before 1970 count as its first.
pub fn local_time(zone: &TimeZone, now: UtcSeconds) -> LocalTime {
    let standard = i64::from(zone.offset_minutes) * 60;
    let daylight = is_daylight(zone, now);
    let offset =
        zone.daylight.filter(|_| daylight).map_or(standard, |rule| i64::from(rule.offset_minutes) * 60);
    let local = now.0.clamp(0, LATEST.0).saturating_add(offset).max(0);
    let (day, second) = ((local / DAY) as u32, local % DAY);
    LocalTime { day, date: date_of(day), weekday: weekday_of(day), minute: (second / 60) as u16, daylight }
}

/// Gives the date of a count of days since 1970-01-01.
pub const fn date_of(day: u32) -> Date {
    let shifted = day + 719_468;
    let era = shifted / 146_097;
    let of_era = shifted % 146_097;
    let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * of_year + 2) / 153;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = era * 400 + year_of_era + (month <= 2) as u32;
    Date { year: year as u16, month: month as u8, day: (of_year - (153 * from_march + 2) / 5 + 1) as u8 }
}

/// Gives the count of days from 1970-01-01 to a date of 1970 or later.
pub const fn day_of(date: Date) -> u32 {
    let year = date.year as u32 - (date.month <= 2) as u32;
    let (era, year_of_era) = (year / 400, year % 400);
    let from_march = (date.month as u32 + 9) % 12;
    let of_year = (153 * from_march + 2) / 5 + date.day as u32 - 1;
    let of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + of_year;
    (era * 146_097 + of_era).saturating_sub(719_468)
}

/// Gives the day of the week of a count of days since 1970-01-01, which was a Thursday; Monday is 0.
pub const fn weekday_of(day: u32) -> u8 {
    ((day + 3) % 7) as u8
}

fn day_before(today: LocalTime) -> LocalTime {
    let day = today.day.saturating_sub(1);
    LocalTime { day, date: date_of(day), weekday: weekday_of(day), ..today }
}

fn begins_on(calendar: &Calendar, rule: &ScheduleRule, day: LocalTime) -> bool {
    rule.days.contains(day.weekday)
        && rule.first.is_none_or(|first| first <= day.date)
        && rule.last.is_none_or(|last| day.date <= last)
        && !is_closed(calendar, day.date)
}

fn is_closed(calendar: &Calendar, date: Date) -> bool {
    calendar.closed.iter().any(|closed| closed.first <= date && date <= closed.last)
}

fn is_daylight(zone: &TimeZone, now: UtcSeconds) -> bool {
    let Some(rule) = zone.daylight else { return false };
    let standard = i64::from(zone.offset_minutes) * 60;
    let saved = i64::from(rule.offset_minutes) * 60;
    let day = now.0.clamp(0, LATEST.0).saturating_add(standard).max(0) / DAY;
    let year = date_of(day as u32).year;
    let start = moment_of(year, &rule.start) - standard;
    let end = moment_of(year, &rule.end) - saved;
    if start < end { start <= now.0 && now.0 < end } else { !(end <= now.0 && now.0 < start) }
}

/// Gives the local second at which a transition of a year happens.
fn moment_of(year: u16, at: &Transition) -> i64 {
    let first = day_of(Date { year, month: at.month, day: 1 });
    let to_weekday = (u32::from(at.weekday) + 7 - u32::from(weekday_of(first))) % 7;
    let mut day = first + to_weekday + 7 * (u32::from(at.week) - 1);
    if date_of(day).month != at.month {
        day -= 7;
    }
    i64::from(day) * DAY + i64::from(at.minute) * 60
}

#[cfg(test)]
mod tests;
