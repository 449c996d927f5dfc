//! Hosts that misbehave: noise, half frames, floods, and one that does not read. The control loop does not care.

use std::io::Write;

use serde_json::json;
use vitrine_exhibit::inputs;
use vitrine_exhibit::units::Milliseconds;
use vitrine_protocol::rate::{BURST, REFILL_MS};
use vitrine_protocol::{Refusal, Reply, Request, Response, frame};

use crate::bench::{Bench, MICROSECOND, MILLISECOND};
use crate::exhibit::neutral_on;
use crate::hosts::Host;
use crate::measures::step_jitter;

fn noise(length: usize, mut seed: u32) -> Vec<u8> {
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 24) as u8
    };
    (0..length).map(|_| next()).collect()
}

#[test]
fn a_flood_of_rubbish_neither_delays_a_step_nor_keeps_the_next_host_out() {
    let (mut bench, mut host) = neutral_on(Bench::with_image("vitrine-pico-bench.elf"));
    let status = frame::encode(7, &Request::Status).expect("a small request");
    let damaged = host.status(&mut bench).damaged_frames;
    bench.edges();
    for round in 0..40 {
        host.stream.write_all(&noise(500, round)).expect("taken");
        host.stream.write_all(&status[..status.len() / 2]).expect("taken");
        host.stream.write_all(&[0]).expect("taken");
        host.stream.write_all(&vec![0x55; 900]).expect("taken");
        host.stream.write_all(&[0]).expect("taken");
        for _ in 0..20 {
            host.stream.write_all(&status).expect("taken");
        }
        bench.run(25 * MILLISECOND);
        while host.hear().is_some() {}
    }
    let jitter = step_jitter(&bench.edges());
    println!("steps under a flood: jitter {jitter} ns");
    assert!(jitter <= 50 * MICROSECOND, "{jitter} ns");
    assert_eq!(bench.take_resets(), 0);

    drop(host);
    bench.run(500 * MILLISECOND);
    let address = bench.listen();
    let mut next = Host::greet(&mut bench, &address);
    assert!(next.status(&mut bench).damaged_frames > damaged + 40, "damaged frames are counted");
}

/// The service port speaks the same frames as USB, and finds the next one after noise.
#[test]
fn the_service_port_answers_and_finds_its_way_out_of_noise() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(50 * MILLISECOND);
    let hello =
        Request::Hello { version: vitrine_protocol::VERSION, fingerprint: vitrine_protocol::FINGERPRINT };
    for (sequence, before) in [(1, vec![]), (2, noise(300, 5)), (3, vec![0x55; 700])] {
        bench.service(&before);
        bench.service(&[0]);
        bench.service(&frame::encode(sequence, &hello).expect("a small request"));
        bench.run(150 * MILLISECOND);
        let mut deframer = frame::Deframer::new();
        let answers: Vec<(u16, Reply)> = bench
            .service_answers()
            .into_iter()
            .filter_map(|byte| deframer.push(byte)?.ok().and_then(frame::decode))
            .collect();
        assert!(
            matches!(&answers[..], [(number, Ok(Response::Hello(_)))] if *number == sequence),
            "{answers:?}"
        );
    }
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn a_host_that_does_not_read_holds_up_nobody() {
    let (mut bench, mut host) = neutral_on(Bench::with_image("vitrine-pico-bench.elf"));
    bench.edges();
    bench.call(json!({"op": "usb_reading", "reading": false}));
    for _ in 0..20 {
        host.send(&Request::Status);
        bench.run(100 * MILLISECOND);
    }
    let jitter = step_jitter(&bench.edges());
    assert!(jitter <= 50 * MICROSECOND, "{jitter} ns");
    assert_eq!(bench.take_resets(), 0);
    bench.call(json!({"op": "usb_reading", "reading": true}));
    bench.run(1_500 * MILLISECOND);
    while host.hear().is_some() {}
    host.status(&mut bench);
}

/// Many requests come in one packet, whose answers nobody takes: each waits for its time, and the watchdog does not bite.
#[test]
fn a_host_that_asks_much_at_once_and_does_not_read_resets_nothing() {
    let (mut bench, mut host) = neutral_on(Bench::with_image("vitrine-pico-bench.elf"));
    bench.call(json!({"op": "usb_reading", "reading": false}));
    let rearm = frame::encode(7, &Request::Exhibit(inputs::Request::Rearm)).expect("a small request");
    for round in 0..6 {
        host.stream.write_all(&rearm.repeat(8)).expect("taken");
        bench.run((400 + round * 90) * MILLISECOND);
    }
    bench.run(2_000 * MILLISECOND);
    println!("LOG {:#?}", bench.log());
    assert_eq!(bench.take_resets(), 0);
    bench.call(json!({"op": "usb_reading", "reading": true}));
    bench.run(1_500 * MILLISECOND);
    while host.hear().is_some() {}
    host.status(&mut bench);
}

/// Every request is whole and allowed: what is too many is refused, and the rest is done.
#[test]
fn a_flood_of_commands_is_held_to_the_rate_and_the_service_port_is_served_meanwhile() {
    let (mut bench, mut host) = neutral_on(Bench::with_image("vitrine-pico-bench.elf"));
    let hello =
        Request::Hello { version: vitrine_protocol::VERSION, fingerprint: vitrine_protocol::FINGERPRINT };
    bench.edges();
    let began = bench.now;
    let (mut done, mut refused, mut served) = (0, 0, 0);
    for round in 0..40_u16 {
        for view in 0..30 {
            let hold = inputs::Request::Hold { view: view % 3, lease: Milliseconds(60_000) };
            host.send(&Request::Exhibit(hold));
        }
        bench.service(&frame::encode(round, &hello).expect("a small request"));
        bench.run(25 * MILLISECOND);
        while let Some((_, reply)) = host.hear() {
            match reply {
                Ok(Response::Done) => done += 1,
                Err(Refusal::TooManyRequests { .. }) => refused += 1,
                other => panic!("{other:?}"),
            }
        }
        served += bench.service_answers().iter().filter(|byte| **byte == 0).count();
    }
    let allowed = u64::from(BURST) + (bench.now - began) / MILLISECOND / REFILL_MS + 1;
    println!(
        "{done} of 1200 commands were done, {refused} refused, {allowed} allowed; {served} of 40 served beside"
    );
    assert!(done <= allowed && done >= allowed / 2 && refused >= 100, "{done} done, {refused} refused");
    assert!(served >= 35, "{served}");
    let jitter = step_jitter(&bench.edges());
    assert!(jitter <= 50 * MICROSECOND, "{jitter} ns");
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn hosts_that_come_and_go_in_mid_frame_leave_the_next_one_a_clean_port() {
    let (mut bench, host) = neutral_on(Bench::with_image("vitrine-pico-bench.elf"));
    drop(host);
    bench.edges();
    let status = frame::encode(7, &Request::Status).expect("a small request");
    for visit in 0..25 {
        bench.run(20 * MILLISECOND);
        let address = bench.listen();
        let mut host = Host::greet(&mut bench, &address);
        host.status(&mut bench);
        host.stream.write_all(&status[..1 + visit % (status.len() - 1)]).expect("taken");
        bench.service(&status[..1 + visit % (status.len() - 1)]);
        // Some stay for a moment, some are gone before the board looks.
        bench.run(visit as u64 % 3 * 60 * MILLISECOND);
    }
    let jitter = step_jitter(&bench.edges());
    assert!(jitter <= 50 * MICROSECOND, "{jitter} ns");
    assert_eq!(bench.take_resets(), 0);
}
