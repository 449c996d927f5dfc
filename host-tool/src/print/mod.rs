//! Films to print: sheets true to size for printers whose dots are not square.
//!
//! [`PrintJob`] lays the films of a stack out on sheets and draws marks around them; its `write` writes each sheet as a
//! 16-bit TIFF and as a PDF file, row by row, and the assembly sheet. What the printer's channels lay for a film's ink
//! is a [`Separation`]'s business.

mod assembly;
mod chart;
mod dots;
mod drawing;
mod estimate;
mod job;
mod laid;
mod layout;
mod lettering;
mod marks;
mod paper;
mod pdf;
mod raster;
mod rows;
mod separation;
mod strips;
mod tiff;
mod write;

pub use chart::ChartFilm;
pub use dots::{DotAxis, INCH_MM, Resolution, TooCoarse};
pub use estimate::Estimate;
pub use job::{LayoutError, PlacedFilm, PrintJob, PrintRequest, Profiles};
pub use layout::{Arrangement, PaperTooSmall};
pub use paper::{PAPERS, Paper, UnknownPaper};
pub use rows::OpenFilm;
pub use separation::{AsDesigned, Dot, Halftone, Run, Separation};
pub use write::{FORMAT, Formats, PrintError, SheetFile, SheetsFile, TiffForm, check_sheets_place};
