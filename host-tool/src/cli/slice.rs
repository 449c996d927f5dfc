//! `vitrine slice`: from a 3D model to a build folder.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::check_place;
use vitrine::config::{
    self, CentreSetting, Exhibit, HiddenSetting, LARGEST_POINT_MM, MOST_VOXELS_ON_DISK, ObjectSettings,
    UNIT_MM, parse_colour,
};
use vitrine::object;
use vitrine::plain;
use vitrine::volume::InkDepth;

use super::design::{Effort, FEW_STACKS, Source, folder_of, told_written};
use super::output::Output;
use super::strips::{self, Outcome, design_by_strips};

/// Lay a 3D model into the films, and write them to a build folder.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine slice flowers.ply -o build
  vitrine slice scan.las -o build --turn-deg=-90,0,0 --films 20 --spacer-mm 1
  vitrine slice teapot.obj -o build --unit-mm 10 --colour '#ff8000' --hidden remove
  vitrine slice flowers.xyz -o build --exhibit exhibit.toml --dry-run
  vitrine view build --horizontal 30 -o right.png

It reads PLY, OBJ, glTF, GLB, STL, LAS, LAZ, and text of x y z r g b on each line. A model fills the stack unless --unit-mm says what its unit is. \
x is to the right, y up, z toward the viewer. What lies outside of the stack is counted and told.

Films too large for memory are laid by strips of rows, for each of which the model is read again. They grow in BUILD.unfinished; \
Ctrl-C or a loss of power costs one strip, and the same command goes on.

To fit them, texts and PLY clouds of up to 12.5 million points are kept in memory (330 MB), larger ones are read twice. \
With --unit-mm and --centre origin nothing is kept.

With --exhibit, everything else is as that exhibit.toml says; options given here count more.")]
pub(super) struct Slice {
    /// The model.
    model: PathBuf,
    /// The build folder to write.
    #[arg(short, long, value_name = "BUILD", required_unless_present = "dry_run")]
    output: Option<PathBuf>,
    /// Take the stack and everything else from this exhibit.toml.
    #[arg(long, value_name = "FILE")]
    exhibit: Option<PathBuf>,
    /// Read the model and tell what would become of it; write nothing.
    #[arg(long)]
    dry_run: bool,
    /// Bits of each ink value in the films.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
    /// Number of films.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=200))]
    films: Option<u32>,
    /// Width of the picture on a film.
    #[arg(long, value_name = "MM", value_parser = |text: &str| number(text, [1.0, 2000.0]))]
    width_mm: Option<f64>,
    /// Pixels of a film: one number, or WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = pixels)]
    pixels: Option<[u32; 2]>,
    /// Thickness of a spacer between two films.
    #[arg(long, value_name = "MM", value_parser = |text: &str| number(text, [0.0, 100.0]))]
    spacer_mm: Option<f64>,
    /// Millimetres that one unit of the model stands for, or `fit`.
    #[arg(long, value_name = "MM", value_parser = unit)]
    unit_mm: Option<Unit>,
    /// Turns about the x axis, then the y axis, then the z axis.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = turn)]
    turn_deg: Option<[f64; 3]>,
    /// What of the model stands in the middle of the stack.
    #[arg(long)]
    centre: Option<Centre>,
    /// The colour of everything, such as #ff8000, or `own`.
    #[arg(long, value_name = "COLOUR", value_parser = colour)]
    colour: Option<Colour>,
    /// Fill a closed mesh.
    #[arg(long)]
    filled: bool,
    /// What becomes of what is hidden behind something else in all views.
    #[arg(long)]
    hidden: Option<Hidden>,
    /// Let points between two films go to either by chance, the nearer the likelier.
    #[arg(long)]
    depth_dither: bool,
    /// Diameter of a point on its film; 0 for one pixel.
    #[arg(long, value_name = "MM", value_parser = |text: &str| number(text, [0.0, LARGEST_POINT_MM]))]
    point_mm: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Centre {
    /// The middle of the box around the turned model.
    Box,
    /// The model's own origin.
    Origin,
}

#[derive(Clone, Copy, ValueEnum)]
enum Hidden {
    /// It is printed, and shines through.
    Keep,
    /// It is left out.
    Remove,
}

/// A unit in mm; none to fit.
#[derive(Clone, Copy)]
struct Unit(Option<f64>);

/// A colour; none for the model's own.
#[derive(Clone, Copy)]
struct Colour(Option<[u8; 3]>);

/// Why a model is not sliced.
#[derive(Debug, Error, Diagnostic)]
enum SliceFailure {
    #[error("the films have {voxels} voxels, and can have {MOST_VOXELS_ON_DISK}")]
    #[diagnostic(code("vitrine::slice::too_many_voxels"), help("give fewer --films or --pixels"))]
    TooManyVoxels { voxels: u64 },
}

impl Slice {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let exhibit = self.exhibit()?;
        let folder = self.exhibit.as_deref().map_or(Path::new(""), folder_of);
        let source = Source { exhibit: &exhibit, exhibit_toml: self.exhibit.as_deref(), folder };
        let depth = if self.bits == "16" { InkDepth::Sixteen } else { InkDepth::Eight };
        let place = self.output.as_deref();
        if strips::are_needed(&exhibit) {
            let place = place.unwrap_or(Path::new("build"));
            match design_by_strips(&source, place, depth, self.dry_run, output)? {
                Outcome::Foretold(foretold) => output.result(&foretold, || foretold.to_string()),
                Outcome::Designed(report) => {
                    output.result(&report, || report.summary());
                    told_written(place, output);
                }
            }
            return Ok(());
        }
        let Some(place) = place.filter(|_| !self.dry_run) else {
            place.map_or(Ok(()), check_place)?;
            let settings = exhibit.object.clone().unwrap_or_default();
            let report =
                object::slice(&settings.model, &settings, &exhibit.film_stack(), &exhibit.sights())?.report;
            output.result(&report, || report.summary());
            return Ok(());
        };
        let report = source.design(place, depth, Effort { iterations: None, stacks: FEW_STACKS }, output)?;
        output.result(&report, || report.summary());
        told_written(place, output);
        Ok(())
    }

    /// The exhibit that is asked for.
    fn exhibit(&self) -> Result<Exhibit, Report> {
        // A file that is not there is told of when it is opened.
        let model = std::path::absolute(&self.model).unwrap_or_else(|_| self.model.clone());
        let mut exhibit = match &self.exhibit {
            Some(path) => config::load(path)?,
            None => {
                let mut exhibit = config::object_exhibit(ObjectSettings::default());
                let name = plain::path(self.model.file_stem().unwrap_or_default());
                exhibit.name = plain::shortened(&name, config::LONGEST_NAME).to_owned();
                exhibit
            }
        };
        let object = exhibit.object.get_or_insert_default();
        object.model = model;
        self.overrule(object);
        let stack = &mut exhibit.stack;
        stack.films = self.films.unwrap_or(stack.films);
        stack.width_mm = self.width_mm.unwrap_or(stack.width_mm);
        stack.pixels = self.pixels.unwrap_or(stack.pixels);
        stack.spacer_mm = self.spacer_mm.unwrap_or(stack.spacer_mm);
        let voxels =
            stack.pixels.iter().map(|side| u64::from(*side)).product::<u64>() * u64::from(stack.films);
        if voxels > MOST_VOXELS_ON_DISK {
            return Err(SliceFailure::TooManyVoxels { voxels }.into());
        }
        Ok(exhibit)
    }

    /// Lets the options count more than exhibit.toml.
    fn overrule(&self, object: &mut ObjectSettings) {
        if let Some(Unit(unit_mm)) = self.unit_mm {
            object.unit_mm = unit_mm;
        }
        if let Some(Colour(colour)) = self.colour {
            object.colour = colour;
        }
        object.turn_deg = self.turn_deg.unwrap_or(object.turn_deg);
        object.point_mm = self.point_mm.unwrap_or(object.point_mm);
        object.filled |= self.filled;
        object.depth_dither |= self.depth_dither;
        match self.centre {
            Some(Centre::Box) => object.centre = CentreSetting::Box,
            Some(Centre::Origin) => object.centre = CentreSetting::Origin,
            None => {}
        }
        match self.hidden {
            Some(Hidden::Keep) => object.hidden = HiddenSetting::Keep,
            Some(Hidden::Remove) => object.hidden = HiddenSetting::Remove,
            None => {}
        }
    }
}

fn number(text: &str, [least, most]: [f64; 2]) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| "give a number".to_owned())?;
    let inside = (least..=most).contains(&number);
    if inside { Ok(number) } else { Err(format!("give a number from {least} to {most}")) }
}

fn pixels(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, text));
    let side = |text: &str| match text.parse() {
        Ok(side @ 8..=65_536) => Ok(side),
        _ => Err("give 8 to 65536 pixels a side: 300, or 512x256".to_owned()),
    };
    Ok([side(width)?, side(height)?])
}

fn unit(text: &str) -> Result<Unit, String> {
    if text == "fit" { Ok(Unit(None)) } else { number(text, UNIT_MM).map(|unit| Unit(Some(unit))) }
}

fn turn(text: &str) -> Result<[f64; 3], String> {
    let angles: Result<Vec<f64>, String> =
        text.split(',').map(|angle| number(angle, [-360.0, 360.0])).collect();
    angles?.try_into().map_err(|_| "give three angles, such as -90,0,0".to_owned())
}

fn colour(text: &str) -> Result<Colour, String> {
    match (text, parse_colour(text)) {
        ("own", _) => Ok(Colour(None)),
        (_, Some(colour)) => Ok(Colour(Some(colour))),
        _ => Err("give a colour such as #ff8000, or own".to_owned()),
    }
}
