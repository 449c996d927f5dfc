//! `vitrine print`: the films on sheets, true to size.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use serde::Serialize;
use thiserror::Error;
use vitrine::build_folder::BuildFolder;
use vitrine::design;
use vitrine::print::{
    Arrangement, AsDesigned, Estimate, Formats, PrintJob, PrintRequest, Resolution, SheetsFile, UnknownPaper,
    check_sheets_place,
};

use super::output::Output;
use super::progress::Progress;

/// Write the films of a build as sheets to print: 16-bit TIFF and PDF, true to size, with marks and an assembly sheet.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine print build -o sheets
  vitrine print build -o sheets --dry-run
  vitrine print build -o sheets --paper A3 --format pdf
  vitrine print build -o sheets --paper \"roll 610\" --dpi 1440x720 --mirrored
  vitrine print build -o sheets --each --json | jq '.sheets[].files'

Resolution, paper and marks are those of [print] in exhibit.toml unless given here. Every dot shows the pixel in which its
centre lies: nothing is interpolated. A TIFF's sample is 65,535 less the ink, so that paper is white; a PDF has the inks as
three spot colours by their names. Print at 100 %, without fitting to the page and without colour management.

The folder is written whole or not at all; sheets that are there already are replaced, anything else is not.")]
pub(super) struct Print {
    /// The build folder.
    build: PathBuf,
    /// The folder to write the sheets to.
    #[arg(short, long, value_name = "SHEETS")]
    output: PathBuf,
    /// The files to write for each sheet.
    #[arg(long, default_value = "both", value_parser = ["tiff", "pdf", "both"])]
    format: String,
    /// The paper: A0 to A4, letter, legal, tabloid, "A4 landscape", or a roll by its width in mm: "roll 610".
    #[arg(long, value_name = "PAPER")]
    paper: Option<String>,
    /// Every film on a sheet of its own, as large as it needs.
    #[arg(long, conflicts_with = "paper")]
    each: bool,
    /// Dots per inch along the width and the height.
    #[arg(long, value_name = "XxY", value_parser = resolution)]
    dpi: Option<Resolution>,
    /// Mirror the sheets, to print on the back of the film.
    #[arg(long)]
    mirrored: bool,
    /// Tell what printing takes, and write nothing.
    #[arg(long)]
    dry_run: bool,
}

/// Why films cannot be printed as the command line says.
#[derive(Debug, Error, Diagnostic)]
enum PrintFailure {
    #[error(transparent)]
    #[diagnostic(code("vitrine::print::unknown_paper"))]
    UnknownPaper(#[from] UnknownPaper),
}

/// What was printed, or would be.
#[derive(Serialize)]
struct Printed {
    estimate: Estimate,
    #[serde(flatten)]
    sheets: SheetsFile,
}

impl Print {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let build = BuildFolder::open(&self.build)?;
        check_sheets_place(&self.output)?;
        let job = PrintJob::new(self.request(&build)?)?;
        let open = &|film| build.film_rows(film);
        let formats = Formats { tiff: self.format != "pdf", pdf: self.format != "tiff" };
        let full_ink = build.manifest().exhibit.print.ink_ml_m2;
        let estimate = Estimate::of(&job, formats, open, &AsDesigned, full_ink)?;
        if self.dry_run {
            let printed = Printed { sheets: job.description(formats), estimate };
            output.result(&printed, || printed.estimate.to_string());
            return Ok(());
        }
        output.note(&estimate.to_string());
        let progress = &mut Progress::new(output.is_json());
        let sheets = job.write(&self.output, formats, open, &AsDesigned, &mut |done, total| {
            progress.report(design::Progress::at("writing sheets", done, total));
        })?;
        let printed = Printed { estimate, sheets };
        output.result(&printed, || {
            let files = printed.sheets.sheets.iter().flat_map(|sheet| &sheet.files);
            let files = files.map(|file| self.output.join(file).display().to_string());
            files.collect::<Vec<_>>().join("\n")
        });
        output.note(&format!("Build the stack as {} says", self.output.join("assembly.pdf").display()));
        Ok(())
    }

    fn request(&self, build: &BuildFolder) -> Result<PrintRequest, Report> {
        let exhibit = &build.manifest().exhibit;
        let paper = self.paper.as_ref().unwrap_or(&exhibit.print.paper);
        let arrangement = match self.each {
            true => Arrangement::Each,
            false => Arrangement::On(paper.parse().map_err(PrintFailure::from)?),
        };
        let mut request = PrintRequest::new(exhibit, build.volume_blake3()?, arrangement);
        request.resolution = self.dpi.unwrap_or(request.resolution);
        request.mirrored |= self.mirrored;
        Ok(request)
    }
}

/// Dots per inch as `5760x1440`, or one number for both.
fn resolution(text: &str) -> Result<Resolution, String> {
    let (x, y) = text.split_once('x').unwrap_or((text, text));
    let number = |text: &str| {
        let number = text.trim().parse::<f64>().ok().filter(|number| (72.0..=50_000.0).contains(number));
        number.ok_or_else(|| "give 72 to 50000 dots per inch, as in 5760x1440".to_owned())
    };
    Ok(Resolution { dpi_x: number(x)?, dpi_y: number(y)? })
}
