//! The build folder: what `vitrine design` writes and the other commands read.
//!
//! ```text
//! films/film-01.png ...            ink of each film, film 1 on top
//! views/ID.png, views/ID.target.png   what a view shows, and its pattern
//! plan.json, plan.bin              the plan to read, and as uploaded
//! report.json, report.html         all figures, and the page to look at
//! manifest.json                    what went in and what came out
//! ```

mod films;
mod look;
mod manifest;
mod page;
mod read;
mod report;
mod strips;
mod turn;
mod whole;
mod write;

pub use films::{FilmError, FilmRows, film_name};
pub use look::{Look, LookRequest, look, look_png};
pub(crate) use manifest::portable_name;
pub use manifest::{FORMAT, LAYOUT, Manifest};
pub use read::{BuildFolder, Films, OpenError};
pub use report::{Figures, InSmall, Report, ViewReport};
pub use strips::{GrowingFilms, GrownFilms, growing_place, strip_bytes};
pub use turn::{Turn, Turned, turn};
pub(crate) use whole::try_beside;
pub use whole::{INTERRUPTED, Interrupt, WholeFolder, clean_up_on_interrupt, try_file, write_file};
pub use write::{Beside, BuildError, Inputs, check_place, write, write_grown};
