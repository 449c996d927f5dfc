//! The battery clock's drift: learnt when it is set again, kept in flash whatever the power does, corrected from then on.

use serde_json::json;
use vitrine_exhibit::clock::ClockRecord;
use vitrine_exhibit::units::UtcSeconds;
use vitrine_protocol::{Request, Response};

use crate::bench::{Bench, MILLISECOND, SECOND};
use crate::hosts::Host;
use crate::room::battery_clock_at;

const SET_AT: i64 = 1_795_379_862;
const MONTH: i64 = 30 * 86_400;
/// What the clock gains in a month.
const GAIN: i64 = 52;

/// Starts the board with a battery clock that shows this time.
fn start(bench: &mut Bench, shows: i64) -> Host {
    battery_clock_at(bench, shows);
    bench.power_on();
    bench.run(300 * MILLISECOND);
    let address = bench.listen();
    Host::greet(bench, &address)
}

/// Sets the clock and waits until the battery clock has it; none when the power goes on the way.
fn set(bench: &mut Bench, host: &mut Host, to: i64) -> Option<()> {
    host.try_ask(bench, &Request::SetClock { now: UtcSeconds(to) })?.expect("set");
    bench.run(SECOND).then_some(())
}

/// The time that the board tells, less this one, and what it knows of its clock.
fn clock(bench: &mut Bench, host: &mut Host, less: i64) -> (i64, ClockRecord) {
    let Ok(Response::Clock(clock)) = host.ask(bench, &Request::Clock) else { panic!("no clock") };
    (clock.now.expect("a time").0 - less, clock.record)
}

/// A board whose clock was set a month ago, without power, and its flash saved.
fn set_a_month_ago() -> Bench {
    let mut bench = Bench::new();
    let mut host = start(&mut bench, SET_AT - 3_600);
    set(&mut bench, &mut host, SET_AT).expect("set");
    let record = clock(&mut bench, &mut host, 0).1;
    assert_eq!((record.last_error_s, record.drift_ppb), (Some(-3_600), 0));
    bench.power_off();
    bench.call(json!({"op": "flash_save"}));
    bench
}

#[test]
fn the_drift_is_learnt_at_the_second_setting_and_corrected_after_a_start() {
    let mut bench = set_a_month_ago();
    let mut host = start(&mut bench, SET_AT + MONTH + GAIN);
    assert!((GAIN..GAIN + 3).contains(&clock(&mut bench, &mut host, SET_AT + MONTH).0));
    set(&mut bench, &mut host, SET_AT + MONTH).expect("set");
    let record = clock(&mut bench, &mut host, 0).1;
    assert!((19..22).contains(&(record.drift_ppb / 1_000)), "{record:?}");
    bench.power_off();

    let mut host = start(&mut bench, SET_AT + 2 * MONTH + GAIN);
    let (late, kept) = clock(&mut bench, &mut host, SET_AT + 2 * MONTH);
    assert!((-1..3).contains(&late), "{late} s");
    assert_eq!(kept, record);
}

#[test]
fn a_power_cut_at_any_step_of_a_setting_keeps_the_old_record_or_the_new_one() {
    let mut bench = set_a_month_ago();
    let mut host = start(&mut bench, SET_AT + MONTH + GAIN);
    let old = clock(&mut bench, &mut host, 0).1;
    let before = bench.flash_steps();
    set(&mut bench, &mut host, SET_AT + MONTH).expect("set");
    let steps = bench.flash_steps() - before;
    bench.power_off();
    assert!((3..20).contains(&steps), "{steps} steps");
    for step in 1..=steps {
        for (part, order) in [(0.0, "rising"), (0.5, "falling"), (0.99, "shuffled")] {
            bench.call(json!({"op": "flash_restore"}));
            let mut host = start(&mut bench, SET_AT + MONTH + GAIN);
            bench.cut_at(step, part, order);
            assert!(set(&mut bench, &mut host, SET_AT + MONTH).is_none(), "no cut at step {step}");
            let mut host = start(&mut bench, SET_AT + MONTH + GAIN);
            let found = clock(&mut bench, &mut host, 0).1;
            let is_new = found.last_error_s.is_some_and(|error| (GAIN..GAIN + 3).contains(&i64::from(error)));
            assert!(found == old || is_new, "step {step}, {order}: {found:?}");
            bench.power_off();
        }
    }
}
