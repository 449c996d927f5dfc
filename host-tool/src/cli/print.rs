//! `vitrine print`: the films on sheets, true to size.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use serde::Serialize;
use thiserror::Error;
use vitrine::build_folder::BuildFolder;
use vitrine::config::{Exhibit, HalftoneSetting, PrintSettings};
use vitrine::design;
use vitrine::experiment::films;
use vitrine::ink::{CurveFile, Separator, SheetInks, wedge};
use vitrine::plain;
use vitrine::print::{
    Arrangement, AsDesigned, ChartFilm, Estimate, Formats, OpenFilm, PrintJob, PrintRequest, Resolution,
    Separation, SheetsFile, TiffForm, UnknownPaper, check_sheets_place,
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
  vitrine print build -o again --films 3,7           those that were spoilt
  vitrine print build -o sheets --halftone blue-noise --curves curves.toml
  vitrine print build -o sheets --icc             for a raster image processor that wants a profile
  vitrine print --wedge -o wedge --dpi 1440x720   a chart to measure inks by: `vitrine calibrate`
  vitrine print --circles -o circles              a chart to measure films by: `vitrine experiment`

Resolution, paper and marks are those of [print] in exhibit.toml unless given here. Every dot shows the pixel in which its \
centre lies: nothing is interpolated. A TIFF's sample is 65,535 less the ink, so that paper is white; a PDF has the inks as \
three spot colours by their names. Print at 100 %, without fitting to the page and without colour management.

Film values become coverages of the three inks as [print] says: the stronger inks are thinned so that equal values glow \
equally, and measured curves are undone. --as-designed prints the values themselves, for a printer that does all this. \
With a halftone no dot carries two inks.

Films are laid out to take the fewest sheets, and of a roll the least length: where that saves any, all lie a quarter turn \
clockwise, which sheets.json says as `turned`.

The inks' numbers are final: a raster image processor has to lay them as they are, without colour management. One that \
wants to know what they mean, for a preview, gets it by --icc: an ICC profile of the light that coverages give, of the RGB \
samples in a TIFF, and of three named inks in the output intent of a PDF and in inks.icc.

The folder is written whole or not at all; sheets that are there already are replaced, anything else is not.")]
pub(super) struct Print {
    /// The build folder; with a chart, whose [print] is to hold for it.
    #[arg(required_unless_present_any = ["wedge", "circles"])]
    build: Option<PathBuf>,
    /// Print the wedge: patches of each ink, to measure them by.
    #[arg(long, conflicts_with = "circles")]
    wedge: bool,
    /// Print circles of each ink, to measure films by.
    #[arg(long)]
    circles: bool,
    /// The folder to write the sheets to.
    #[arg(short, long, value_name = "SHEETS")]
    output: PathBuf,
    /// The files to write for each sheet; a TIFF that may grow beyond 2 GiB is a BigTIFF, with big-tiff any is.
    #[arg(long, default_value = "both", value_parser = ["tiff", "big-tiff", "pdf", "both"])]
    format: String,
    /// The paper: A0 to A4, letter, legal, tabloid, "A4 landscape", or a roll by its width in mm: "roll 610".
    #[arg(long, value_name = "PAPER")]
    paper: Option<String>,
    /// Every film on a sheet of its own, as large as it needs.
    #[arg(long, conflicts_with = "paper")]
    each: bool,
    /// Print these films only, by their numbers, and no assembly sheet: those that were spoilt, say.
    #[arg(long, value_name = "N,N", value_delimiter = ',', conflicts_with_all = ["wedge", "circles"])]
    films: Vec<usize>,
    /// Dots per inch along the width and the height.
    #[arg(long, value_name = "XxY", value_parser = resolution)]
    dpi: Option<Resolution>,
    /// Mirror the sheets, to print on the back of the film.
    #[arg(long)]
    mirrored: bool,
    /// The inks' measured curves, as `vitrine calibrate` has written them.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["as_designed", "wedge", "circles"])]
    curves: Option<PathBuf>,
    /// Who lays out the dots: the printer, or Vitrine in one of two ways.
    #[arg(long, value_name = "WAY", conflicts_with = "as_designed")]
    halftone: Option<Way>,
    /// Print film values as they are: inks are not parted, dots not laid out.
    #[arg(long)]
    as_designed: bool,
    /// Put an ICC profile of the inks into the sheets, and beside them as inks.icc.
    #[arg(long, conflicts_with_all = ["as_designed", "wedge", "circles"])]
    icc: bool,
    /// Tell what printing takes, and write nothing.
    #[arg(long)]
    dry_run: bool,
}

/// Who lays out the dots.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Way {
    /// The printer, or its raster image processor.
    None,
    /// A mask of blue noise.
    BlueNoise,
    /// Error diffusion.
    ErrorDiffusion,
}

impl From<Way> for HalftoneSetting {
    fn from(way: Way) -> Self {
        match way {
            Way::None => Self::None,
            Way::BlueNoise => Self::BlueNoise,
            Way::ErrorDiffusion => Self::ErrorDiffusion,
        }
    }
}

/// Why films cannot be printed as the command line says.
#[derive(Debug, Error, Diagnostic)]
enum PrintFailure {
    #[error(transparent)]
    #[diagnostic(code("vitrine::print::unknown_paper"))]
    UnknownPaper(#[from] UnknownPaper),
    #[error("the build's curves are no curves: {0}")]
    #[diagnostic(
        code("vitrine::ink::bad_curves"),
        help("give measured ones with --curves, or design the exhibit again")
    )]
    Curves(String),
    #[error("an ink limit of {0} cannot be kept by dots side by side, which cover at most 1")]
    #[diagnostic(
        code("vitrine::print::limit"),
        help("lower `ink_limit` in [print], or leave --halftone out")
    )]
    Limit(f64),
    #[error("there is no film {film}: the build has films 1 to {films}")]
    #[diagnostic(code("vitrine::print::no_film"), help("name films by their numbers, as in --films 3,7"))]
    NoFilm { film: usize, films: usize },
    #[error("the chart cannot be drawn")]
    #[diagnostic(
        code("vitrine::print::chart"),
        help("look at the free space and the permissions of the folder for temporary files")
    )]
    Chart(#[from] std::io::Error),
}

/// What was printed, or would be.
#[derive(Serialize)]
struct Printed {
    estimate: Estimate,
    /// The part of the films' pixels that the ink limit dims.
    dimmed: f64,
    #[serde(flatten)]
    sheets: SheetsFile,
}

impl Print {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        check_sheets_place(&self.output)?;
        let build = self.build.as_deref().map(BuildFolder::open).transpose()?;
        let settings = build.as_ref().map(|build| build.manifest().exhibit.print.clone()).unwrap_or_default();
        let (name, chart) = match (self.wedge, self.circles) {
            (true, _) => ("Ink wedge", wedge()),
            (_, true) => ("Circles behind films", films::chart()),
            _ => {
                let Some(build) = &build else { return Ok(()) };
                let request = self.request(&build.manifest().exhibit, build.volume_blake3()?)?;
                return self.print(request, &|film| build.film_rows(film), &settings, output);
            }
        };
        let film = ChartFilm::new(&chart).map_err(PrintFailure::from)?;
        let exhibit = name.to_owned();
        let request = PrintRequest {
            films: vec![0],
            stack: film.stack().clone(),
            exhibit,
            volume_blake3: film.blake3(),
            inks: settings.inks.clone(),
            resolution: self.dpi.unwrap_or(Resolution { dpi_x: settings.dpi_x, dpi_y: settings.dpi_y }),
            arrangement: self.arrangement(&settings)?,
            marks: false,
            mirrored: settings.mirrored || self.mirrored,
            pin_mm: settings.pin_mm,
            profiles: None,
        };
        self.print(request, &|_| film.rows(), &settings, output)
    }

    fn print(
        &self,
        mut request: PrintRequest,
        open: OpenFilm<'_>,
        settings: &PrintSettings,
        output: Output,
    ) -> Result<(), Report> {
        let inks = self.inks(settings, request.resolution)?;
        let separation: &dyn Separation = if self.as_designed { &AsDesigned } else { &inks };
        request.profiles = self.icc.then(|| inks.profiles(&request.inks)).flatten();
        let job = PrintJob::new(request)?;
        let (tiff, pdf) = match self.format.as_str() {
            "tiff" => (Some(TiffForm::Fitting), false),
            "big-tiff" => (Some(TiffForm::Big), false),
            "pdf" => (None, true),
            _ => (Some(TiffForm::Fitting), true),
        };
        let formats = Formats { tiff, pdf };
        let estimate = Estimate::of(&job, formats, open, separation, settings.ink_ml_m2)?;
        if inks.dimmed() > 0.0 {
            let percent = inks.dimmed() * 100.0;
            output.note(&format!("the ink limit dims {percent:.1} % of the films' pixels"));
        }
        if self.dry_run {
            let printed = Printed { sheets: job.description(formats), estimate, dimmed: inks.dimmed() };
            output.result(&printed, || printed.estimate.to_string());
            return Ok(());
        }
        output.note(&estimate.to_string());
        let progress = &mut Progress::new(output.is_json());
        let sheets = job.write(&self.output, formats, open, separation, &mut |done, total| {
            progress.report(design::Progress::at("writing sheets", done, total));
        })?;
        let printed = Printed { estimate, dimmed: inks.dimmed(), sheets };
        output.result(&printed, || {
            let files = printed.sheets.sheets.iter().flat_map(|sheet| &sheet.files);
            let files = files.map(|file| plain::path(self.output.join(file)));
            files.collect::<Vec<_>>().join("\n")
        });
        if !(self.wedge || self.circles) && self.films.is_empty() {
            output
                .note(&format!("Build the stack as {} says", plain::path(self.output.join("assembly.pdf"))));
        }
        Ok(())
    }

    /// How values become ink: a chart's are coverages already.
    fn inks(&self, settings: &PrintSettings, resolution: Resolution) -> Result<SheetInks, Report> {
        let mut ink = settings.ink.clone();
        if let Some(way) = self.halftone {
            ink.halftone = way.into();
        }
        if ink.halftone != HalftoneSetting::None && ink.ink_limit > 1.0 {
            return Err(PrintFailure::Limit(ink.ink_limit).into());
        }
        if let Some(path) = &self.curves {
            ink.curves = Some(CurveFile::read(path)?);
        }
        let screens = ink.screens(resolution.dpi_x, resolution.dpi_y);
        if self.wedge || self.circles {
            return Ok(SheetInks::new(None, screens));
        }
        let inks = ink.inks().map_err(PrintFailure::Curves)?;
        Ok(SheetInks::new(Some(Separator::new(&inks)), screens))
    }

    fn request(&self, exhibit: &Exhibit, volume_blake3: String) -> Result<PrintRequest, Report> {
        let mut request = PrintRequest::new(exhibit, volume_blake3, self.arrangement(&exhibit.print)?);
        request.resolution = self.dpi.unwrap_or(request.resolution);
        request.mirrored |= self.mirrored;
        if !self.films.is_empty() {
            let films = request.stack.films;
            if let Some(&film) = self.films.iter().find(|&&film| !(1..=films).contains(&film)) {
                return Err(PrintFailure::NoFilm { film, films }.into());
            }
            request.films.retain(|film| self.films.contains(&(film + 1)));
        }
        Ok(request)
    }

    fn arrangement(&self, settings: &PrintSettings) -> Result<Arrangement, Report> {
        let paper = self.paper.as_ref().unwrap_or(&settings.paper);
        Ok(match self.each {
            true => Arrangement::Each,
            false => Arrangement::On(paper.parse().map_err(PrintFailure::from)?),
        })
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
