//! The boot loader of the RP2040 board.
//!
//! It holds the lamps' lines low, brings an update as far as it goes, verifies the active image's signature, and starts it
//! under the watchdog: an image that hangs before it can feed the dog is reset, and gone back from where it is on trial.
//! All that decides lies in `vitrine-boot`.
//!
//! The status LED is lit while it works. Where no image verifies nothing is started: the lamps stay dark, and the LED
//! blinks three times and pauses, again and again. The flash is then written anew over USB, by the chip's own boot ROM.
#![no_std]
#![no_main]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, entry, exception};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::pac;
use embassy_rp::peripherals::FLASH;
use embassy_rp::watchdog::Watchdog;
use embassy_time::Duration;
use vitrine_boot::{LAYOUT, Start, public_key, start};
use vitrine_storage::map::FLASH_BYTES;

include!(concat!(env!("OUT_DIR"), "/pins.rs"));

type Chip = Flash<'static, FLASH, Blocking, { FLASH_BYTES as usize }>;

/// An image that does not start its own watchdog within this time is reset: nearly the longest that the dog can wait.
const IMAGE_STARTS_WITHIN: Duration = Duration::from_secs(8);

/// Function 5 of a pin is the processor's own output.
const FUNCTION_SIO: u8 = 5;

/// A second of the boot loader's clock.
const SECOND: u32 = 125_000_000;

#[entry]
fn main() -> ! {
    darken();
    let peripherals = embassy_rp::init(embassy_rp::config::Config::default());
    // Setting the clocks up has reset the pins; their pull-downs held the lines meanwhile.
    darken();
    light(true);
    let mut chip = Chip::new_blocking(peripherals.FLASH);
    // A flash that fails is no reason to run what may not have been verified.
    let Ok(Start::Image { .. }) = start(&mut chip, &LAYOUT, &public_key()) else { rest() };
    light(false);
    let mut watchdog = Watchdog::new(peripherals.WATCHDOG);
    watchdog.pause_on_debug(true);
    watchdog.start(IMAGE_STARTS_WITHIN);
    run()
}

/// Leaves the processor to the active image.
fn run() -> ! {
    let table = LAYOUT.address();
    // SAFETY: `start` has verified that what lies at this address is an image signed for this board: it begins with a vector
    // table, whose first words are its stack and its entry. No interrupt is enabled that could use the boot loader's table.
    unsafe {
        (*cortex_m::peripheral::SCB::PTR).vtor.write(table);
        cortex_m::asm::bootload(table as *const u32)
    }
}

/// Nothing is to run: dark for ever, and telling so.
fn rest() -> ! {
    loop {
        for _ in 0..3 {
            light(true);
            cortex_m::asm::delay(SECOND / 8);
            light(false);
            cortex_m::asm::delay(SECOND / 8);
        }
        cortex_m::asm::delay(SECOND);
    }
}

/// Makes the lamps' lines outputs and low, whatever state the chip is in.
fn darken() {
    pac::RESETS.reset().modify(|reset| {
        reset.set_io_bank0(false);
        reset.set_pads_bank0(false);
    });
    while {
        let done = pac::RESETS.reset_done().read();
        !done.io_bank0() || !done.pads_bank0()
    } {}
    for pin in [LAMP_ENABLE, LAMP_TOP_DIM, LAMP_BOTTOM_DIM] {
        drive(pin, false);
    }
}

fn light(lit: bool) {
    drive(STATUS_LED, lit);
}

fn drive(pin: usize, high: bool) {
    let level = pac::SIO.gpio_out(0);
    if high { level.value_set() } else { level.value_clr() }.write_value(1 << pin);
    pac::SIO.gpio_oe(0).value_set().write_value(1 << pin);
    pac::IO_BANK0.gpio(pin).ctrl().write(|control| control.set_funcsel(FUNCTION_SIO));
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    darken();
    rest()
}

#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    darken();
    rest()
}
