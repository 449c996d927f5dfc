//! An error as it is told: whatever its words were made of, no terminal obeys them.

use std::error::Error;
use std::fmt;

use miette::{Diagnostic, LabeledSpan, NamedSource, Severity, SourceCode, SourceSpan};
use vitrine::plain;

/// A plain copy of an error.
#[derive(Debug)]
pub(super) struct Told {
    message: String,
    code: Option<String>,
    severity: Option<Severity>,
    help: Option<String>,
    source_code: Option<NamedSource<String>>,
    labels: Option<Vec<LabeledSpan>>,
    related: Option<Vec<Told>>,
    cause: Option<Cause>,
}

/// What is behind an error.
#[derive(Debug)]
struct Cause {
    message: String,
    cause: Option<Box<Cause>>,
}

impl Told {
    pub(super) fn new(of: &dyn Diagnostic) -> Self {
        let said = |said: Box<dyn fmt::Display + '_>| plain::name(&said.to_string()).into_owned();
        let label = |label: LabeledSpan| {
            let text = label.label().map(|text| plain::name(text).into_owned());
            LabeledSpan::new_with_span(text, *label.inner())
        };
        Self {
            message: plain::name(&of.to_string()).into_owned(),
            code: of.code().map(said),
            severity: of.severity(),
            help: of.help().map(said),
            source_code: of.source_code().and_then(whole),
            labels: of.labels().map(|labels| labels.map(label).collect()),
            related: of.related().map(|related| related.map(Self::new).collect()),
            cause: of.source().map(Cause::new),
        }
    }
}

impl Cause {
    fn new(of: &(dyn Error + 'static)) -> Self {
        let cause = of.source().map(|cause| Box::new(Self::new(cause)));
        Self { message: plain::name(&of.to_string()).into_owned(), cause }
    }
}

/// The whole of a source, its places where they were.
fn whole(source: &dyn SourceCode) -> Option<NamedSource<String>> {
    let contents = source.read_span(&SourceSpan::from(0), 0, usize::MAX).ok()?;
    let text = String::from_utf8_lossy(contents.data());
    Some(NamedSource::new(plain::name(contents.name()?), plain::in_place(&text)))
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Error for Told {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.cause.as_ref().map(|cause| cause as &(dyn Error + 'static))
    }
}

impl Error for Cause {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.cause.as_deref().map(|cause| cause as &(dyn Error + 'static))
    }
}

impl Diagnostic for Told {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.code.as_ref().map(|code| Box::new(code) as Box<dyn fmt::Display>)
    }

    fn severity(&self) -> Option<Severity> {
        self.severity
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source_code.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let labels = self.labels.as_ref()?.iter().cloned();
        Some(Box::new(labels))
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let related = self.related.as_ref()?.iter().map(|told| told as &dyn Diagnostic);
        Some(Box::new(related))
    }
}
