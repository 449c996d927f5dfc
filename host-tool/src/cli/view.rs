//! `vitrine view`: what a viewer sees from any direction.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::{BuildFolder, LookRequest, look, look_png, write_file};
use vitrine::config::ToneSetting;
use vitrine::optics::{Direction, LampPair};
use vitrine::projection::ViewerDistance;

use super::output::Output;

/// Simulate what a viewer sees from a direction, from the films of a build.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine view build --horizontal 30 -o right.png
  vitrine view build --horizontal -30 --vertical 10 --top 1 --bottom 0 -o view.png
  vitrine view build --horizontal 30 --ideal --gain 2 -o view.png --json

Each pixel is the light divided by the sum of the films' weights, times the gain. Values are written as they are;
where the design is in linear light, the file says so (gamma 1), and --encode writes sRGB instead.")]
pub(super) struct View {
    /// The build folder.
    build: PathBuf,
    /// Degrees to the right of the stack's normal; negative is to the left.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = angle)]
    horizontal: f64,
    /// Degrees above the stack's normal; negative is below.
    #[arg(long, value_name = "DEGREES", default_value = "0", allow_hyphen_values = true, value_parser = angle)]
    vertical: f64,
    /// Level of the top lamp, on the viewer's side, 0 to 1.
    #[arg(long, value_name = "LEVEL", default_value = "1", value_parser = level)]
    top: f64,
    /// Level of the bottom lamp, 0 to 1.
    #[arg(long, value_name = "LEVEL", default_value = "1", value_parser = level)]
    bottom: f64,
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
    /// The PNG file to write.
    #[arg(short, long, value_name = "FILE")]
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
        let seen = look(exhibit, &films.volume, &self.request(exhibit.film_stack().depth_mm(), exhibit)?);
        let png = look_png(&seen, exhibit.design.tone, self.encode).map_err(ViewFailure::Encode)?;
        write_file(&self.output, &png)
            .map_err(|source| ViewFailure::Write { path: self.output.clone(), source })?;
        let light = exhibit.design.tone == ToneSetting::Linear && !self.encode;
        let result = serde_json::json!({
            "picture": self.output,
            "horizontal_deg": self.horizontal,
            "vertical_deg": self.vertical,
            "gain": seen.gain,
            "weight_sum": seen.weight_sum,
            "values": if light { "light" } else { "sRGB" },
            "changed_films": films.changed,
        });
        output.result(&result, || format!("{}  gain {:.4}", self.output.display(), seen.gain));
        Ok(())
    }

    fn request(&self, depth_mm: f64, exhibit: &vitrine::config::Exhibit) -> Result<LookRequest, ViewFailure> {
        let mut request = LookRequest::new(exhibit, Direction::new(self.horizontal, self.vertical));
        request.lamps = LampPair::new(self.top, self.bottom);
        if self.ideal {
            request.ideal = true;
            request.distance = ViewerDistance::Parallel;
        }
        request.gain = self.gain;
        if let Some(distance_mm) = self.distance {
            if !(distance_mm.is_finite() && distance_mm > depth_mm) {
                return Err(ViewFailure::TooNear { distance_mm, depth_mm });
            }
            request.distance = ViewerDistance::Millimetres(distance_mm);
        }
        Ok(request)
    }
}

fn angle(text: &str) -> Result<f64, String> {
    number(text, -80.0, 80.0)
}

fn level(text: &str) -> Result<f64, String> {
    number(text, 0.0, 1.0)
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, 1e-9, 1e9)
}

fn number(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "give a number".to_owned())?;
    if (least..=most).contains(&number) {
        Ok(number)
    } else {
        Err(format!("give a number from {least} to {most}"))
    }
}
