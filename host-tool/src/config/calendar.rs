//! `[[schedule]]` and `[calendar]`: days, times and dates.

use jiff::civil::Date;
use toml::Spanned;
use toml::de::DeValue;
use vitrine_exhibit::plan::calendar::MAX_CLOSED;

use super::exhibit::{CalendarSettings, ScheduleRule};
use super::problem::Problems;
use super::reader::{Bounds, Placed, TableReader};
use super::zone;

const DAY_NAMES: [&str; 7] = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];
const DAYS_WANTED: &str = "days such as \"mon\", \"tue-fri\" or \"daily\", or a list of them";
const MINUTES_A_DAY: u16 = 24 * 60;

/// `[calendar]`.
pub(super) fn calendar(mut reader: TableReader<'_>, problems: &mut Problems) -> CalendarSettings {
    let mut time_zone = "UTC".to_owned();
    if let Some(text) = reader.text("time_zone") {
        match zone::time_zone(text.value) {
            Ok(_) => time_zone = text.value.to_owned(),
            Err(error) => reader.report_value(text.span, error.to_string(), zone_help(text.value)),
        }
    }
    let mut closed = Vec::new();
    if let Some(items) = reader.array("closed", "a list of dates such as \"2026-12-25\"") {
        for item in items {
            closed.extend(date(&mut reader, "closed", item));
        }
    }
    closed.sort_unstable();
    closed.dedup();
    if closed_spans(&closed).len() > MAX_CLOSED {
        let message = format!("more than {MAX_CLOSED} separate spans of closed days");
        reader.report_value(
            reader.span(),
            message,
            "close whole weekdays by leaving them out of the schedule",
        );
    }
    reader.finish(problems);
    CalendarSettings { time_zone, closed }
}

/// First and last days of the spans that `days`, in their order, make up.
pub(crate) fn closed_spans(days: &[Date]) -> Vec<(Date, Date)> {
    let mut spans: Vec<(Date, Date)> = Vec::new();
    for &day in days {
        match spans.last_mut() {
            Some((_, last)) if last.tomorrow().ok() == Some(day) => *last = day,
            _ => spans.push((day, day)),
        }
    }
    spans
}

fn zone_help(wrong: &str) -> String {
    match zone::closest_name(wrong).filter(|name| *name != wrong) {
        Some(name) => format!("did you mean \"{name}\"? Names are those of the IANA database"),
        None => "give a name of the IANA database, such as \"Europe/Berlin\"".to_owned(),
    }
}

/// One `[[schedule]]`.
pub(super) fn schedule_rule(mut reader: TableReader<'_>, problems: &mut Problems) -> ScheduleRule {
    let days = days(&mut reader);
    let from = time(&mut reader, "from", 0);
    let to = time(&mut reader, "to", MINUTES_A_DAY);
    let first = reader.raw("first").and_then(|value| date(&mut reader, "first", value));
    let last = reader.raw("last").and_then(|value| date(&mut reader, "last", value));
    let level = reader.number("level", 1.0, Bounds { least: 0.0, most: 1.0, reason: "1 is all the light" });
    if let (Some(first), Some(last)) = (first, last)
        && last < first
    {
        let message = format!("the rule ends on {last}, before it begins on {first}");
        reader.report_value(reader.span(), message, "swap `first` and `last`");
    }
    if from.value == MINUTES_A_DAY {
        reader.report_value(from.span, "a rule cannot begin at \"24:00\"".to_owned(), "write \"00:00\"");
    } else if from.value == to.value {
        let message = "the rule ends when it begins".to_owned();
        reader.report_value(to.span.clone(), message, "for a whole day, leave `from` and `to` out");
    }
    if let (Some(first), Some(last)) = (first, last)
        && first <= last
        && !holds_within(days, first, last)
    {
        let message = format!("none of the rule's days lies between {first} and {last}");
        reader.report_value(reader.span(), message, "widen `first` and `last`, or name other `days`");
    }
    reader.finish(problems);
    ScheduleRule { days, from_minute: from.value, to_minute: to.value, first, last, level }
}

/// Whether one of the weekdays `days` lies between two dates, both included.
fn holds_within(days: [bool; 7], first: Date, last: Date) -> bool {
    let weekday = |date: Date| usize::from(date.weekday().to_monday_zero_offset().unsigned_abs());
    let week = std::iter::successors(Some(first), |date| date.tomorrow().ok()).take(7);
    week.take_while(|date| *date <= last).any(|date| days[weekday(date)])
}

/// `days`, on each of which the rule holds; every day where it is left out.
fn days(reader: &mut TableReader<'_>) -> [bool; 7] {
    let Some(value) = reader.raw("days") else { return [true; 7] };
    let items: Vec<&Spanned<DeValue<'_>>> = match value.get_ref() {
        DeValue::Array(items) => items.iter().collect(),
        _ => vec![value],
    };
    if items.is_empty() {
        reader.report_value(value.span(), "`days` names no days".to_owned(), format!("write {DAYS_WANTED}"));
    }
    let mut days = [false; 7];
    for item in items {
        let Some(text) = item.get_ref().as_str() else {
            reader.report_type("days", item, DAYS_WANTED);
            continue;
        };
        match day_range(text) {
            Some(range) => range.iter().for_each(|&day| days[day] = true),
            None => reader.report_value(
                item.span(),
                format!("\"{text}\" names no days"),
                format!("write {DAYS_WANTED}"),
            ),
        }
    }
    days
}

/// The days, Monday being 0, that a text such as `sat-mon` names.
fn day_range(text: &str) -> Option<Vec<usize>> {
    let text = text.trim().to_lowercase();
    if text == "daily" {
        return Some((0..7).collect());
    }
    let day = |name: &str| DAY_NAMES.iter().position(|known| name.len() >= 3 && day_matches(name, known));
    match text.split_once('-') {
        None => Some(vec![day(&text)?]),
        Some((first, last)) => {
            let (first, last) = (day(first.trim())?, day(last.trim())?);
            Some((0..=(last + 7 - first) % 7).map(|step| (first + step) % 7).collect())
        }
    }
}

/// Whether `name`, short or in full, is the day that `short` stands for.
fn day_matches(name: &str, short: &str) -> bool {
    const FULL: [&str; 7] = ["monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday"];
    name == short || FULL.iter().any(|full| *full == name && full.starts_with(short))
}

/// A time of day in minutes after midnight, as a text or as TOML's local time.
fn time(reader: &mut TableReader<'_>, key: &'static str, default: u16) -> Placed<u16> {
    let Some(value) = reader.raw(key) else { return Placed { value: default, span: reader.span() } };
    let text = match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Datetime(datetime) => datetime.to_string(),
        _ => {
            reader.report_type(key, value, "a time such as \"09:30\"");
            return Placed { value: default, span: value.span() };
        }
    };
    match parse_time(&text) {
        Some(minute) => Placed { value: minute, span: value.span() },
        None => {
            let help = "write hours and minutes, \"00:00\" to \"24:00\"";
            reader.report_value(value.span(), format!("`{key}` is \"{text}\", which is no time"), help);
            Placed { value: default, span: value.span() }
        }
    }
}

fn parse_time(text: &str) -> Option<u16> {
    let mut parts = text.split(':').map(|part| {
        let digits = (1..=2).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_digit());
        digits.then(|| part.parse::<u16>().ok()).flatten()
    });
    let (hour, minute) = (parts.next()??, parts.next()??);
    let seconds = parts.next().unwrap_or(Some(0))?;
    if parts.next().is_some() || minute > 59 || seconds != 0 {
        return None;
    }
    let minute = hour.checked_mul(60)? + minute;
    (minute <= MINUTES_A_DAY).then_some(minute)
}

fn date(reader: &mut TableReader<'_>, key: &str, value: &Spanned<DeValue<'_>>) -> Option<Date> {
    let text = match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Datetime(datetime) => datetime.to_string(),
        _ => {
            reader.report_type(key, value, "a date such as \"2026-12-25\"");
            return None;
        }
    };
    let date =
        text.parse::<Date>().ok().filter(|date| text.len() == 10 && (1970..=2199).contains(&date.year()));
    if date.is_none() {
        let help = "write year-month-day, such as \"2026-12-25\"";
        reader.report_value(value.span(), format!("`{key}` is \"{text}\", which is no date"), help);
    }
    date
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_may_be_named_alone_or_as_a_range_over_the_weekend() {
        assert_eq!(day_range("tue"), Some(vec![1]));
        assert_eq!(day_range("Saturday - Monday"), Some(vec![5, 6, 0]));
        assert_eq!(day_range("daily").map(|days| days.len()), Some(7));
        assert_eq!(day_range("tu"), None);
        assert_eq!(day_range("mon-"), None);
    }

    #[test]
    fn closed_days_in_a_row_are_one_span() {
        let day = |day| jiff::civil::date(2026, 12, day);
        assert_eq!(
            closed_spans(&[day(24), day(25), day(26), day(31)]),
            [(day(24), day(26)), (day(31), day(31))]
        );
    }

    #[test]
    fn times_reach_from_midnight_to_midnight() {
        assert_eq!(parse_time("00:00"), Some(0));
        assert_eq!(parse_time("24:00"), Some(MINUTES_A_DAY));
        assert_eq!(parse_time("09:30:00"), Some(570));
        for wrong in ["24:01", "9:60", "+9:00", "9", "09:30:10", "a:b", ""] {
            assert_eq!(parse_time(wrong), None, "{wrong}");
        }
    }
}
