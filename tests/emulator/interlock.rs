//! The interlock: dark at once, whatever else goes on.

use serde_json::json;
use vitrine_exhibit::events::{DarkReason, Event};
use vitrine_exhibit::inputs;
use vitrine_protocol::{Request, Response};

use crate::bench::{Bench, INTERLOCK_A, INTERLOCK_B, LAMP_PINS, MICROSECOND, MILLISECOND, SECOND, number_of};
use crate::exhibit::{neutral_on, with_plan};
use crate::hosts::Host;

/// A loop's opening makes both dimming pins and the enable line low within this time.
const DARK_WITHIN: u64 = 20 * MICROSECOND;

/// An erase of a sector, and what follows it.
const ERASE: u64 = 46 * MILLISECOND;

/// How many random moments are tried; `VITRINE_MOMENTS` says otherwise.
const MOMENTS: u64 = 300;

#[test]
fn either_loop_makes_the_lamps_dark_and_only_a_rearm_lights_them_again() {
    let (mut bench, mut room) = with_plan();
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    for gp in [INTERLOCK_A, INTERLOCK_B] {
        room.live(&mut bench, 3 * SECOND);
        bench.edges();
        room.live(&mut bench, 100 * MILLISECOND);
        assert!(bench.edges().iter().any(|edge| edge.high), "lit before GP{gp} opens");

        let trip = bench.trip(gp, true, 1_234_567, MILLISECOND);
        assert!(trip.dark, "GP{gp}: {:?}", trip.latencies);
        bench.edges();
        room.live(&mut bench, 200 * MILLISECOND);
        bench.pin(gp, false);
        room.live(&mut bench, 2 * SECOND);
        assert!(
            bench.edges().iter().all(|edge| !edge.high || !LAMP_PINS.contains(&edge.pin)),
            "GP{gp}: lit again"
        );
        let rearmed = host.ask(&mut bench, &Request::Exhibit(inputs::Request::Rearm));
        assert_eq!(rearmed, Ok(Response::Done));
    }
}

#[test]
fn a_lit_lamp_is_dark_within_twenty_microseconds_at_any_moment() {
    let (mut bench, mut room) = with_plan();
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let (moments, from) = (number_of("VITRINE_MOMENTS", MOMENTS), number_of("VITRINE_MOMENTS_FROM", 0));
    let began = std::time::Instant::now();
    let mut random = from + 1;
    let (mut latencies, mut in_erases) = (Vec::new(), Vec::new());
    for moment in from..from + moments {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Somebody walks about, so that the lamps fade; sensors are read; every tenth moment a host asks.
        if moment % 5 == 0 {
            room.person_deg = Some((random >> 40) as f64 % 70.0 - 35.0);
            room.show(&mut bench);
        }
        if moment % 10 == 0 {
            host.send(&Request::Status);
        }
        let gp = if random >> 63 == 0 { INTERLOCK_A } else { INTERLOCK_B };
        let steps = bench.flash_steps();
        let trip = bench.trip(gp, true, (random >> 20) % (25 * MILLISECOND), 50 * MILLISECOND);
        assert!(trip.dark, "moment {moment} at {} ns: GP{gp} did not make it dark", bench.now);
        assert!(
            trip.was_lit,
            "moment {moment}: nothing was lit; {:?}",
            host.status(&mut bench).snapshot.dark
        );
        let latency = *trip.latencies.iter().max().expect("three pins");
        // The log is full of spikes by now, and a sector of it was being erased: the hardware path is the one that counts.
        let in_erase = latency > DARK_WITHIN && bench.flash_steps() > steps;
        if in_erase {
            in_erases.push(latency);
        } else {
            latencies.push(latency);
        }
        // A spike shorter than a step: the governor hears of it from the guard, and the lamps fade in again.
        bench.pin(gp, false);
        bench.run(150 * MILLISECOND);
        // A loop that bounces again and again is broken, and one that was open for as long as an erase is a door: a person
        // looks, and re-arms.
        if moment % 4 == 3 || in_erase {
            bench.run(400 * MILLISECOND);
            let rearmed = host.ask(&mut bench, &Request::Exhibit(inputs::Request::Rearm));
            assert_eq!(rearmed, Ok(Response::Done));
            bench.run(100 * MILLISECOND);
        }
        bench.edges();
        while host.hear().is_some() {}
        if (moment + 1 - from).is_multiple_of(500) {
            let done = moment + 1 - from;
            println!("{done} moments; {:.1} a second", done as f64 / began.elapsed().as_secs_f64());
        }
    }
    latencies.sort_unstable();
    let worst = latencies.last().copied().unwrap_or(0);
    println!(
        "interlock to dark over {moments} moments: median {} ns, worst {worst} ns",
        latencies[latencies.len() / 2]
    );
    let longest = in_erases.iter().copied().max().unwrap_or(0);
    println!("and {} while a sector was erased, worst {longest} ns", in_erases.len());
    assert!(worst <= DARK_WITHIN, "{worst} ns");
    assert!(longest <= ERASE, "{longest} ns");
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn a_spike_that_only_the_guard_sees_is_told_and_the_fifth_asks_for_a_rearm() {
    let (mut bench, mut host) = neutral_on(Bench::new());
    for spike in 1..=5_u64 {
        // At another place of the step each time, and over its edge too.
        bench.run(700 * MILLISECOND + spike * 2_300 * MICROSECOND);
        bench.pin(INTERLOCK_A, true);
        bench.run(spike * spike * 300 * MICROSECOND);
        bench.pin(INTERLOCK_A, false);
        bench.run(600 * MILLISECOND);
        let dark = host.status(&mut bench).snapshot.dark;
        let wanted = (spike == 5).then_some(DarkReason::InterlockNotArmed);
        assert_eq!(dark, wanted, "after spike {spike}");
    }
    let from = host.status(&mut bench).log_next.saturating_sub(8);
    let Ok(Response::Log(page)) = host.ask(&mut bench, &Request::ReadLog { from }) else { panic!("no log") };
    let told =
        page.entries.iter().filter(|entry| entry.event == Event::Dark(DarkReason::InterlockOpen)).count();
    assert!(told >= 3, "{:?}", page.entries);
    assert_eq!(host.ask(&mut bench, &Request::Exhibit(inputs::Request::Rearm)), Ok(Response::Done));
    bench.run(SECOND);
    assert_eq!(host.status(&mut bench).snapshot.dark, None);
}

#[test]
fn a_loop_that_stays_open_from_the_start_keeps_the_lamps_dark() {
    let mut bench = Bench::new();
    bench.call(json!({"op": "pin", "gp": INTERLOCK_A, "high": true}));
    bench.power_on();
    bench.run(3 * SECOND);
    assert!(bench.edges().iter().all(|edge| !edge.high || !LAMP_PINS.contains(&edge.pin)));
}
