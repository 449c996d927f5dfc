//! `vitrine design` by strips: films too large for memory.

use std::path::{Path, PathBuf};
use std::time::Instant;

use miette::{Diagnostic, Report};
use serde::Serialize;
use thiserror::Error;
use vitrine::build_folder::{self, Beside, GrowingFilms, Inputs, growing_place, strip_bytes};
use vitrine::config::{Exhibit, FrameSetting};
use vitrine::design::{self, DesignError, Stop, StripDesign};
use vitrine::object::{ModelError, ObjectStrips, Shown};
use vitrine::volume::{CHANNELS, InkDepth, Volume};

use super::design::{DesignFailure, Source, stoppable};
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
    Write { kept: PathBuf, source: std::io::Error },
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

/// Designs the exhibit of `source` into the build folder `place`, or tells what that takes.
pub(super) fn design_by_strips(
    source: &Source<'_>,
    place: &Path,
    depth: InkDepth,
    dry_run: bool,
    output: Output,
) -> Result<Outcome, Report> {
    let exhibit = source.exhibit;
    build_folder::check_place(place)?;
    refuse_what_needs_whole_films(exhibit)?;
    let allowed_mib = exhibit.design.memory_mib.unwrap_or(MOST_MIB);
    let strips_mib = STRIPS_PART * f64::from(allowed_mib);
    if exhibit.is_object_alone() {
        return lay_by_strips(source, place, depth, (strips_mib, allowed_mib), dry_run, output);
    }
    let request = exhibit
        .strip_request(source.folder, depth, SMALL_PX, strips_mib)
        .map_err(DesignFailure::from)?
        .ok_or_else(|| too_little_memory(exhibit, depth, allowed_mib))?;
    let (stop, settings) = (request.small.stop.clone(), request.small.clone());
    let progress = &mut Progress::new(output.is_json());
    let (strips, small, takes) = stoppable(source.name(), &stop, || {
        let (strips, small) = StripDesign::prepare(request, &mut |step| progress.report(step))?;
        let count = (strips.strips() / STRIPS_A_SAMPLE).clamp(1, MOST_SAMPLED);
        let takes = sampled((count, strips.strips()), depth, |index| strips.strip(index, &mut |_| ()))?;
        let values = small.volume.channel(0).len() as f64;
        // Some strips tell less of it than the whole in small.
        let ink = [0, 1, 2].map(|channel| sum(small.volume.channel(channel)) / values);
        Ok((strips, small, Takes { ink, ..takes }))
    })?;
    let foretold = foretell(exhibit, (strips.strips(), strips.rows()), &takes);
    if dry_run {
        return Ok(Outcome::Foretold(foretold));
    }
    let inputs = Inputs::new(exhibit, source.folder, source.exhibit_toml, &[]);
    let growth = Growth { source, place, depth, stop: &stop, foretold, output };
    let films = growth.grow(&inputs, progress, |index| strips.strip(index, &mut |_| ()).map(Ok))?;
    let report =
        build_folder::write_grown(place, &inputs, exhibit, (&settings, &small), Beside::default(), films)?;
    Ok(Outcome::Designed(Box::new(report)))
}

/// Lays the object of `source`, which is alone, into the build folder `place`, or tells what that takes, within
/// `strips_mib` of the `allowed_mib` of memory.
fn lay_by_strips(
    source: &Source<'_>,
    place: &Path,
    depth: InkDepth,
    (strips_mib, allowed_mib): (f64, u32),
    dry_run: bool,
    output: Output,
) -> Result<Outcome, Report> {
    let exhibit = source.exhibit;
    let progress = &mut Progress::new(output.is_json());
    let in_small = exhibit.in_small(SMALL_PX);
    let model = source.model();
    let strips = ObjectStrips::open(&model, exhibit, depth, strips_mib)?
        .ok_or_else(|| too_little_memory(exhibit, depth, allowed_mib))?;
    let sliced = Source { exhibit: &in_small, ..*source }.slice(progress)?;
    let object = sliced.as_ref().map(|sliced| Shown::new(&in_small, sliced));
    let request =
        in_small.design_request(source.folder, depth, object.as_ref()).map_err(DesignFailure::from)?;
    let volume = object.map_or_else(|| Volume::new(0, 0, 0), Shown::into_volume);
    let small = stoppable(source.name(), &request.stop, || {
        design::show(&request, volume, &mut |step| progress.report(step))
    })?;
    // An object may fill few strips, and laying one is quick.
    let count = strips.strips().min(MOST_SAMPLED);
    let takes = sampled((count, strips.strips()), depth, |index| strips.strip(index))?;
    let foretold = foretell(exhibit, (strips.strips(), strips.rows(0).len()), &takes);
    if dry_run {
        return Ok(Outcome::Foretold(foretold));
    }
    let inputs = Inputs::new(exhibit, source.folder, source.exhibit_toml, &strips.files());
    let growth = Growth { source, place, depth, stop: &request.stop, foretold, output };
    let films = growth.grow(&inputs, progress, |index| Ok(strips.strip(index)))?;
    let report = sliced.as_ref().map(|sliced| strips.report(sliced));
    let beside = Beside { object: report.as_ref(), ..Beside::default() };
    let report = build_folder::write_grown(place, &inputs, exhibit, (&request, &small), beside, films)?;
    Ok(Outcome::Designed(Box::new(report)))
}

/// Films that grow strip by strip at a place.
struct Growth<'a> {
    source: &'a Source<'a>,
    place: &'a Path,
    depth: InkDepth,
    stop: &'a Stop,
    foretold: Foretold,
    output: Output,
}

impl Growth<'_> {
    /// Tells what it takes and lets the films grow to their end, from where they were left.
    fn grow<F: Iterator<Item = Vec<Volume>>>(
        &self,
        inputs: &Inputs,
        progress: &mut Progress,
        strip: impl Fn(usize) -> Result<Result<F, ModelError>, DesignError>,
    ) -> Result<GrowingFilms, Report> {
        let Self { source, depth, foretold, output, .. } = self;
        output.note(&foretold.to_string());
        let (kept, stack) = (growing_place(self.place), source.exhibit.film_stack());
        let fail = |source| StripsFailure::Write { kept: kept.clone(), source };
        let fingerprint = fingerprint(source.exhibit, inputs, *depth, foretold).map_err(fail)?;
        let size = (stack.films, stack.width_px, stack.height_px);
        let mut films = GrowingFilms::open(&kept, &fingerprint, size, *depth).map_err(fail)?;
        if films.strips() > 0 {
            output.note(&format!("going on after {} strips", films.strips()));
        }
        for index in films.strips()..foretold.strips {
            progress.report(design::Progress::at("designing strips", index, foretold.strips));
            let strip = stoppable(source.name(), self.stop, || strip(index));
            let strip = strip.map_err(|failure| match failure {
                DesignFailure::Stopped => {
                    DesignFailure::Paused { done: index, strips: foretold.strips, kept: kept.clone() }
                }
                other => other,
            })?;
            films.push(strip?).map_err(fail)?;
        }
        progress.report(design::Progress::at("reading the films again", 0, 1));
        Ok(films)
    }
}

fn too_little_memory(exhibit: &Exhibit, depth: InkDepth, allowed_mib: u32) -> DesignFailure {
    let (stack, settings) = (exhibit.film_stack(), exhibit.settings(depth));
    let needed_mib = design::predicted_memory_mib_of(&stack, &settings, exhibit.views.len()) as u64;
    DesignFailure::Memory { needed_mib, allowed_mib }
}

fn refuse_what_needs_whole_films(exhibit: &Exhibit) -> Result<(), StripsFailure> {
    let has_pictures = !exhibit.is_object_alone();
    let wholes = [
        (exhibit.object.is_some() && has_pictures, "[object] with pictures around it"),
        (exhibit.design.adapt, "adapt = true"),
        (exhibit.print.levels.is_some() && has_pictures, "levels"),
        (exhibit.viewer.frame == FrameSetting::Viewer && has_pictures, "frame = \"viewer\""),
    ];
    match wholes.iter().find(|whole| whole.0) {
        Some(&(_, what)) => Err(StripsFailure::WholeOnly { what }),
        None => Ok(()),
    }
}

/// The most strips that are looked at beforehand, and how many that are solved stand for each at least.
const MOST_SAMPLED: usize = 5;
const STRIPS_A_SAMPLE: usize = 8;

/// What a strip takes.
#[derive(Clone, Copy, Default)]
struct Takes {
    seconds: f64,
    /// Of the films' files.
    bytes: f64,
    /// The mean of each ink.
    ink: [f64; CHANNELS],
}

/// What one of `strips` takes, by `count` of them from top to bottom: what the exhibit in small does beside it is done once,
/// and its pictures are not as smooth.
fn sampled<F: Iterator<Item = Vec<Volume>>, E>(
    (count, strips): (usize, usize),
    depth: InkDepth,
    strip: impl Fn(usize) -> Result<F, E>,
) -> Result<Takes, E> {
    let (mut takes, mut bytes) = (Takes::default(), 0);
    let (mut ink, mut values) = ([0.0; CHANNELS], 0);
    for sample in 0..count {
        let begun = Instant::now();
        for films in strip((2 * sample + 1) * strips / (2 * count))? {
            bytes += strip_bytes(&films, depth);
            for rows in &films {
                values += rows.channel(0).len();
                (0..CHANNELS).for_each(|channel| ink[channel] += sum(rows.channel(channel)));
            }
        }
        takes.seconds += begun.elapsed().as_secs_f64() / count as f64;
    }
    Ok(Takes { bytes: bytes as f64 / count as f64, ink: ink.map(|sum| sum / values as f64), ..takes })
}

fn sum(values: &[f32]) -> f64 {
    values.iter().map(|&value| f64::from(value)).sum()
}

/// What so many strips of so many rows take.
fn foretell(exhibit: &Exhibit, (strips, rows): (usize, usize), takes: &Takes) -> Foretold {
    let stack = exhibit.film_stack();
    let area_m2 = stack.width_mm * stack.height_mm() * 1e-6 * stack.films as f64;
    Foretold {
        strips,
        rows,
        bytes: (takes.bytes * strips as f64) as u64,
        minutes: takes.seconds * strips as f64 / 60.0,
        ink_ml: takes.ink.map(|mean| mean * area_m2 * exhibit.print.ink_ml_m2),
    }
}

/// What a design depends on, so that films only go on as they began.
fn fingerprint(
    exhibit: &Exhibit,
    inputs: &Inputs,
    depth: InkDepth,
    foretold: &Foretold,
) -> std::io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&serde_json::to_vec(exhibit)?);
    hasher.update(format!("{} {depth:?} {}", env!("CARGO_PKG_VERSION"), foretold.rows).as_bytes());
    for picture_or_model in inputs.shown() {
        let mut own = blake3::Hasher::new();
        own.update_reader(std::fs::File::open(picture_or_model)?)?;
        hasher.update(own.finalize().as_bytes());
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
