//! `[object]`: the model that stands in the stack, and how it is laid into the films.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use toml::de::DeValue;

use super::exhibit::ViewSettings;
use super::problem::{Problem, Problems};
use super::reader::{Bounds, TableReader, as_number};

/// Where the three views stand that an object without `[[view]]` is shown from, as in the paper's Fig. 2c.
const OWN_VIEWS: [(&str, f64); 3] = [("left", -30.0), ("front", 0.0), ("right", 30.0)];

/// Millimetres that one unit of a model may stand for.
pub const UNIT_MM: [f64; 2] = [1e-9, 1e9];
/// The largest diameter of a point in mm.
pub const LARGEST_POINT_MM: f64 = 50.0;

/// `[object]`; `Default` is what exhibit.toml leaves out, but for the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectSettings {
    /// The model, relative to exhibit.toml: PLY, OBJ, glTF, GLB, STL, LAS, LAZ or text of x y z r g b.
    pub model: PathBuf,
    /// Millimetres that one unit of the model stands for; `None` lets the model fill the stack.
    pub unit_mm: Option<f64>,
    /// Turns about the x axis, then the y axis, then the z axis; positive turns y toward z, z toward x, x toward y.
    pub turn_deg: [f64; 3],
    /// What of the model stands in the middle of the stack.
    pub centre: CentreSetting,
    /// The colour of everything as sRGB code values; `None` keeps the model's own.
    pub colour: Option<[u8; 3]>,
    /// Whether a closed mesh is filled; else its surface alone is shown.
    pub filled: bool,
    /// What becomes of what is hidden behind something else in all views.
    pub hidden: HiddenSetting,
    /// Whether a point between two films goes to either by chance, the nearer the likelier.
    pub depth_dither: bool,
    /// Diameter of a point on its film; 0 for one pixel.
    pub point_mm: f64,
}

/// What of a model stands in the middle of the stack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CentreSetting {
    /// The middle of the box around the turned model.
    #[default]
    Box,
    /// The model's own origin.
    Origin,
}

/// What becomes of what is hidden.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HiddenSetting {
    /// It is printed, and shines through.
    #[default]
    Keep,
    /// It is left out.
    Remove,
}

/// Reads `[object]`; the model is looked for in `folder`.
pub(super) fn object(
    mut reader: TableReader<'_>,
    folder: &Path,
    problems: &mut Problems,
) -> Option<ObjectSettings> {
    let model = model(&mut reader, folder);
    let centre = reader.choice("centre", &[("box", CentreSetting::Box), ("origin", CentreSetting::Origin)]);
    let hidden = reader.choice("hidden", &[("keep", HiddenSetting::Keep), ("remove", HiddenSetting::Remove)]);
    let point = Bounds { least: 0.0, most: LARGEST_POINT_MM, reason: "0 is one pixel" };
    let settings = ObjectSettings {
        model: model.clone().unwrap_or_default(),
        unit_mm: unit_mm(&mut reader),
        turn_deg: turn_deg(&mut reader),
        centre: centre.unwrap_or_default(),
        colour: colour(&mut reader),
        filled: reader.truth("filled", false),
        hidden: hidden.unwrap_or_default(),
        depth_dither: reader.truth("depth_dither", false),
        point_mm: reader.number("point_mm", 0.0, point),
    };
    reader.finish(problems);
    model.map(|_| settings)
}

/// The views that an object is shown from where the file has none.
pub(super) fn own_views(distance_mm: Option<f64>) -> Vec<ViewSettings> {
    let view = |(id, horizontal_deg): (&str, f64)| ViewSettings {
        id: id.to_owned(),
        pattern: None,
        horizontal_deg,
        vertical_deg: 0.0,
        weight: 1.0,
        distance_mm,
        mask: None,
        lamp: None,
    };
    OWN_VIEWS.map(view).into()
}

/// The path of a model that is there.
fn model(reader: &mut TableReader<'_>, folder: &Path) -> Option<PathBuf> {
    let Some(text) = reader.text("model") else {
        if reader.raw("model").is_none() {
            reader.report(Problem::new(
                "vitrine::config::missing_key",
                reader.span(),
                "[object] has no `model`",
                "this table",
                "add `model = \"flowers.ply\"`",
            ));
        }
        return None;
    };
    let path = PathBuf::from(text.value);
    let found = folder.join(&path);
    if !found.is_file() {
        reader.report(Problem::new(
            "vitrine::config::bad_model",
            text.span,
            format!("there is no model {}", found.display()),
            "this model",
            "give the path of a model, relative to exhibit.toml",
        ));
        return None;
    }
    Some(path)
}

/// `unit_mm = "fit"` or a number.
fn unit_mm(reader: &mut TableReader<'_>) -> Option<f64> {
    const KEY: &str = "unit_mm";
    let [least, most] = UNIT_MM;
    let range = Bounds { least, most, reason: "1.0 for a model in mm, 1000.0 for one in m" };
    let value = reader.raw(KEY)?;
    if value.get_ref().as_str() == Some("fit") {
        return None;
    }
    match as_number(value.get_ref()) {
        Some(number) => reader.check_number(KEY, number, value.span(), range).map(|placed| placed.value),
        None => {
            reader.report_type(KEY, value, "a number, or \"fit\"");
            None
        }
    }
}

/// `turn_deg = [x, y, z]`.
fn turn_deg(reader: &mut TableReader<'_>) -> [f64; 3] {
    const KEY: &str = "turn_deg";
    const WANTED: &str = "three angles about the axes: [x, y, z]";
    let range = Bounds { least: -360.0, most: 360.0, reason: "" };
    let Some(value) = reader.raw(KEY) else { return [0.0; 3] };
    let angles: Option<Vec<f64>> = match value.get_ref() {
        DeValue::Array(items) => items.iter().map(|item| as_number(item.get_ref())).collect(),
        _ => None,
    };
    let Some(Ok(angles)) = angles.map(<[f64; 3]>::try_from) else {
        reader.report_type(KEY, value, WANTED);
        return [0.0; 3];
    };
    for angle in angles {
        if reader.check_number(KEY, angle, value.span(), range).is_none() {
            break;
        }
    }
    angles
}

/// `colour = "own"` or `"#ff8000"`.
fn colour(reader: &mut TableReader<'_>) -> Option<[u8; 3]> {
    let text = reader.text("colour")?;
    if text.value == "own" {
        return None;
    }
    let colour = parse_colour(text.value);
    if colour.is_none() {
        let message = format!("`colour` in [object] cannot be \"{}\"", text.value);
        let help = "give \"own\", or red, green and blue as two hexadecimal digits each: \"#ff8000\"";
        reader.report_value(text.span, message, help);
    }
    colour
}

/// The sRGB code values of a colour written as `#ff8000`.
pub fn parse_colour(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?;
    if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let number = u32::from_str_radix(digits, 16).ok()?;
    let [_, red, green, blue] = number.to_be_bytes();
    Some([red, green, blue])
}
