use super::*;
use crate::plan::calendar::{ClosedDays, MinuteOfDay, Weekdays};
use jiff::civil;
use jiff::tz;

fn utc(text: &str) -> UtcSeconds {
    UtcSeconds(text.parse::<jiff::Timestamp>().unwrap().as_second())
}

fn berlin() -> TimeZone {
    TimeZone::from_posix("CET-1CEST,M3.5.0,M10.5.0/3").unwrap()
}

fn rule(days: u8, from: u16, to: u16) -> ScheduleRule {
    ScheduleRule {
        days: Weekdays(days),
        from: MinuteOfDay(from),
        to: MinuteOfDay(to),
        first: None,
        last: None,
        level: Level::FULL,
    }
}

fn calendar(rules: &[ScheduleRule]) -> Calendar {
    Calendar { time_zone: berlin(), rules: rules.iter().copied().collect(), ..Calendar::default() }
}

fn is_open(calendar: &Calendar, text: &str) -> bool {
    level_at(calendar, utc(text)) > Level::OFF
}

/// The local time of zones from all over the world, in every hour of 40 years, as jiff has it.
#[test]
fn zones_agree_with_an_independent_library() {
    for posix in [
        "UTC0",
        "CET-1CEST,M3.5.0,M10.5.0/3",
        "GMT0BST,M3.5.0/1,M10.5.0",
        "EST5EDT,M3.2.0,M11.1.0",
        "AEST-10AEDT,M10.1.0,M4.1.0/3",
        "<+1030>-10:30<+11>-11,M10.1.0,M4.1.0",
        "<-02>2<-01>,M3.5.0/-1,M10.5.0/0",
        "IST-5:30",
        "NZST-12NZDT,M9.5.0,M4.1.0/3",
    ] {
        let zone = TimeZone::from_posix(posix).unwrap();
        let oracle = tz::TimeZone::posix(posix).unwrap();
        let mut now = EARLIEST.0;
        while now < utc("2065-01-01T00:00:00Z").0 {
            let ours = local_time(&zone, UtcSeconds(now));
            let theirs = oracle.to_datetime(jiff::Timestamp::from_second(now).unwrap());
            assert_eq!(
                (ours.date.year, ours.date.month, ours.date.day, ours.minute),
                (
                    theirs.year() as u16,
                    theirs.month() as u8,
                    theirs.day() as u8,
                    theirs.hour() as u16 * 60 + theirs.minute() as u16
                ),
                "{posix} at {now}"
            );
            assert_eq!(ours.weekday, theirs.date().weekday().to_monday_zero_offset() as u8);
            now += 3_600 * 3 + 1_799;
        }
    }
}

#[test]
fn every_day_of_two_centuries_survives_the_way_there_and_back() {
    let mut date = civil::date(1970, 1, 1);
    for day in 0..84_006 {
        assert_eq!(
            date_of(day),
            Date { year: date.year() as u16, month: date.month() as u8, day: date.day() as u8 }
        );
        assert_eq!(day_of(date_of(day)), day);
        date = date.tomorrow().unwrap();
    }
}

#[test]
fn impossible_zones_are_refused() {
    for text in
        ["", "CE", "CET", "CET-25", "CET-1CEST", "CET-1CEST,J60,J300", "CET-1CEST,M13.1.0,M4.1.0", "UTC0 "]
    {
        assert!(TimeZone::from_posix(text).is_err(), "{text}");
    }
}

#[test]
fn a_rule_over_midnight_belongs_to_the_day_on_which_it_begins() {
    let fridays = calendar(&[rule(0b001_0000, 22 * 60, 2 * 60)]);
    assert!(is_open(&fridays, "2026-05-01T20:00:00Z"));
    assert!(is_open(&fridays, "2026-05-01T23:59:00Z"));
    assert!(!is_open(&fridays, "2026-05-02T00:00:00Z"));
    assert!(!is_open(&fridays, "2026-04-30T20:00:00Z"));
}

#[test]
fn a_closed_friday_has_no_night_either_but_a_closed_saturday_keeps_fridays() {
    let mut fridays = calendar(&[rule(0b001_0000, 22 * 60, 2 * 60)]);
    let day = |day| Date { year: 2026, month: 5, day };
    fridays.closed.push(ClosedDays { first: day(2), last: day(2) }).unwrap();
    assert!(is_open(&fridays, "2026-05-01T23:30:00Z"));
    fridays.closed.push(ClosedDays { first: day(1), last: day(1) }).unwrap();
    assert!(!is_open(&fridays, "2026-05-01T23:30:00Z"));
}

#[test]
fn the_later_rule_makes_the_exception() {
    let noon = ScheduleRule { level: Level::OFF, ..rule(127, 12 * 60, 13 * 60) };
    let lunch = calendar(&[rule(127, 9 * 60, 17 * 60), noon]);
    assert!(is_open(&lunch, "2026-01-15T10:59:59Z"));
    assert!(!is_open(&lunch, "2026-01-15T11:00:00Z"));
    assert!(is_open(&lunch, "2026-01-15T12:00:00Z"));
}

#[test]
fn first_and_last_date_are_both_included() {
    let date = |month, day| Some(Date { year: 2026, month, day });
    let summer = calendar(&[ScheduleRule { first: date(6, 1), last: date(8, 31), ..rule(127, 0, 1_440) }]);
    assert!(!is_open(&summer, "2026-05-31T21:59:00Z"));
    assert!(is_open(&summer, "2026-05-31T22:00:00Z"));
    assert!(is_open(&summer, "2026-08-31T21:59:00Z"));
    assert!(!is_open(&summer, "2026-08-31T22:00:00Z"));
}

#[test]
fn opening_hours_follow_the_clock_on_the_wall_through_both_changes() {
    let nine = calendar(&[rule(127, 9 * 60, 17 * 60)]);
    for (day, opens) in [("2026-03-28", 8), ("2026-03-29", 7), ("2026-10-24", 7), ("2026-10-25", 8)] {
        assert!(!is_open(&nine, &format(day, opens - 1, 59)), "{day}");
        assert!(is_open(&nine, &format(day, opens, 0)), "{day}");
    }
}

fn format(day: &str, hour: u8, minute: u8) -> heapless::String<32> {
    let mut text = heapless::String::new();
    core::fmt::write(&mut text, format_args!("{day}T{hour:02}:{minute:02}:00Z")).unwrap();
    text
}
