//! The `[[view]]` tables: their keys, defaults and bounds.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::de::DeTable;
use vitrine_exhibit::plan::MAX_VIEWS;

use super::{bounds, distance};
use crate::config::exhibit::{
    DesignSettings, LampSetting, OpticsSetting, StackSettings, ViewSettings, ViewerSettings,
};
use crate::config::problem::{Problem, Problems};
use crate::config::reader::{Bounds, TableReader, closest};
use crate::picture::Picture;

/// The longest view id the plan holds, in bytes.
const LONGEST_ID: usize = 24;
const ANGLE: Bounds = Bounds {
    least: -80.0,
    most: 80.0,
    reason: "0 looks straight at the film; positive is to the right, or above; beyond 80 the films are seen edge-on",
};

/// What views stand in: pictures are looked for in `folder`, and the tables hold for all views.
#[derive(Clone, Copy)]
pub(in crate::config) struct Surroundings<'a> {
    pub(in crate::config) folder: &'a Path,
    pub(in crate::config) stack: &'a StackSettings,
    pub(in crate::config) viewer: &'a ViewerSettings,
    pub(in crate::config) design: &'a DesignSettings,
    /// Whether there is something to show without a picture.
    pub(in crate::config) has_object: bool,
}

/// All `[[view]]` tables.
pub(in crate::config) fn views(
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
