//! The tables of exhibit.toml: their keys, defaults and bounds.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};
use vitrine_exhibit::limits;
use vitrine_exhibit::plan::{MAX_CURVE, MAX_VIEWS};
use vitrine_exhibit::units::{Dose, Irradiance, Milliseconds};

use super::exhibit::{
    BelowFloorSetting, DesignSettings, FrameSetting, LampSetting, LampSettings, LimitSettings, MethodSetting,
    OpticsSetting, PrintSettings, StackSettings, ToneSetting, ViewSettings, ViewerSettings,
};
use super::problem::{Problem, Problems};
use super::reader::{Bounds, TableReader, as_number, as_whole, closest};
use super::{ink, materials};
use crate::picture::Picture;
use crate::print::Paper;
use crate::stack::MOST_VOXELS_IN_MEMORY;

/// The most values a volume may have, per colour, that is held in memory.
pub const MOST_VOXELS: u64 = MOST_VOXELS_IN_MEMORY as u64;
/// The most values a volume may have, per colour: 400 GB of films as 16-bit RGB.
const MOST_ON_DISK: u64 = 64_000_000_000;
/// The longest name the plan holds, in bytes.
pub const LONGEST_NAME: usize = 48;
/// The longest view id the plan holds, in bytes.
const LONGEST_ID: usize = 24;

const TRANSMITTANCE: Bounds =
    Bounds { least: 0.01, most: 1.0, reason: "it is the part of the light that passes" };
const ANGLE: Bounds = Bounds {
    least: -80.0,
    most: 80.0,
    reason: "0 looks straight at the film; positive is to the right, or above; beyond 80 the films are seen edge-on",
};

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
    if voxels > MOST_ON_DISK {
        let message = format!("{films} films of {} x {} pixels are {voxels} voxels", pixels[0], pixels[1]);
        let help = format!("give fewer pixels or films: at most {MOST_ON_DISK} voxels fit onto a disk");
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

/// What views stand in: pictures are looked for in `folder`, and the tables hold for all views.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) folder: &'a Path,
    pub(super) stack: &'a StackSettings,
    pub(super) viewer: &'a ViewerSettings,
    pub(super) design: &'a DesignSettings,
    /// Whether there is something to show without a picture.
    pub(super) has_object: bool,
}

/// All `[[view]]` tables.
pub(super) fn views(
    entries: Vec<(Range<usize>, &DeTable<'_>)>,
    surroundings: Surroundings<'_>,
    problems: &mut Problems,
) -> Vec<ViewSettings> {
    let mut seen = HashMap::new();
    let mut views: Vec<ViewSettings> = Vec::new();
    for (index, (span, table)) in entries.into_iter().enumerate() {
        if index == MAX_VIEWS {
            let message = format!("there are more than {index} views");
            let help = format!("the controller's plan holds {index} views: leave the rest out");
            problems.push(Problem::new(
                "vitrine::config::too_many_views",
                span.clone(),
                message,
                "one too many",
                help,
            ));
        }
        let reader = TableReader::new("[[view]]", Some(table), span.clone());
        let Some(view) = view(reader, surroundings, &mut seen, problems) else { continue };
        if let Some(other) = views.iter().find(|other| cannot_be_pages(other, &view)) {
            problems.push(Problem::new(
                "vitrine::config::same_direction",
                span,
                format!("the views `{}` and `{}` have the same direction", other.id, view.id),
                "this view",
                "give one of the two `lamp = \"top\"` and the other `lamp = \"bottom\"`: the controller then turns \
                 them like pages; a third view needs a direction of its own",
            ));
        }
        views.push(view);
    }
    views
}

/// Two views in one direction are told apart by their lamps alone.
fn cannot_be_pages(one: &ViewSettings, other: &ViewSettings) -> bool {
    // The plan keeps hundredths of a degree.
    let direction = |view: &ViewSettings| {
        [view.horizontal_deg, view.vertical_deg].map(|degrees| (degrees * 100.0).round() as i32)
    };
    let apart = one.lamp.is_some() && other.lamp.is_some() && one.lamp != other.lamp;
    direction(one) == direction(other) && !apart
}

fn view(
    mut reader: TableReader<'_>,
    surroundings: Surroundings<'_>,
    seen: &mut HashMap<String, Range<usize>>,
    problems: &mut Problems,
) -> Option<ViewSettings> {
    let id = view_id(&mut reader, seen);
    let pattern = view_picture(&mut reader, "pattern", surroundings.folder);
    if pattern.is_none() && !surroundings.has_object {
        report_missing(&mut reader, "pattern", "pattern = \"photo.jpg\"");
    }
    let horizontal_deg = reader.number("horizontal_deg", 0.0, ANGLE);
    let vertical_deg = reader.number("vertical_deg", 0.0, ANGLE);
    let weight = reader.number("weight", 1.0, bounds(0.01, 100.0, "1 is the weight of an ordinary view"));
    let distance_mm = distance(&mut reader, surroundings.stack, surroundings.viewer.distance_mm);
    let mask = view_picture(&mut reader, "mask", surroundings.folder);
    let lamp = view_lamp(&mut reader, surroundings.design.optics);
    reader.finish(problems);
    Some(ViewSettings { id: id?, pattern, horizontal_deg, vertical_deg, weight, distance_mm, mask, lamp })
}

/// `lamp = "top"` or `"bottom"`; left out, the view has the pair that shows it best.
fn view_lamp(reader: &mut TableReader<'_>, optics: OpticsSetting) -> Option<LampSetting> {
    let span = reader.raw("lamp")?.span();
    let lamp = reader.choice("lamp", &[("top", LampSetting::Top), ("bottom", LampSetting::Bottom)]);
    if optics == OpticsSetting::Ideal {
        let message = "`lamp` in [[view]] does nothing where `optics` in [design] is \"ideal\"".to_owned();
        let help = "leave it out, or set optics = \"stack\": only films that absorb tell the lamps apart";
        reader.report_value(span, message, help);
    }
    lamp
}

/// An id becomes a file name, so it is held to characters that every system takes.
fn view_id(reader: &mut TableReader<'_>, seen: &mut HashMap<String, Range<usize>>) -> Option<String> {
    let Some(text) = reader.text("id") else {
        report_missing(reader, "id", "id = \"front\"");
        return None;
    };
    let id = text.value;
    let plain = id.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    if id.is_empty() || id.len() > LONGEST_ID || !plain || id.starts_with('-') {
        let help =
            format!("an id becomes a file name: use 1 to {LONGEST_ID} letters, digits, - or _, not - first");
        reader.report(Problem::new(
            "vitrine::config::bad_id",
            text.span,
            format!("`{id}` is no id for a view"),
            "here",
            help,
        ));
        return None;
    }
    // Some file systems do not tell upper from lower case.
    if let Some(first) = seen.insert(id.to_lowercase(), text.span.clone()) {
        reader.report(Problem::new(
            "vitrine::config::duplicate_id",
            text.span,
            format!("two views have the id `{id}`"),
            format!("also at byte {}", first.start),
            "give every view an id of its own",
        ));
        return None;
    }
    Some(id.to_owned())
}

/// The path of a picture that can be read, relative to `folder`, if the key is there.
fn view_picture(reader: &mut TableReader<'_>, key: &'static str, folder: &Path) -> Option<PathBuf> {
    let text = reader.text(key)?;
    let path = PathBuf::from(text.value);
    let found = folder.join(&path);
    if let Err(error) = Picture::check(&found) {
        let help = match most_like(&found) {
            Some(other) if !found.exists() => format!("did you mean \"{other}\"?"),
            _ => "give the path of a whole PNG, JPEG, TIFF or WebP picture, relative to exhibit.toml"
                .to_owned(),
        };
        reader.report(Problem::new(
            "vitrine::config::bad_picture",
            text.span,
            error.to_string(),
            "this picture",
            help,
        ));
        return None;
    }
    Some(path)
}

/// The name of the file most like `path` in its folder, where one is like it.
fn most_like(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?;
    let entries = std::fs::read_dir(
        path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")),
    )
    .ok()?;
    let names: Vec<String> = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    let in_lower_case: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let candidates: Vec<&str> = in_lower_case.iter().map(String::as_str).collect();
    let like = closest(wanted, &candidates)?;
    names.into_iter().find(|name| name.to_lowercase() == like)
}

/// Notes a missing key, once: a key of the wrong type has been reported already.
fn report_missing(reader: &mut TableReader<'_>, key: &'static str, example: &str) {
    if reader.raw(key).is_some() {
        return;
    }
    let message = format!("[[view]] has no `{key}`");
    let span = reader.span();
    reader.report(Problem::new(
        "vitrine::config::missing_key",
        span,
        message,
        "this view",
        format!("add `{example}`"),
    ));
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

/// `[lamps]`.
pub(super) fn lamps(mut reader: TableReader<'_>, problems: &mut Problems) -> LampSettings {
    let (hardware, firmware) = (watts(limits::HARDWARE_CEILING), watts(limits::CEILING));
    let irradiance = bounds(0.01, hardware, "the sense resistors hold a lamp to 50 W/m2");
    let ceiling = bounds(0.01, firmware, "the firmware cuts above 20 W/m2");
    let below_floor = reader
        .choice("below_floor", &[("cut", BelowFloorSetting::Cut), ("dither", BelowFloorSetting::Dither)]);
    let settings = LampSettings {
        irradiance_w_m2: reader.number("irradiance_w_m2", 10.0, irradiance),
        ceiling_w_m2: reader.number("ceiling_w_m2", 10.0, ceiling),
        calibration: calibration(&mut reader),
        below_floor: below_floor.unwrap_or(BelowFloorSetting::Cut),
        ultraviolet_at_full_w_m2: ultraviolet_at_full(&mut reader),
    };
    reader.finish(problems);
    settings
}

/// `ultraviolet_at_full_w_m2 = [top, bottom]`, or `"not measured"`.
fn ultraviolet_at_full(reader: &mut TableReader<'_>) -> Option<[f64; 2]> {
    const KEY: &str = "ultraviolet_at_full_w_m2";
    const WANTED: &str = "what the sensor reads under each lamp alone, [top, bottom], or \"not measured\"";
    let value = reader.raw(KEY)?;
    if value.get_ref().as_str() == Some("not measured") {
        return None;
    }
    let readings: Option<Vec<f64>> = value
        .get_ref()
        .as_array()
        .and_then(|pair| pair.iter().map(|reading| as_number(reading.get_ref())).collect());
    let Some(Ok(pair)) = readings.map(<[f64; 2]>::try_from) else {
        reader.report_type(KEY, value, WANTED);
        return None;
    };
    // The plan keeps mW/m2, and a reading of nothing cannot be held against a lamp.
    let range =
        bounds(0.001, watts(limits::HARDWARE_CEILING), "read it at commissioning, one lamp at a time");
    let checked = pair.map(|reading| reader.check_number(KEY, reading, value.span(), range));
    checked.iter().all(Option::is_some).then_some(pair)
}

fn watts(irradiance: Irradiance) -> f64 {
    f64::from(irradiance.0) / 1000.0
}

fn joules(dose: Dose) -> f64 {
    dose.0 as f64 / 1e6
}

fn seconds(time: Milliseconds) -> f64 {
    f64::from(time.0) / 1000.0
}

/// `calibration = [[duty, level], ...]`, rising in both from nothing to full level.
fn calibration(reader: &mut TableReader<'_>) -> Vec<[f64; 2]> {
    const WANTED: &str = "pairs of duty and level: [[0.0, 0.0], [0.5, 0.46], [1.0, 1.0]]";
    let Some(items) = reader.array("calibration", WANTED) else { return Vec::new() };
    let mut points: Vec<[f64; 2]> = Vec::new();
    for item in items {
        let pair: Option<Vec<f64>> = item
            .get_ref()
            .as_array()
            .and_then(|pair| pair.iter().map(|value| as_number(value.get_ref())).collect());
        let Some(Ok(pair)) = pair.map(<[f64; 2]>::try_from) else {
            reader.report_type("calibration", item, WANTED);
            return Vec::new();
        };
        points.push(pair);
    }
    let from_nothing = points.first().is_none_or(|first| *first == [0.0, 0.0]);
    let to_full_level = points.last().is_none_or(|last| last[1] == 1.0 && last[0] <= 1.0);
    // A level is kept in 16 bits: nearer points would fall together.
    let rising = points.windows(2).all(|pair| (0..2).all(|axis| pair[1][axis] - pair[0][axis] > 1e-4));
    if points.len() == 1 || points.len() > MAX_CURVE || !(from_nothing && to_full_level && rising) {
        let message = "`calibration` in [lamps] does not rise from [0, 0] to level 1".to_owned();
        reader.report_value(reader.span(), message, format!("give 2 to {MAX_CURVE} {WANTED}"));
        return Vec::new();
    }
    points
}

/// `[limits]`: never more than the firmware's own.
pub(super) fn limits(mut reader: TableReader<'_>, problems: &mut Problems) -> LimitSettings {
    const KINDER: &str = "the firmware's own limit is the most; a plan may only ask for less";
    let (day, life) = (joules(limits::DAILY_DOSE), joules(limits::LIFE_DOSE));
    let (continuous, rest) = (seconds(limits::CONTINUOUS), seconds(limits::REST));
    let settings = LimitSettings {
        daily_dose_j_m2: reader.number("daily_dose_j_m2", day, bounds(1.0, day, KINDER)),
        life_dose_j_m2: reader.number("life_dose_j_m2", life, bounds(1.0, life, KINDER)),
        continuous_s: reader.number("continuous_s", continuous, bounds(1.0, continuous, KINDER)),
        rest_s: reader.number("rest_s", rest, bounds(rest, 86_400.0, "LEDs live longer with rests")),
    };
    if settings.daily_dose_j_m2 > settings.life_dose_j_m2 {
        let message = "the dose of a day is more than the dose of the stack's life".to_owned();
        reader.report_value(reader.span(), message, "lower `daily_dose_j_m2` or raise `life_dose_j_m2`");
    }
    reader.finish(problems);
    settings
}
