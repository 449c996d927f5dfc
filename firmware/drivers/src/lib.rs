//! Drivers of the exhibit's parts over embedded-hal, without a word about the microcontroller.
//!
//! A driver reports what it finds and leaves the judgement to the governor: an interlock that cannot be read is open,
//! a sensor that does not answer is an error, and neither is ever a panic.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

pub mod battery_clock;
pub mod grid_eye;
pub mod interlock;
pub mod lamps;
pub mod radar;
pub mod supply;
pub mod thermistor;
pub mod uv_sensor;

#[cfg(test)]
mod test_bus;
