//! `vitrine turn`: an animation of what a viewer sees who walks past.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::{BuildFolder, LookRequest, Turn, turn, write_file};
use vitrine::optics::{Direction, LampPair};
use vitrine::plain;
use vitrine::projection::ViewerDistance;

use super::output::Output;
use super::view::{angle, level, number, png_file, positive};

/// Write an animation (APNG) of what a viewer sees who walks past a build.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine turn build -o turn.png
  vitrine turn build -o turn.png --from -45 --to 45 --steps 61 --fps 30
  vitrine turn build -o round.png --vertical 20 --once --ideal

Every frame has the same gain: without --gain, the one that brings the 99.5th percentile of the brightest frame to 1. \
Values are sRGB code values. Browsers and most viewers play the file; others show its first frame. There is no WebP: no \
encoder of animations is maintained in Rust alone.")]
pub(super) struct TurnCommand {
    /// The build folder.
    build: PathBuf,
    /// The first frame's degrees to the right of the stack's normal.
    #[arg(long, value_name = "DEGREES", default_value = "-30", allow_hyphen_values = true, value_parser = angle)]
    from: f64,
    /// The last frame's degrees to the right of the stack's normal.
    #[arg(long, value_name = "DEGREES", default_value = "30", allow_hyphen_values = true, value_parser = angle)]
    to: f64,
    /// Degrees above the stack's normal.
    #[arg(long, value_name = "DEGREES", default_value = "0", allow_hyphen_values = true, value_parser = angle)]
    vertical: f64,
    /// Frames from the first to the last angle.
    #[arg(long, value_name = "N", default_value = "31", value_parser = clap::value_parser!(u16).range(2..=1000))]
    steps: u16,
    /// Frames a second.
    #[arg(long, value_name = "FPS", default_value = "15", value_parser = clap::value_parser!(u16).range(1..=100))]
    fps: u16,
    /// Do not turn back again: begin anew after the last angle.
    #[arg(long)]
    once: bool,
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
    #[arg(long, value_name = "MM", conflicts_with = "ideal", value_parser = |text: &str| number(text, 1.0, 1e6))]
    distance: Option<f64>,
    /// What the light is multiplied by.
    #[arg(long, value_name = "GAIN", value_parser = positive)]
    gain: Option<f64>,
    /// Tell the frames and write nothing.
    #[arg(long)]
    dry_run: bool,
    /// The PNG file to write.
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(png_file))]
    output: PathBuf,
}

/// Why an animation is not written.
#[derive(Debug, Error, Diagnostic)]
enum TurnFailure {
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code("vitrine::turn::write"),
        help("look at the disk's free space and the folder's permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot encode the animation")]
    #[diagnostic(
        code("vitrine::turn::encode"),
        help("this is a fault of vitrine: please report it with the build")
    )]
    Encode(#[source] png::EncodingError),
    #[error("a viewer at {distance_mm} mm is not in front of the stack, which is {depth_mm} mm deep")]
    #[diagnostic(code("vitrine::turn::too_near"), help("give a larger --distance"))]
    TooNear { distance_mm: f64, depth_mm: f64 },
}

impl TurnCommand {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let build = BuildFolder::open(&self.build)?;
        let exhibit = &build.manifest().exhibit;
        let depth_mm = exhibit.film_stack().depth_mm();
        if let Some(distance_mm) = self.distance.filter(|distance_mm| *distance_mm <= depth_mm) {
            return Err(TurnFailure::TooNear { distance_mm, depth_mm }.into());
        }
        let frames = self.frames(LookRequest::new(exhibit, Direction::new(self.from, self.vertical)));
        let wanted = Turn { frames, fps: self.fps, gain: self.gain };
        let mut gain = self.gain;
        if !self.dry_run {
            let films = build.films()?;
            for name in &films.changed {
                output.note(&format!("note: {name} is not as the design wrote it"));
            }
            let turned = turn(exhibit, &films.volume, &wanted).map_err(TurnFailure::Encode)?;
            gain = Some(turned.gain);
            write_file(&self.output, &turned.png)
                .map_err(|source| TurnFailure::Write { path: self.output.clone(), source })?;
        }
        let result = serde_json::json!({
            "animation": self.output,
            "frames": wanted.frames.len(),
            "seconds": wanted.frames.len() as f64 / f64::from(self.fps),
            "from_deg": self.from,
            "to_deg": self.to,
            "gain": gain,
            "written": !self.dry_run,
        });
        output.result(&result, || {
            format!("{}  {} frames, {} a second", plain::path(&self.output), wanted.frames.len(), self.fps)
        });
        Ok(())
    }

    /// What is looked at in each frame: from the first angle to the last, and back unless that is not wanted.
    fn frames(&self, first: LookRequest) -> Vec<LookRequest> {
        let last = usize::from(self.steps - 1);
        let back = if self.once { 0..0 } else { 1..last };
        let frame = |step: usize| {
            let horizontal = self.from + (self.to - self.from) * step as f64 / last as f64;
            let distance = match self.distance {
                _ if self.ideal => ViewerDistance::Parallel,
                Some(distance_mm) => ViewerDistance::Millimetres(distance_mm),
                None => first.distance,
            };
            LookRequest {
                direction: Direction::new(horizontal, self.vertical),
                distance,
                lamps: LampPair::new(self.top, self.bottom),
                ideal: self.ideal,
                gain: self.gain,
            }
        };
        (0..=last).chain(back.rev()).map(frame).collect()
    }
}
