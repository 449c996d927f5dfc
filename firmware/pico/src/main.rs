//! The RP2040 image of the exhibit controller.
fn main() {}
