//! `vitrine design` by strips: films too large for memory.

use std::path::Path;
use std::time::Instant;

use miette::{Diagnostic, Report};
use serde::Serialize;
use thiserror::Error;
use vitrine::build_folder::{self, GrowingFilms, Inputs, growing_place, strip_bytes};
use vitrine::config::{Exhibit, FrameSetting};
use vitrine::design::{self, DesignError, StripDesign};
use vitrine::volume::InkDepth;

use super::design::{DesignFailure, stoppable};
use super::output::Output;
use super::progress::Progress;

/// The memory that a design by strips keeps to, where exhibit.toml does not say.
const MOST_MIB: u32 = 2048;
/// The part of it that strips may use; the rest is for the program and the exhibit in small.
const STRIPS_PART: f64 = 0.75;
/// Pixels along the longer side of the exhibit in small.
const SMALL_PX: u32 = 512;

/// Why a design by strips failed.
#[derive(Debug, Error, Diagnostic)]
enum StripsFailure {
    #[error("`{what}` looks at whole films, and these are too large for memory: they are designed by strips")]
    #[diagnostic(
        code("vitrine::design::not_by_strips"),
        help("leave it out, or design fewer `pixels` or `films` in [stack]")
    )]
    WholeOnly { what: &'static str },
    #[error("cannot write the films in {}", kept.display())]
    #[diagnostic(
        code("vitrine::design::strips_write"),
        help("make room on the disk, or mend the folder's permissions, and run the same command to go on")
    )]
    Write { kept: std::path::PathBuf, source: std::io::Error },
}

/// What a design by strips takes, told beforehand.
#[derive(Debug, Serialize)]
pub(super) struct Foretold {
    strips: usize,
    rows: usize,
    /// Of the films' files, about.
    bytes: u64,
    /// On this computer, about.
    minutes: f64,
    /// Of each ink on all films, about.
    ink_ml: [f64; 3],
}

/// What comes of a design by strips.
pub(super) enum Outcome {
    Foretold(Foretold),
    Designed(Box<build_folder::Report>),
}

/// Whether the exhibit's films are too large for the memory that it may use.
pub(super) fn are_needed(exhibit: &Exhibit) -> bool {
    let settings = exhibit.settings(InkDepth::default());
    let needed = design::predicted_memory_mib_of(&exhibit.film_stack(), &settings, exhibit.views.len());
    let allowed = exhibit.design.memory_mib.map_or(f64::INFINITY, f64::from);
    needed > allowed || exhibit.is_too_large_for_memory()
}

/// Designs the exhibit.toml at `path` into the build folder `place`, or tells what that takes.
pub(super) fn design_by_strips(
    exhibit: &Exhibit,
    path: &Path,
    place: &Path,
    depth: InkDepth,
    dry_run: bool,
    output: Output,
) -> Result<Outcome, Report> {
    build_folder::check_place(place)?;
    refuse_what_needs_whole_films(exhibit)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let allowed_mib = exhibit.design.memory_mib.unwrap_or(MOST_MIB);
    let request = exhibit
        .strip_request(folder, depth, SMALL_PX, STRIPS_PART * f64::from(allowed_mib))
        .map_err(DesignFailure::from)?;
    let stack = exhibit.film_stack();
    let settings = exhibit.settings(depth);
    let needed_mib = design::predicted_memory_mib_of(&stack, &settings, exhibit.views.len()) as u64;
    let request = request.ok_or(DesignFailure::Memory { needed_mib, allowed_mib })?;
    let (stop, settings) = (request.small.stop.clone(), request.small.clone());
    let progress = &mut Progress::new(output.is_json());
    let (strips, small, (seconds, bytes)) = stoppable(path, &stop, || {
        let (strips, small) = StripDesign::prepare(request, &mut |step| progress.report(step))?;
        let takes = a_strip(&strips, depth)?;
        Ok((strips, small, takes))
    })?;
    let count = strips.strips() as f64;
    let (seconds, bytes) = (seconds * count, bytes * count);
    let foretold = foretell(exhibit, &strips, &small, seconds, bytes);
    if dry_run {
        return Ok(Outcome::Foretold(foretold));
    }
    output.note(&foretold.to_string());
    let kept = growing_place(place);
    let fail = |source| StripsFailure::Write { kept: kept.clone(), source };
    let fingerprint = fingerprint(exhibit, folder, depth, &foretold).map_err(fail)?;
    let size = (stack.films, stack.width_px, stack.height_px);
    let mut films = GrowingFilms::open(&kept, &fingerprint, size, depth).map_err(fail)?;
    if films.strips() > 0 {
        output.note(&format!("going on after {} strips", films.strips()));
    }
    for index in films.strips()..strips.strips() {
        progress.report(design::Progress::at("designing strips", index, strips.strips()));
        let strip =
            stoppable(path, &stop, || strips.strip(index, &mut |_| ())).map_err(|failure| match failure {
                DesignFailure::Stopped => Report::from(DesignFailure::Paused {
                    done: index,
                    strips: strips.strips(),
                    kept: kept.clone(),
                }),
                other => Report::from(other),
            })?;
        films.push(strip).map_err(fail)?;
    }
    progress.report(design::Progress::at("reading the films again", 0, 1));
    let inputs = Inputs::new(exhibit, folder, Some(path), &[]);
    let report = build_folder::write_grown(place, &inputs, exhibit, (&settings, &small), films)?;
    Ok(Outcome::Designed(Box::new(report)))
}

fn refuse_what_needs_whole_films(exhibit: &Exhibit) -> Result<(), StripsFailure> {
    let wholes = [
        (exhibit.object.is_some(), "[object]"),
        (exhibit.design.adapt, "adapt = true"),
        (exhibit.print.levels.is_some(), "levels"),
        (exhibit.viewer.frame == FrameSetting::Viewer, "frame = \"viewer\""),
    ];
    match wholes.iter().find(|whole| whole.0) {
        Some(&(_, what)) => Err(StripsFailure::WholeOnly { what }),
        None => Ok(()),
    }
}

/// The most strips that are looked at beforehand, and how many stand for each at least.
const MOST_SAMPLED: usize = 5;
const STRIPS_A_SAMPLE: usize = 8;

/// The seconds and the bytes of films that a strip takes, by some of them from top to bottom: what the exhibit in small
/// does beside it is done once, and its pictures are not as smooth.
fn a_strip(strips: &StripDesign, depth: InkDepth) -> Result<(f64, f64), DesignError> {
    let count = (strips.strips() / STRIPS_A_SAMPLE).clamp(1, MOST_SAMPLED);
    let (mut seconds, mut bytes) = (0.0, 0);
    for sample in 0..count {
        let begun = Instant::now();
        let strip = strips.strip((2 * sample + 1) * strips.strips() / (2 * count), &mut |_| ())?;
        bytes += strip.map(|films| strip_bytes(&films, depth)).sum::<usize>();
        seconds += begun.elapsed().as_secs_f64();
    }
    Ok((seconds / count as f64, bytes as f64 / count as f64))
}

/// Extrapolates from the exhibit in small; all strips take about `seconds` and `bytes`.
fn foretell(
    exhibit: &Exhibit,
    strips: &StripDesign,
    small: &design::Design,
    seconds: f64,
    bytes: f64,
) -> Foretold {
    let stack = exhibit.film_stack();
    let volume = &small.volume;
    let area_m2 = stack.width_mm * stack.height_mm() * 1e-6 * stack.films as f64;
    let mean = |channel: usize| {
        let values = volume.channel(channel);
        values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
    };
    Foretold {
        strips: strips.strips(),
        rows: strips.rows(),
        bytes: bytes as u64,
        minutes: seconds / 60.0,
        ink_ml: [0, 1, 2].map(|channel| mean(channel) * area_m2 * exhibit.print.ink_ml_m2),
    }
}

/// What a design depends on, so that films only go on as they began.
fn fingerprint(
    exhibit: &Exhibit,
    folder: &Path,
    depth: InkDepth,
    foretold: &Foretold,
) -> std::io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&serde_json::to_vec(exhibit)?);
    hasher.update(format!("{} {depth:?} {}", env!("CARGO_PKG_VERSION"), foretold.rows).as_bytes());
    for view in &exhibit.views {
        for picture in view.pattern.iter().chain(&view.mask) {
            hasher.update(blake3::hash(&std::fs::read(folder.join(picture))?).as_bytes());
        }
    }
    Ok(hasher.finalize().to_hex().to_string())
}

impl std::fmt::Display for Foretold {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [red, green, blue] = self.ink_ml;
        write!(
            out,
            "{} strips of {} rows: about {:.2} GB of films, {:.0} minutes, ink {red:.2} + {green:.2} + {blue:.2} ml",
            self.strips,
            self.rows,
            self.bytes as f64 / 1e9,
            self.minutes.ceil()
        )
    }
}
