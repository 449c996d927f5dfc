//! What a film-stack exhibit knows and decides.
//!
//! Pure logic without hardware, heap, clock or I/O: time and inputs go in, lamp levels and events come out.
//! The controller's firmware and the host tool share it, so that what is previewed is what is run.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

pub mod plan;
pub mod units;
