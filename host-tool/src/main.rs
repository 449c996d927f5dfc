//! The `vitrine` command.
#![forbid(unsafe_code)]
fn main() {}
