//! Writes all sheets into a folder, whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use super::job::{LayoutError, PlacedFilm, PrintJob, Sheet};
use super::pdf::PdfSheet;
use super::rows::{OpenFilm, SheetRows};
use super::separation::Separation;
use super::tiff::TakeRows;
use super::{assembly, tiff};
use crate::build_folder::{OpenError, WholeFolder, try_beside};

/// The files that are written for each sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Formats {
    /// 16-bit TIFF, if any.
    pub tiff: Option<TiffForm>,
    /// PDF.
    pub pdf: bool,
}

/// Which kind of TIFF is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TiffForm {
    /// BigTIFF where the file may grow beyond 2 GiB, plain TIFF else.
    Fitting,
    /// BigTIFF always.
    Big,
}

/// Why films cannot be printed.
#[derive(Debug, Error, Diagnostic)]
pub enum PrintError {
    /// Something else stands in the sheets' place.
    #[error("{} is there already and holds no sheets of vitrine", .0.display())]
    #[diagnostic(
        code("vitrine::print::not_sheets"),
        help("name another folder, or remove this one: only sheets and empty folders are replaced")
    )]
    NotSheets(PathBuf),
    /// The films do not go onto the sheets.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Layout(#[from] LayoutError),
    /// A film cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Film(#[from] OpenError),
    /// A file cannot be written.
    #[error("cannot write the sheets to {}", path.display())]
    #[diagnostic(
        code("vitrine::print::write"),
        help(
            "look at the disk's free space (--dry-run says what is needed) and the folder's permissions; nothing was left behind"
        )
    )]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file cannot be written, wherever it is.
    #[error("cannot write a sheet")]
    #[diagnostic(code("vitrine::print::write"))]
    Output(#[from] io::Error),
    /// A TIFF file cannot be written.
    #[error("cannot write a TIFF file")]
    #[diagnostic(code("vitrine::print::write"))]
    Tiff(#[source] ::tiff::TiffError),
}

/// The inks' ICC profile beside the sheets.
const PROFILE: &str = "inks.icc";
/// What marks a folder of sheets.
pub const FORMAT: &str = "vitrine-sheets";

/// `sheets.json`: what is where on the sheets.
#[derive(Clone, Debug, Serialize)]
pub struct SheetsFile {
    format: &'static str,
    /// The program's version.
    vitrine: &'static str,
    /// The exhibit's name.
    pub exhibit: String,
    /// BLAKE3 of the volume.
    pub volume_blake3: String,
    dpi_x: f64,
    dpi_y: f64,
    mirrored: bool,
    inks: [String; 3],
    /// The file of the inks' ICC profile, where one was wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    profile: Option<&'static str>,
    /// A film's picture, as it lies on its sheet.
    pub film_dots: [usize; 2],
    /// The same upright.
    film_pixels: [usize; 2],
    /// Whether films lie a quarter turn clockwise.
    turned: bool,
    /// The part of the paper that is no film with its marks.
    pub waste: f64,
    /// The sheets in order.
    pub sheets: Vec<SheetFile>,
}

/// One sheet of [`SheetsFile`].
#[derive(Clone, Debug, Serialize)]
pub struct SheetFile {
    /// The file names, without a folder.
    pub files: Vec<String>,
    /// Width and height.
    pub mm: [f64; 2],
    /// Width and height.
    pub dots: [usize; 2],
    /// The films on it.
    pub films: Vec<PlacedFilm>,
}

impl PrintJob {
    /// What is where on the sheets.
    pub fn description(&self, formats: Formats) -> SheetsFile {
        let request = &self.request;
        let sheets = self.sheets.iter().enumerate().map(|(index, sheet)| {
            let (width_mm, height_mm) = sheet.size_mm(request.resolution);
            let endings = [(formats.tiff.is_some(), "tif"), (formats.pdf, "pdf")];
            let written = endings.into_iter().filter(|ending| ending.0);
            SheetFile {
                files: written.map(|(_, ending)| sheet_name(index, ending)).collect(),
                mm: [width_mm, height_mm],
                dots: [sheet.width, sheet.height],
                films: sheet.films.clone(),
            }
        });
        let (width, height) = self.film_dots();
        SheetsFile {
            format: FORMAT,
            vitrine: env!("CARGO_PKG_VERSION"),
            exhibit: request.exhibit.clone(),
            volume_blake3: request.volume_blake3.clone(),
            dpi_x: request.resolution.dpi_x,
            dpi_y: request.resolution.dpi_y,
            mirrored: request.mirrored,
            inks: request.inks.clone(),
            profile: request.profiles.as_ref().map(|_| PROFILE),
            film_dots: [width, height],
            film_pixels: [request.stack.width_px, request.stack.height_px],
            turned: self.turned,
            waste: self.waste,
            sheets: sheets.collect(),
        }
    }

    /// Writes the sheets, the assembly sheet and `sheets.json` to the folder `place`; `report` is told how many files
    /// are done, of how many.
    ///
    /// # Errors
    /// Fails when `place` is taken by something else, a film cannot be read, or anything cannot be written; then `place`
    /// is as it was.
    pub fn write(
        &self,
        place: &Path,
        formats: Formats,
        open: OpenFilm<'_>,
        separation: &dyn Separation,
        report: &mut dyn FnMut(usize, usize),
    ) -> Result<SheetsFile, PrintError> {
        check_sheets_place(place)?;
        let at = |path: PathBuf| move |error| placed(error, path);
        let folder = WholeFolder::beside(place).map_err(PrintError::Output).map_err(at(place.to_owned()))?;
        let description = self.description(formats);
        let total = description.sheets.iter().map(|sheet| sheet.files.len()).sum::<usize>() + 1;
        let mut done = 0;
        let mut tell = |step: usize| {
            done += step;
            report(done, total);
        };
        tell(0);
        for (index, sheet) in self.sheets.iter().enumerate() {
            self.write_sheet(&folder, place, (index, sheet), formats, open, separation)?;
            tell(description.sheets[index].files.len());
        }
        // A stack of which some films are printed anew has its sheet already.
        let whole = self.request.films.len() == self.request.stack.films;
        let assembly = whole.then(|| assembly::sheet(self, open)).transpose()?;
        let described = serde_json::to_vec_pretty(&description).map_err(io::Error::other)?;
        let profile = self.request.profiles.as_ref().map(|profiles| profiles.inks.clone());
        let files = [("assembly.pdf", assembly), ("sheets.json", Some(described)), (PROFILE, profile)];
        for (name, bytes) in files.iter().filter_map(|(name, bytes)| Some((*name, bytes.as_deref()?))) {
            folder.write(name, bytes).map_err(PrintError::Output).map_err(at(place.join(name)))?;
        }
        tell(1);
        check_sheets_place(place)?;
        folder.commit().map_err(PrintError::Output).map_err(at(place.to_owned()))?;
        Ok(description)
    }

    /// Writes the files of one sheet side by side: its films are read, separated and laid out once for both.
    fn write_sheet(
        &self,
        folder: &WholeFolder,
        place: &Path,
        (index, sheet): (usize, &Sheet),
        formats: Formats,
        open: OpenFilm<'_>,
        separation: &dyn Separation,
    ) -> Result<(), PrintError> {
        let names = ["tif", "pdf"].map(|ending| sheet_name(index, ending));
        let [tiff_at, pdf_at] = names.each_ref().map(|name| {
            let path = place.join(name);
            move |error| placed(error, path.clone())
        });
        let [tiff_name, pdf_name] = names;
        let begin = |name: &str| Ok(BufWriter::new(folder.create(name)?));
        let top_level = separation.top_level();
        let begin_pdf = || PdfSheet::begin(begin(&pdf_name)?, (self, index, sheet), top_level);
        let mut pdf = formats.pdf.then(begin_pdf).transpose().map_err(&pdf_at)?;
        let rows = SheetRows::new(self, sheet, separation);
        let mut each = |take: TakeRows<'_>| {
            rows.each(open, &mut |batch| {
                if let Some(pdf) = &mut pdf {
                    pdf.rows(&rows, batch).map_err(&pdf_at)?;
                }
                take(batch)
            })
        };
        match formats.tiff {
            None => each(&mut |_| Ok(()))?,
            Some(form) => begin(&tiff_name)
                .and_then(|mut out| {
                    tiff::write(&mut out, (self, index, sheet), form, &rows, top_level.is_some(), each)?;
                    Ok(finish(out)?)
                })
                .map_err(&tiff_at)?,
        }
        pdf.map_or(Ok(()), |pdf| Ok(finish(pdf.end()?)?)).map_err(&pdf_at)
    }
}

/// Writes through to the disk: a full one shows here at the latest.
fn finish(out: BufWriter<File>) -> io::Result<()> {
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
}

/// The error with the place where it happened.
fn placed(error: PrintError, path: PathBuf) -> PrintError {
    match error {
        PrintError::Output(source) | PrintError::Tiff(::tiff::TiffError::IoError(source)) => {
            PrintError::Write { path, source }
        }
        PrintError::Tiff(error) => PrintError::Write { path, source: io::Error::other(error) },
        other => other,
    }
}

fn sheet_name(index: usize, ending: &str) -> String {
    format!("sheet-{:02}.{ending}", index + 1)
}

/// Looks whether sheets may be put at `place`: where nothing is, an empty folder, or other sheets.
///
/// # Errors
/// Fails when anything else is there, and where nothing can be written.
pub fn check_sheets_place(place: &Path) -> Result<(), PrintError> {
    if place.symlink_metadata().is_ok() {
        let empty = std::fs::read_dir(place).is_ok_and(|mut entries| entries.next().is_none());
        let described = std::fs::read_to_string(place.join("sheets.json")).ok();
        let described = described.and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok());
        let is_sheets =
            described.is_some_and(|value| value.get("format").is_some_and(|format| format == FORMAT));
        if !(empty || is_sheets) {
            return Err(PrintError::NotSheets(place.to_owned()));
        }
    }
    try_beside(place).map_err(|source| PrintError::Write { path: place.to_owned(), source })
}
