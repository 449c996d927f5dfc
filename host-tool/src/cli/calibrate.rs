//! `vitrine calibrate`: the inks' curves from a photograph of the printed wedge.

use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use serde_json::json;
use thiserror::Error;
use vitrine::build_folder::write_file;
use vitrine::chart::overlay;
use vitrine::ink::{Calibration, calibrate, wedge};
use vitrine::picture::{Photograph, PictureError};
use vitrine::plain;

use super::output::Output;

/// Measure how the inks glow from a photograph of the printed wedge, and write their curves.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine calibrate photo.jpg -o curves.toml  then `curves = \"curves.toml\"` in [print]
  vitrine print --wedge -o wedge              prints the wedge to photograph under ultraviolet
  vitrine calibrate photo.jpg -o curves.toml --overlay found.png --json
  vitrine calibrate photo.tif -o curves.toml --gamma 1  values in proportion to light

The photograph shows the whole wedge in an otherwise dark room, no patch overexposed, all brightness adjustments of the \
camera off. It may be tilted, turned, and unevenly lit; curves come out within 0.02 of full light.

Its values become light by the file's ICC profile. A file without one is taken for sRGB, which is said: a wrong gamma bends \
the curves (1.8 instead of 2.2 by 0.07), so give --gamma where the camera or its developer wrote another.")]
pub(super) struct Calibrate {
    /// The photograph: JPEG, PNG, TIFF or WebP.
    photograph: PathBuf,
    /// The file of curves to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Also write the photograph with what was found in it, as PNG.
    #[arg(long, value_name = "FILE")]
    overlay: Option<PathBuf>,
    /// Light is this power of the photograph's values, whatever its profile says.
    #[arg(long, value_name = "GAMMA", value_parser = gamma)]
    gamma: Option<f64>,
    /// Measure, and write nothing.
    #[arg(long)]
    dry_run: bool,
}

/// A photograph's gamma.
pub(super) fn gamma(text: &str) -> Result<f64, String> {
    let gamma = text.parse().ok().filter(|gamma| (0.5..=4.0).contains(gamma));
    gamma.ok_or_else(|| "give a number from 0.5 to 4, as 2.2, or 1 where values are light".to_owned())
}

#[derive(Debug, Error, Diagnostic)]
enum CalibrateFailure {
    #[error(transparent)]
    #[diagnostic(
        code("vitrine::ink::bad_photograph"),
        help("give the photograph of the wedge as a JPEG, PNG, TIFF or WebP file")
    )]
    Photograph(#[from] PictureError),
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code("vitrine::ink::write"),
        help("look at the folder, the disk's free space and the permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot put the curves into TOML")]
    #[diagnostic(
        code("vitrine::ink::encode"),
        help("this is a fault of vitrine: please report it with the photograph")
    )]
    Encode(#[from] toml::ser::Error),
}

impl Calibrate {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let Photograph { light, tones } =
            Photograph::read(&self.photograph, self.gamma).map_err(CalibrateFailure::from)?;
        let name = self.photograph.file_name().unwrap_or(self.photograph.as_os_str());
        let calibration = calibrate(&light, &name.to_string_lossy())?;
        if !self.dry_run {
            let text = calibration.file.to_toml().map_err(CalibrateFailure::from)?;
            let write = |source| CalibrateFailure::Write { path: self.output.clone(), source };
            write_file(&self.output, text.as_bytes()).map_err(write)?;
            if let Some(path) = &self.overlay {
                let drawn = overlay(&light, &wedge(), &calibration.found);
                drawn.write_png(path).map_err(CalibrateFailure::from)?;
            }
        }
        let result = json!({
            "curves": self.output,
            "overlay": self.overlay,
            "written": !self.dry_run,
            "pixels_per_mm": calibration.found.pixels_per_mm,
            "spread": calibration.spread,
            "brightest": calibration.brightest,
            "decoded_by": tones.to_string(),
            "measured": calibration.file,
        });
        output.note(&format!("The photograph is decoded by {tones}"));
        output.result(&result, || self.text(&calibration));
        Ok(())
    }

    fn text(&self, calibration: &Calibration) -> String {
        let mut text = if self.dry_run { "nothing written".to_owned() } else { plain::path(&self.output) };
        text += &format!("  {:.1} pixels a mm\n", calibration.found.pixels_per_mm);
        text += "ink    light of half coverage   at its most from   equal patches differ by";
        let file = &calibration.file;
        for (ink, (name, curve)) in
            [("red", &file.red), ("green", &file.green), ("blue", &file.blue)].into_iter().enumerate()
        {
            let half = curve.coverage.iter().zip(&curve.light).min_by(|a, b| {
                let off = |coverage: &f64| (coverage - 0.5).abs();
                off(a.0).total_cmp(&off(b.0))
            });
            let fullest = curve.coverage.last().copied().unwrap_or(1.0);
            text += &format!(
                "\n{name:5}  {:21.3}   {fullest:16.2}   {:21.1} %",
                half.map_or(0.0, |half| *half.1),
                calibration.spread[ink] * 100.0
            );
        }
        text
    }
}
