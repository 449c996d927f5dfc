//! The radar on the image's second serial port: its reports reach the tracker, noise between them does not.

use vitrine_exhibit::plan::ViewerSensor;
use vitrine_exhibit::units::CentiCelsius;
use vitrine_tests::room::{self, Body, Waypoint, radar_bytes};

use crate::bench::{Bench, MILLISECOND, SECOND};
use crate::exhibit::plan;
use crate::hosts::Host;

/// The radar sends ten reports a second.
const REPORT: u64 = 100 * MILLISECOND;

/// Lets the board live before a radar that sees the room, from a time of the room on; `spoil` is done to the bytes.
fn live(
    bench: &mut Bench,
    room: &mut room::Room,
    from_s: f64,
    reports: u32,
    spoil: fn(u32, Vec<u8>) -> Vec<u8>,
) {
    for number in 0..reports {
        let report = room.radar(from_s + f64::from(number) * 0.1);
        bench.radar(&spoil(number, radar_bytes(&report)));
        bench.run(REPORT);
    }
}

fn walker() -> room::Room {
    let mut room = room::Room::new(3);
    let path = vec![
        Waypoint(0.0, -40.0, 1.5),
        Waypoint(4.0, -22.0, 1.5),
        Waypoint(6.0, 30.0, 1.5),
        Waypoint(12.0, 25.0, 1.5),
    ];
    room.bodies.push(Body { path, ..Body::standing(0.0, 1.0) });
    room
}

fn board(sensor: ViewerSensor) -> (Bench, Host) {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let mut plan = plan();
    plan.viewer.sensor = sensor;
    host.upload(&mut bench, &plan);
    bench.run(2 * SECOND);
    (bench, host)
}

/// The id of the view shown.
fn view(bench: &mut Bench, host: &mut Host) -> String {
    host.status(bench).plan.expect("a plan").view_id.to_string()
}

#[test]
fn who_walks_before_the_radar_is_followed() {
    for sensor in [ViewerSensor::Radar, ViewerSensor::Either] {
        let (mut bench, mut host) = board(sensor);
        let mut room = walker();
        live(&mut bench, &mut room, 0.5, 30, |_, bytes| bytes);
        assert_eq!(view(&mut bench, &mut host), "left", "{sensor:?}");
        live(&mut bench, &mut room, 3.5, 45, |_, bytes| bytes);
        assert_eq!(view(&mut bench, &mut host), "right", "{sensor:?}");
        let bearing = host.status(&mut bench).snapshot.bearing.expect("a bearing").horizontal.0;
        assert!((2_400..3_200).contains(&bearing), "{bearing}");
    }
}

#[test]
fn noise_and_short_reports_on_the_radars_wire_do_no_harm() {
    let (mut bench, mut host) = board(ViewerSensor::Radar);
    let spoil = |number: u32, bytes: Vec<u8>| match number % 5 {
        0 => bytes[..17].to_vec(),
        1 => [&[0xaa, 0xff, 0x03][..], &bytes].concat(),
        2 => (0..60).map(|i| (i as u32 * 7919 + number) as u8).collect(),
        _ => bytes,
    };
    live(&mut bench, &mut walker(), 0.5, 30, spoil);
    assert_eq!(view(&mut bench, &mut host), "left");
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn a_plan_for_the_thermal_pair_does_not_ask_the_radar() {
    let (mut bench, mut host) = board(ViewerSensor::Thermal);
    live(&mut bench, &mut walker(), 0.5, 30, |_, bytes| bytes);
    assert_eq!(host.status(&mut bench).snapshot.viewers, 0);
}

/// The ultraviolet sensor's own temperature stands for the enclosure's air: 0.05 degrees a count from -66.9 on.
#[test]
fn the_enclosures_air_is_read_and_cuts() {
    let (mut bench, mut host) = board(ViewerSensor::Either);
    let air = |celsius: f64| (((celsius + 66.9) / 0.05).round() as u16).to_le_bytes();
    bench.device(0x74, 0x00, &[0x83, 0x08, 0x21, 0x00, 0, 0]);
    // Where the identity is asked, and where the air is read, is one register here: the identity stays in its place.
    for (celsius, dark) in
        [(35.0, None), (50.5, Some("EnclosureTooHot")), (46.0, Some("EnclosureTooHot")), (44.0, None)]
    {
        let [low, _] = air(celsius);
        bench.device(0x74, 0x02, &[0x21]);
        bench.run(1_200 * MILLISECOND);
        let [_, high] = air(celsius);
        bench.device(0x74, 0x02, &[low, high]);
        bench.run(SECOND);
        let snapshot = host.status(&mut bench).snapshot;
        let near = |found: CentiCelsius| (f64::from(found.0) / 100.0 - celsius).abs() < 0.06;
        assert!(snapshot.enclosure.is_some_and(near), "{:?} at {celsius}", snapshot.enclosure);
        let is_too_hot = snapshot.dark.map(|reason| format!("{reason:?}"));
        assert_eq!(is_too_hot.as_deref().filter(|reason| *reason == "EnclosureTooHot"), dark, "at {celsius}");
    }
}
