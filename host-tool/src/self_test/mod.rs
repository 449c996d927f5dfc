//! The self-test: walks every part of an exhibit's hardware and says what it found.
//!
//! What the controller measures by itself is read; the lamps are lit one after the other by holding views of the
//! active plan, so that they never give more than the exhibit does; what only a person can do (open the door, press
//! the staff key, stand before it) is asked of a [`Person`].

mod sheet;
mod walk;

pub use sheet::{Finding, Sheet, Verdict};
pub use walk::{Person, walk};

#[cfg(test)]
mod tests;
