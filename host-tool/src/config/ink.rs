//! The keys of `[print]` about ink.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::de::DeValue;

use super::problem::Problem;
use super::reader::{Bounds, TableReader, as_number};
use crate::ink::{Curve, CurveFile, CurveFileError, Dots, Gamut, Halftone, Inks, Screens, YIELDS};
use crate::volume::CHANNELS;

/// How film values become ink.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InkSettings {
    /// Light of each ink at full coverage under the same ultraviolet light: red, green, blue.
    pub yields: [f64; CHANNELS],
    /// How much each ink's molecules quench each other, as [`Curve::quenching`] has it.
    pub quench: [f64; CHANNELS],
    /// The curves that were measured from a wedge, if they were.
    pub curves: Option<CurveFile>,
    /// The most that the coverages of a spot add up to.
    pub ink_limit: f64,
    /// What becomes of colours beyond the limit.
    pub gamut: GamutSetting,
    /// Who lays out the dots.
    pub halftone: HalftoneSetting,
    /// Levels of a dot, from none to full, where Vitrine lays them out.
    pub dot_levels: u16,
}

/// What becomes of colours beyond the ink limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GamutSetting {
    /// They are dimmed to the limit.
    Clip,
    /// They are dimmed ever more.
    Compress,
    /// All values are dimmed alike, so that white fits.
    Fit,
}

/// Who lays out the dots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HalftoneSetting {
    /// The printer, or its raster image processor: sheets hold coverages.
    None,
    /// A mask of blue noise.
    BlueNoise,
    /// Error diffusion.
    ErrorDiffusion,
}

impl HalftoneSetting {
    /// The way in which Vitrine lays out dots, if it does.
    pub fn method(self) -> Option<Halftone> {
        match self {
            Self::None => None,
            Self::BlueNoise => Some(Halftone::BlueNoise),
            Self::ErrorDiffusion => Some(Halftone::ErrorDiffusion),
        }
    }
}

impl InkSettings {
    /// The inks to separate for.
    ///
    /// # Errors
    /// When the measured curves are none, which those of a file that was read are not.
    pub fn inks(&self) -> Result<Inks, String> {
        let dots = match (self.halftone, self.dot_levels) {
            (HalftoneSetting::None, _) => Dots::Continuous,
            (_, 2) => Dots::Binary,
            (_, levels) => Dots::Levels(levels),
        };
        let curves = match &self.curves {
            Some(measured) => measured.curves()?,
            // Full dots are all alike: more of them quench no more.
            None if dots == Dots::Binary => [0, 1, 2].map(|_| Curve::linear()),
            None => self.quench.map(Curve::quenching),
        };
        let gamut = match self.gamut {
            GamutSetting::Clip => Gamut::Clip,
            GamutSetting::Compress => Gamut::Compress,
            GamutSetting::Fit => Gamut::Fit,
        };
        Ok(Inks { yields: self.yields, curves, limit: self.ink_limit, gamut, dots })
    }
}

impl InkSettings {
    /// What lays out the dots of a printer of this resolution, if Vitrine does.
    pub fn screens(&self, dpi_x: f64, dpi_y: f64) -> Option<Screens> {
        self.halftone.method().map(|method| Screens::new(method, self.dot_levels, dpi_x / dpi_y))
    }
}

/// The keys about ink in `[print]`; a file of curves is looked for in `folder`.
pub(super) fn ink(reader: &mut TableReader<'_>, folder: &Path) -> InkSettings {
    let range = |least, most, reason| Bounds { least, most, reason };
    let gamuts =
        [("clip", GamutSetting::Clip), ("compress", GamutSetting::Compress), ("fit", GamutSetting::Fit)];
    let halftones = [
        ("none", HalftoneSetting::None),
        ("blue-noise", HalftoneSetting::BlueNoise),
        ("error-diffusion", HalftoneSetting::ErrorDiffusion),
    ];
    let halftone = reader.choice("halftone", &halftones).unwrap_or(HalftoneSetting::None);
    let most = if halftone == HalftoneSetting::None { 3.0 } else { 1.0 };
    InkSettings {
        yields: three(reader, "yields", YIELDS, range(0.01, 1.0, "light at full coverage, red, green, blue")),
        quench: three(reader, "quench", [0.0; CHANNELS], range(0.0, 10.0, "0 is none")),
        curves: curves(reader, folder),
        ink_limit: reader.number(
            "ink_limit",
            1.0,
            range(0.05, most, "dots side by side cover at most 1; only a printer's own screens can lay more"),
        ),
        gamut: reader.choice("gamut", &gamuts).unwrap_or(GamutSetting::Clip),
        halftone,
        dot_levels: reader.whole("dot_levels", 2, range(2.0, 256.0, "2 are full or empty")) as u16,
    }
}

/// `curves = "curves.toml"` or `"none"`.
fn curves(reader: &mut TableReader<'_>, folder: &Path) -> Option<CurveFile> {
    let text = reader.text("curves").filter(|text| text.value != "none")?;
    match CurveFile::read(&folder.join(text.value)) {
        Ok(curves) => Some(curves),
        Err(error) => {
            let (code, help) = match &error {
                CurveFileError::Unreadable { source, .. } => (
                    "vitrine::ink::unreadable_curves",
                    format!("{source}; paths are relative to exhibit.toml"),
                ),
                CurveFileError::Invalid { .. } => (
                    "vitrine::ink::bad_curves",
                    "measure the wedge again with `vitrine calibrate`".to_owned(),
                ),
            };
            reader.report(Problem::new(code, text.span, error.to_string(), "this file", help));
            None
        }
    }
}

/// Three numbers, for the red, green and blue ink.
fn three(
    reader: &mut TableReader<'_>,
    key: &'static str,
    default: [f64; CHANNELS],
    bounds: Bounds,
) -> [f64; CHANNELS] {
    const WANTED: &str = "three numbers, for the red, green and blue ink";
    let Some(value) = reader.raw(key) else { return default };
    let numbers: Option<Vec<f64>> = match value.get_ref() {
        DeValue::Array(items) => items.iter().map(|item| as_number(item.get_ref())).collect(),
        _ => None,
    };
    let Some(Ok(numbers)) = numbers.map(<[f64; CHANNELS]>::try_from) else {
        reader.report_type(key, value, WANTED);
        return default;
    };
    for number in numbers {
        if reader.check_number(key, number, value.span(), bounds).is_none() {
            return default;
        }
    }
    numbers
}
