//! The lamps over the viewer's angle, as the controller chooses them.

use std::collections::BTreeMap;

use maud::{Markup, html};
use vitrine_exhibit::chooser::smooth;
use vitrine_exhibit::plan::{Between, Emphasis, Plan, View};
use vitrine_exhibit::units::{Level, Milliseconds};
use vitrine_exhibit::viewer::{Bearing, Selector};

use super::chart::{Axis, Chart, Line, legend};

/// How far to the sides viewers are followed, in hundredths of a degree.
const FARTHEST: i16 = 6_000;
const STEP: i16 = 50;

/// The emphasis over the angle: a plot for each height at which views lie.
pub(super) fn section(plan: &Plan) -> Markup {
    let mut heights: Vec<i16> = plan.views.iter().map(|view| view.vertical.0).collect();
    heights.sort_unstable();
    heights.dedup();
    html! {
        section aria-labelledby="emphasis" {
            h2 id="emphasis" { "Emphasis over the angle" }
            p {
                "The lamp levels that the controller gives a single viewer who walks past, by its own rules: the thin lines "
                "are those of a walk to the left, which differ where a view is kept until another is clearly nearer. Of views "
                "in one direction, which are turned like pages, it has the first."
            }
            @for height in heights { (plot(plan, height)) }
            (legend(&[("top", "Top lamp"), ("bottom", "Bottom lamp")]))
        }
    }
}

fn plot(plan: &Plan, height: i16) -> Markup {
    let to_the_right: Vec<i16> = (-FARTHEST..=FARTHEST).step_by(STEP.unsigned_abs().into()).collect();
    let to_the_left: Vec<i16> = to_the_right.iter().rev().copied().collect();
    let mut lines = Vec::new();
    for (walk, [top, bottom]) in
        [(&to_the_left, ["top back", "bottom back"]), (&to_the_right, ["top", "bottom"])]
    {
        let pairs = levels(plan, height, walk);
        lines.push(Line { class: top, points: stairs(walk, &pairs, |pair| pair.top) });
        lines.push(Line { class: bottom, points: stairs(walk, &pairs, |pair| pair.bottom) });
    }
    let degrees = f64::from(height) / 100.0;
    let names = notes(plan, height, |_, id| id.to_owned());
    let description = format!("Lamp levels over the viewer's horizontal angle, at {degrees}° vertical");
    let marks = [-60, -30, 0, 30, 60].map(|angle| (f64::from(angle), format!("{angle}°")));
    let chart = Chart {
        description: &description,
        x: Axis { title: "Viewer's angle to the right", from: -60.0, to: 60.0, marks: marks.to_vec() },
        y: Axis::percent(""),
    };
    let numbers = (!chart.has_room_for(&names)).then(|| notes(plan, height, |number, _| number.to_string()));
    html! {
        figure {
            (chart.draw(&lines, numbers.as_ref().unwrap_or(&names)))
            @if numbers.is_some() { figcaption { (key(plan, height)) } }
            @if degrees != 0.0 { figcaption { "Viewer at " (degrees) "° vertical" } }
        }
    }
}

/// Views at this height by their numbers, from 1.
fn views_at(plan: &Plan, height: i16) -> impl Iterator<Item = (usize, &View)> {
    (1..).zip(&plan.views).filter(move |(_, view)| view.vertical.0 == height)
}

/// What stands above each direction in which views lie, in degrees from left to right.
fn notes(plan: &Plan, height: i16, word: impl Fn(usize, &str) -> String) -> Vec<(f64, String)> {
    let mut words: BTreeMap<i16, Vec<String>> = BTreeMap::new();
    for (number, view) in views_at(plan, height) {
        words.entry(view.horizontal.0).or_default().push(word(number, &view.id));
    }
    words.into_iter().map(|(angle, words)| (f64::from(angle) / 100.0, words.join(", "))).collect()
}

/// Which number is which view.
fn key(plan: &Plan, height: i16) -> String {
    let views = views_at(plan, height).map(|(number, view)| format!("{number} {}", view.id));
    views.collect::<Vec<_>>().join(", ")
}

/// The pairs at the angles of a walk, each of which lasts long enough for a choice.
fn levels(plan: &Plan, height: i16, walk: &[i16]) -> Vec<Emphasis> {
    let mut selector = Selector::new();
    let long = Milliseconds(plan.viewer.dwell.0.saturating_add(1));
    walk.iter()
        .map(|&angle| {
            let bearing = Bearing::new(angle, height);
            if plan.viewer.between == Between::Smooth {
                return smooth(plan, bearing);
            }
            selector.choose(plan, bearing, long);
            let view = selector.choose(plan, bearing, long);
            view.and_then(|view| plan.views.get(usize::from(view))).map_or(plan.neutral, |view| view.emphasis)
        })
        .collect()
}

/// Points of the line, those within a straight piece left out.
fn stairs(walk: &[i16], pairs: &[Emphasis], lamp: impl Fn(&Emphasis) -> Level) -> Vec<(f64, f64)> {
    let percent = |pair: &Emphasis| 100.0 * f64::from(lamp(pair).0) / f64::from(Level::FULL.0);
    let all: Vec<(f64, f64)> =
        walk.iter().zip(pairs).map(|(&angle, pair)| (f64::from(angle) / 100.0, percent(pair))).collect();
    let last = all.len().saturating_sub(1);
    let turns = |index: usize| {
        index == 0 || index == last || all[index - 1].1 != all[index].1 || all[index + 1].1 != all[index].1
    };
    (0..all.len()).filter(|&index| turns(index)).map(|index| all[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vitrine_exhibit::units::PerLamp;

    #[test]
    fn a_walk_goes_through_the_views_pairs_and_keeps_each_until_the_next_is_clearly_nearer() {
        let plan = super::super::tests::plan_of_three();
        let walk: Vec<i16> = (-6_000..=6_000).step_by(50).collect();
        let pairs = levels(&plan, 0, &walk);
        let at = |degrees: i16| pairs[usize::try_from((degrees * 100 + 6_000) / 50).unwrap()];
        assert_eq!([at(-40), at(0), at(40)], [0, 1, 2].map(|view| plan.views[view].emphasis));
        // The boundary lies at 15 degrees; the view is kept for half the hysteresis more.
        assert_eq!([at(16), at(19)], [plan.views[1].emphasis, plan.views[2].emphasis]);
    }

    #[test]
    fn names_do_not_lie_upon_each_other() {
        let mut plan = super::super::tests::plan_of_three();
        assert!(!plot(&plan, 0).into_string().contains("figcaption"));
        plan.views[1].horizontal = plan.views[0].horizontal;
        let paging = plot(&plan, 0).into_string();
        assert!(paging.contains(">left, middle</text>"), "{paging}");
        plan.views[1].horizontal.0 += 300;
        let crowded = plot(&plan, 0).into_string();
        assert!(crowded.contains(">2</text>") && crowded.contains("1 left, 2 middle, 3 right"), "{crowded}");
    }

    #[test]
    fn only_the_corners_of_a_line_are_drawn() {
        let level = |level: u16| PerLamp::new(Level(level), Level::OFF);
        let pairs = [level(0), level(0), level(0), level(u16::MAX), level(u16::MAX)];
        let points = stairs(&[-200, -100, 0, 100, 200], &pairs, |pair| pair.top);
        assert_eq!(points, [(-2.0, 0.0), (0.0, 0.0), (1.0, 100.0), (2.0, 100.0)]);
    }
}
