//! From the text of exhibit.toml to an [`Exhibit`].

use std::ops::Range;
use std::path::Path;

use toml::de::{DeTable, DeValue};
use vitrine_exhibit::plan::calendar::MAX_RULES;

use super::exhibit::{Exhibit, StackSettings};
use super::object::{self, ObjectSettings};
use super::problem::{ConfigError, Problem, Problems};
use super::reader::{AskedKey, TableReader};
use super::{calendar, contradictions, tables, visitors};

/// Reads the exhibit.toml at `path` and looks whether its pictures are there.
///
/// # Errors
/// Fails when the file cannot be read, and with all problems of its contents at once.
pub fn load(path: &Path) -> Result<Exhibit, ConfigError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| ConfigError::Unreadable { path: path.to_owned(), source })?;
    parse(path, &text)
}

/// Reads `text` as the exhibit.toml at `path`.
///
/// # Errors
/// Fails with all problems of the text at once.
pub fn parse(path: &Path, text: &str) -> Result<Exhibit, ConfigError> {
    let (root, syntax_errors) = DeTable::parse_recoverable(text);
    let mut problems = Problems::default();
    syntax_errors.iter().for_each(|error| problems.push(syntax_problem(error, text)));
    if problems.is_empty() {
        let folder = path.parent().unwrap_or(Path::new(""));
        let exhibit = read_root(root.get_ref(), folder, &mut problems);
        if problems.is_empty() {
            contradictions::find(&exhibit, root.get_ref(), &mut problems);
        }
        if problems.is_empty() {
            return Ok(exhibit);
        }
    }
    Err(ConfigError::invalid(path, text, problems.into_found()))
}

/// The keys that are asked for when `text` is read, whatever is wrong with it.
pub(super) fn asked_keys(text: &str) -> Vec<AskedKey> {
    let (root, _) = DeTable::parse_recoverable(text);
    let mut problems = Problems::default();
    read_root(root.get_ref(), Path::new(""), &mut problems);
    problems.into_asked()
}

/// The exhibit of an object alone, with every default.
pub fn object_exhibit(object: ObjectSettings) -> Exhibit {
    let mut exhibit = read_root(&DeTable::new(), Path::new(""), &mut Problems::default());
    exhibit.views = object::own_views(exhibit.viewer.distance_mm);
    exhibit.object = Some(object);
    exhibit
}

fn syntax_problem(error: &toml::de::Error, text: &str) -> Problem {
    let span = error.span().unwrap_or(0..0);
    let before = text.get(..span.start).unwrap_or_default();
    let line = text[before.rfind('\n').map_or(0, |end| end + 1)..].lines().next().unwrap_or_default();
    Problem::new("vitrine::config::syntax", span, error.message().trim(), "here", syntax_help(line))
}

/// What is mostly meant by a line that is no TOML.
fn syntax_help(line: &str) -> &'static str {
    let begins = |text: &str, is: fn(char) -> bool| text.trim_start().starts_with(is);
    let ends = |text: &str, is: fn(char) -> bool| text.trim_end().ends_with(is);
    let digit = |letter: char| letter.is_ascii_digit();
    let decimal_comma =
        || line.split_once(',').is_some_and(|(whole, part)| ends(whole, digit) && begins(part, digit));
    if line.contains(['\u{201c}', '\u{201d}', '\u{201e}', '\u{2018}', '\u{2019}']) {
        "texts stand in straight quotes, as \"this one\""
    } else if line.contains('\\') {
        "a backslash has a meaning in double quotes: write paths with /, or in single quotes"
    } else if line.trim_start().starts_with("[view]") || line.trim_start().starts_with("[schedule]") {
        "there may be several: begin each with two brackets, as [[view]] or [[schedule]]"
    } else if !line.contains('[') && decimal_comma() {
        "decimals are written with a point, as 13.3"
    } else {
        "the file is written in TOML: texts in quotes, one `key = value` a line, tables as [name]"
    }
}

/// The wanted white where the file has none.
const BRIGHTNESS: f64 = 0.4;

/// The wanted white where the file has none, and an object. A surface has the light of the film that it lies on, or of
/// two where it is steep: with white as bright as two films of full ink it stands out, and pictures around it are still
/// as true as without it.
fn brightness_around_an_object(stack: &StackSettings) -> f64 {
    (2.0 / f64::from(stack.films)).clamp(0.01, BRIGHTNESS)
}

/// Reads every table. The exhibit is only of use where no problem was noted.
fn read_root(root: &DeTable<'_>, folder: &Path, problems: &mut Problems) -> Exhibit {
    let mut reader = TableReader::new("exhibit.toml", Some(root), 0..0);
    let mut section = |name: &'static str, display: &'static str| section(&mut reader, name, display);

    let exhibit = section("exhibit", "[exhibit]");
    let stack = section("stack", "[stack]");
    let viewer = section("viewer", "[viewer]");
    let design = section("design", "[design]");
    let print = section("print", "[print]");
    let lamps = section("lamps", "[lamps]");
    let visitors = section("visitors", "[visitors]");
    let presence = section("presence", "[presence]");
    let calendar = section("calendar", "[calendar]");
    let limits = section("limits", "[limits]");
    let object = section("object", "[object]");

    let name = tables::exhibit(exhibit, problems);
    let stack = tables::stack(stack, problems);
    let viewer = tables::viewer(viewer, &stack, problems);
    let has_object = root.contains_key("object");
    let usual_brightness = if has_object { brightness_around_an_object(&stack) } else { BRIGHTNESS };
    let design = tables::design(design, usual_brightness, problems);
    let print = tables::print(print, folder, problems);
    let lamps = tables::lamps(lamps, problems);
    let visitors = visitors::visitors(visitors, problems);
    let presence = visitors::presence(presence, problems);
    let calendar = calendar::calendar(calendar, problems);
    let limits = tables::limits(limits, problems);

    let mut schedule = Vec::new();
    for rule in entries(&mut reader, "schedule") {
        schedule
            .push(calendar::schedule_rule(TableReader::new("[[schedule]]", Some(rule.1), rule.0), problems));
    }
    if schedule.len() > MAX_RULES {
        let message = format!("there are more than {MAX_RULES} [[schedule]] rules");
        let help = format!("the controller's plan holds {MAX_RULES}: a rule may name several days");
        reader.report(Problem::new("vitrine::config::too_many_rules", 0..0, message, "", help));
    }
    let object = if has_object { object::object(object, folder, problems) } else { None };
    let surroundings =
        tables::Surroundings { folder, stack: &stack, viewer: &viewer, design: &design, has_object };
    let mut views = tables::views(entries(&mut reader, "view"), surroundings, problems);
    if has_object && !root.contains_key("view") {
        views = object::own_views(viewer.distance_mm);
    } else if views.is_empty() && !root.contains_key("view") {
        reader.report(Problem::new(
            "vitrine::config::no_view",
            0..0,
            "there is no [[view]]",
            "",
            "add at least one:\n[[view]]\nid = \"front\"\npattern = \"photo.jpg\"\nor an object: [object] with its model",
        ));
    }
    reader.finish(problems);
    Exhibit {
        name,
        stack,
        viewer,
        views,
        object,
        design,
        print,
        lamps,
        visitors,
        presence,
        schedule,
        calendar,
        limits,
    }
}

/// The reader of one `[table]`, which may be left out.
fn section<'a>(root: &mut TableReader<'a>, key: &'static str, display: &'static str) -> TableReader<'a> {
    let Some(value) = root.raw(key) else { return TableReader::new(display, None, 0..0) };
    let table = value.get_ref().as_table();
    if table.is_none() {
        root.report_type(key, value, &format!("a table: {display}"));
    }
    TableReader::new(display, table, value.span())
}

/// The tables of a `[[list of tables]]` with their places.
fn entries<'a>(root: &mut TableReader<'a>, key: &'static str) -> Vec<(Range<usize>, &'a DeTable<'a>)> {
    let wanted = format!("a list of tables: [[{key}]]");
    let Some(items) = root.array(key, &wanted) else { return Vec::new() };
    let mut found = Vec::new();
    for item in items {
        match item.get_ref() {
            DeValue::Table(table) => found.push((item.span(), table)),
            _ => root.report_type(key, item, &wanted),
        }
    }
    found
}
