//! Reads a time zone's rule from a POSIX TZ string, such as the last line of every zone in the tz database.

use core::fmt;

use crate::plan::calendar::{DaylightRule, TimeZone, Transition};

/// Why a POSIX TZ string was not understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneError {
    /// A zone's abbreviation is missing or too short.
    Name,
    /// An offset or a time is not `hh[:mm[:ss]]` within a day, or a week for a change.
    Time,
    /// A change is not `Mmonth.week.weekday`; other forms are not kept.
    Change,
    /// Something follows the rule.
    Trailing,
}

impl fmt::Display for ZoneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Name => "a zone's abbreviation is missing",
            Self::Time => "an offset or time is not hh[:mm[:ss]]",
            Self::Change => "a change of time is not given as Mmonth.week.weekday",
            Self::Trailing => "something follows the zone's rule",
        })
    }
}

impl core::error::Error for ZoneError {}

impl TimeZone {
    /// Reads a rule such as `CET-1CEST,M3.5.0,M10.5.0/3`.
    ///
    /// # Errors
    /// What is missing or not understood. Changes by day of the year (`Jn`, `n`) are not kept.
    pub fn from_posix(text: &str) -> Result<Self, ZoneError> {
        let (rest, west) = offset(name(text)?)?.ok_or(ZoneError::Time)?;
        let offset_minutes = -west;
        if rest.is_empty() {
            return Ok(Self { offset_minutes, daylight: None });
        }
        let rest = name(rest)?;
        let (rest, east) = match offset(rest)? {
            Some((rest, west)) => (rest, -west),
            None => (rest, offset_minutes + 60),
        };
        let (rest, start) = change(rest)?;
        let (rest, end) = change(rest)?;
        if !rest.is_empty() {
            return Err(ZoneError::Trailing);
        }
        Ok(Self { offset_minutes, daylight: Some(DaylightRule { offset_minutes: east, start, end }) })
    }
}

/// Skips an abbreviation: at least three letters, or anything between angle brackets.
fn name(text: &str) -> Result<&str, ZoneError> {
    if let Some(quoted) = text.strip_prefix('<') {
        return quoted.split_once('>').map(|(_, rest)| rest).ok_or(ZoneError::Name);
    }
    let rest = text.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    if text.len() - rest.len() < 3 { Err(ZoneError::Name) } else { Ok(rest) }
}

fn offset(text: &str) -> Result<Option<(&str, i16)>, ZoneError> {
    if !text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+') {
        return Ok(None);
    }
    let (rest, minutes) = time(text, 24)?;
    Ok(Some((rest, minutes)))
}

/// Reads `[+-]hh[:mm[:ss]]` as minutes; seconds must be zero.
fn time(text: &str, most_hours: u16) -> Result<(&str, i16), ZoneError> {
    let negative = text.starts_with('-');
    let text = text.strip_prefix(['-', '+']).unwrap_or(text);
    let (mut rest, hours) = number(text).ok_or(ZoneError::Time)?;
    let mut minutes = 0;
    if let Some(after) = rest.strip_prefix(':') {
        (rest, minutes) = number(after).ok_or(ZoneError::Time)?;
        if let Some(after) = rest.strip_prefix(':') {
            let (after, seconds) = number(after).ok_or(ZoneError::Time)?;
            rest = after;
            if seconds != 0 {
                return Err(ZoneError::Time);
            }
        }
    }
    if hours > most_hours || minutes > 59 {
        return Err(ZoneError::Time);
    }
    let total = (hours * 60 + minutes) as i16;
    Ok((rest, if negative { -total } else { total }))
}

fn change(text: &str) -> Result<(&str, Transition), ZoneError> {
    let text = text.strip_prefix(",M").ok_or(ZoneError::Change)?;
    let (text, month) = field(text, 1..=12)?;
    let (text, week) = field(text.strip_prefix('.').ok_or(ZoneError::Change)?, 1..=5)?;
    let (text, from_sunday) = field(text.strip_prefix('.').ok_or(ZoneError::Change)?, 0..=6)?;
    let (text, minute) = match text.strip_prefix('/') {
        Some(text) => time(text, 167)?,
        None => (text, 120),
    };
    Ok((text, Transition { month, week, weekday: (from_sunday + 6) % 7, minute }))
}

fn field(text: &str, range: core::ops::RangeInclusive<u8>) -> Result<(&str, u8), ZoneError> {
    let (rest, value) = number(text).ok_or(ZoneError::Change)?;
    u8::try_from(value)
        .ok()
        .filter(|value| range.contains(value))
        .map(|value| (rest, value))
        .ok_or(ZoneError::Change)
}

fn number(text: &str) -> Option<(&str, u16)> {
    let rest = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let digits = text.strip_suffix(rest)?;
    digits.parse().ok().map(|value| (rest, value))
}
