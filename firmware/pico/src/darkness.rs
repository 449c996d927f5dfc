//! The shortest way to darkness, for the interlock's interrupt and for a program that is about to end.
//!
//! A compare value of the PWM takes effect only at the end of its period, up to 2 ms later. So darkness does not go
//! through the PWM: the enable line falls, and the pins' output override holds both dimming lines low whatever the PWM
//! does, until [`light_unless_tripped`]. Nothing here can fail, wait or allocate.

use embassy_rp::pac;
use pac::io::vals::Outover;
use portable_atomic::{AtomicBool, Ordering};

use crate::board::{INTERLOCK_A, INTERLOCK_B, LAMP_BOTTOM_DIM, LAMP_ENABLE, LAMP_TOP_DIM};

/// Function 4 of a pin is its PWM output.
const FUNCTION_PWM: u8 = 4;

/// Both loops in the register of all inputs: high is open.
const LOOPS: u32 = 1 << INTERLOCK_A | 1 << INTERLOCK_B;

/// Set by the interlock's interrupt, and cleared by the state's owner just before it reads the loops for the governor.
static TRIPPED: AtomicBool = AtomicBool::new(false);

/// At least one of the edges since then was an opening.
static OPENED: AtomicBool = AtomicBool::new(false);

/// Makes both lamps dark at once.
#[inline(always)]
pub(crate) fn darken() {
    pac::SIO.gpio_out(0).value_clr().write_value(1 << LAMP_ENABLE);
    override_dimming(Outover::LOW);
}

/// Makes both lamps dark at once and keeps them so until the governor has seen it.
#[inline(always)]
pub(crate) fn trip() {
    darken();
    TRIPPED.store(true, Ordering::Relaxed);
}

/// Takes note that the edge was an opening.
#[inline(always)]
pub(crate) fn note_opening() {
    OPENED.store(true, Ordering::Relaxed);
}

/// Forgets what has tripped the interlock since the last call; tells whether an opening was among it.
pub(crate) fn take_opening() -> bool {
    // Load and store, not swap: the processor has no atomic swap, and between the two an edge can only be seen early.
    critical_section::with(|_| {
        TRIPPED.store(false, Ordering::Relaxed);
        let opened = OPENED.load(Ordering::Relaxed);
        OPENED.store(false, Ordering::Relaxed);
        opened
    })
}

/// Runs `light` with the overrides lifted, unless a loop is open or an edge came since the governor last looked; tells whether
/// it ran.
pub(crate) fn light_unless_tripped(light: impl FnOnce()) -> bool {
    // Without interrupts the interlock's cannot come between the question and the light: it comes right after.
    critical_section::with(|_| {
        if TRIPPED.load(Ordering::Relaxed) || pac::SIO.gpio_in(0).read() & LOOPS != 0 {
            return false;
        }
        override_dimming(Outover::NORMAL);
        light();
        true
    })
}

#[inline(always)]
fn override_dimming(level: Outover) {
    for pin in [LAMP_TOP_DIM, LAMP_BOTTOM_DIM] {
        pac::IO_BANK0.gpio(pin).ctrl().write(|control| {
            control.set_funcsel(FUNCTION_PWM);
            control.set_outover(level);
        });
    }
}
