//! The board: its pins and what else of the chip each owner gets, generated from hardware/pins.toml.

use assign_resources::assign_resources;
use embassy_rp::{Peri, Peripherals, bind_interrupts, dma, peripherals};

include!(concat!(env!("OUT_DIR"), "/pins.rs"));

bind_interrupts!(pub(crate) struct Interrupts {
    USBCTRL_IRQ => embassy_rp::usb::InterruptHandler<peripherals::USB>;
    I2C0_IRQ => embassy_rp::i2c::InterruptHandler<peripherals::I2C0>;
    ADC_IRQ_FIFO => embassy_rp::adc::InterruptHandler;
    UART1_IRQ => embassy_rp::uart::BufferedInterruptHandler<peripherals::UART1>;
    UART0_IRQ => embassy_rp::uart::BufferedInterruptHandler<peripherals::UART0>;
    DMA_IRQ_0 => dma::InterruptHandler<peripherals::DMA_CH0>;
});

/// Hands every owner what is its own.
pub(crate) fn split(peripherals: Peripherals) -> AssignedResources {
    split_resources!(peripherals)
}
