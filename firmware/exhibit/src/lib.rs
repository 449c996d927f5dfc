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

#[cfg(test)]
extern crate std;

mod angle;
pub mod chooser;
pub mod clock;
pub mod controller;
pub mod duty;
pub mod events;
pub mod exposure;
pub mod fader;
pub mod governor;
pub mod inputs;
pub mod interlock;
pub mod ledger;
pub mod limits;
pub mod plan;
pub mod schedule;
pub mod settings;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod units;
pub mod viewer;

pub use controller::{Presence, Snapshot, State, step};
