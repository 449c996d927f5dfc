//! Refuses what is right key by key, and cannot be kept together: rules that never light anything, rules between which
//! nobody could choose, hours that the dose does not last for, rests that outlast the day, views that are never shown.
//!
//! A schedule repeats from week to week between the dates that its rules and closed days name, and within a day
//! nothing changes but where a rule begins or ends. So a few days behind each such date, at each such minute, show all
//! that can happen; at these moments the rules are asked as the controller asks them.

mod doses;
mod sights;

use std::ops::Range;

use toml::de::{DeTable, DeValue};
use vitrine_exhibit::plan::calendar::{Calendar, Date, ScheduleRule};
use vitrine_exhibit::schedule::{LocalTime, date_of, day_of, holds, local_time, weekday_of};
use vitrine_exhibit::units::{Level, UtcSeconds};

use super::exhibit::Exhibit;
use super::problem::{Problem, Problems};

/// A week, and a day before it whose rules may run over midnight.
const PERIOD_DAYS: u32 = 8;
/// Where no rule names a date any week will do; this one has no change of clocks anywhere.
const SOME_DAY: Date = Date { year: 2026, month: 6, day: 1 };

/// Notes every contradiction of an `exhibit` whose keys are all right by themselves; `root` is the file.
pub(super) fn find(exhibit: &Exhibit, root: &DeTable<'_>, problems: &mut Problems) {
    let places = Places { root };
    let Ok(calendar) = exhibit.plan_calendar() else { return };
    let moments = moments(&calendar);
    find_in_schedule(&calendar, &moments, &places, problems);
    find_in_closed_days(exhibit, &places, problems);
    doses::find(exhibit, &calendar, &moments, &places, problems);
    sights::find(exhibit, &places, problems);
    find_inks_balanced_twice(exhibit, &places, problems);
    if exhibit.object.is_some() && exhibit.design.adapt {
        let message =
            "`adapt` changes pictures so that they agree with each other, and knows nothing of the object";
        let help = "leave `adapt` out where there is an [object]";
        problems.push(contradiction(places.key("design", "adapt"), message.to_owned(), help));
    }
}

/// A design that gives weak inks more, and sheets that give strong ones less, make the weak ones too bright.
fn find_inks_balanced_twice(exhibit: &Exhibit, places: &Places<'_>, problems: &mut Problems) {
    let differ = |yields: [f64; 3]| yields.iter().any(|ink| *ink != yields[0]);
    if differ(exhibit.stack.ink_yields) && differ(exhibit.print.ink.yields) {
        let message = "the inks are balanced twice: by `ink_yields` in the design, and by `yields` in [print] on the sheets";
        let help = "leave `ink_yields` out, or give `yields = [1.0, 1.0, 1.0]` in [print] for sheets with the design's own values";
        problems.push(contradiction(places.key("stack", "ink_yields"), message.to_owned(), help));
    }
}

/// Where things stand in the file.
struct Places<'a> {
    root: &'a DeTable<'a>,
}

impl Places<'_> {
    /// The value of a key, or its table where it is left out.
    fn key(&self, table: &str, key: &str) -> Range<usize> {
        let Some(found) = self.root.get(table) else { return 0..0 };
        let value = found.get_ref().as_table().and_then(|table| table.get(key));
        value.map_or(found.span(), |value| value.span())
    }

    /// The table of this number among those of a name, or one of its values.
    fn entry(&self, list: &str, index: usize, key: Option<&str>) -> Range<usize> {
        let items = self.root.get(list).and_then(|list| list.get_ref().as_array());
        let Some(item) = items.and_then(|items| items.get(index)) else { return 0..0 };
        let value = key.and_then(|key| item.get_ref().as_table()?.get(key));
        value.map_or(item.span(), |value| value.span())
    }

    /// A date of `closed`.
    fn closed(&self, date: jiff::civil::Date) -> Range<usize> {
        let list = self.root.get("calendar").and_then(|table| table.get_ref().as_table()?.get("closed"));
        let items = list.and_then(|list| list.get_ref().as_array());
        let is_date = |value: &DeValue<'_>| match value {
            DeValue::String(text) => text.as_ref() == date.to_string(),
            DeValue::Datetime(datetime) => datetime.to_string() == date.to_string(),
            _ => false,
        };
        let item = items.and_then(|items| items.iter().find(|item| is_date(item.get_ref())));
        item.map_or_else(|| self.key("calendar", "closed"), |item| item.span())
    }
}

/// Minutes from a moment to the next one, or to the end of its day.
fn minutes_from(moments: &[LocalTime], at: usize) -> u32 {
    let now = moments[at];
    let next = moments.get(at + 1).filter(|next| next.day == now.day);
    u32::from(next.map_or(1_440, |next| next.minute) - now.minute)
}

fn contradiction(span: Range<usize>, message: String, help: impl Into<String>) -> Problem {
    Problem::new("vitrine::config::contradiction", span, message, "here", help)
}

/// The moments that show all that can happen, in their order. Nothing changes between one and the next of its day.
fn moments(calendar: &Calendar) -> Vec<LocalTime> {
    let day_after = |date: Date| day_of(date) + 1;
    let rules = calendar.rules.iter().flat_map(|rule| [rule.first.map(day_of), rule.last.map(day_after)]);
    let closed = calendar.closed.iter().flat_map(|span| [day_of(span.first), day_after(span.last)]);
    let mut dates: Vec<u32> = rules.flatten().chain(closed).collect();
    let earliest = dates.iter().min().copied().unwrap_or(day_of(SOME_DAY));
    dates.push(earliest.saturating_sub(PERIOD_DAYS));
    let mut days: Vec<u32> = dates.into_iter().flat_map(|date| date..=date + PERIOD_DAYS).collect();
    days.sort_unstable();
    days.dedup();
    let mut minutes: Vec<u16> =
        calendar.rules.iter().flat_map(|rule| [rule.from.0, rule.to.0 % 1440]).collect();
    minutes.push(0);
    minutes.sort_unstable();
    minutes.dedup();
    let at = |day: u32, minute: u16| LocalTime {
        day,
        date: date_of(day),
        weekday: weekday_of(day),
        minute,
        daylight: false,
    };
    days.iter().flat_map(|&day| minutes.iter().map(move |&minute| at(day, minute))).collect()
}

/// What is known of a rule over all moments.
struct Reach {
    /// It holds, whatever later rules say.
    holds: Vec<bool>,
    /// It decides.
    decides: Vec<bool>,
}

fn reaches(calendar: &Calendar, moments: &[LocalTime]) -> Vec<Reach> {
    let mut later = vec![false; moments.len()];
    let mut found: Vec<Reach> = calendar
        .rules
        .iter()
        .rev()
        .map(|rule| {
            let holds: Vec<bool> = moments.iter().map(|&now| holds(calendar, rule, now)).collect();
            let decides = holds.iter().zip(&later).map(|(holds, later)| *holds && !later).collect();
            later.iter_mut().zip(&holds).for_each(|(later, holds)| *later |= holds);
            Reach { holds, decides }
        })
        .collect();
    found.reverse();
    found
}

fn find_in_schedule(
    calendar: &Calendar,
    moments: &[LocalTime],
    places: &Places<'_>,
    problems: &mut Problems,
) {
    let reaches = reaches(calendar, moments);
    let level = |at: usize| {
        let deciding = calendar.rules.iter().zip(&reaches).find(|(_, reach)| reach.decides[at]);
        deciding.map_or(Level::OFF, |(rule, _)| rule.level)
    };
    if !calendar.rules.is_empty() && (0..moments.len()).all(|at| level(at) == Level::OFF) {
        let message = "the schedule never lights the exhibit".to_owned();
        let help = "give one rule at least a `level` above 0, and days on which it is open";
        problems.push(contradiction(places.entry("schedule", 0, None), message, help));
        return;
    }
    for (index, (rule, reach)) in calendar.rules.iter().zip(&reaches).enumerate() {
        let earlier = calendar.rules.iter().zip(&reaches).take(index);
        let problem = never_holds(reach)
            .or_else(|| never_decides(reach))
            .or_else(|| never_on_the_clock(calendar, reach, moments))
            .or_else(|| darkens_nothing(rule, reach, earlier.clone()));
        if let Some((message, help)) = problem {
            problems.push(contradiction(places.entry("schedule", index, None), message, help));
        } else if let Some(other) = earlier.clone().position(|other| is_ambiguous(other, (rule, reach))) {
            let message = format!(
                "rules {} and {} overlap with different levels, and neither is an exception of the other",
                other + 1,
                index + 1
            );
            let help = "let one begin where the other ends, or let the later one name fewer days or dates";
            problems.push(contradiction(places.entry("schedule", index, None), message, help));
        }
    }
}

type Found = Option<(String, &'static str)>;

fn never_holds(reach: &Reach) -> Found {
    let message = || "the rule never begins: all its days are closed".to_owned();
    (!reach.holds.contains(&true)).then(|| (message(), "take the rule out, or days out of `closed`"))
}

fn never_decides(reach: &Reach) -> Found {
    let message = || "the rule never decides: whenever it holds, a later rule does too".to_owned();
    let help = "the last rule that holds decides: put exceptions behind what they are exceptions of";
    (!reach.decides.contains(&true)).then(|| (message(), help))
}

/// All that a rule decides falls into the hour that is left out in spring.
fn never_on_the_clock(calendar: &Calendar, reach: &Reach, moments: &[LocalTime]) -> Found {
    let zone = &calendar.time_zone;
    let offsets = [Some(zone.offset_minutes), zone.daylight.map(|rule| rule.offset_minutes)];
    let comes = |now: LocalTime| {
        offsets.into_iter().flatten().any(|offset| {
            let local_s = i64::from(now.day) * 86_400 + i64::from(now.minute) * 60;
            let found = local_time(zone, UtcSeconds(local_s - i64::from(offset) * 60));
            (found.day, found.minute) == (now.day, now.minute)
        })
    };
    let some_of_it_comes = |at: usize| {
        let begins = moments[at];
        let minutes = begins.minute..begins.minute + minutes_from(moments, at) as u16;
        minutes.into_iter().any(|minute| comes(LocalTime { minute, ..begins }))
    };
    let mut decides = (0..moments.len()).filter(|at| reach.decides[*at]);
    let message = || "the rule falls into the hour that is left out when the clocks go forward".to_owned();
    (!decides.any(some_of_it_comes))
        .then(|| (message(), "begin it earlier, end it later, or take another day"))
}

fn darkens_nothing<'a>(
    rule: &ScheduleRule,
    reach: &Reach,
    earlier: impl Iterator<Item = (&'a ScheduleRule, &'a Reach)>,
) -> Found {
    if rule.level != Level::OFF {
        return None;
    }
    let mut lit = vec![false; reach.holds.len()];
    for (_, of_other) in earlier.filter(|(other, _)| other.level != Level::OFF) {
        lit.iter_mut().zip(&of_other.holds).for_each(|(lit, holds)| *lit |= holds);
    }
    let darkens = reach.decides.iter().zip(&lit).any(|(decides, lit)| *decides && *lit);
    let message = || "the rule has level 0 and no earlier rule lights anything then".to_owned();
    (!darkens)
        .then(|| (message(), "where no rule holds it is dark anyway: take this one out, or give it a level"))
}

/// Whether two rules of different levels hold at one moment although none of them reads as an exception: a rule of
/// fewer days, of narrower dates, or within the other's times.
fn is_ambiguous(earlier: (&ScheduleRule, &Reach), later: (&ScheduleRule, &Reach)) -> bool {
    let ((first, of_first), (second, of_second)) = (earlier, later);
    let together = || of_first.holds.iter().zip(&of_second.holds);
    let within =
        |inner: &[bool], outer: &[bool]| inner.iter().zip(outer).all(|(inner, outer)| !inner || *outer);
    let fewer_days = second.days != first.days && second.days.0 & !first.days.0 == 0;
    let bounded = |rule: &ScheduleRule| usize::from(rule.first.is_some()) + usize::from(rule.last.is_some());
    let narrower = bounded(second) > bounded(first)
        || second.first.zip(first.first).is_some_and(|(second, first)| second > first)
            && second.last.zip(first.last).is_some_and(|(second, first)| second <= first)
        || second.last.zip(first.last).is_some_and(|(second, first)| second < first)
            && second.first.zip(first.first).is_some_and(|(second, first)| second >= first);
    first.level != second.level
        && of_first.decides.contains(&true)
        && together().any(|(first, second)| *first && *second)
        && !(fewer_days || narrower || within(&of_second.holds, &of_first.holds))
}

fn find_in_closed_days(exhibit: &Exhibit, places: &Places<'_>, problems: &mut Problems) {
    if exhibit.schedule.is_empty() {
        return;
    }
    let covers = |day: jiff::civil::Date| {
        exhibit.schedule.iter().any(|rule| {
            rule.first.is_none_or(|first| first <= day) && rule.last.is_none_or(|last| day <= last)
        })
    };
    for &day in exhibit.calendar.closed.iter().filter(|day| !covers(**day)) {
        let message = format!("{day} is closed, but no rule lights the exhibit on a date around it");
        let help = "is its year right? Days outside the rules' `first` and `last` are dark anyway";
        problems.push(contradiction(places.closed(day), message, help));
    }
}

#[cfg(test)]
mod tests;
