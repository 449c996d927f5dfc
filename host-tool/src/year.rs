//! A year of an exhibit: when its schedule lights it, and what dose its films may get.
//!
//! The calendar is asked through the controller's own [`level_at`], minute by minute, so that what is previewed is what
//! is kept.

use serde::Serialize;
use vitrine_exhibit::limits::IDLE_FLOOR;
use vitrine_exhibit::plan::Limits;
use vitrine_exhibit::plan::calendar::{Calendar, Date};
use vitrine_exhibit::schedule::{date_of, day_of, level_at, local_time};
use vitrine_exhibit::units::{Irradiance, Level, UtcSeconds};

const MINUTE_S: i64 = 60;
const DAY_S: i64 = 86_400;
/// Local time is at most this far from UTC.
const MOST_OFFSET_S: i64 = DAY_S;

/// One day of the year.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Day {
    /// The month, 1 to 12.
    pub month: u8,
    /// The day of the month, from 1.
    pub day: u8,
    /// Hours in which the exhibit may be lit.
    pub open_h: f64,
    /// The most dose of one lamp, with somebody there all the time.
    pub dose_j_m2: f64,
}

/// A year of an exhibit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Year {
    /// The year.
    pub year: u16,
    /// Its days.
    pub days: Vec<Day>,
    /// Hours in which the exhibit may be lit.
    pub open_h: f64,
    /// Days on which it may be lit.
    pub open_days: usize,
    /// The most dose of one lamp in the year, with somebody there all the time.
    pub dose_j_m2: f64,
    /// How long a lamp may be at full level until the day's dose is used up.
    pub full_level_h_a_day: f64,
    /// In how many such years the dose of the stack's life is used up; none where it never is.
    pub life_years: Option<f64>,
}

/// Goes through `year` in local time, with a lamp of `full_level` at its full level.
pub fn year(calendar: &Calendar, limits: &Limits, full_level: Irradiance, year: u16) -> Year {
    let first = day_of(Date { year, month: 1, day: 1 });
    let last = day_of(Date { year: year.saturating_add(1), month: 1, day: 1 });
    let mut tallies = vec![Tally::default(); (last - first) as usize];
    let lamp = lamp_w_m2(full_level, limits);
    let budget_j_m2 = limits.daily_dose.0 as f64 / 1e6;
    let mut moment = i64::from(first) * DAY_S - MOST_OFFSET_S;
    while moment < i64::from(last) * DAY_S + MOST_OFFSET_S {
        let now = UtcSeconds(moment);
        moment += MINUTE_S;
        let local = local_time(&calendar.time_zone, now);
        let Some(tally) = local.day.checked_sub(first).and_then(|day| tallies.get_mut(day as usize)) else {
            continue;
        };
        tally.pass_minute(level_at(calendar, now), lamp, budget_j_m2);
    }
    let days: Vec<Day> = (first..last).zip(&tallies).map(|(day, tally)| tally.day(day)).collect();
    let dose_j_m2 = days.iter().map(|day| day.dose_j_m2).sum();
    let life_j_m2 = limits.life_dose.0 as f64 / 1e6;
    Year {
        year,
        open_h: days.iter().map(|day| day.open_h).sum(),
        open_days: days.iter().filter(|day| day.open_h > 0.0).count(),
        dose_j_m2,
        full_level_h_a_day: budget_j_m2 / lamp / 3600.0,
        life_years: (dose_j_m2 > 0.0).then(|| life_j_m2 / dose_j_m2),
        days,
    }
}

/// A moment of a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Local time, in hours after midnight.
    pub hour: f64,
    /// The part of the light that the schedule gives, 0..=1.
    pub level: f64,
    /// The most dose of one lamp since midnight, with somebody there all the time.
    pub dose_j_m2: f64,
}

/// Goes through one local day, minute by minute, as [`year`] does. A minute that the clock shows twice comes twice.
pub fn day_course(calendar: &Calendar, limits: &Limits, full_level: Irradiance, date: Date) -> Vec<Moment> {
    let day = day_of(date);
    let lamp = lamp_w_m2(full_level, limits);
    let budget_j_m2 = limits.daily_dose.0 as f64 / 1e6;
    let mut tally = Tally::default();
    let mut moments = Vec::new();
    let midnight = i64::from(day) * DAY_S;
    for moment in (midnight - MOST_OFFSET_S..midnight + DAY_S + MOST_OFFSET_S).step_by(MINUTE_S as usize) {
        let now = UtcSeconds(moment);
        let local = local_time(&calendar.time_zone, now);
        if local.day != day {
            continue;
        }
        let level = level_at(calendar, now);
        let hour = f64::from(local.minute) / 60.0;
        moments.push(Moment {
            hour,
            level: f64::from(level.0) / f64::from(Level::FULL.0),
            dose_j_m2: tally.dose_j_m2,
        });
        tally.pass_minute(level, lamp, budget_j_m2);
    }
    moments
}

/// What a lamp gives at full level, the plan's ceiling considered.
fn lamp_w_m2(full_level: Irradiance, limits: &Limits) -> f64 {
    f64::from(full_level.0.min(limits.ceiling.0)) / 1000.0
}

/// What has come together of one day.
#[derive(Clone, Debug, Default)]
struct Tally {
    minutes: u32,
    dose_j_m2: f64,
}

impl Tally {
    /// Until the budget is used up the lamp gives what the schedule wants, then no more than the idle glow.
    fn pass_minute(&mut self, level: Level, lamp_w_m2: f64, budget_j_m2: f64) {
        if level == Level::OFF {
            return;
        }
        self.minutes += 1;
        let wanted = lamp_w_m2 * f64::from(level.0) / f64::from(Level::FULL.0);
        let idle = wanted.min(f64::from(IDLE_FLOOR.0) / 1000.0);
        let given = if self.dose_j_m2 < budget_j_m2 { wanted } else { idle };
        self.dose_j_m2 += given * MINUTE_S as f64;
    }

    fn day(&self, day: u32) -> Day {
        let date = date_of(day);
        Day {
            month: date.month,
            day: date.day,
            open_h: f64::from(self.minutes) / 60.0,
            dose_j_m2: self.dose_j_m2,
        }
    }
}

impl Year {
    /// The year as a calendar to read: a line a month, a character a day.
    pub fn calendar_lines(&self) -> Vec<String> {
        const MONTHS: [&str; 12] =
            ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
        let mut lines = vec![format!("{:<9} 1        11        21        31", self.year)];
        for (month, name) in (1..).zip(MONTHS) {
            let days: Vec<&Day> = self.days.iter().filter(|day| day.month == month).collect();
            let marks: String = days.iter().map(|day| if day.open_h > 0.0 { '#' } else { '.' }).collect();
            let hours: f64 = days.iter().map(|day| day.open_h).sum();
            lines.push(format!("{name:<9} {marks:<31} {hours:>7.1} h"));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vitrine_exhibit::plan::calendar::{ClosedDays, MinuteOfDay, ScheduleRule, TimeZone, Weekdays};
    use vitrine_exhibit::units::Dose;

    fn weekends(zone: &str) -> Calendar {
        let rule = ScheduleRule {
            days: Weekdays(0b110_0000),
            from: MinuteOfDay(600),
            to: MinuteOfDay(1080),
            first: None,
            last: None,
            level: Level::FULL,
        };
        let mut calendar =
            Calendar { time_zone: crate::config::time_zone(zone).unwrap(), ..Calendar::default() };
        calendar.rules.push(rule).unwrap();
        calendar
    }

    #[test]
    fn hours_are_those_of_the_clock_on_the_wall() {
        // 2026 has 52 Saturdays and 52 Sundays.
        for zone in ["UTC", "Europe/Berlin", "Pacific/Auckland", "America/Los_Angeles"] {
            let year = year(&weekends(zone), &Limits::default(), Irradiance(10_000), 2026);
            assert_eq!((year.open_days, year.open_h, year.days.len()), (104, 832.0, 365), "{zone}");
        }
    }

    #[test]
    fn an_hour_is_missing_in_spring_and_doubled_in_autumn() {
        let mut calendar = weekends("Europe/Berlin");
        calendar.rules[0].from = MinuteOfDay(0);
        calendar.rules[0].to = MinuteOfDay(1440);
        let year = year(&calendar, &Limits::default(), Irradiance(10_000), 2026);
        let hours = |month, day| year.days.iter().find(|d| (d.month, d.day) == (month, day)).unwrap().open_h;
        assert_eq!((hours(3, 29), hours(10, 25), hours(3, 28)), (23.0, 25.0, 24.0));
    }

    #[test]
    fn closed_days_are_dark() {
        let mut calendar = Calendar { time_zone: TimeZone::default(), ..Calendar::default() };
        let date = |day| Date { year: 2026, month: 12, day };
        calendar.closed.push(ClosedDays { first: date(24), last: date(26) }).unwrap();
        let year = year(&calendar, &Limits::default(), Irradiance(10_000), 2026);
        assert_eq!((year.open_days, year.open_h), (362, 362.0 * 24.0));
        assert!(year.calendar_lines()[12].contains("#######################...#####"));
    }

    #[test]
    fn the_course_of_a_day_ends_at_the_years_dose_of_it() {
        let calendar = weekends("Europe/Berlin");
        let (limits, full) = (Limits::default(), Irradiance(10_000));
        let whole = year(&calendar, &limits, full, 2026);
        for (month, day, minutes) in [(3, 28, 1440), (3, 29, 1380), (10, 25, 1500)] {
            let course = day_course(&calendar, &limits, full, Date { year: 2026, month, day });
            assert_eq!(course.len(), minutes);
            let lit = course.iter().filter(|moment| moment.level == 1.0);
            assert!(lit.clone().all(|moment| (10.0..18.0).contains(&moment.hour)));
            let of_year = whole.days.iter().find(|d| (d.month, d.day) == (month, day)).unwrap();
            assert_eq!(lit.count() as f64 / 60.0, of_year.open_h);
            assert_eq!(course.last().unwrap().dose_j_m2, of_year.dose_j_m2);
        }
    }

    #[test]
    fn the_dose_of_a_day_is_its_budget_and_then_the_idle_glow() {
        let limits = Limits { daily_dose: Dose(6_000_000_000), ..Limits::default() };
        let year = year(&weekends("UTC"), &limits, Irradiance(10_000), 2026);
        let saturday = year.days.iter().find(|day| day.open_h > 0.0).unwrap();
        // 10 minutes of 10 W/m2, then 470 minutes of 1 W/m2.
        assert_eq!(saturday.dose_j_m2, 6_000.0 + 470.0 * 60.0);
        assert!((year.full_level_h_a_day - 1.0 / 6.0).abs() < 1e-9);
        assert!((year.life_years.unwrap() - 1e7 / (104.0 * 34_200.0)).abs() < 1e-9);
    }
}
