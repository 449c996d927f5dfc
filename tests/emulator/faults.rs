//! However the program ends, the lamps are dark first. Tried on the bench image, whose tasks end badly on demand.

use crate::bench::{Bench, LAMP_ENABLE, LAMP_PINS, MICROSECOND, MILLISECOND, SECOND};
use crate::exhibit::neutral_on;

/// The tasks of the image, by their bit at the watchdog.
const TASKS: [(&str, u32); 7] =
    [("controller", 0), ("lamps", 1), ("sensors", 2), ("analog", 3), ("store", 4), ("usb", 5), ("serial", 6)];

const PANIC: u32 = 1;
const HARD_FAULT: u32 = 2;
const ENDLESS_LOOP: u32 = 3;

/// A task checks in at least so often.
const CHECK_IN: u64 = 110 * MILLISECOND;

fn bench_image() -> Bench {
    Bench::with_image("vitrine-pico-bench.elf")
}

/// Asks a task to end badly and runs on; gives how long lamps stayed lit after the last moment at which it may have
/// begun, the number of resets, and what was logged.
fn end_badly(action: u32, task: u32) -> (u64, usize, Vec<String>) {
    let (mut bench, _host) = neutral_on(bench_image());
    bench.log();
    bench.edges();
    let asked = bench.now;
    bench.poke("VITRINE_BENCH", action << 16 | 1 << task);
    bench.run(700 * MILLISECOND);
    let dark_at = bench
        .edges()
        .iter()
        .filter(|edge| !edge.high && LAMP_PINS.contains(&edge.pin))
        .find(|edge| edge.pin == LAMP_ENABLE)
        .map(|edge| edge.at)
        .expect("the enable line fell");
    let resets = bench.take_resets();
    bench.run(SECOND);
    assert!(bench.is_dark(), "dark for the two seconds after a start");
    (dark_at - asked, resets, bench.log())
}

#[test]
fn a_panic_in_any_task_is_dark_and_told_after_the_reset() {
    for (name, task) in TASKS {
        let (lit_for, resets, log) = end_badly(PANIC, task);
        assert!(lit_for <= CHECK_IN, "{name}: {lit_for} ns");
        assert_eq!(resets, 1, "{name}");
        let told =
            log.iter().any(|line| line.contains("the bench asked for it") && line.contains("hooks.rs"));
        assert!(told, "{name}: {log:#?}");
    }
}

#[test]
fn a_hard_fault_is_dark_and_told_after_the_reset() {
    for (name, task) in [TASKS[0], TASKS[4]] {
        let (lit_for, resets, log) = end_badly(HARD_FAULT, task);
        assert!(lit_for <= CHECK_IN, "{name}: {lit_for} ns");
        assert_eq!(resets, 1, "{name}");
        assert!(log.iter().any(|line| line.contains("hard fault at 0x1")), "{name}: {log:#?}");
    }
}

#[test]
fn an_endless_loop_in_any_task_is_dark_within_the_watchdogs_time() {
    for (name, task) in TASKS {
        let (lit_for, resets, _) = end_badly(ENDLESS_LOOP, task);
        assert!(lit_for <= CHECK_IN + 500 * MILLISECOND, "{name}: {lit_for} ns");
        assert_eq!(resets, 1, "{name}");
    }
}

/// From the first instruction of the panic's or the fault's end to dark: measured at the pins, the enable line falls
/// first and both dimming lines with it.
#[test]
fn all_three_lines_fall_together() {
    for action in [PANIC, HARD_FAULT] {
        let (mut bench, _host) = neutral_on(bench_image());
        bench.poke("VITRINE_BENCH", action << 16 | 1);
        bench.edges();
        bench.run(50 * MILLISECOND);
        let edges = bench.edges();
        let enable = edges.iter().find(|edge| edge.pin == LAMP_ENABLE && !edge.high).expect("dark").at;
        let mut high = [None; 9];
        for edge in edges.iter().filter(|edge| LAMP_PINS.contains(&edge.pin) && edge.at <= enable) {
            high[usize::from(edge.pin)] = Some(edge.high);
        }
        // A dimming line that was high when the enable line fell must fall too; one that was low must stay low.
        let mut took = 0;
        for edge in edges.iter().filter(|edge| LAMP_PINS.contains(&edge.pin) && edge.at > enable) {
            assert!(!edge.high, "{edge:?} after dark");
            if high[usize::from(edge.pin)] == Some(true) {
                took = edge.at - enable;
                high[usize::from(edge.pin)] = Some(false);
            }
        }
        assert!(took <= 20 * MICROSECOND, "{took} ns");
    }
}
