//! The controller, simulated on this computer.
//!
//! [`VirtualController`] runs the firmware's own crates: the exhibit's step 100 times a second, the protocol's server,
//! the stores in flash. Around them stand simulated parts: flash in a file, a viewer as two thermal sensors see one,
//! lamps that warm up, an interlock. It is driven step by step with [`VirtualController::advance`], or served over
//! TCP in real time by [`serve()`].

mod flash;
mod machine;
mod room;
mod serve;
mod surroundings;
mod time;
mod updates;

pub use flash::{FlashError, FlashFile};
pub use machine::VirtualController;
pub use room::{Noise, Viewer, Walk, thermal_frames};
pub use serve::{DEFAULT_PORT, Pace, ServeError, Served, serve, try_place};
pub use surroundings::Surroundings;
pub use time::Clock;

#[cfg(test)]
mod tests;
