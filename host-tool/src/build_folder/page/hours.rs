//! When the exhibit is lit, and what that costs the films: a day, the week, the year, against the budgets.

use maud::{Markup, html};
use vitrine_exhibit::plan::Plan;
use vitrine_exhibit::plan::calendar::Date;
use vitrine_exhibit::schedule::{day_of, weekday_of};

use super::chart::{Axis, Chart, Line, legend};
use super::tables::table;
use crate::config::Exhibit;
use crate::year::{Day, Moment, Year, day_course, year};

/// The year that is shown where the calendar names no date: then all are alike but for their weekdays.
const ANY_YEAR: u16 = 2026;
const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
const WEEKDAYS: [&str; 7] = ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"];

/// The hours of the exhibit, and its doses against their budgets.
pub(super) fn section(exhibit: &Exhibit, plan: &Plan) -> Markup {
    let calendar = &plan.calendar;
    let number = named_year(plan).unwrap_or(ANY_YEAR);
    let whole = year(calendar, &plan.limits, exhibit.full_level(), number);
    let fullest = whole.days.iter().rev().max_by(|a, b| a.dose_j_m2.total_cmp(&b.dose_j_m2));
    let zone = &exhibit.calendar.time_zone;
    html! {
        section aria-labelledby="hours" {
            h2 id="hours" { "Hours and dose" }
            @if calendar.rules.is_empty() {
                p { "There is no schedule: the exhibit is lit at any time." }
            } @else {
                p { (format!("Lit {:.0} h on {} days of {number}, in local time of {zone}.", whole.open_h, whole.open_days)) }
            }
            p { (budget_in_words(exhibit, &whole)) }
            @if let Some(day) = fullest.filter(|day| day.open_h > 0.0) { (day_plot(exhibit, plan, number, day)) }
            (year_plot(&whole, exhibit.limits.daily_dose_j_m2))
            (months_table(&whole, exhibit.limits.daily_dose_j_m2))
        }
    }
}

/// The first year of which the calendar names a date.
fn named_year(plan: &Plan) -> Option<u16> {
    let rules = plan.calendar.rules.iter().filter_map(|rule| rule.first.or(rule.last));
    let closed = plan.calendar.closed.iter().map(|span| span.first);
    rules.chain(closed).map(|date| date.year).min()
}

fn budget_in_words(exhibit: &Exhibit, year: &Year) -> String {
    let limits = &exhibit.limits;
    format!(
        "A lamp at full level uses up the day's {:.1} kJ/m2 in {:.0} minutes, and the idle glow is left for the rest of \
         it; {}.",
        limits.daily_dose_j_m2 / 1000.0,
        60.0 * year.full_level_h_a_day,
        exhibit.life_in_words(year)
    )
}

/// The day with the most dose: its schedule, and the dose against the day's budget.
fn day_plot(exhibit: &Exhibit, plan: &Plan, year: u16, day: &Day) -> Markup {
    let date = Date { year, month: day.month, day: day.day };
    let course = day_course(&plan.calendar, &plan.limits, exhibit.full_level(), date);
    let budget = exhibit.limits.daily_dose_j_m2;
    let most = day.dose_j_m2.max(budget);
    let line = |class, value: &dyn Fn(&Moment) -> f64| Line {
        class,
        points: corners(course.iter().map(|moment| (moment.hour, value(moment))).collect()),
    };
    let budget_line =
        Line { class: "budget", points: vec![(0.0, 100.0 * budget / most), (24.0, 100.0 * budget / most)] };
    let lines = [
        line("top", &|moment| 100.0 * moment.level),
        line("dose", &|moment| 100.0 * moment.dose_j_m2 / most),
        budget_line,
    ];
    let weekday = WEEKDAYS[usize::from(weekday_of(day_of(date))) % WEEKDAYS.len()];
    let name = format!("{weekday}, {} {} {year}", day.day, MONTHS[usize::from(day.month - 1) % MONTHS.len()]);
    let marks = (0..=8).map(|index| (f64::from(3 * index), format!("{}:00", 3 * index)));
    let description = format!("Level of the schedule and dose over the hours of {name}");
    let chart = Chart {
        description: &description,
        x: Axis { title: "Local time", from: 0.0, to: 24.0, marks: marks.collect() },
        y: Axis::percent(""),
    };
    html! {
        figure {
            (chart.draw(&lines, &[]))
            figcaption {
                (name) ", the day with the most dose: at most " (kilojoules(day.dose_j_m2)) " kJ/m2 of a lamp, for "
                (kilojoules(budget)) " kJ/m2 of the day's budget. Doses in percent of " (kilojoules(most)) " kJ/m2."
            }
            (legend(&[("top", "Schedule's level"), ("dose", "Dose since midnight"), ("budget", "Day's budget")]))
        }
    }
}

/// The dose of each day of the year against the day's budget.
fn year_plot(year: &Year, budget_j_m2: f64) -> Markup {
    let most = year.days.iter().map(|day| day.dose_j_m2).fold(budget_j_m2, f64::max);
    let days = year.days.len() as f64;
    let mut points = Vec::with_capacity(2 * year.days.len());
    for (index, day) in year.days.iter().enumerate() {
        let percent = 100.0 * day.dose_j_m2 / most;
        points.extend([(index as f64, percent), (index as f64 + 1.0, percent)]);
    }
    let budget = vec![(0.0, 100.0 * budget_j_m2 / most), (days, 100.0 * budget_j_m2 / most)];
    let lines = [Line { class: "dose", points: corners(points) }, Line { class: "budget", points: budget }];
    let firsts = year.days.iter().enumerate().filter(|(_, day)| day.day == 1);
    let marks = firsts
        .map(|(index, day)| (index as f64, MONTHS[usize::from(day.month - 1) % MONTHS.len()].to_owned()));
    let description = format!("Most dose of a lamp on each day of {}", year.year);
    let chart = Chart {
        description: &description,
        x: Axis { title: "", from: 0.0, to: days, marks: marks.collect() },
        y: Axis::percent(""),
    };
    html! {
        figure {
            (chart.draw(&lines, &[]))
            figcaption { "The days of " (year.year) ", in percent of " (kilojoules(most)) " kJ/m2." }
            (legend(&[("dose", "Most dose of a lamp on each day"), ("budget", "Day's budget")]))
        }
    }
}

fn months_table(year: &Year, budget_j_m2: f64) -> Markup {
    let caption = format!("The months of {}", year.year);
    table(
        &caption,
        &["Month", "Days lit", "Hours", "Most dose of a lamp", "Days at the budget"],
        html! {
            @for (month, name) in (1..).zip(MONTHS) {
                @let days: Vec<&Day> = year.days.iter().filter(|day| day.month == month).collect();
                tr {
                    th scope="row" { (name) }
                    td { (days.iter().filter(|day| day.open_h > 0.0).count()) }
                    td { (format!("{:.0}", days.iter().map(|day| day.open_h).sum::<f64>())) }
                    td { (kilojoules(days.iter().map(|day| day.dose_j_m2).sum())) " kJ/m2" }
                    td { (days.iter().filter(|day| day.dose_j_m2 >= budget_j_m2).count()) }
                }
            }
        },
    )
}

fn kilojoules(joules: f64) -> String {
    format!("{:.1}", joules / 1000.0)
}

/// The points at which a line changes its direction, along which as many lie as one likes.
fn corners(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if let [.., a, b] = kept[..] {
            let cross = (b.0 - a.0) * (point.1 - a.1) - (point.0 - a.0) * (b.1 - a.1);
            if cross.abs() < 1e-6 && b.0 <= point.0 {
                kept.pop();
            }
        }
        kept.push(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_along_a_straight_piece_are_left_out() {
        let line = vec![(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 2.0), (4.0, 2.0), (4.0, 0.0)];
        assert_eq!(corners(line), [(0.0, 0.0), (2.0, 2.0), (4.0, 2.0), (4.0, 0.0)]);
    }
}
