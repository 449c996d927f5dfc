//! From the power to the first sign of life: dark, and soon on USB.

use crate::bench::{Bench, LAMP_PINS, MILLISECOND, SECOND};
use crate::exhibit::neutral_on;

#[test]
fn no_lamp_pin_is_ever_high_without_a_plan() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(4 * SECOND);
    let rises = bench.edges().into_iter().filter(|edge| edge.high && LAMP_PINS.contains(&edge.pin)).count();
    assert_eq!(rises, 0);
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn usb_is_up_within_half_a_second() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(500 * MILLISECOND);
    let up = bench.usb_up_at().expect("enumerated");
    assert!(up <= 500 * MILLISECOND, "{up} ns");
}

/// With a plan in flash a start is dark for its dwell of two seconds, and lit soon after it.
#[test]
fn the_first_light_comes_soon_after_the_dwell() {
    let (mut bench, _host) = neutral_on(Bench::new());
    bench.power_off();
    bench.edges();
    let began = bench.now;
    bench.power_on();
    bench.run(3 * SECOND);
    let lit = bench.edges().into_iter().find(|edge| edge.high && LAMP_PINS.contains(&edge.pin));
    let after = lit.expect("lit").at - began;
    println!("reset to first light: {} ms", after / MILLISECOND);
    assert!((2 * SECOND..=2_300 * MILLISECOND).contains(&after), "{after} ns");
}

#[test]
fn a_board_without_sensors_keeps_feeding_its_watchdog() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(20 * SECOND);
    assert_eq!(bench.take_resets(), 0);
    assert!(bench.is_dark());
}
