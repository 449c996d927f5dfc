//! The controller's terms in plain words.

use vitrine_exhibit::Presence;
use vitrine_exhibit::events::{Cut, Event, ProgramEnd};
use vitrine_exhibit::interlock::InterlockState;
use vitrine_exhibit::units::{Lamp, Milliseconds};
use vitrine_exhibit::viewer::Bearing;
use vitrine_protocol::message::LogEntry;

pub(super) fn presence(presence: Presence) -> &'static str {
    match presence {
        Presence::Somebody => "somebody is there",
        Presence::JustGone => "the last viewer has just gone",
        Presence::Idle => "nobody is there: idle glow",
        Presence::Empty => "nobody has been there for a while",
        Presence::Unknown => "the viewer sensors give nothing credible",
    }
}

pub(super) fn interlock(state: InterlockState) -> &'static str {
    match state {
        InterlockState::Open => "open",
        InterlockState::WaitsForRearm => "closed, waits for `vitrine rearm`",
        InterlockState::Armed => "closed and armed",
        InterlockState::Disagrees => "its two loops disagree; mend it, then `vitrine rearm`",
    }
}

pub(super) fn cut(cut: Cut) -> &'static str {
    match cut {
        Cut::Warm => "the lamp board is warm",
        Cut::DayDose => "the day's dose is used up",
        Cut::LifeDose => "the stack's life is nearly used up",
        Cut::Resting => "resting after a long time lit",
        Cut::FirmwareCeiling => "the firmware's ceiling",
        Cut::PlanCeiling => "the plan's ceiling",
        Cut::Slew => "fading",
        Cut::BelowFloor => "below the driver's floor",
    }
}

/// What a host has asked for that runs out by itself, where there is such a thing.
pub(super) fn lease(left: Milliseconds) -> Option<String> {
    let seconds = left.0.div_ceil(1_000);
    (seconds > 0).then(|| format!("hold, dark or open, for another {seconds} s; `vitrine release` ends it"))
}

pub(super) fn lamp(lamp: Lamp) -> &'static str {
    match lamp {
        Lamp::Top => "top",
        Lamp::Bottom => "bottom",
    }
}

/// A bearing as a person says it.
pub(super) fn bearing(bearing: Bearing) -> String {
    let side = |centi_degrees: i16, positive: &str, negative: &str| {
        let degrees = f64::from(centi_degrees.unsigned_abs()) / 100.0;
        format!("{degrees:.1} deg {}", if centi_degrees < 0 { negative } else { positive })
    };
    format!("{}, {}", side(bearing.horizontal.0, "right", "left"), side(bearing.vertical.0, "above", "below"))
}

/// When an entry of the log was made.
pub(super) fn moment(entry: &LogEntry) -> String {
    entry.time.map_or_else(|| format!("{} s after the start", entry.uptime_s), super::clock::time_text)
}

/// An event of the log as a sentence.
pub(super) fn event(event: Event) -> String {
    match event {
        Event::Dark(reason) => format!("dark: {reason}"),
        Event::Lit => "the lamps are let through".to_owned(),
        Event::ViewChosen(view) => format!("view {} was chosen", u16::from(view) + 1),
        Event::ViewerCame => "somebody has come".to_owned(),
        Event::ViewersGone => "nobody is left".to_owned(),
        Event::ViewerSensorLost => "the viewer sensors give nothing credible: neutral pair".to_owned(),
        Event::ViewerSensorBack => "the viewer sensors are back".to_owned(),
        Event::CutBegan(which, why) => format!("{} lamp dimmed: {}", lamp(which), cut(why)),
        Event::CutEnded(which, why) => format!("{} lamp no longer dimmed: {}", lamp(which), cut(why)),
        Event::Rearmed => "re-armed".to_owned(),
        Event::RearmRefused => "a re-arm was refused: its cause persists".to_owned(),
        Event::PlanChanged => "another plan is active".to_owned(),
        Event::PlanLost => "the plan is gone or was refused".to_owned(),
        Event::NoSuchView(view) => {
            format!("view {} was asked for and is not in the plan", u16::from(view) + 1)
        }
        Event::LeaseLapsed => "a host's hold, dark or open ran out".to_owned(),
        Event::DayBegan => "a new day of the dose ledger began".to_owned(),
        Event::DayDose { lamp: which, day, joules_m2, lit_hours } => {
            let date = super::clock::date_text(day);
            format!("{} lamp on {date}: {joules_m2} J/m2; {lit_hours} h lit in all", lamp(which))
        }
        Event::LifeDoseUsed(which, percent) => {
            format!("{} lamp: {percent} % of the stack's life dose are used", lamp(which))
        }
        Event::UltravioletLow => "less ultraviolet than the lamps should give: service is due".to_owned(),
        Event::EnclosureWarm => "the air in the enclosure is warm".to_owned(),
        Event::LampHours(which, hours) => format!("{} lamp: {hours} hours at full level", lamp(which)),
        Event::NewStack => "a fresh stack was declared".to_owned(),
        Event::UltravioletSensorLost => {
            "the ultraviolet sensor on which the plan counts is silent: service is due".to_owned()
        }
        Event::UltravioletSensorBack => "the ultraviolet sensor is back".to_owned(),
        Event::ClockJumped { seconds } => {
            let way = if seconds < 0 { "back" } else { "forward" };
            format!("the clock was put {way} by {} s", seconds.unsigned_abs())
        }
        Event::ProgramEnded { end, at } => match (end, at) {
            (ProgramEnd::Panic, 1..) => format!("the program before this one ended: {end}, in line {at}"),
            (ProgramEnd::HardFault, _) => format!("the program before this one ended: {end} at {at:#010x}"),
            _ => format!("the program before this one ended: {end}"),
        },
        Event::EventsLost(count) => {
            format!("{count} events are missing here: too many came while the log waited for steady lamps")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vitrine_exhibit::events::{Cuts, DarkReason};

    /// The value of an enumeration behind this discriminant, with its first lamp where it has one.
    fn reason(discriminant: u8) -> Option<DarkReason> {
        postcard::from_bytes(&[discriminant, 0]).ok()
    }

    #[test]
    fn the_book_says_what_to_do_about_every_darkness_and_every_dimming() {
        let faults = include_str!("../../book/src/technician/faults.md");
        let reasons: Vec<String> = (0..).map_while(reason).map(|reason| reason.to_string()).collect();
        assert!(reasons.len() > 15, "{reasons:?}");
        for text in reasons.into_iter().chain(Cuts::ALL.map(|why| format!("dimmed: {}", cut(why)))) {
            let text = text.replace("the top lamp board", "a lamp board");
            assert!(faults.contains(&format!("| {text} |")), "{text} is not in the book's table of faults");
        }
    }
}
