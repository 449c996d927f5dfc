//! What differs between the RP2040 and the RP2350.
//!
//! Both run at 125 MHz, so that the lamps' dimming and every measured time are the same.

use embassy_rp::config::Config;
use embassy_rp::interrupt;

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
