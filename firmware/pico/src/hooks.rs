//! For the bench image only: makes a task end badly when the bench asks for it, and shows the state's step at a pin.
//!
//! The bench writes [`VITRINE_BENCH`] from outside; no host, wire or setting can.

use embassy_rp::pac;
use portable_atomic::{AtomicU32, Ordering};

use crate::watchdog::Client;

/// GP16 is not connected: high while the state's owner computes a step.
const STEP_PIN: usize = 16;

/// GP17 is not connected: rises when a task begins to end badly.
const END_PIN: usize = 17;

/// What a task is to do at its next check-in: the action in the upper half, the client's bit in the lower.
#[unsafe(no_mangle)]
static VITRINE_BENCH: AtomicU32 = AtomicU32::new(0);

const PANIC: u32 = 1;
const HARD_FAULT: u32 = 2;
const ENDLESS_LOOP: u32 = 3;
const SILENCE: u32 = 4;

/// Does what the bench asks of this client; tells whether that is not to check in, as a task does that waits for ever.
pub(crate) fn obey(client: Client) -> bool {
    let asked = VITRINE_BENCH.load(Ordering::Relaxed);
    if asked & 0xffff != client as u32 {
        return false;
    }
    pac::SIO.gpio_out(0).value_set().write_value(1 << END_PIN);
    match asked >> 16 {
        PANIC => unreachable!("the bench asked for it"),
        HARD_FAULT => cortex_m::asm::udf(),
        ENDLESS_LOOP => loop {
            cortex_m::asm::nop();
        },
        action => action == SILENCE,
    }
}

/// Makes both pins outputs.
pub(crate) fn set_up() {
    for pin in [STEP_PIN, END_PIN] {
        pac::IO_BANK0.gpio(pin).ctrl().write(|control| control.set_funcsel(5));
        pac::SIO.gpio_oe(0).value_set().write_value(1 << pin);
    }
}

/// Shows that a step begins or has ended.
pub(crate) fn step(runs: bool) {
    let port = pac::SIO.gpio_out(0);
    if runs { port.value_set() } else { port.value_clr() }.write_value(1 << STEP_PIN);
}
