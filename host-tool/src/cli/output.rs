//! Where results and errors go.

use std::io::{IsTerminal, Write};

use miette::{GraphicalReportHandler, GraphicalTheme, JSONReportHandler, Report};
use serde::Serialize;
use vitrine::plain;

use super::told::Told;

/// Prints results to stdout and everything else to stderr, as text or as JSON.
#[derive(Clone, Copy)]
pub(crate) struct Output {
    json: bool,
}

impl Output {
    pub(crate) fn new(json: bool) -> Self {
        Self { json }
    }

    /// Whether results are wanted as JSON.
    pub(crate) fn is_json(self) -> bool {
        self.json
    }

    /// Prints a result: `value` as JSON, or `text`.
    pub(crate) fn result(self, value: &impl Serialize, text: impl FnOnce() -> String) {
        let line = if self.json { to_json(value) } else { text() };
        // An empty list has no line.
        if !line.is_empty() {
            print_line(std::io::stdout(), &line);
        }
    }

    /// Prints one of many results, each on a line of its own.
    pub(crate) fn line(self, value: &impl Serialize, text: impl FnOnce() -> String) {
        let line = if self.json { serde_json::to_string(value).unwrap_or_default() } else { text() };
        print_line(std::io::stdout(), &line);
    }

    /// Tells a person what is going on; programs that read JSON are not told.
    pub(crate) fn note(self, text: &str) {
        if !self.json {
            print_line(std::io::stderr(), text);
        }
    }

    /// Asks a person on the terminal; nothing where there is none, or where JSON is wanted.
    pub(crate) fn asks(self, question: &str) -> std::io::Result<Option<bool>> {
        let terminal = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        if self.json || !terminal {
            return Ok(None);
        }
        let mut stream = std::io::stderr();
        write!(stream, "{} [y/N] ", plain::name(question))?;
        stream.flush()?;
        let mut answer = String::new();
        std::io::stdin().read_line(&mut answer)?;
        Ok(Some(is_yes(&answer)))
    }

    /// Prints why a command failed.
    pub(crate) fn error(self, report: &Report) {
        let mut text = String::new();
        if self.json {
            if JSONReportHandler::new().render_report(&mut text, report.as_ref()).is_err() {
                text = report.to_string();
            }
            print_line(std::io::stderr(), text.trim_end());
            return;
        }
        let told = Told::new(report.as_ref());
        if graphical().render_report(&mut text, &told).is_err() {
            text = told.to_string();
        }
        // Its colours are all that a terminal obeys in it.
        print_as_it_is(std::io::stderr(), text.trim_end());
    }
}

/// Anything but a clear yes is a no.
fn is_yes(answer: &str) -> bool {
    matches!(answer.trim().to_lowercase().as_str(), "y" | "yes")
}

/// Plain lines where nobody watches a terminal, and where NO_COLOR asks for them.
fn graphical() -> GraphicalReportHandler {
    let plain = !std::io::stderr().is_terminal()
        || std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let theme = if plain { GraphicalTheme::none() } else { GraphicalTheme::unicode() };
    GraphicalReportHandler::new_themed(theme).with_width(if plain { 240 } else { 100 }).with_links(!plain)
}

fn to_json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default()
}

/// Prints what may be made of foreign names, so that no terminal obeys them.
fn print_line(stream: impl Write, line: &str) {
    print_as_it_is(stream, &plain::lines(line));
}

/// A reader that has gone away, such as `head`, is no reason to fail.
fn print_as_it_is(mut stream: impl Write, line: &str) {
    let _ = writeln!(stream, "{line}");
}

#[cfg(test)]
mod tests {
    use super::is_yes;

    #[test]
    fn only_yes_is_a_yes() {
        assert!(["y", "Y\n", " yes \n"].into_iter().all(is_yes));
        assert!(!["", "\n", "n", "yess", "j", "no"].into_iter().any(is_yes));
    }
}
