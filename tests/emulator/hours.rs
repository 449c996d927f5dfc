//! Hours of visitors on the image: no step is missed, no event lost, and the ledger books at least what the pins gave.
//!
//! `VITRINE_HOURS` says how many of them; the emulator skips what the processor sleeps.

use crate::bench::{Bench, LAMP_BOTTOM, LAMP_TOP, MILLISECOND, SECOND, number_of};
use crate::exhibit::with_plan_on;
use crate::hosts::Host;

const STEP_PIN: u8 = 16;
/// Both lamps' irradiance at full level in the bench's plan, in mW/m2.
const FULL_MW_M2: f64 = 10_000.0;

/// Who comes when, the same in every run: a bearing for some seconds, or nobody for some more.
fn visits(seed: u64) -> (Option<f64>, u64) {
    let mixed =
        seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 20;
    if seed.is_multiple_of(2) {
        (Some((mixed % 70) as f64 - 35.0), 5 + mixed % 40)
    } else {
        (None, 3 + mixed % 90)
    }
}

#[test]
fn hours_of_visitors_miss_no_step_lose_no_event_and_book_all_light() {
    let seconds = match number_of("VITRINE_HOURS", 0) {
        0 => 20,
        hours => hours * 3_600,
    };
    let began = std::time::Instant::now();
    let (mut bench, mut room) = with_plan_on(Bench::with_image("vitrine-pico-bench.elf"));
    let pins = [LAMP_TOP, LAMP_BOTTOM, STEP_PIN];
    bench.sums(pins);
    let start = bench.now;
    let (mut steps, mut given_uj, mut visit) = (0, [0.0_f64; 2], 0);
    while bench.now - start < seconds * SECOND {
        let (person_deg, stays_s) = visits(visit);
        room.person_deg = person_deg;
        for _ in 0..stays_s.min(seconds) {
            room.live(&mut bench, SECOND);
            let [top, bottom, step] = bench.sums(pins);
            steps += step.0;
            for (given_uj, (_, high_ns)) in given_uj.iter_mut().zip([top, bottom]) {
                *given_uj += high_ns / 1e6 * FULL_MW_M2;
            }
            bench.log();
        }
        visit += 1;
        if visit % 60 == 0 {
            let simulated = (bench.now - start) / SECOND;
            println!(
                "{simulated} s simulated, {:.1} times as fast as real",
                simulated as f64 / began.elapsed().as_secs_f64()
            );
        }
    }
    let wanted = (bench.now - start) / (10 * MILLISECOND);
    assert!(steps.abs_diff(wanted) <= 1, "{steps} of {wanted} steps");
    assert_eq!(bench.peek("VITRINE_LOST_EVENTS"), 0, "events were lost");
    assert_eq!(bench.take_resets(), 0);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let booked = host.status(&mut bench).snapshot.life_dose;
    println!(
        "{} s with {visit} visits and pauses: {steps} steps, none missed; top {:.1} of {:.1} J/m2 booked, bottom {:.1} of {:.1}",
        (bench.now - start) / SECOND,
        given_uj[0] / 1e6,
        booked.top.0 as f64 / 1e6,
        given_uj[1] / 1e6,
        booked.bottom.0 as f64 / 1e6
    );
    for (given, booked) in given_uj.into_iter().zip([booked.top.0, booked.bottom.0]) {
        assert!(given > 0.0, "no light was measured");
        // The pins are measured to 8 ns a period; levels round down, bookings up.
        assert!(given <= booked as f64 * 1.0001, "{given} uJ/m2 at the pins, {booked} booked");
    }
}
