//! Hours of visitors on the image: no step is missed, no event lost, nothing erased in a fade, and the ledger books at least
//! what the pins gave. All of it is asserted as the hours pass, so that what fails is told at once.
//!
//! `VITRINE_HOURS` says how many of them; the emulator skips what the processor sleeps.

use crate::bench::{Bench, Erase, LAMP_BOTTOM, LAMP_TOP, MILLISECOND, SECOND, number_of};
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

/// Visits and pauses between two looks at how the board fares.
const LOOK: u64 = 60;

/// What the pins have done since the beginning.
struct Pins {
    start: u64,
    steps: u64,
    given_uj_m2: [f64; 2],
    erases: usize,
}

impl Pins {
    const WATCHED: [u8; 3] = [LAMP_TOP, LAMP_BOTTOM, STEP_PIN];

    fn watch(bench: &mut Bench) -> Self {
        bench.sums(Self::WATCHED);
        Self { start: bench.now, steps: 0, given_uj_m2: [0.0; 2], erases: 0 }
    }

    fn add_up(&mut self, bench: &mut Bench) {
        let [top, bottom, step] = bench.sums(Self::WATCHED);
        self.steps += step.0;
        for (given, (_, high_ns)) in self.given_uj_m2.iter_mut().zip([top, bottom]) {
            *given += high_ns / 1e6 * FULL_MW_M2;
        }
    }

    /// Holds all that must be true at any time; gives a line that tells it.
    fn look(&mut self, bench: &mut Bench) -> String {
        self.add_up(bench);
        let (simulated, wanted) = (bench.now - self.start, (bench.now - self.start) / (10 * MILLISECOND));
        assert!(self.steps.abs_diff(wanted) <= 1, "{} of {wanted} steps", self.steps);
        assert_eq!(bench.peek("VITRINE_LOST_EVENTS"), 0, "events were lost");
        assert_eq!(bench.take_resets(), 0);
        let erases = bench.erases();
        assert!(erases.iter().all(Erase::is_in_steady_light), "erased in a fade: {erases:?}");
        self.erases += erases.len();
        let given = self.given_uj_m2;
        let address = bench.listen();
        let booked = Host::greet(bench, &address).status(bench).snapshot.life_dose;
        let booked = [booked.top.0 as f64, booked.bottom.0 as f64];
        for (given, booked) in given.into_iter().zip(booked) {
            assert!(given > 0.0, "no light was measured");
            // The pins are measured to 8 ns a period; levels round down, bookings up.
            assert!(given <= booked * 1.0001, "{given} uJ/m2 at the pins, {booked} booked");
        }
        let [top, bottom] =
            [0, 1].map(|lamp| format!("{:.1} of {:.1}", given[lamp] / 1e6, booked[lamp] / 1e6));
        format!(
            "{} s: {} steps, none missed; {} erases, none in a fade; top {top} J/m2 booked, bottom {bottom}",
            simulated / SECOND,
            self.steps,
            self.erases
        )
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
    let mut pins = Pins::watch(&mut bench);
    let mut visit = 0;
    while bench.now - pins.start < seconds * SECOND {
        let (person_deg, stays_s) = visits(visit);
        room.person_deg = person_deg;
        for _ in 0..stays_s.min(seconds) {
            room.live(&mut bench, SECOND);
            pins.add_up(&mut bench);
            bench.rtt();
        }
        visit += 1;
        if visit % LOOK == 0 {
            let times = (bench.now - pins.start) as f64 / 1e9 / began.elapsed().as_secs_f64();
            println!("{}; {times:.1} times as fast as real", pins.look(&mut bench));
        }
    }
    println!("{visit} visits and pauses in {}", pins.look(&mut bench));
}
