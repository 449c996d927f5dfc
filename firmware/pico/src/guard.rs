//! The interlock's own interrupt: any edge on either loop makes the lamps dark before any task runs.
//!
//! The chip's library owns the handler of the pins' interrupt and would wake a task. The guard goes before it: it moves
//! the vector table into RAM and puts its own handler there, at the highest priority, itself in RAM. No task of this
//! image waits for a pin, so the library's handler is not missed.

use core::cell::UnsafeCell;

use embassy_rp::gpio::{Input, Pull};
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::pac;

use crate::board::{INTERLOCK_A, INTERLOCK_B, InterlockResources};
use crate::darkness;

/// 16 exceptions, and the chip's interrupts: 26, which are stored as 32, or 52.
const VECTORS: usize = if cfg!(feature = "rp2350") { 16 + 52 } else { 16 + 32 };

/// Exceptions come first in the table.
const EXCEPTIONS: usize = 16;

/// The processor wants a table of up to 128 entries on a multiple of 512 bytes.
#[repr(C, align(512))]
struct VectorTable(UnsafeCell<[usize; VECTORS]>);

// SAFETY: written once by `arm`, before the table is made the processor's; read by the processor only.
unsafe impl Sync for VectorTable {}

static TABLE: VectorTable = VectorTable(UnsafeCell::new([0; VECTORS]));

/// Both loops' inputs, with the guard standing.
pub(crate) type Interlock = vitrine_drivers::interlock::Interlock<Input<'static>, Input<'static>>;

/// Sets up both loops and their interrupt. From here on an opening loop makes the lamps dark.
pub(crate) fn arm(resources: InterlockResources) -> Interlock {
    let loop_a = Input::new(resources.loop_a, Pull::Up);
    let loop_b = Input::new(resources.loop_b, Pull::Up);
    critical_section::with(|_| {
        move_vectors();
        for pin in [INTERLOCK_A, INTERLOCK_B] {
            pac::IO_BANK0.intr(pin / 8).write(|edges| {
                edges.set_edge_high(pin % 8, true);
                edges.set_edge_low(pin % 8, true);
            });
            pac::IO_BANK0.int_proc(0).inte(pin / 8).modify(|edges| {
                edges.set_edge_high(pin % 8, true);
                edges.set_edge_low(pin % 8, true);
            });
        }
    });
    interrupt::IO_IRQ_BANK0.set_priority(Priority::P0);
    vitrine_drivers::interlock::Interlock::new(loop_a, loop_b)
}

fn move_vectors() {
    // SAFETY: VTOR points at the image's table of as many entries in flash, the RAM table is not yet in use, and interrupts
    // are off, so nobody reads or writes either meanwhile. The handler stays where the table says for ever.
    unsafe {
        let system = &*cortex_m::peripheral::SCB::PTR;
        let table = &mut *TABLE.0.get();
        core::ptr::copy_nonoverlapping(system.vtor.read() as *const usize, table.as_mut_ptr(), VECTORS);
        let entry = EXCEPTIONS + interrupt::IO_IRQ_BANK0 as usize;
        if let Some(vector) = table.get_mut(entry) {
            *vector = on_edge as *const () as usize;
        }
        system.vtor.write(TABLE.0.get() as u32);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Runs from RAM, so that not even a cache miss in flash delays it.
#[unsafe(link_section = ".data.guard")]
extern "C" fn on_edge() {
    darkness::trip();
    let opens = |pin: usize| pac::IO_BANK0.intr(pin / 8).read().edge_high(pin % 8);
    if opens(INTERLOCK_A) || opens(INTERLOCK_B) {
        darkness::note_opening();
    }
    for pin in [INTERLOCK_A, INTERLOCK_B] {
        pac::IO_BANK0.intr(pin / 8).write(|edges| {
            edges.set_edge_high(pin % 8, true);
            edges.set_edge_low(pin % 8, true);
        });
    }
}
