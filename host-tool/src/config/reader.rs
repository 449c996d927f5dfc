//! Reads one table of exhibit.toml key by key and collects all that is wrong with it.
//!
//! A key that was not asked for by the time of [`TableReader::finish`] is unknown; the keys that were asked for
//! are what it could have meant.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::{Problem, Problems};
use crate::plain::is_plain;

/// What numbers a key takes.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) least: f64,
    pub(super) most: f64,
    /// Why, or what to do; ends up in the error's help.
    pub(super) reason: &'static str,
}

/// A value with its place in the file.
#[derive(Clone, Debug)]
pub(super) struct Placed<T> {
    pub(super) value: T,
    pub(super) span: Range<usize>,
}

/// What a key was asked to be.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Wanted {
    /// A number within bounds.
    Number { least: f64, most: f64, whole: bool },
    /// A text.
    Text,
    /// A truth value.
    Truth,
    /// One of these texts.
    Choice(Vec<&'static str>),
    /// Of a form of its own, see `super::schema`.
    Special,
}

/// A key that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AskedKey {
    /// The table as messages call it, such as `[stack]` or `[[view]]`; `exhibit.toml` for the tables themselves.
    pub(super) table: String,
    /// The key.
    pub(super) key: &'static str,
    /// What it was asked to be.
    pub(super) wanted: Wanted,
}

/// One table, read key by key.
pub(super) struct TableReader<'a> {
    name: &'a str,
    table: Option<&'a DeTable<'a>>,
    span: Range<usize>,
    asked: Vec<AskedKey>,
    problems: Vec<Problem>,
}

impl<'a> TableReader<'a> {
    /// Reads `table`, called `name` in messages; `None` stands for a table left out.
    pub(super) fn new(name: &'a str, table: Option<&'a DeTable<'a>>, span: Range<usize>) -> Self {
        Self { name, table, span, asked: Vec::new(), problems: Vec::new() }
    }

    /// The place of the whole table.
    pub(super) fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The value of `key`, whatever its type.
    pub(super) fn raw(&mut self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.value(key, Wanted::Special)
    }

    fn value(&mut self, key: &'static str, wanted: Wanted) -> Option<&'a Spanned<DeValue<'a>>> {
        self.asked.push(AskedKey { table: self.name.to_owned(), key, wanted });
        self.table?.get(key)
    }

    /// Notes a problem.
    pub(super) fn report(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// Notes that the value at `span` is not what `key` wants.
    pub(super) fn report_type(&mut self, key: &str, value: &Spanned<DeValue<'_>>, wanted: &str) {
        let message = format!("`{key}` in {} wants {wanted}", self.name);
        let label = format!("this is {}", type_name(value.get_ref()));
        self.report(Problem::new(
            "vitrine::config::wrong_type",
            value.span(),
            message,
            label,
            format!("write {wanted}"),
        ));
    }

    /// Notes that a value is out of its range or set.
    pub(super) fn report_value(&mut self, span: Range<usize>, message: String, help: impl Into<String>) {
        self.report(Problem::new("vitrine::config::bad_value", span, message, "here", help));
    }

    /// A finite number within `bounds`, or `default` where the key is left out.
    pub(super) fn number(&mut self, key: &'static str, default: f64, bounds: Bounds) -> f64 {
        self.placed_number(key, bounds).map_or(default, |placed| placed.value)
    }

    /// A finite number within `bounds`, if the key is there and right.
    pub(super) fn placed_number(&mut self, key: &'static str, bounds: Bounds) -> Option<Placed<f64>> {
        let wanted = Wanted::Number { least: bounds.least, most: bounds.most, whole: false };
        let value = self.value(key, wanted)?;
        let Some(number) = as_number(value.get_ref()) else {
            self.report_type(key, value, "a number");
            return None;
        };
        self.check_number(key, number, value.span(), bounds)
    }

    /// `number` with its place, if it is finite and within `bounds`.
    pub(super) fn check_number(
        &mut self,
        key: &str,
        number: f64,
        span: Range<usize>,
        bounds: Bounds,
    ) -> Option<Placed<f64>> {
        if number.is_finite() && (bounds.least..=bounds.most).contains(&number) {
            return Some(Placed { value: number, span });
        }
        let range = format!("{} to {}", bounds.least, bounds.most);
        self.report_value(
            span,
            format!("`{key}` in {} is {number}, outside {range}", self.name),
            format!(
                "give a number from {range}{}{}",
                if bounds.reason.is_empty() { "" } else { ": " },
                bounds.reason
            ),
        );
        None
    }

    /// A whole number within `bounds`, or `default`.
    pub(super) fn whole(&mut self, key: &'static str, default: u32, bounds: Bounds) -> u32 {
        let wanted = Wanted::Number { least: bounds.least, most: bounds.most, whole: true };
        let Some(value) = self.value(key, wanted) else { return default };
        let Some(number) = as_whole(value.get_ref()) else {
            self.report_type(key, value, "a whole number");
            return default;
        };
        match self.check_number(key, number as f64, value.span(), bounds) {
            Some(placed) => placed.value as u32,
            None => default,
        }
    }

    /// A text, if the key is there and right.
    pub(super) fn text(&mut self, key: &'static str) -> Option<Placed<&'a str>> {
        self.text_of(key, Wanted::Text)
    }

    fn text_of(&mut self, key: &'static str, wanted: Wanted) -> Option<Placed<&'a str>> {
        let value = self.value(key, wanted)?;
        match value.get_ref().as_str() {
            Some(text) if !is_plain(text) => {
                let message = format!("`{key}` in {} holds a control character", self.name);
                self.report_value(value.span(), message, "write it as letters, digits and signs on one line");
                None
            }
            Some(text) => Some(Placed { value: text, span: value.span() }),
            None => {
                self.report_type(key, value, "a text in quotes");
                None
            }
        }
    }

    /// A truth value, or `default`.
    pub(super) fn truth(&mut self, key: &'static str, default: bool) -> bool {
        let Some(value) = self.value(key, Wanted::Truth) else { return default };
        match value.get_ref().as_bool() {
            Some(truth) => truth,
            None => {
                self.report_type(key, value, "true or false");
                default
            }
        }
    }

    /// One of the `choices`, the first where the key is left out.
    pub(super) fn choice<T: Copy>(&mut self, key: &'static str, choices: &[(&'static str, T)]) -> Option<T> {
        let wanted = Wanted::Choice(choices.iter().map(|choice| choice.0).collect());
        let Some(text) = self.text_of(key, wanted) else { return choices.first().map(|choice| choice.1) };
        if let Some(choice) = choices.iter().find(|choice| choice.0 == text.value) {
            return Some(choice.1);
        }
        let names: Vec<&str> = choices.iter().map(|choice| choice.0).collect();
        let listed = names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" or ");
        let help = match closest(text.value, &names) {
            Some(name) => format!("did you mean \"{name}\"? It takes {listed}"),
            None => format!("it takes {listed}"),
        };
        self.report_value(text.span, format!("`{key}` in {} cannot be \"{}\"", self.name, text.value), help);
        choices.first().map(|choice| choice.1)
    }

    /// The values of an array, or none where the key is left out.
    pub(super) fn array(&mut self, key: &'static str, wanted: &str) -> Option<&'a [Spanned<DeValue<'a>>]> {
        let value = self.raw(key)?;
        match value.get_ref() {
            DeValue::Array(items) => Some(items),
            _ => {
                self.report_type(key, value, wanted);
                None
            }
        }
    }

    /// Ends the table: what is left in it is unknown.
    pub(super) fn finish(mut self, problems: &mut Problems) {
        let known: Vec<&'static str> = self.asked.iter().map(|asked| asked.key).collect();
        for (key, _) in self.table.into_iter().flat_map(|table| table.iter()) {
            let name: &str = key.get_ref();
            if known.contains(&name) {
                continue;
            }
            let help = match closest(name, &known) {
                Some(known) => format!("did you mean `{known}`?"),
                None => format!("{} knows {}", self.name, known.join(", ")),
            };
            let message = format!("unknown key `{name}` in {}", self.name);
            self.problems.push(Problem::new(
                "vitrine::config::unknown_key",
                key.span(),
                message,
                "unknown",
                help,
            ));
        }
        problems.take_over(self.problems, self.asked);
    }
}

/// The number that a value is, whole or not.
pub(super) fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(_) => as_whole(value).map(|whole| whole as f64),
        _ => None,
    }
}

/// The whole number that a value is.
pub(super) fn as_whole(value: &DeValue<'_>) -> Option<i64> {
    let integer = value.as_integer()?;
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

/// What a value is called in a message.
pub(super) fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// The name among `names` that `word` was probably meant to be.
pub fn closest<'n>(word: &str, names: &[&'n str]) -> Option<&'n str> {
    let similarity = |name: &str| strsim::jaro_winkler(&word.to_lowercase(), name);
    names
        .iter()
        .map(|name| (similarity(name), *name))
        .filter(|(similarity, _)| *similarity > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
