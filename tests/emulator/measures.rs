//! What the image costs: time, stack. Budgets that fail the test when they are outgrown.

use vitrine_exhibit::plan::{Between, Policy};

use crate::bench::{Bench, MICROSECOND, MILLISECOND, SECOND};
use crate::exhibit::lit_on;
use crate::hosts::Host;
use crate::mind::largest_plan;
use crate::signals::Edge;

/// High while a step of the state runs, on the bench image.
const STEP_PIN: u8 = 16;

const STEP: u64 = 10 * MILLISECOND;

/// The stack's budget in bytes: half of its room.
const STACK_BUDGET: u64 = 32 * 1024;

#[test]
fn a_hundred_steps_a_second_are_on_time_and_cheap() {
    let (mut bench, mut room) = lit_on(Bench::with_image("vitrine-pico-bench.elf"));
    bench.edges();
    room.person_deg = Some(20.0);
    room.live(&mut bench, 4 * SECOND);
    let edges = bench.edges();
    let steps: Vec<u64> =
        steps(&edges).windows(2).filter(|pair| pair[0].high).map(|pair| pair[1].at - pair[0].at).collect();
    assert!(steps.len() >= 390, "{} steps in 4 s", steps.len());
    let jitter = step_jitter(&edges);
    let share = steps.iter().sum::<u64>() as f64 / (4 * SECOND) as f64;
    let longest = steps.iter().max().expect("steps");
    println!("steps: jitter {jitter} ns, longest {longest} ns, {:.2} % of the processor", share * 100.0);
    assert!(jitter <= 50 * MICROSECOND, "jitter {jitter} ns");
    assert!(share <= 0.10, "{share}");
}

fn steps(edges: &[Edge]) -> Vec<Edge> {
    edges.iter().copied().filter(|edge| edge.pin == STEP_PIN).collect()
}

/// By how much the beginnings of steps stray from the grid of the ticks, from the earliest to the latest, in ns:
/// against the grid and not from step to step, so that lateness cannot add up unseen.
pub(crate) fn step_jitter(edges: &[Edge]) -> u64 {
    let begins: Vec<u64> = steps(edges).iter().filter(|edge| edge.high).map(|edge| edge.at).collect();
    let first = *begins.first().expect("steps");
    let strayed = |at: &u64| (at + STEP + STEP / 2 - first % STEP) % STEP;
    let (least, most) = (begins.iter().map(strayed).min(), begins.iter().map(strayed).max());
    most.expect("steps") - least.expect("steps")
}

/// Holds the deepest stack so far to its budget.
pub(crate) fn hold_stack_to_its_budget(bench: &mut Bench, after: &str) {
    let (used, of) = bench.stack();
    println!("stack after {after}: {used} of {of} bytes");
    assert!(used <= STACK_BUDGET, "{used} bytes after {after}");
}

/// What goes deepest: a plan that is read, checked and taken while the mind steps, and at the start before it does. An update's
/// signature is held to the same budget in `update.rs`.
#[test]
fn the_stack_keeps_its_budget() {
    let (mut bench, mut room) = lit_on(Bench::new());
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    host.upload(&mut bench, &largest_plan(Policy::Shared, Between::Smooth));
    room.live(&mut bench, 2 * SECOND);
    host.log(&mut bench, 1);
    hold_stack_to_its_budget(&mut bench, "uploads");
    bench.power_off();
    bench.power_on();
    room.live(&mut bench, SECOND);
    hold_stack_to_its_budget(&mut bench, "a start");
}
