//! Hours, levels, rests and doses that do not go together.

use vitrine_exhibit::duty::{PWM_FLOOR, counts};
use vitrine_exhibit::plan::calendar::{Calendar, ScheduleRule};
use vitrine_exhibit::plan::{BelowFloor, LampCalibration};
use vitrine_exhibit::schedule::{LocalTime, holds};
use vitrine_exhibit::units::Level;

use super::super::exhibit::Exhibit;
use super::super::problem::Problems;
use super::{Places, contradiction, minutes_from};

pub(super) fn find(
    exhibit: &Exhibit,
    calendar: &Calendar,
    moments: &[LocalTime],
    places: &Places<'_>,
    problems: &mut Problems,
) {
    find_in_levels(exhibit, calendar, places, problems);
    find_in_rests(exhibit, calendar, moments, places, problems);
    find_in_doses(exhibit, calendar, moments, places, problems);
}

/// Levels that the driver's floor cuts away altogether.
fn find_in_levels(exhibit: &Exhibit, calendar: &Calendar, places: &Places<'_>, problems: &mut Problems) {
    let lamp = exhibit.lamp_calibration(0);
    for (index, rule) in calendar.rules.iter().enumerate() {
        if exhibit.schedule[index].level > 0.0 && is_cut(&lamp, rule) {
            let message = format!(
                "the rule's level {} lies below the driver's floor of 1 % even where a view wants all the light",
                exhibit.schedule[index].level
            );
            let help = "give it more, 0 for dark, or set `below_floor = \"dither\"` in [lamps]";
            problems.push(contradiction(places.entry("schedule", index, Some("level")), message, help));
        }
    }
}

fn is_cut(lamp: &LampCalibration, rule: &ScheduleRule) -> bool {
    let counts = counts(lamp, rule.level);
    counts == 0 || (counts < PWM_FLOOR && lamp.below_floor == BelowFloor::Cut)
}

fn find_in_rests(
    exhibit: &Exhibit,
    calendar: &Calendar,
    moments: &[LocalTime],
    places: &Places<'_>,
    problems: &mut Problems,
) {
    let limits = &exhibit.limits;
    let shown = [("least_hold_s", exhibit.visitors.least_hold_s), ("fade_s", exhibit.visitors.fade_s)];
    for (key, seconds) in shown.into_iter().filter(|(_, seconds)| *seconds > limits.continuous_s) {
        let message = format!(
            "`{key}` is {seconds} s, longer than the {} s that the lamps may be lit at a stretch",
            limits.continuous_s
        );
        let help = format!("lower `{key}` in [visitors], or raise `continuous_s` in [limits]");
        problems.push(contradiction(places.key("visitors", key), message, help));
    }
    let longest_s = f64::from(longest_opening_min(calendar, moments)) * 60.0;
    if longest_s > 0.0 && limits.continuous_s < longest_s && limits.rest_s >= longest_s {
        let message = format!(
            "a rest of {} s lasts longer than the {longest_s} s for which the schedule lights the exhibit at most",
            limits.rest_s
        );
        let help = "after its first rest it would not light again before it closes: lower `rest_s`";
        problems.push(contradiction(places.key("limits", "rest_s"), message, help));
    }
}

fn find_in_doses(
    exhibit: &Exhibit,
    calendar: &Calendar,
    moments: &[LocalTime],
    places: &Places<'_>,
    problems: &mut Problems,
) {
    let limits = &exhibit.limits;
    let full_w_m2 = exhibit.lamps.irradiance_w_m2.min(exhibit.lamps.ceiling_w_m2);
    if full_w_m2 * limits.continuous_s > limits.daily_dose_j_m2 {
        let message = format!(
            "the day's {} J/m2 last for {:.0} s of full level, less than the {} s lit at a stretch",
            limits.daily_dose_j_m2,
            limits.daily_dose_j_m2 / full_w_m2,
            limits.continuous_s
        );
        let help = "lower `continuous_s`, or `ceiling_w_m2` in [lamps], or raise `daily_dose_j_m2`";
        problems.push(contradiction(places.key("limits", "continuous_s"), message, help));
    }
    let Some(expected_h) = exhibit.presence.expected_h_a_day else { return };
    let place = || places.key("presence", "expected_h_a_day");
    let open_h = most_open_min(calendar, moments).map(|minutes| f64::from(minutes) / 60.0);
    if let Some(open_h) = open_h.filter(|open_h| *open_h < expected_h) {
        let message =
            format!("somebody is expected for {expected_h} h a day, but it is open for {open_h} h at most");
        problems.push(contradiction(place(), message, "lower `expected_h_a_day`, or open longer"));
    }
    let needed_j_m2 = exhibit.expected_dose_j_m2();
    if needed_j_m2 > limits.daily_dose_j_m2 {
        let message = format!(
            "{expected_h} h with somebody there need {needed_j_m2:.0} J/m2 a day of a lamp at full level, more than \
             the {} J/m2 allowed",
            limits.daily_dose_j_m2
        );
        let lasts_h = expected_h * limits.daily_dose_j_m2 / needed_j_m2;
        let help = format!(
            "the dose lasts for {lasts_h:.2} h a day: lower `ceiling_w_m2` in [lamps] or the schedule's levels, or \
             expect less"
        );
        problems.push(contradiction(place(), message, help));
    }
}

fn is_lit(calendar: &Calendar, now: LocalTime) -> bool {
    let deciding = calendar.rules.iter().rev().find(|rule| holds(calendar, rule, now));
    deciding.is_some_and(|rule| rule.level != Level::OFF)
}

/// The longest stretch that the schedule lights without a break; 0 where there is no schedule.
fn longest_opening_min(calendar: &Calendar, moments: &[LocalTime]) -> u32 {
    let (mut longest, mut stretch, mut end) = (0, 0, 0);
    for (at, now) in moments.iter().enumerate() {
        let begins = now.day * 1_440 + u32::from(now.minute);
        let length = minutes_from(moments, at);
        stretch = if is_lit(calendar, *now) { length + if end == begins { stretch } else { 0 } } else { 0 };
        end = begins + length;
        longest = longest.max(stretch);
    }
    longest
}

/// The most minutes that the schedule lights in a day; none where there is no schedule.
fn most_open_min(calendar: &Calendar, moments: &[LocalTime]) -> Option<u32> {
    if calendar.rules.is_empty() {
        return None;
    }
    let mut of_days = std::collections::HashMap::new();
    for (at, now) in moments.iter().enumerate().filter(|(_, now)| is_lit(calendar, **now)) {
        *of_days.entry(now.day).or_insert(0) += minutes_from(moments, at);
    }
    of_days.into_values().max()
}
