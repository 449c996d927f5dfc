//! Power that goes at any step of the flash, again and again, on one board that is never wiped: while a plan is uploaded,
//! while ledger and log are written at a start, while the lamps spend what is reserved.
//!
//! `VITRINE_CUTS` says how many, `VITRINE_CUTS_FROM` with which to begin.

use vitrine_exhibit::plan::Plan;
use vitrine_protocol::{Request, Response};

use crate::bench::{Bench, MILLISECOND, number_of};
use crate::exhibit::{neutral_on, plan};
use crate::hosts::Host;

/// What must never be less after a start than it was before.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    life_uj_m2: [u64; 2],
    power_cycles: u32,
    log_next: u32,
}

impl Known {
    fn of(bench: &mut Bench, host: &mut Host) -> (Self, String) {
        let status = host.status(bench);
        let life = status.snapshot.life_dose;
        let known = Self {
            life_uj_m2: [life.top.0, life.bottom.0],
            power_cycles: status.snapshot.power_cycles,
            log_next: status.log_next,
        };
        (known, status.plan.map(|plan| plan.name.to_string()).unwrap_or_default())
    }

    fn is_kept_by(&self, later: &Self) -> bool {
        let doses = self.life_uj_m2.iter().zip(later.life_uj_m2).all(|(before, after)| *before <= after);
        // A start whose first record was cut off may be counted again; nothing that was told is taken back.
        doses && self.power_cycles <= later.power_cycles + 1 && self.log_next <= later.log_next
    }
}

fn named(name: &str) -> Plan {
    Plan { name: name.try_into().expect("a short name"), ..plan() }
}

/// Starts the board; none when the power goes before it answers.
fn start(bench: &mut Bench) -> Option<Host> {
    bench.power_on();
    if !bench.run(100 * MILLISECOND) {
        return None;
    }
    let address = bench.listen();
    Host::try_greet(bench, &address)
}

/// Every entry that the log says it keeps can be read, in its order.
fn log_is_whole(bench: &mut Bench, host: &mut Host) {
    let Ok(Response::Log(page)) = host.ask(bench, &Request::ReadLog { from: 0 }) else { panic!("no log") };
    for (entry, wanted) in page.entries.iter().zip(page.oldest..) {
        assert_eq!(entry.sequence, wanted, "a gap in the log");
    }
}

#[test]
fn power_cuts_at_flash_steps_never_take_what_was_there() {
    let (count, from) = (number_of("VITRINE_CUTS", 60), number_of("VITRINE_CUTS_FROM", 0));
    let began = std::time::Instant::now();
    let (mut bench, mut host) = neutral_on(Bench::new());
    host.upload(&mut bench, &named("plan 0"));
    let (mut known, mut name) = Known::of(&mut bench, &mut host);
    bench.power_off();
    let (mut torn, mut kept, mut taken) = (0, 0, 0);
    for cut in from..from + count {
        let order = ["rising", "falling", "shuffled"][(cut % 3) as usize];
        let part = [0.0, 0.3, 0.7, 0.99][(cut / 3 % 4) as usize];
        let wanted = format!("plan {cut}");
        // Every third cut comes while the board starts, the others while it has a plan uploaded.
        let in_start = cut % 3 == 2;
        let step = 1 + cut / 12 % if in_start { 5 } else { 9 };
        if in_start {
            bench.cut_at(step, part, order);
        }
        let lives = if cut % 10 == 9 { 3_500 } else { 200 };
        let went = match start(&mut bench) {
            Some(mut host) => {
                if !in_start {
                    bench.cut_at(step, part, order);
                    host.try_upload(&mut bench, &named(&wanted));
                }
                // What is left of the steps goes to ledger and log; now and then the lamps are lit until then.
                !bench.run(lives * MILLISECOND)
            }
            None => true,
        };
        bench.power_off();

        // A cut that was not reached waits for the next start.
        let next = start(&mut bench);
        let waited = next.is_none();
        let mut host = next.or_else(|| start(&mut bench)).expect("it starts after a cut");
        torn += u64::from(went || waited);
        let before = name.clone();
        (known, name) = check(&mut bench, &mut host, known, &name, &wanted, cut);
        kept += u64::from(name == before);
        taken += u64::from(name == wanted);
        bench.power_off();
        if (cut + 1 - from).is_multiple_of(100) {
            println!(
                "{} cuts; {:.2} a second",
                cut + 1 - from,
                (cut + 1 - from) as f64 / began.elapsed().as_secs_f64()
            );
        }
    }
    println!(
        "cuts {from} to {}: {torn} torn; the old plan {kept} times, the new one {taken} times; {:.2} a second",
        from + count,
        count as f64 / began.elapsed().as_secs_f64()
    );
    assert!(torn * 2 > count, "{torn} of {count} cuts tore a step");
}

fn check(
    bench: &mut Bench,
    host: &mut Host,
    known: Known,
    old: &str,
    wanted: &str,
    cut: u64,
) -> (Known, String) {
    let (found, name) = Known::of(bench, host);
    assert!(known.is_kept_by(&found), "cut {cut}: {known:?} became {found:?}");
    assert!(name == old || name == wanted, "cut {cut}: neither '{old}' nor '{wanted}' but '{name}'");
    log_is_whole(bench, host);
    (found, name)
}
