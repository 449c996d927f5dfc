//! `vitrine demo`: the whole chain on the bundled photographs.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::{self, BuildFolder};
use vitrine::config;
use vitrine::demo::{Moment, contact_sheet, walk};
use vitrine::plain;
use vitrine::starter;
use vitrine::volume::InkDepth;

use super::design::{Effort, FEW_STACKS, Source, design_exhibit, folder_of};
use super::output::Output;

/// A demo is watched while it runs: it stops a few tenths of a dB short of what `vitrine design` reaches.
const ITERATIONS: usize = 15;

/// Design the bundled photographs, start a simulated controller, upload, and let a viewer walk past.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine demo
  vitrine demo --open                 shows its page in the browser
  vitrine demo -o my-demo
  vitrine demo my-exhibit/exhibit.toml -o my-demo

It leaves a build folder with one more picture, contact-sheet.png: the patterns, and below them what is seen.")]
pub(super) struct Demo {
    /// An exhibit of your own instead of the bundled one.
    exhibit: Option<PathBuf>,
    /// The build folder to write.
    #[arg(short, long, value_name = "BUILD", default_value = "vitrine-demo")]
    output: PathBuf,
    /// Open the page report.html in the browser when all is done.
    #[arg(long)]
    open: bool,
    /// Read all that the design needs, tell what would be written, and write nothing.
    #[arg(long, conflicts_with = "open")]
    dry_run: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum DemoFailure {
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code(vitrine::demo::write),
        help("look at the disk's free space and the folder's permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot draw the contact sheet")]
    #[diagnostic(code(vitrine::demo::sheet), help("this is a fault of vitrine: please report it"))]
    Sheet(#[source] image::ImageError),
    #[error("{} is written, but no browser could be opened", path.display())]
    #[diagnostic(code(vitrine::demo::open), help("open it in a browser by hand"))]
    Open { path: PathBuf, source: std::io::Error },
}

impl Demo {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let bundled = tempfile::tempdir()
            .map_err(|source| DemoFailure::Write { path: std::env::temp_dir(), source })?;
        let exhibit = match self.exhibit {
            Some(exhibit) => exhibit,
            None => {
                let folder = bundled.path().join("exhibit");
                starter::write(&folder)?;
                folder.join("exhibit.toml")
            }
        };
        let sheet = self.output.join("contact-sheet.png");
        let page = self.output.join("report.html");
        if self.dry_run {
            let folder = folder_of(&exhibit);
            let source = Source { exhibit: &config::load(&exhibit)?, exhibit_toml: Some(&exhibit), folder };
            let foretold = source.foretell(&self.output, InkDepth::Eight)?;
            let told = serde_json::json!({ "build": self.output, "contact_sheet": sheet, "page": page, "takes": foretold });
            output.result(&told, || {
                format!("would write {} and {}; {foretold}", plain::path(&page), plain::path(&sheet))
            });
            return Ok(());
        }
        output.note("Designing the films and the lamp pairs");
        let effort = Effort { iterations: Some(ITERATIONS), stacks: FEW_STACKS };
        let report = design_exhibit(&exhibit, &self.output, InkDepth::Eight, effort, output)?;
        output.note(&report.summary());
        output.note("\nA simulated controller takes the plan, and a viewer walks from left to right");
        let build = BuildFolder::open(&self.output)?;
        let moments = walk(&build.plan_file()?, &mut |moment| output.note(&line(moment)))?;
        write_sheet(&sheet, &build, &report, &moments)?;
        let done = serde_json::json!({
            "build": self.output,
            "contact_sheet": sheet,
            "page": page,
            "report": report,
            "walk": moments,
        });
        output.result(&done, || plain::path(&sheet));
        output.note(&format!("Films, views and report are in {}", plain::path(&self.output)));
        if self.open {
            let opened = open::that_detached(&page);
            opened.map_err(|source| DemoFailure::Open { path: page.clone(), source })?;
            output.note(&format!("{} opens in the browser", plain::path(&page)));
        } else {
            output.note(&format!("Now look at {}: `vitrine demo --open` opens it", plain::path(&page)));
        }
        Ok(())
    }
}

fn write_sheet(
    path: &Path,
    build: &BuildFolder,
    report: &build_folder::Report,
    moments: &[Moment],
) -> Result<(), Report> {
    let mut png = Vec::new();
    contact_sheet(build, report, moments)?
        .write_to(&mut Cursor::new(&mut png), image::ImageFormat::Png)
        .map_err(DemoFailure::Sheet)?;
    build_folder::write_file(path, &png)
        .map_err(|source| DemoFailure::Write { path: path.to_owned(), source })?;
    Ok(())
}

/// One moment as a line: where the viewer is and is seen, the view, and a bar for each lamp.
fn line(moment: &Moment) -> String {
    let seen = moment.seen_deg.map_or_else(|| "  -  ".to_owned(), |degrees| format!("{degrees:+5.1}"));
    let dark = moment.dark.as_ref().map(|reason| format!("  dark: {reason}")).unwrap_or_default();
    format!(
        "viewer at {:+3.0} deg, seen at {seen} deg   {:<16} top {} {:>3.0} %   bottom {} {:>3.0} %{dark}",
        moment.viewer_deg,
        moment.view.as_deref().unwrap_or("-"),
        bar(moment.top),
        100.0 * moment.top,
        bar(moment.bottom),
        100.0 * moment.bottom,
    )
}

fn bar(level: f64) -> String {
    const LENGTH: usize = 10;
    let full = (level * LENGTH as f64).round() as usize;
    format!("[{}{}]", "#".repeat(full.min(LENGTH)), ".".repeat(LENGTH.saturating_sub(full)))
}
