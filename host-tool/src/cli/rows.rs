//! The state of an exhibit in plain words, row by row.

use vitrine_exhibit::Snapshot;
use vitrine_exhibit::events::Cut;
use vitrine_exhibit::units::{CentiCelsius, Dose, Lamp, PerLamp};
use vitrine_protocol::Status;

use super::clock::{source_text, time_text};
use super::model::Model;
use super::words;

/// What, in words, and whether it wants attention.
pub(super) fn rows(model: &Model, status: &Status) -> Vec<(&'static str, String, bool)> {
    let snapshot = &status.snapshot;
    let place = snapshot.bearing.map(|bearing| format!(", {}", words::bearing(bearing))).unwrap_or_default();
    let view = snapshot.view.map_or_else(|| "none".to_owned(), |view| model.view_name(view));
    let mut lines = vec![
        ("viewer", format!("{}{place}", words::presence(snapshot.presence)), false),
        ("view", view, false),
    ];
    lines.extend(words::lease(snapshot.lease).map(|asked| ("asked for", asked, false)));
    if let Some(reason) = snapshot.dark {
        lines.push(("dark", reason.to_string(), true));
    }
    let cuts = cuts(snapshot);
    if !cuts.is_empty() {
        // A fade passes.
        let fades = [Lamp::Top, Lamp::Bottom]
            .into_iter()
            .all(|lamp| snapshot.cuts.get(lamp).iter().all(|cut| cut == Cut::Slew));
        lines.push(("dimmed", cuts, !fades));
    }
    let armed = snapshot.interlock == vitrine_exhibit::interlock::InterlockState::Armed;
    lines.push(("interlock", words::interlock(snapshot.interlock).to_owned(), !armed));
    let boards = both(snapshot.boards, |board| board.map_or_else(|| "no reading".to_owned(), celsius));
    lines.push(("boards", boards, snapshot.boards.top.is_none() || snapshot.boards.bottom.is_none()));
    if let Some(air) = snapshot.enclosure {
        lines.push(("enclosure", celsius(air), false));
    }
    if snapshot.ultraviolet_lost {
        let silent = "the sensor on which the plan counts is silent: service is due";
        lines.push(("ultraviolet", silent.to_owned(), true));
    }
    let limits = model.plan.as_ref().map(|plan| &plan.limits);
    let of = |most: Option<Dose>| most.map(|most| format!(" of {}", kilojoules(most))).unwrap_or_default();
    let day = both(snapshot.day_dose, kilojoules) + &of(limits.map(|limits| limits.daily_dose));
    let life = both(snapshot.life_dose, kilojoules) + &of(limits.map(|limits| limits.life_dose));
    lines.push(("dose today", day, false));
    lines.push(("dose, life", life, false));
    let clock = match status.clock.now {
        Some(now) => format!("{} from {}", time_text(now), source_text(status.clock.source)),
        None => "not known".to_owned(),
    };
    lines.push(("clock", clock, status.clock.now.is_none()));
    lines
}

fn cuts(snapshot: &Snapshot) -> String {
    let of = |lamp: Lamp| {
        snapshot.cuts.get(lamp).iter().map(move |cut| format!("{}: {}", words::lamp(lamp), words::cut(cut)))
    };
    of(Lamp::Top).chain(of(Lamp::Bottom)).collect::<Vec<_>>().join(", ")
}

fn both<T>(pair: PerLamp<T>, text: impl Fn(T) -> String) -> String {
    let texts = pair.map(text);
    format!("top {}, bottom {}", texts.top, texts.bottom)
}

fn kilojoules(dose: Dose) -> String {
    format!("{:.1} kJ/m2", dose.0 as f64 / 1e9)
}

fn celsius(temperature: CentiCelsius) -> String {
    format!("{:.1} C", f64::from(temperature.0) / 100.0)
}
