//! What differs between the RP2040 and the RP2350.
//!
//! Both run at 125 MHz, so that the lamps' dimming and every measured time are the same.

use embassy_rp::config::Config;
use embassy_rp::interrupt;
use heapless::String;

use crate::steady_flash::Chip;

#[cfg(all(feature = "rp2040", feature = "rp2350"))]
compile_error!("an image is for one chip: --no-default-features --features rp2350 is that of the Pico 2");

/// The interrupt of the time driver.
#[cfg(feature = "rp2040")]
pub(crate) const TIME_INTERRUPT: interrupt::Interrupt = interrupt::TIMER_IRQ_0;
/// The interrupt of the time driver.
#[cfg(feature = "rp2350")]
pub(crate) const TIME_INTERRUPT: interrupt::Interrupt = interrupt::TIMER0_IRQ_0;

/// The clocks.
#[cfg(feature = "rp2040")]
pub(crate) fn config() -> Config {
    Config::default()
}

/// The clocks: 125 MHz, where the library's own choice is 150.
#[cfg(feature = "rp2350")]
pub(crate) fn config() -> Config {
    use embassy_rp::clocks::ClockConfig;
    // Where the dividers cannot make it, the library's choice still runs: the lamps would dim at 600 Hz, which the drivers take.
    ClockConfig::system_freq(125_000_000).map_or_else(|_| Config::default(), Config::new)
}

/// The board's number in hexadecimal: that of its flash chip. Empty where it cannot be read.
#[cfg(feature = "rp2040")]
pub(crate) fn serial_number(flash: &mut Chip) -> String<24> {
    flash.unique_id().map(u64::from_be_bytes).map(hexadecimal).unwrap_or_default()
}

/// The board's number in hexadecimal: that of the chip itself. Empty where it cannot be read.
#[cfg(feature = "rp2350")]
pub(crate) fn serial_number(_flash: &mut Chip) -> String<24> {
    embassy_rp::otp::get_chipid().map(hexadecimal).unwrap_or_default()
}

fn hexadecimal(number: u64) -> String<24> {
    let mut text = String::new();
    // 16 digits fit.
    let _ = core::fmt::write(&mut text, format_args!("{number:016X}"));
    text
}
