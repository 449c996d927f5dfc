//! The file of measured curves, as `vitrine calibrate` writes it and `curves` in `[print]` names it.
//!
//! ```toml
//! format = 1
//! measured_from = "wedge.jpg"
//!
//! [red]
//! coverage = [0.0, 0.1, 0.5, 1.0]   # parts of the spot, rising from 0
//! light = [0.0, 0.13, 0.6, 1.0]     # parts of the ink's full light, rising from 0
//! ```
//! with `[green]` and `[blue]` likewise.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::curve::{Curve, CurveError};
use crate::volume::CHANNELS;

/// The layout of the file that this version reads and writes.
const FORMAT: u32 = 1;

/// Measured curves of the three inks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveFile {
    format: u32,
    /// The photograph that the curves were measured from.
    pub measured_from: String,
    /// The red ink.
    pub red: InkCurve,
    /// The green ink.
    pub green: InkCurve,
    /// The blue ink.
    pub blue: InkCurve,
}

/// One ink's points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InkCurve {
    /// Coverages, 0..=1, rising from 0.
    pub coverage: Vec<f64>,
    /// Light as a part of the ink's full light, 0..=1, rising from 0.
    pub light: Vec<f64>,
}

/// Why a file of curves cannot be used.
#[derive(Debug, Error, Diagnostic)]
pub enum CurveFileError {
    /// It cannot be read.
    #[error("cannot read the curves {}", path.display())]
    #[diagnostic(
        code("vitrine::ink::unreadable_curves"),
        help("name a file that `vitrine calibrate` has written; paths are relative to exhibit.toml")
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Its text is not that of curves.
    #[error("{}: {cause}", path.display())]
    #[diagnostic(
        code("vitrine::ink::bad_curves"),
        help("measure the wedge again: vitrine calibrate PHOTO.jpg -o curves.toml")
    )]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
}

impl CurveFile {
    /// Puts the points of the three inks, red, green, blue, into a file's form.
    pub fn new(measured_from: String, inks: [InkCurve; CHANNELS]) -> Self {
        let [red, green, blue] = inks;
        Self { format: FORMAT, measured_from, red, green, blue }
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// When the file cannot be read or its points are no curves.
    pub fn read(path: &Path) -> Result<Self, CurveFileError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| CurveFileError::Unreadable { path: path.to_owned(), source })?;
        let invalid = |cause| CurveFileError::Invalid { path: path.to_owned(), cause };
        let file = Self::parse(&text).map_err(invalid)?;
        file.curves().map_err(invalid)?;
        Ok(file)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let file: Self = toml::from_str(text).map_err(|error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            format!("line {}: {}", before.matches('\n').count() + 1, error.message().trim())
        })?;
        if file.format == FORMAT {
            Ok(file)
        } else {
            Err(format!("its format is {}, this version reads {FORMAT}", file.format))
        }
    }

    /// The curves of the three inks: red, green, blue.
    ///
    /// # Errors
    /// Says which ink's points are no curve, and why.
    pub fn curves(&self) -> Result<[Curve; CHANNELS], String> {
        let curve = |name: &str, ink: &InkCurve| {
            if ink.coverage.len() != ink.light.len() {
                let (coverages, lights) = (ink.coverage.len(), ink.light.len());
                return Err(format!("[{name}] has {coverages} coverages and {lights} lights"));
            }
            let points: Vec<[f64; 2]> = ink.coverage.iter().zip(&ink.light).map(|(&c, &l)| [c, l]).collect();
            Curve::measured(&points).map_err(|error: CurveError| format!("[{name}] is no curve: {error}"))
        };
        Ok([curve("red", &self.red)?, curve("green", &self.green)?, curve("blue", &self.blue)?])
    }

    /// The file's text.
    ///
    /// # Errors
    /// When the points cannot be written as TOML, which no numbers cause.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> CurveFile {
        let ink = |bend: f64| InkCurve { coverage: vec![0.0, 0.5, 1.0], light: vec![0.0, bend, 1.0] };
        CurveFile::new("wedge.jpg".to_owned(), [ink(0.6), ink(0.7), ink(0.5)])
    }

    #[test]
    fn written_curves_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curves.toml");
        std::fs::write(&path, file().to_toml().unwrap()).unwrap();
        let curves = CurveFile::read(&path).unwrap().curves().unwrap();
        assert_eq!([0, 1, 2].map(|ink| curves[ink].light(0.5)), [0.6, 0.7, 0.5]);
    }

    #[test]
    fn wrong_files_say_what_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curves.toml");
        let told = |text: &str| {
            std::fs::write(&path, text).unwrap();
            CurveFile::read(&path).unwrap_err().to_string()
        };
        let text = file().to_toml().unwrap();
        assert!(told(&text.replace("0.7", "1.7")).contains("[green] is no curve: point 2"));
        assert!(told(&text.replace("format = 1", "format = 9")).contains("this version reads 1"));
        let unknown = told(&text.replacen("coverage", "cover", 1));
        assert!(unknown.contains("line 5: unknown field `cover`") && !unknown.contains('\n'), "{unknown}");
        assert!(told(&text.replacen("0.5, ", "", 1)).contains("[red] has 2 coverages and 3 lights"));
        assert!(matches!(
            CurveFile::read(&folder.path().join("none.toml")),
            Err(CurveFileError::Unreadable { .. })
        ));
    }
}
