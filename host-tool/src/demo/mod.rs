//! The whole chain before one's eyes: a viewer walks past, the lamps follow, and a contact sheet shows what is seen.

mod sheet;
mod walk;

pub use sheet::contact_sheet;
pub use walk::{Moment, WalkError, walk};
