//! `vitrine experiment`: trying materials out.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use miette::{Diagnostic, Report};
use serde_json::{Value, json};
use thiserror::Error;
use vitrine::build_folder::write_file;
use vitrine::chart::overlay;
use vitrine::experiment::films::{
    FilmFit, FitError, MOST_FILMS, SIDES, Side, Transmittance, chart, draw, fit,
};
use vitrine::material::FILMS;
use vitrine::picture::{Photograph, PictureError};
use vitrine::plain;

use super::calibrate::gamma;
use super::output::Output;

/// Try materials out: simulate an experiment, and measure by photographs of it.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  vitrine experiment films -o films.png\n  vitrine experiment films --help"
)]
pub(super) struct Experiment {
    #[command(subcommand)]
    which: Which,
}

#[derive(Subcommand)]
enum Which {
    Films(Films),
}

/// Circles behind 0 to 25 films: how they fade, and what one film lets through.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine experiment films -o films.png                  the paper's Fig. 5: picture and table
  vitrine experiment films --tau-uv 0.9 -o films.png
  vitrine print --circles -o circles                     prints the circles
  vitrine experiment films --fit photo.jpg --side lamp   what one film of your own lets through
  vitrine experiment films --fit a.jpg b.jpg --side viewer --overlay found.png --json

Cut 25 strips of film, each 6 mm shorter than the last, and lay them over the middle band of the printed circles, flush on \
the right, so that column n lies behind n strips; the bands above and below stay bare. With the films on the lamp's side \
(--side lamp) the photograph gives tau_uv, with the films on the camera's side (--side viewer) tau_visible, with films, \
lamp and camera all on one side (--side both) their product. tau is found within 1 %.

A photograph's values become light by its ICC profile. One without is taken for sRGB, which is said; --gamma says otherwise.")]
struct Films {
    /// The picture to write, as PNG.
    #[arg(short, long, value_name = "FILE", required_unless_present = "fit", conflicts_with = "fit")]
    output: Option<PathBuf>,
    /// Part of the UV that one film lets through; polyester's, if left out.
    #[arg(long, value_name = "PART", value_parser = part, conflicts_with = "fit")]
    tau_uv: Option<f64>,
    /// Part of the visible light that one film lets through; polyester's, if left out.
    #[arg(long, value_name = "PART", value_parser = part, conflicts_with = "fit")]
    tau_visible: Option<f64>,
    /// Photographs of the printed circles with strips of your own film.
    #[arg(long, value_name = "PHOTO", num_args = 1.., requires = "side")]
    fit: Vec<PathBuf>,
    /// Where the films lie in the photographs.
    #[arg(long, requires = "fit")]
    side: Option<SideName>,
    /// Also write the first photograph with what was found in it, as PNG.
    #[arg(long, value_name = "FILE", requires = "fit")]
    overlay: Option<PathBuf>,
    /// Light is this power of the photographs' values, whatever their profiles say.
    #[arg(long, value_name = "GAMMA", value_parser = gamma, requires = "fit")]
    gamma: Option<f64>,
    /// Simulate or measure, and write nothing.
    #[arg(long)]
    dry_run: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum SideName {
    /// Between lamp and circles.
    Lamp,
    /// Between circles and camera.
    Viewer,
    /// Lamp and camera on the films' side.
    Both,
}

impl From<SideName> for Side {
    fn from(name: SideName) -> Self {
        match name {
            SideName::Lamp => Self::Lamp,
            SideName::Viewer => Self::Viewer,
            SideName::Both => Self::Both,
        }
    }
}

#[derive(Debug, Error, Diagnostic)]
enum ExperimentFailure {
    #[error(transparent)]
    #[diagnostic(
        code("vitrine::experiment::bad_photograph"),
        help("give photographs of the printed circles as JPEG, PNG, TIFF or WebP files")
    )]
    Photograph(#[from] PictureError),
    #[error("{}: {cause}", path.display())]
    #[diagnostic(forward(cause))]
    Fit { path: PathBuf, cause: FitError },
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code("vitrine::experiment::write"),
        help("look at the folder, the disk's free space and the permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot encode the picture")]
    #[diagnostic(
        code("vitrine::experiment::encode"),
        help("this is a fault of vitrine: please report it with the command")
    )]
    Encode(#[from] image::ImageError),
}

impl Experiment {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let Which::Films(films) = self.which;
        match films.side {
            Some(side) => Ok(films.measure(side.into(), output)?),
            None => Ok(films.simulate(output)?),
        }
    }
}

impl Films {
    fn simulate(self, output: Output) -> Result<(), ExperimentFailure> {
        let polyester = &FILMS[0];
        let films = Transmittance {
            tau_uv: self.tau_uv.unwrap_or(polyester.tau_uv),
            tau_visible: self.tau_visible.unwrap_or(polyester.tau_visible),
        };
        if let Some(path) = self.output.as_ref().filter(|_| !self.dry_run) {
            let mut png = std::io::Cursor::new(Vec::new());
            draw(films).write_to(&mut png, image::ImageFormat::Png)?;
            let write = |source| ExperimentFailure::Write { path: path.clone(), source };
            write_file(path, png.get_ref()).map_err(write)?;
        }
        let behind = |count: usize| SIDES.map(|side| films.behind(count, side));
        let rows: Vec<Value> = (0..=MOST_FILMS)
            .map(|count| {
                let [lamp, viewer, both] = behind(count);
                json!({ "films": count, "lamp": lamp, "viewer": viewer, "both": both })
            })
            .collect();
        let result = json!({
            "picture": self.output,
            "tau_uv": films.tau_uv,
            "tau_visible": films.tau_visible,
            "light": rows,
            "written": self.output.is_some() && !self.dry_run,
        });
        output.result(&result, || {
            let mut text =
                "films   on the lamp's side   on the viewer's side   both on their side".to_owned();
            for count in 0..=MOST_FILMS {
                let [lamp, viewer, both] = behind(count).map(|part| part * 100.0);
                text += &format!("\n{count:5} {lamp:18.1} % {viewer:20.1} % {both:18.1} %");
            }
            text
        });
        Ok(())
    }

    fn measure(self, side: Side, output: Output) -> Result<(), ExperimentFailure> {
        let (mut fits, mut tones): (Vec<FilmFit>, Vec<String>) = Default::default();
        for path in &self.fit {
            let photograph = Photograph::read(path, self.gamma)?;
            let fitted = fit(&photograph.light)
                .map_err(|cause| ExperimentFailure::Fit { path: path.clone(), cause })?;
            if let Some(drawn) = self.overlay.as_ref().filter(|_| fits.is_empty() && !self.dry_run) {
                overlay(&photograph.light, &chart(), &fitted.found).write_png(drawn)?;
            }
            output.note(&format!("{} is decoded by {}", plain::path(path), photograph.tones));
            tones.push(photograph.tones.to_string());
            fits.push(fitted);
        }
        let tau = fits.iter().map(|fitted| fitted.tau).sum::<f64>() / fits.len() as f64;
        let key = match side {
            Side::Lamp => "tau_uv",
            Side::Viewer => "tau_visible",
            Side::Both => "tau_uv times tau_visible",
        };
        let photographs = self.fit.iter().zip(&tones).zip(&fits).map(|((path, tones), fitted)| {
            json!({
                "photograph": path,
                "decoded_by": tones,
                "tau": fitted.tau,
                "tau_by_ink": fitted.tau_by_ink,
                "spread": fitted.spread,
                "measured": fitted.measured,
                "pixels_per_mm": fitted.found.pixels_per_mm,
            })
        });
        let result = json!({
            "side": side,
            "key": key,
            "tau": tau,
            "photographs": photographs.collect::<Vec<_>>(),
            "overlay": self.overlay,
            "written": self.overlay.is_some() && !self.dry_run,
        });
        output.result(&result, || {
            let mut text = format!("{key} = {tau:.3}");
            for (path, fitted) in self.fit.iter().zip(&fits) {
                let [red, green, blue] = fitted.tau_by_ink;
                text += &format!(
                    "\n{}: {:.3} (red {red:.3}, green {green:.3}, blue {blue:.3}), off by {:.1} %",
                    plain::path(path),
                    fitted.tau,
                    fitted.spread * 100.0
                );
            }
            text
        });
        Ok(())
    }
}

fn part(text: &str) -> Result<f64, String> {
    let part: f64 = text.parse().map_err(|_| "give a number".to_owned())?;
    if part > 0.0 && part <= 1.0 { Ok(part) } else { Err("give a number above 0 and up to 1".to_owned()) }
}
