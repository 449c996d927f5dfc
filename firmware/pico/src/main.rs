//! The RP2040 image of the exhibit controller.
#![no_std]
#![no_main]
use defmt_rtt as _;
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
#[cortex_m_rt::entry]
fn main() -> ! {
    let _p = embassy_rp::init(Default::default());
    defmt::info!("hello");
    loop {}
}
