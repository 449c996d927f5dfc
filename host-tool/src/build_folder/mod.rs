//! The build folder: what `vitrine design` writes and the other commands read.

mod sources;
mod whole;

pub use sources::{PictureProblem, look_at_picture};
pub use whole::{WholeFolder, clean_up_on_interrupt, write_file};
