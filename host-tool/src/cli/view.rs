//! `vitrine view`: what a viewer sees from any direction.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::{BuildFolder, LookRequest, look, look_png, write_file};
use vitrine::config::{ToneSetting, distance};
use vitrine::optics::{Direction, LampPair};
use vitrine::plain;
use vitrine::projection::ViewerDistance;

use super::output::Output;

/// Simulate what a viewer sees from a direction, from the films of a build.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine view build --horizontal 30 -o right.png
  vitrine view build --view cat -o cat.png
  vitrine view build --horizontal -30 --vertical 10 --top 1 --bottom 0 -o view.png
  vitrine view build --horizontal 30 --ideal --gain 2 -o view.png --json

Each pixel is the light divided by the sum of the films' weights, times the gain. Values are written as they are; \
where the design is in linear light, the file says so (gamma 1), and --encode writes sRGB instead.")]
pub(super) struct View {
    /// The build folder.
    build: PathBuf,
    /// Degrees to the right of the stack's normal; negative is to the left.
    #[arg(
        long,
        value_name = "DEGREES",
        allow_hyphen_values = true,
        value_parser = angle,
        required_unless_present = "view"
    )]
    horizontal: Option<f64>,
    /// Degrees above the stack's normal; negative is below. Straight ahead, if left out.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = angle)]
    vertical: Option<f64>,
    /// As the viewer of this view sees it: from its direction and distance, under its own lamp pair.
    #[arg(long, value_name = "ID", conflicts_with_all = ["horizontal", "vertical"])]
    view: Option<String>,
    /// Level of the top lamp, on the viewer's side, 0 to 1; full, if left out, or that of the view.
    #[arg(long, value_name = "LEVEL", value_parser = level)]
    top: Option<f64>,
    /// Level of the bottom lamp, 0 to 1; full, if left out, or that of the view.
    #[arg(long, value_name = "LEVEL", value_parser = level)]
    bottom: Option<f64>,
    /// Without absorption, seen from far away.
    #[arg(long)]
    ideal: bool,
    /// Seen from this many millimetres instead of the exhibit's distance.
    #[arg(long, value_name = "MM", conflicts_with = "ideal")]
    distance: Option<f64>,
    /// What the light is multiplied by; without it the 99.5th percentile becomes 1.
    #[arg(long, value_name = "GAIN", value_parser = positive)]
    gain: Option<f64>,
    /// Write light as sRGB code values.
    #[arg(long)]
    encode: bool,
    /// Look, and write nothing.
    #[arg(long)]
    dry_run: bool,
    /// The PNG file to write.
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(png_file))]
    output: PathBuf,
}

/// Why a view failed.
#[derive(Debug, Error, Diagnostic)]
enum ViewFailure {
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code("vitrine::view::write"),
        help("look at the disk's free space and the folder's permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot encode the picture")]
    #[diagnostic(
        code("vitrine::view::encode"),
        help("this is a fault of vitrine: please report it with the build")
    )]
    Encode(#[source] png::EncodingError),
    #[error("the build has no view {id}")]
    #[diagnostic(code("vitrine::view::no_such_view"), help("it has {views}"))]
    NoSuchView { id: String, views: String },
    #[error(transparent)]
    #[diagnostic(code("vitrine::view::plan"), help("design the exhibit again into this folder"))]
    Plan(#[from] vitrine_protocol::plan_file::PlanFileError),
    #[error("a viewer at {distance_mm} mm is not in front of the stack, which is {depth_mm} mm deep")]
    #[diagnostic(code("vitrine::view::too_near"), help("give a larger --distance"))]
    TooNear { distance_mm: f64, depth_mm: f64 },
}

impl View {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let build = BuildFolder::open(&self.build)?;
        let exhibit = &build.manifest().exhibit;
        let films = build.films()?;
        for name in &films.changed {
            output.note(&format!("note: {name} is not as the design wrote it"));
        }
        let request = self.request(&build)?;
        let seen = look(exhibit, &films.volume, &request);
        let png = look_png(&seen, exhibit.design.tone, self.encode).map_err(ViewFailure::Encode)?;
        if !self.dry_run {
            write_file(&self.output, &png)
                .map_err(|source| ViewFailure::Write { path: self.output.clone(), source })?;
        }
        let light = exhibit.design.tone == ToneSetting::Linear && !self.encode;
        let result = serde_json::json!({
            "picture": self.output,
            "horizontal_deg": request.direction.horizontal_deg,
            "vertical_deg": request.direction.vertical_deg,
            "top": request.lamps.top,
            "bottom": request.lamps.bottom,
            "gain": seen.gain,
            "weight_sum": seen.weight_sum,
            "values": if light { "light" } else { "sRGB" },
            "changed_films": films.changed,
            "written": !self.dry_run,
        });
        output.result(&result, || format!("{}  gain {:.4}", plain::path(&self.output), seen.gain));
        Ok(())
    }

    fn request(&self, build: &BuildFolder) -> Result<LookRequest, Report> {
        let exhibit = &build.manifest().exhibit;
        let direction = Direction::new(self.horizontal.unwrap_or(0.0), self.vertical.unwrap_or(0.0));
        let mut request = match &self.view {
            Some(id) => as_viewed(build, id)?,
            None => LookRequest::new(exhibit, direction),
        };
        request.lamps.top = self.top.unwrap_or(request.lamps.top);
        request.lamps.bottom = self.bottom.unwrap_or(request.lamps.bottom);
        if self.ideal {
            request.ideal = true;
            request.distance = ViewerDistance::Parallel;
        }
        request.gain = self.gain;
        if let Some(distance_mm) = self.distance {
            let depth_mm = exhibit.film_stack().depth_mm();
            if !(distance_mm.is_finite() && distance_mm > depth_mm) {
                return Err(ViewFailure::TooNear { distance_mm, depth_mm }.into());
            }
            request.distance = ViewerDistance::Millimetres(distance_mm);
        }
        Ok(request)
    }
}

/// Looks as the viewer of the view `id` does, under the pair that the plan has for it.
fn as_viewed(build: &BuildFolder, id: &str) -> Result<LookRequest, Report> {
    let exhibit = &build.manifest().exhibit;
    let plan = vitrine_protocol::plan_file::decode(&build.plan_file()?).map_err(ViewFailure::from)?;
    let views = exhibit.views.iter().zip(&plan.views);
    let Some((view, planned)) = views.into_iter().find(|(view, _)| view.id == id) else {
        let views = exhibit.views.iter().map(|view| view.id.as_str()).collect::<Vec<_>>().join(", ");
        return Err(ViewFailure::NoSuchView { id: id.to_owned(), views }.into());
    };
    let mut request = LookRequest::new(exhibit, Direction::new(view.horizontal_deg, view.vertical_deg));
    request.distance = distance(view.distance_mm);
    let level = |level: vitrine_exhibit::units::Level| f64::from(level.0) / f64::from(u16::MAX);
    request.lamps = LampPair::new(level(planned.emphasis.top), level(planned.emphasis.bottom));
    Ok(request)
}

/// The name of a file that will hold a PNG: with another ending it would promise what it is not.
pub(super) fn png_file(path: PathBuf) -> Result<PathBuf, &'static str> {
    let is_png = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("png") || ending.eq_ignore_ascii_case("apng"));
    if is_png { Ok(path) } else { Err("a PNG is written: give a name that ends in .png") }
}

pub(super) fn angle(text: &str) -> Result<f64, String> {
    number(text, -80.0, 80.0)
}

pub(super) fn level(text: &str) -> Result<f64, String> {
    number(text, 0.0, 1.0)
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text, 1e-9, 1e9)
}

pub(super) fn number(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "give a number".to_owned())?;
    if (least..=most).contains(&number) {
        Ok(number)
    } else {
        Err(format!("give a number from {least} to {most}"))
    }
}
