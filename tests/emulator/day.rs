//! A day of visitors, shortened to a minute: they come, walk, and go; the lamps follow, rest and go dark.

use vitrine_exhibit::units::Milliseconds;

use crate::bench::{Bench, Erase, LAMP_BOTTOM, LAMP_TOP, MILLISECOND, SECOND};
use crate::exhibit::plan;
use crate::hosts::Host;
use crate::room::{Room, battery_clock, thermistor_reading};
use crate::signals::duty;
use crate::trace::{self, Moment};

/// Who stands where, and for how many half seconds; nobody without a bearing.
const DAY: [(Option<f64>, u64); 7] = [
    (None, 4),
    (Some(-30.0), 12),
    (Some(0.0), 12),
    (Some(28.0), 12),
    (None, 30),
    (Some(-28.0), 10),
    (None, 34),
];

/// A lamp board's degrees above the room at full level, and its time constant in half seconds.
const WARMTH: f64 = 25.0;
const INERTIA: f64 = 20.0;

#[test]
fn visitors_come_walk_and_go() {
    let mut bench = Bench::new();
    battery_clock(&mut bench);
    bench.power_on();
    let mut room = Room::empty();
    room.live(&mut bench, 100 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let mut short = plan();
    short.presence.hold = Milliseconds(3_000);
    short.presence.idle = Milliseconds(4_000);
    host.upload(&mut bench, &short);
    room.live(&mut bench, 5 * SECOND);

    let (mut run, mut edges) = (Vec::new(), Vec::new());
    let mut celsius = 22.0;
    for (person_deg, halves) in DAY {
        room.person_deg = person_deg;
        for _ in 0..halves {
            room.live(&mut bench, SECOND / 2);
            edges.extend(bench.edges());
            let (top, bottom) = (
                duty(&edges, LAMP_TOP, bench.now, 10, false),
                duty(&edges, LAMP_BOTTOM, bench.now, 10, false),
            );
            celsius += (22.0 + WARMTH * top - celsius) / INERTIA;
            bench.analog(0, thermistor_reading(celsius));
            let snapshot = host.status(&mut bench).snapshot;
            run.push(Moment {
                at: bench.now,
                person_deg,
                bearing_deg: snapshot.bearing.map(|bearing| f64::from(bearing.horizontal.0) / 100.0),
                view: snapshot.view,
                top,
                bottom,
                celsius,
                dose: snapshot.day_dose.top.0 as f64 / 1e6,
            });
        }
    }
    if let Some(folder) = trace::folder() {
        std::fs::write(folder.join("day.vcd"), trace::waveform(&edges)).expect("written");
        std::fs::write(folder.join("day.svg"), trace::picture(&run)).expect("written");
    }

    let end_of = |visit: usize| {
        let halves: u64 = DAY.iter().take(visit + 1).map(|(_, halves)| halves).sum();
        run[halves as usize - 1]
    };
    let left = end_of(1);
    assert!((left.top - 1.0).abs() < 0.005 && (left.bottom - 0.4).abs() < 0.005, "{left:?}");
    let ahead = end_of(2);
    assert!((ahead.top - 0.1).abs() < 0.005 && (ahead.bottom - 1.0).abs() < 0.005, "{ahead:?}");
    let right = end_of(3);
    assert!((right.top - 0.3).abs() < 0.005 && (right.bottom - 0.7).abs() < 0.005, "{right:?}");
    for (visit, (stands, _)) in DAY.iter().enumerate().take(4).skip(1) {
        let seen = end_of(visit).bearing_deg.expect("somebody is seen");
        let stands = stands.expect("somebody stands");
        assert!((seen - stands).abs() < 6.0, "seen at {seen}, stands at {stands}");
    }
    let shown = [1, 2, 3].map(|visit| end_of(visit).view);
    assert_eq!(shown, [Some(0), Some(1), Some(2)], "each sees the view made for where they stand");
    let nobody = end_of(6);
    assert!(nobody.top == 0.0 && nobody.bottom == 0.0, "dark when nobody has been there: {nobody:?}");
    assert!(run.windows(2).all(|pair| pair[0].dose <= pair[1].dose), "dose never falls");
    assert_eq!(bench.take_resets(), 0);
    let erases = bench.erases();
    assert!(!erases.is_empty() && erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
}
