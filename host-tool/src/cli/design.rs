//! `vitrine design`: from exhibit.toml to a build folder.

use std::path::{Path, PathBuf};

use clap::Args;
use miette::{Diagnostic, Report};
use serde::Serialize;
use thiserror::Error;
use vitrine::build_folder::{self, Beside, Inputs, Interrupt};
use vitrine::config::{self, Exhibit};
use vitrine::design::{
    self, AsBuilt, DesignError, DesignRequest, HandErrors, SEED, STACKS, Stop, adapt, built_by_hand,
    predicted_memory_mib,
};
use vitrine::object::{self, Shown, Sliced};
use vitrine::optics::LampPair;
use vitrine::picture::PictureError;
use vitrine::plain;
use vitrine::volume::InkDepth;

use super::output::Output;
use super::progress::Progress;
use super::strips::{self, Outcome, design_by_strips};

/// Design the films and the lamp pairs, and write them to a build folder.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine design exhibit.toml -o build
  vitrine design exhibit.toml -o build --bits 16
  vitrine design exhibit.toml -o build --as-built
  vitrine design exhibit.toml -o build --dry-run
  vitrine design exhibit.toml -o build --strips --dry-run
  vitrine design exhibit.toml -o build --json | jq .mean_psnr_db

report.html tells what becomes of the views in human hands, from 6 random stacks, always the same; --as-built looks at \
16: with the errors of films, gaps and viewers that [design] expects (misplacement_um, spacing_um, \
direction_error_deg, distance_error_part: all standard deviations).

Films too large for memory (or for `memory_mib` in [design]) are designed by strips of rows. They grow in BUILD.unfinished; \
Ctrl-C or a loss of power costs one strip, and the same command goes on. Their lamps and report are those of the same \
exhibit in small.

The folder is written whole or not at all; a build that is there already is replaced, anything else is not. Ctrl-C \
stops the optimiser within an iteration and writes nothing; the exit code is 130.")]
pub(super) struct Design {
    /// The exhibit.
    exhibit: PathBuf,
    /// The build folder to write.
    #[arg(short, long, value_name = "BUILD")]
    output: PathBuf,
    /// Look at more random stacks, to tell better what becomes of the views in human hands.
    #[arg(long)]
    as_built: bool,
    /// Design some rows at a time, as is done anyway where the films are too large for memory.
    #[arg(long, conflicts_with = "as_built")]
    strips: bool,
    /// Read all that the design needs, tell what it takes, and write nothing: its memory, and with strips its minutes,
    /// bytes and ink, too.
    #[arg(long)]
    dry_run: bool,
    /// Bits of each ink value in the films.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
}

/// Why a design failed.
#[derive(Debug, Error, Diagnostic)]
pub(super) enum DesignFailure {
    #[error(transparent)]
    #[diagnostic(code("vitrine::design::picture"))]
    Picture(#[from] PictureError),
    #[error("cannot design {}: {source}", path.display())]
    #[diagnostic(code("vitrine::design::impossible"))]
    Impossible { path: PathBuf, source: DesignError },
    #[error(
        "this design needs about {needed_mib} MiB of memory, and `memory_mib` in [design] allows {allowed_mib}"
    )]
    #[diagnostic(
        code("vitrine::design::memory"),
        help(
            "raise `memory_mib` where the computer has more, or design fewer `pixels` or `films` in [stack]"
        )
    )]
    Memory { needed_mib: u64, allowed_mib: u32 },
    #[error("stopped after {done} of {strips} strips, which are kept in {}", kept.display())]
    #[diagnostic(
        code("vitrine::design::paused"),
        help("run the same command to go on; remove that folder to begin anew")
    )]
    Paused { done: usize, strips: usize, kept: PathBuf },
    #[error("stopped by an interrupt; nothing was written")]
    #[diagnostic(code("vitrine::design::stopped"))]
    Stopped,
}

/// Does `work` for the exhibit.toml at `path`; the next interrupt asks it to stop.
pub(super) fn stoppable<T>(
    path: &Path,
    stop: &Stop,
    work: impl FnOnce() -> Result<T, DesignError>,
) -> Result<T, DesignFailure> {
    let asked = stop.clone();
    let interrupt = Interrupt::does(move || asked.ask());
    let done = work();
    drop(interrupt);
    if stop.is_asked() {
        return Err(DesignFailure::Stopped);
    }
    done.map_err(|source| DesignFailure::Impossible { path: path.to_owned(), source })
}

impl Design {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let depth = if self.bits == "16" { InkDepth::Sixteen } else { InkDepth::Eight };
        let exhibit = config::load(&self.exhibit)?;
        let source =
            Source { exhibit: &exhibit, exhibit_toml: Some(&self.exhibit), folder: folder_of(&self.exhibit) };
        let report = if self.strips || strips::are_needed(&exhibit) {
            match design_by_strips(&source, &self.output, depth, self.dry_run, output)? {
                Outcome::Foretold(foretold) => {
                    output.result(&foretold, || foretold.to_string());
                    return Ok(());
                }
                Outcome::Designed(report) => *report,
            }
        } else if self.dry_run {
            let foretold = source.foretell(&self.output, depth)?;
            output.result(&foretold, || foretold.to_string());
            return Ok(());
        } else {
            let effort = Effort { iterations: None, stacks: if self.as_built { STACKS } else { FEW_STACKS } };
            design_exhibit(&self.exhibit, &self.output, depth, effort, output)?
        };
        output.result(&report, || report.summary());
        told_written(&self.output, output);
        Ok(())
    }
}

/// Says where a build is, and what can be done with it.
pub(super) fn told_written(place: &Path, output: Output) {
    output.note(&format!(
        "Written to {0}; look at {1}\nNext: vitrine upload {2}, and vitrine watch. Without a controller, start a simulated one first: \
         vitrine controller --visitor",
        plain::path(place),
        plain::path(place.join("report.html")),
        plain::word(place)
    ));
}

/// Random stacks that every design is looked at in: enough for a first word, at a fraction of the design's own time.
pub(super) const FEW_STACKS: usize = 6;

/// How much is done for a design.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    /// The most iterations of the optimiser, in place of exhibit.toml's.
    pub(super) iterations: Option<usize>,
    /// How many random stacks are looked at.
    pub(super) stacks: usize,
}

/// Designs the exhibit.toml at `path` into the build folder `place`.
pub(super) fn design_exhibit(
    path: &Path,
    place: &Path,
    depth: InkDepth,
    effort: Effort,
    output: Output,
) -> Result<build_folder::Report, Report> {
    let exhibit = config::load(path)?;
    let source = Source { exhibit: &exhibit, exhibit_toml: Some(path), folder: folder_of(path) };
    source.design(place, depth, effort, output)
}

/// The folder that the paths in the exhibit.toml at `path` are relative to.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// An exhibit to be designed.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) exhibit: &'a Exhibit,
    /// The file that says so, where there is one.
    pub(super) exhibit_toml: Option<&'a Path>,
    /// What its paths are relative to.
    pub(super) folder: &'a Path,
}

impl Source<'_> {
    /// Designs the exhibit into the build folder `place`.
    pub(super) fn design(
        &self,
        place: &Path,
        depth: InkDepth,
        effort: Effort,
        output: Output,
    ) -> Result<build_folder::Report, Report> {
        let exhibit = self.exhibit;
        build_folder::check_place(place)?;
        let progress = &mut Progress::new(output.is_json());
        let sliced = self.slice(progress)?;
        let object = sliced.as_ref().map(|sliced| Shown::new(exhibit, sliced));
        let mut request =
            exhibit.design_request(self.folder, depth, object.as_ref()).map_err(DesignFailure::from)?;
        if let Some(iterations) = effort.iterations {
            request.settings.iterations = iterations;
        }
        output.note(&format!("needs at most about {} MiB of memory", allowed_memory_mib(exhibit, &request)?));
        let similarity = exhibit.design.adapt.then_some(exhibit.design.adapt_similarity);
        let (adapted, designed) = stoppable(self.name(), &request.stop, || {
            let report = &mut |step| progress.report(step);
            let adapted = similarity.map(|similarity| adapt(&request, similarity, report)).transpose()?;
            let wanted = adapted.as_ref().map_or(&request, |adapted| &adapted.request);
            let designed = match object {
                Some(object) if exhibit.is_object_alone() => {
                    design::show(wanted, object.into_volume(), report)?
                }
                Some(object) => design::design_around(wanted, object.into_fixed().as_ref(), report)?,
                None => design::design(wanted, report)?,
            };
            Ok((adapted, designed))
        })?;
        let (wanted, given) = match &adapted {
            Some(adapted) => (&adapted.request, Some(&request)),
            None => (&request, None),
        };
        let as_built = look_as_built(wanted, &designed, effort.stacks, progress);
        let report = sliced.as_ref().map(|sliced| &sliced.report);
        let beside = Beside { given, as_built: Some(&as_built), object: report };
        let files = sliced.as_ref().map(|sliced| sliced.files.as_slice()).unwrap_or_default();
        let inputs = Inputs::new(exhibit, self.folder, self.exhibit_toml, files);
        Ok(build_folder::write(place, &inputs, exhibit, wanted, beside, designed)?)
    }

    /// Reads all that the design into the build folder `place` needs, and writes nothing.
    pub(super) fn foretell(&self, place: &Path, depth: InkDepth) -> Result<Foretold, Report> {
        build_folder::check_place(place)?;
        let sliced = self.slice(&mut Progress::new(true))?;
        let object = sliced.as_ref().map(|sliced| Shown::new(self.exhibit, sliced));
        let request =
            self.exhibit.design_request(self.folder, depth, object.as_ref()).map_err(DesignFailure::from)?;
        let memory_mib = allowed_memory_mib(self.exhibit, &request)?;
        let [width, height] = self.exhibit.stack.pixels;
        Ok(Foretold { films: self.exhibit.stack.films, pixels: [width, height], memory_mib })
    }

    /// What the exhibit is called where something is wrong with it.
    pub(super) fn name(&self) -> &Path {
        self.exhibit_toml.unwrap_or(Path::new("the exhibit"))
    }

    /// Where the object's model is.
    pub(super) fn model(&self) -> PathBuf {
        let object = self.exhibit.object.as_ref();
        self.folder.join(object.map_or(Path::new(""), |object| &object.model))
    }

    /// Lays the exhibit's object into the films, where there is one.
    pub(super) fn slice(&self, progress: &mut Progress) -> Result<Option<Sliced>, Report> {
        let Some(object) = &self.exhibit.object else { return Ok(None) };
        progress.report(design::Progress::at("slicing the object", 0, 1));
        let stack = self.exhibit.film_stack();
        Ok(Some(object::slice(&self.model(), object, &stack, &self.exhibit.sights())?))
    }
}

/// What a design in memory takes, told beforehand.
#[derive(Debug, Serialize)]
pub(super) struct Foretold {
    films: u32,
    pixels: [u32; 2],
    memory_mib: u64,
}

impl std::fmt::Display for Foretold {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { films, pixels: [width, height], memory_mib } = self;
        write!(
            out,
            "{films} films of {width} x {height} pixels: seconds or minutes, and at most about {memory_mib} MiB of memory"
        )
    }
}

/// The memory in MiB that the design takes at most.
fn allowed_memory_mib(exhibit: &Exhibit, request: &DesignRequest) -> Result<u64, DesignFailure> {
    let needed_mib = predicted_memory_mib(request).ceil() as u64;
    match exhibit.design.memory_mib {
        Some(allowed_mib) if u64::from(allowed_mib) < needed_mib => {
            Err(DesignFailure::Memory { needed_mib, allowed_mib })
        }
        _ => Ok(needed_mib),
    }
}

/// Looks at so many random stacks of the design.
fn look_as_built(
    request: &DesignRequest,
    designed: &design::Design,
    stacks: usize,
    progress: &mut Progress,
) -> AsBuilt {
    progress.report(design::Progress::at("looking at random stacks", 0, stacks));
    let pairs: Vec<LampPair> = designed.views.iter().map(|view| view.emphasis).collect();
    let errors = HandErrors::expected(request);
    built_by_hand(request, &designed.volume, &pairs, errors, stacks, SEED)
}
