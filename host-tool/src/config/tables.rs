//! The tables of exhibit.toml: their keys, defaults and bounds.

mod lamps;
mod views;

use std::path::Path;

use toml::de::DeValue;

pub(super) use self::lamps::{lamps, limits};
pub(super) use self::views::{Surroundings, views};
use super::exhibit::{
    DesignSettings, FrameSetting, MethodSetting, OpticsSetting, PrintSettings, StackSettings, ToneSetting,
    ViewerSettings,
};
use super::problem::Problems;
use super::reader::{Bounds, TableReader, as_number, as_whole};
use super::{ink, materials};
use crate::print::Paper;

/// The most values a volume may have, per colour: 400 GB of films as 16-bit RGB.
pub const MOST_VOXELS_ON_DISK: u64 = 64_000_000_000;
/// The longest name the plan holds, in bytes.
pub const LONGEST_NAME: usize = 48;

const TRANSMITTANCE: Bounds =
    Bounds { least: 0.01, most: 1.0, reason: "it is the part of the light that passes" };

const fn bounds(least: f64, most: f64, reason: &'static str) -> Bounds {
    Bounds { least, most, reason }
}

/// `[exhibit]`: the name.
pub(super) fn exhibit(mut reader: TableReader<'_>, problems: &mut Problems) -> String {
    let mut name = "Vitrine".to_owned();
    if let Some(text) = reader.text("name") {
        if text.value.trim().is_empty() || text.value.len() > LONGEST_NAME {
            let message = format!("`name` in [exhibit] has {} bytes", text.value.len());
            let help = format!(
                "give a name of 1 to {LONGEST_NAME} bytes: plain letters take one, those with accents two, others up to four"
            );
            reader.report_value(text.span, message, help);
        } else {
            name = text.value.to_owned();
        }
    }
    reader.finish(problems);
    name
}

/// `[stack]`.
pub(super) fn stack(mut reader: TableReader<'_>, problems: &mut Problems) -> StackSettings {
    let films = reader.whole("films", 20, bounds(1.0, 200.0, "the paper's stack has 20"));
    let pixels = pixels(&mut reader);
    let (film, spacer) = materials::materials(&mut reader);
    let spacer_mm = reader.number("spacer_mm", 0.5, bounds(0.0, 100.0, "the paper's spacer is 0.5 mm thick"));
    let layer = spacer.on_film(film, spacer_mm);
    let index = bounds(1.0, 2.5, "1.0 is air between the films, 1.49 acrylic");
    let stack = StackSettings {
        films,
        width_mm: reader.number("width_mm", 35.0, bounds(1.0, 2000.0, "the paper's film is 35 mm wide")),
        pixels,
        film_mm: reader.number(
            "film_mm",
            film.film_mm,
            bounds(0.001, 20.0, "the paper's film is 0.1 mm thick"),
        ),
        spacer_mm,
        index: reader.number("index", spacer.index, index),
        tau_uv: reader.number("tau_uv", layer.tau_uv, TRANSMITTANCE),
        tau_visible: reader.number("tau_visible", layer.tau_visible, TRANSMITTANCE),
        spacer_tau_uv: reader.number("spacer_tau_uv", layer.spacer_tau_uv, TRANSMITTANCE),
        spacer_tau_visible: reader.number("spacer_tau_visible", layer.spacer_tau_visible, TRANSMITTANCE),
        blur_um: reader.number("blur_um", 0.0, bounds(0.0, 1000.0, "it is how far a dot's light spreads")),
        ink_yields: ink_yields(&mut reader),
        ink_absorbance: reader.number(
            "ink_absorbance",
            0.0,
            bounds(0.0, 10.0, "0 is light in proportion to ink; with more, full ink adds ever less light"),
        ),
    };
    let voxels = u64::from(stack.films) * u64::from(pixels[0]) * u64::from(pixels[1]);
    if voxels > MOST_VOXELS_ON_DISK {
        let message = format!("{films} films of {} x {} pixels are {voxels} voxels", pixels[0], pixels[1]);
        let help =
            format!("give fewer pixels or films: at most {MOST_VOXELS_ON_DISK} voxels fit onto a disk");
        reader.report_value(reader.span(), message, help);
    }
    reader.finish(problems);
    stack
}

/// `ink_yields = [red, green, blue]`.
fn ink_yields(reader: &mut TableReader<'_>) -> [f64; 3] {
    const DEFAULT: [f64; 3] = [1.0; 3];
    const WANTED: &str = "three numbers from 0.01 to 1, for red, green and blue";
    let Some(items) = reader.array("ink_yields", WANTED) else { return DEFAULT };
    let yields: Option<Vec<f64>> = items.iter().map(|item| as_number(item.get_ref())).collect();
    match yields.map(<[f64; 3]>::try_from) {
        Some(Ok(yields)) if yields.iter().all(|part| (0.01..=1.0).contains(part)) => yields,
        _ => {
            let message = "`ink_yields` in [stack] is not three parts of light".to_owned();
            reader.report_value(reader.span(), message, format!("give {WANTED}"));
            DEFAULT
        }
    }
}

/// `pixels = 512` or `pixels = [width, height]`.
fn pixels(reader: &mut TableReader<'_>) -> [u32; 2] {
    const DEFAULT: [u32; 2] = [512, 512];
    const WANTED: &str = "a whole number, or [width, height]";
    let side = bounds(8.0, 65_536.0, "a film has at least 8 and at most 65536 pixels a side");
    let Some(value) = reader.raw("pixels") else { return DEFAULT };
    let sides: Option<Vec<i64>> = match value.get_ref() {
        DeValue::Array(items) if items.len() == 2 => {
            items.iter().map(|item| as_whole(item.get_ref())).collect()
        }
        single => as_whole(single).map(|side| vec![side, side]),
    };
    let Some(sides) = sides else {
        reader.report_type("pixels", value, WANTED);
        return DEFAULT;
    };
    let mut checked = DEFAULT;
    for (slot, pixels) in checked.iter_mut().zip(sides) {
        let Some(placed) = reader.check_number("pixels", pixels as f64, value.span(), side) else { break };
        *slot = placed.value as u32;
    }
    checked
}

/// `distance_mm = "parallel"` or a number, `left_out` where the key is. The eye has to be in front of the `stack`.
fn distance(reader: &mut TableReader<'_>, stack: &StackSettings, left_out: Option<f64>) -> Option<f64> {
    let nearest = f64::from(stack.films) * stack.film_pitch_mm();
    let range = bounds(nearest.max(10.0), 100_000.0, "the eye has to be well in front of the films");
    let Some(value) = reader.raw("distance_mm") else { return left_out };
    match value.get_ref() {
        DeValue::String(text) if text.as_ref() == "parallel" => None,
        other => match as_number(other) {
            Some(number) => {
                reader.check_number("distance_mm", number, value.span(), range).map(|placed| placed.value)
            }
            None => {
                reader.report_type("distance_mm", value, "a number, or \"parallel\"");
                None
            }
        },
    }
}

/// `[viewer]`.
pub(super) fn viewer(
    mut reader: TableReader<'_>,
    stack: &StackSettings,
    problems: &mut Problems,
) -> ViewerSettings {
    let distance_mm = distance(&mut reader, stack, None);
    let frame = reader.choice("frame", &[("film", FrameSetting::Film), ("viewer", FrameSetting::Viewer)]);
    reader.finish(problems);
    ViewerSettings { distance_mm, frame: frame.unwrap_or(FrameSetting::Film) }
}

/// `[design]`. Without absorption there are no errors of hands and viewers either, unless the file says so.
pub(super) fn design(
    mut reader: TableReader<'_>,
    usual_brightness: f64,
    problems: &mut Problems,
) -> DesignSettings {
    let method = reader.choice(
        "method",
        &[("least-squares", MethodSetting::LeastSquares), ("product", MethodSetting::Product)],
    );
    let optics = reader.choice("optics", &[("stack", OpticsSetting::Stack), ("ideal", OpticsSetting::Ideal)]);
    let tone = reader.choice("tone", &[("linear", ToneSetting::Linear), ("code", ToneSetting::Code)]);
    let optics = optics.unwrap_or(OpticsSetting::Stack);
    let defaults = crate::design::DesignSettings::default();
    let expected = |error: f64| if optics == OpticsSetting::Ideal { 0.0 } else { error };
    let settings = DesignSettings {
        method: method.unwrap_or(MethodSetting::LeastSquares),
        optics,
        tone: tone.unwrap_or(ToneSetting::Linear),
        brightness: reader.number(
            "brightness",
            usual_brightness,
            bounds(0.01, 1.0, "more is brighter, less is truer"),
        ),
        misplacement_um: reader.number(
            "misplacement_um",
            expected(defaults.misplacement_um),
            bounds(0.0, 5000.0, "films laid by hand on pins are about 68 um off"),
        ),
        spacing_um: reader.number(
            "spacing_um",
            expected(defaults.spacing_um),
            bounds(0.0, 5000.0, "acrylic sheet is sold within a tenth of its thickness"),
        ),
        direction_error_deg: reader.number(
            "direction_error_deg",
            expected(defaults.direction_error_deg),
            bounds(0.0, 20.0, "who leans from one foot to the other moves by a degree or two"),
        ),
        distance_error_part: reader.number(
            "distance_error_part",
            expected(defaults.distance_error_part),
            bounds(0.0, 0.3, "visitors keep a distance within a fifth"),
        ),
        pedestal: reader.number("pedestal", 0.0, bounds(0.0, 10.0, "more is truer and has less contrast")),
        white_ratio: reader.number(
            "white_ratio",
            defaults.white_ratio,
            bounds(1.0, 1000.0, "1 makes all views equally bright, by dimming the brighter ones"),
        ),
        structure: structure(&mut reader),
        balance: reader.number(
            "balance",
            defaults.balance,
            bounds(0.0, 1.0, "0 is the least error in all views, 1 much the same in each"),
        ),
        iterations: reader.whole(
            "iterations",
            defaults.iterations as u32,
            bounds(1.0, 100_000.0, "the optimiser stops by itself when nothing is gained any more"),
        ),
        tolerance_db: reader.number(
            "tolerance_db",
            defaults.tolerance_db,
            bounds(1e-6, 10.0, "less takes longer"),
        ),
        memory_mib: memory_mib(&mut reader),
        adapt: reader.truth("adapt", false),
        adapt_similarity: reader.number(
            "adapt_similarity",
            0.9,
            bounds(0.5, 0.99, "less lets the pictures give way more"),
        ),
    };
    reader.finish(problems);
    settings
}

/// `structure = 2.4`, or left out for what suits the tone.
fn structure(reader: &mut TableReader<'_>) -> Option<f64> {
    let range = bounds(0.0, 100.0, "0 looks at the squared error alone");
    reader.raw("structure")?;
    Some(reader.number("structure", 0.0, range))
}

/// `memory_mib = 4096`, or left out for as much as there is.
fn memory_mib(reader: &mut TableReader<'_>) -> Option<u32> {
    let range = bounds(16.0, 16_777_216.0, "leave it out for as much as there is");
    reader.raw("memory_mib")?;
    Some(reader.whole("memory_mib", 0, range))
}

/// `[print]`; its file of curves is looked for in `folder`.
pub(super) fn print(mut reader: TableReader<'_>, folder: &Path, problems: &mut Problems) -> PrintSettings {
    let dpi = bounds(72.0, 50_000.0, "the paper's printer has 5760 x 1440");
    let mut inks = ["red", "green", "blue"].map(str::to_owned);
    if let Some(items) = reader.array("inks", "three names") {
        let names: Vec<&str> = items.iter().filter_map(|item| item.get_ref().as_str()).collect();
        match <[&str; 3]>::try_from(names) {
            Ok(names) if items.len() == 3 => inks = names.map(str::to_owned),
            _ => {
                let help = "name the inks for red, green and blue: inks = [\"red\", \"green\", \"blue\"]";
                reader.report_value(reader.span(), "`inks` in [print] is not three names".to_owned(), help);
            }
        }
    }
    let paper = paper(&mut reader);
    let settings = PrintSettings {
        dpi_x: reader.number("dpi_x", 5760.0, dpi),
        dpi_y: reader.number("dpi_y", 1440.0, dpi),
        inks,
        levels: levels(&mut reader),
        marks: reader.truth("marks", true),
        ink: ink::ink(&mut reader, folder),
        paper,
        mirrored: reader.truth("mirrored", false),
        pin_mm: reader.number(
            "pin_mm",
            3.0,
            bounds(0.5, 6.0, "the border that carries the holes is 7 mm wide"),
        ),
        ink_ml_m2: reader.number(
            "ink_ml_m2",
            10.0,
            bounds(0.1, 200.0, "weigh a sheet before and after to measure it"),
        ),
    };
    reader.finish(problems);
    settings
}

/// `paper = "A4"` or another that is known.
fn paper(reader: &mut TableReader<'_>) -> String {
    const DEFAULT: &str = "A4";
    let Some(text) = reader.text("paper") else { return DEFAULT.to_owned() };
    if let Err(error) = text.value.parse::<Paper>() {
        reader.report_value(text.span, error.to_string(), "roll widths are 50 to 5500 mm".to_owned());
    }
    text.value.to_owned()
}

/// `levels = 2`, `4`, `16` or `"continuous"`.
fn levels(reader: &mut TableReader<'_>) -> Option<u16> {
    const WANTED: &str = "2, 4, 16 or \"continuous\"";
    let value = reader.raw("levels")?;
    if value.get_ref().as_str() == Some("continuous") {
        return None;
    }
    match as_whole(value.get_ref()) {
        // They divide 255 evenly, so that the films' files hold them exactly.
        Some(levels @ (2 | 4 | 16)) => Some(levels as u16),
        _ => {
            reader.report_type("levels", value, WANTED);
            None
        }
    }
}
