//! The exhibit on the bench: a plan, a room, and what the lamps' pins show of it.

use vitrine_exhibit::plan::Plan;
use vitrine_exhibit::testing;
use vitrine_exhibit::units::{Level, PerLamp};

use crate::bench::{Bench, LAMP_BOTTOM, LAMP_TOP, MILLISECOND, SECOND};
use crate::hosts::Host;
use crate::room::{Room, battery_clock};
use crate::signals::{Edge, duty};

/// The views of the test plan: name, degrees to the right, and the levels of both lamps, in parts of 65,535.
pub(crate) const VIEWS: [(&str, i16, u16, u16); 3] =
    [("left", -30, 65_535, 26_214), ("ahead", 0, 6_554, 65_535), ("right", 30, 19_661, 45_875)];

/// A plan with three views and no schedule.
pub(crate) fn plan() -> Plan {
    let view =
        |(id, degrees, top, bottom): (&str, i16, u16, u16)| testing::view(id, degrees * 100, top, bottom);
    Plan {
        name: "On the bench".try_into().expect("a short name"),
        views: VIEWS.into_iter().map(view).collect(),
        neutral: PerLamp::new(Level(32_768), Level(32_768)),
        ..testing::plan()
    }
}

/// A bench with the plan in flash and an empty room long enough for the sensors' background.
pub(crate) fn with_plan() -> (Bench, Room) {
    with_plan_on(Bench::new())
}

/// The same on a bench of one's own.
pub(crate) fn with_plan_on(mut bench: Bench) -> (Bench, Room) {
    battery_clock(&mut bench);
    bench.power_on();
    let mut room = Room::empty();
    room.live(&mut bench, 100 * MILLISECOND);
    let address = bench.listen();
    Host::greet(&mut bench, &address).upload(&mut bench, &plan());
    room.live(&mut bench, 5 * SECOND);
    (bench, room)
}

/// A bench with somebody in front of the exhibit, and its lamps at a steady level.
pub(crate) fn lit_on(bench: Bench) -> (Bench, Room) {
    let (mut bench, mut room) = with_plan_on(bench);
    room.person_deg = Some(0.0);
    room.live(&mut bench, 3 * SECOND);
    bench.edges();
    (bench, room)
}

/// A bench without sensors, lit with the plan's neutral pair: quickly there, for what has nothing to do with viewers.
pub(crate) fn neutral_on(mut bench: Bench) -> (Bench, Host) {
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    host.upload(&mut bench, &plan());
    bench.run(3 * SECOND);
    let lit = bench.edges().iter().any(|edge| edge.pin == LAMP_TOP && edge.high);
    assert!(lit, "lit after the dwell: {:?}", host.status(&mut bench).snapshot.dark);
    (bench, host)
}

/// What a lamp's dimming must be for a level, in counts of its 62,500.
fn counts(level: u16) -> f64 {
    (f64::from(level) / 65_535.0 * 62_500.0).round()
}

#[test]
fn the_duty_at_the_pins_is_the_plans_to_one_count() {
    let (mut bench, _room) = lit_on(Bench::new());
    let (_, _, top, bottom) = VIEWS[1];
    bench.run(50 * MILLISECOND);
    let (edges, now) = (bench.edges(), bench.now);
    for (pin, level) in [(LAMP_TOP, top), (LAMP_BOTTOM, bottom)] {
        let measured = duty(&edges, pin, now, 10, true) * 62_500.0;
        assert!(
            (measured - counts(level)).abs() <= 1.0,
            "GP{pin}: {measured} counts instead of {}",
            counts(level)
        );
    }
}

#[test]
fn a_person_at_a_views_bearing_is_shown_its_pair() {
    let (mut bench, mut room) = with_plan();
    for (id, degrees, top, bottom) in VIEWS {
        room.person_deg = Some(f64::from(degrees));
        bench.edges();
        room.live(&mut bench, 5 * SECOND);
        let (edges, now): (Vec<Edge>, u64) = (bench.edges(), bench.now);
        for (pin, level) in [(LAMP_TOP, top), (LAMP_BOTTOM, bottom)] {
            let duty = duty(&edges, pin, now, 10, false);
            let wanted = f64::from(level) / 65_535.0;
            assert!((duty - wanted).abs() < 0.005, "{id}, GP{pin}: {duty} instead of {wanted}");
        }
    }
}

#[test]
fn the_plan_outlives_the_power() {
    let (mut bench, mut room) = with_plan();
    bench.power_off();
    bench.power_on();
    room.person_deg = None;
    room.live(&mut bench, 5 * SECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let status = host.status(&mut bench);
    let plan = status.plan.expect("a plan");
    assert_eq!(plan.name.as_str(), "On the bench");
    assert_eq!(status.snapshot.power_cycles, 2);
    assert!(bench.edges().iter().any(|edge| edge.high && edge.pin == LAMP_TOP), "lit again");
}

#[test]
fn settings_are_changed_over_the_cable_and_outlive_the_power() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let address = bench.listen();
    let change = ["settings", "--set", "supply_divider=12", "--set", "place=Hall 3", "--to", &address];
    bench.vitrine(&[&change[..], &["--yes"]].concat());
    bench.power_off();
    bench.power_on();
    bench.run(300 * MILLISECOND);
    let told = bench.vitrine(&["settings", "--to", &address, "--json"]);
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!((&told["place"], &told["supply_divider"]), (&"Hall 3".into(), &12.0.into()));
    // And the board goes by them: 24 V behind a divider of 11 now read as a twelfth more.
    let status = bench.vitrine(&["status", "--to", &address, "--json"]);
    let status: serde_json::Value = serde_json::from_str(&status).expect("JSON");
    let volts = status["supply_v"].as_f64().expect("a voltage");
    assert!((volts - 24.0 * 12.0 / 11.0).abs() < 0.05, "{volts}");
}
