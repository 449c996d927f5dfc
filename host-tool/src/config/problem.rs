//! What is wrong with an exhibit.toml, with its place and its remedy.

use std::ops::Range;
use std::path::{Path, PathBuf};

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

use super::reader::AskedKey;

/// One thing wrong in exhibit.toml.
#[derive(Clone, Debug, Error)]
#[error("{message}")]
pub struct Problem {
    code: &'static str,
    message: String,
    label: String,
    span: SourceSpan,
    help: String,
}

impl Problem {
    /// Describes one thing wrong at `span`, a range of bytes of the file.
    pub fn new(
        code: &'static str,
        span: Range<usize>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self { code, message: message.into(), label: label.into(), span: span.into(), help: help.into() }
    }

    /// The stable name of this kind of problem, for `vitrine explain`.
    pub fn code_name(&self) -> &'static str {
        self.code
    }
}

impl Diagnostic for Problem {
    fn code<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        Some(Box::new(self.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        (!self.help.is_empty()).then(|| Box::new(&self.help) as Box<dyn std::fmt::Display>)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = miette::LabeledSpan> + '_>> {
        let label = (!self.label.is_empty()).then(|| self.label.clone());
        Some(Box::new(std::iter::once(miette::LabeledSpan::new_with_span(label, self.span))))
    }
}

/// What the reading of one exhibit.toml has found: what is wrong with it, and which keys were asked for.
#[derive(Debug, Default)]
pub(super) struct Problems {
    found: Vec<Problem>,
    asked: Vec<AskedKey>,
}

impl Problems {
    /// Notes a problem.
    pub(super) fn push(&mut self, problem: Problem) {
        self.found.push(problem);
    }

    /// Takes over what the reading of one table has found.
    pub(super) fn take_over(&mut self, problems: Vec<Problem>, asked: Vec<AskedKey>) {
        self.found.extend(problems);
        self.asked.extend(asked);
    }

    /// Whether nothing is wrong.
    pub(super) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// All that is wrong.
    pub(super) fn into_found(self) -> Vec<Problem> {
        self.found
    }

    /// The keys that were asked for, table by table; a key that was asked for in two ways stands in it twice.
    pub(super) fn into_asked(self) -> Vec<AskedKey> {
        self.asked
    }
}

/// Why an exhibit.toml cannot be used.
#[derive(Debug, Error, Diagnostic)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    #[diagnostic(code("vitrine::config::unreadable"), help("{}", unreadable_help(path, source)))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file's contents are wrong.
    #[error("{}: {}", source_code.name(), count_problems(problems.len()))]
    #[diagnostic(code("vitrine::config::invalid"))]
    Invalid {
        /// The file's text.
        #[source_code]
        source_code: NamedSource<String>,
        /// All that is wrong, in the order of the file.
        #[related]
        problems: Vec<Problem>,
    },
}

impl ConfigError {
    /// Reports `problems` of the file at `path`, in the order of the file.
    pub(super) fn invalid(path: &Path, text: &str, mut problems: Vec<Problem>) -> Self {
        problems.sort_by_key(|problem| problem.span.offset());
        let source_code = NamedSource::new(path.display().to_string(), text.to_owned()).with_language("toml");
        Self::Invalid { source_code, problems }
    }
}

fn count_problems(count: usize) -> String {
    if count == 1 { "1 problem".to_owned() } else { format!("{count} problems") }
}

fn unreadable_help(path: &Path, source: &std::io::Error) -> String {
    match source.kind() {
        std::io::ErrorKind::IsADirectory => {
            format!("it is a folder: name the file in it, such as {}", path.join("exhibit.toml").display())
        }
        std::io::ErrorKind::InvalidData => {
            "it is no text: save it as UTF-8, as editors do by default".to_owned()
        }
        std::io::ErrorKind::PermissionDenied => "you may not read it: look at its permissions".to_owned(),
        _ => "name an existing exhibit.toml; `vitrine new DIR` writes one to start from".to_owned(),
    }
}
