//! What spans crates: helpers shared by the tests in this folder.
#![forbid(unsafe_code)]

pub mod bench;
pub mod room;
pub mod scenario;
