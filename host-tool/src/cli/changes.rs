//! What changes from one plan to another, in words.

use vitrine_exhibit::plan::{Emphasis, Limits, Plan, View};
use vitrine_exhibit::units::{CentiDegrees, Level};

/// What changes from the plan `before` to the plan `after`, a line for each.
pub(super) fn changes(before: Option<&Plan>, after: &Plan) -> Vec<String> {
    let Some(before) = before else {
        return vec![format!("\"{}\" is the controller's first plan", after.name)];
    };
    if before == after {
        return vec![format!("\"{}\" is the same as the controller's plan", after.name)];
    }
    let mut lines = Vec::new();
    if before.name != after.name {
        lines.push(format!("name \"{}\" becomes \"{}\"", before.name, after.name));
    }
    if before.volume.blake3 != after.volume.blake3 {
        lines.push("it belongs to other films".to_owned());
    }
    lines.extend(view_changes(&before.views, &after.views));
    lines.extend(becomes("neutral pair", before.neutral, after.neutral, pair));
    lines.extend(limit_changes(&before.limits, &after.limits));
    for (what, differs) in [
        ("pairs for two viewers", before.shared != after.shared),
        ("lamps' calibration", before.lamps != after.lamps),
        ("viewer settings", before.viewer != after.viewer || before.presence != after.presence),
        ("schedule and calendar", before.calendar != after.calendar),
    ] {
        if differs {
            lines.push(format!("{what} change"));
        }
    }
    lines
}

fn view_changes(before: &[View], after: &[View]) -> Vec<String> {
    let missing = |from: &[View], of: &[View]| -> Vec<String> {
        let is_missing = |view: &&View| !from.iter().any(|other| other.id == view.id);
        of.iter().filter(is_missing).map(|view| view.id.to_string()).collect()
    };
    let mut lines = Vec::new();
    for (what, ids) in [("added", missing(before, after)), ("removed", missing(after, before))] {
        if !ids.is_empty() {
            lines.push(format!("views {what}: {}", ids.join(", ")));
        }
    }
    let kept = after.iter().filter_map(|view| Some((before.iter().find(|old| old.id == view.id)?, view)));
    for (old, new) in kept.clone() {
        let place = |view: &View| (view.horizontal, view.vertical);
        lines.extend(becomes(&format!("direction of {}", new.id), place(old), place(new), direction));
        lines.extend(becomes(&format!("lamps of {}", new.id), old.emphasis, new.emphasis, pair));
    }
    let order = |views: &[View]| views.iter().map(|view| view.id.clone()).collect::<Vec<_>>();
    if lines.is_empty() && order(before) != order(after) {
        lines.push("the views' order changes".to_owned());
    }
    lines
}

fn limit_changes(before: &Limits, after: &Limits) -> Vec<String> {
    let dose = |limits: &Limits| [limits.daily_dose, limits.life_dose].map(|dose| dose.0 as f64 / 1e9);
    let ([day, life], [new_day, new_life]) = (dose(before), dose(after));
    let kilojoules = |dose: f64| format!("{dose:.1} kJ/m2");
    let seconds = |milliseconds: u32| format!("{} s", f64::from(milliseconds) / 1e3);
    let watts = |milliwatts: u32| format!("{:.2} W/m2", f64::from(milliwatts) / 1e3);
    [
        becomes("ceiling", before.ceiling.0, after.ceiling.0, watts),
        becomes("daily dose", day, new_day, kilojoules),
        becomes("life's dose", life, new_life, kilojoules),
        becomes("longest time lit", before.continuous.0, after.continuous.0, seconds),
        becomes("rest", before.rest.0, after.rest.0, seconds),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn becomes<T: PartialEq>(what: &str, old: T, new: T, text: impl Fn(T) -> String) -> Option<String> {
    (old != new).then(|| format!("{what}: {} becomes {}", text(old), text(new)))
}

fn direction((horizontal, vertical): (CentiDegrees, CentiDegrees)) -> String {
    let degrees = |angle: CentiDegrees| f64::from(angle.0) / 100.0;
    format!("{:.1}, {:.1} deg", degrees(horizontal), degrees(vertical))
}

fn pair(emphasis: Emphasis) -> String {
    let percent = |level: &Level| 100.0 * f64::from(level.0) / f64::from(Level::FULL.0);
    use vitrine_exhibit::units::Lamp::{Bottom, Top};
    format!("top {:.0} %, bottom {:.0} %", percent(emphasis.get(Top)), percent(emphasis.get(Bottom)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vitrine_exhibit::testing;
    use vitrine_exhibit::units::Dose;

    #[test]
    fn each_change_is_told_with_what_was_and_what_will_be() {
        let before = testing::plan();
        assert!(changes(None, &before)[0].contains("first plan"));
        assert!(changes(Some(&before), &before)[0].contains("the same"));
        let mut after = before.clone();
        let view = &mut after.views[0];
        let (id, degrees) = (view.id.clone(), f64::from(view.horizontal.0) / 100.0);
        view.horizontal.0 += 200;
        after.limits.daily_dose = Dose(20_000_000_000_000);
        let told = changes(Some(&before), &after);
        let moved = format!("direction of {id}: {degrees:.1}, 0.0 deg becomes {:.1}, 0.0 deg", degrees + 2.0);
        assert!(told.contains(&moved), "{told:?}");
        assert!(told.iter().any(|line| line.ends_with("becomes 20000.0 kJ/m2")), "{told:?}");
        assert_eq!(told.len(), 2, "{told:?}");
        after.views.swap_remove(0);
        assert!(changes(Some(&before), &after).contains(&format!("views removed: {id}")));
    }
}
