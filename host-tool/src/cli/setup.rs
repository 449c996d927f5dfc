//! `vitrine explain` and `completions`: help for the command itself.

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use miette::{Diagnostic, Report};
use serde_json::json;
use thiserror::Error;
use vitrine::config::closest;

use super::Cli;
use super::output::Output;

/// What all codes begin with.
const COMMON: &str = "vitrine::";
const EXPLANATIONS: &str = include_str!("explain.txt");

/// Explain an error by its code, or list all codes.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine explain vitrine::config::unknown_key
  vitrine explain link::busy
  vitrine explain                     lists all codes")]
pub(super) struct Explain {
    /// The code that stands above an error's message; `vitrine::` may be left out.
    code: Option<String>,
}

/// Print a completion script for a shell.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine completions bash > ~/.local/share/bash-completion/completions/vitrine
  vitrine completions zsh > ~/.zfunc/_vitrine

It completes commands, options and the values that are always the same, not what only a build or a controller knows: names of \
views, serial numbers.")]
pub(super) struct Completions {
    /// The shell.
    shell: Shell,
}

#[derive(Debug, Error, Diagnostic)]
enum SetupFailure {
    #[error("there is no error with the code {code}")]
    #[diagnostic(code(vitrine::setup::no_such_code), help("{help}"))]
    NoSuchCode { code: String, help: String },
}

impl Explain {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let Some(code) = self.code else {
            let codes: Vec<&str> = explanations().map(|(code, _)| code).collect();
            output.result(&codes, || codes.join("\n"));
            return Ok(());
        };
        let full = if code.starts_with(COMMON) { code.clone() } else { format!("{COMMON}{code}") };
        let Some((code, text)) = explanations().find(|(known, _)| *known == full) else {
            // What all codes begin with would make every two alike.
            let ends: Vec<&str> = explanations().filter_map(|(code, _)| code.strip_prefix(COMMON)).collect();
            let help = match closest(code.strip_prefix(COMMON).unwrap_or(&code), &ends) {
                Some(known) => format!("did you mean {COMMON}{known}? `vitrine explain` lists all codes"),
                None => "`vitrine explain` lists all codes".to_owned(),
            };
            return Err(SetupFailure::NoSuchCode { code, help }.into());
        };
        output.result(&json!({ "code": code, "explanation": text }), || format!("{code}\n\n{text}"));
        Ok(())
    }
}

/// Codes with their explanations.
fn explanations() -> impl Iterator<Item = (&'static str, &'static str)> {
    let sections = EXPLANATIONS.split("# ").filter(|section| !section.is_empty());
    sections.filter_map(|section| section.split_once('\n')).map(|(code, text)| (code, text.trim()))
}

impl Completions {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "vitrine", &mut script);
        let script = String::from_utf8_lossy(&script).into_owned();
        output.result(&json!({ "shell": self.shell.to_string(), "script": script }), || script.clone());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    /// All error codes in the crate's sources.
    fn codes_in(folder: &Path, found: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                codes_in(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                for mark in ["code(vitrine::", "\"vitrine::"] {
                    found.extend(text.split(mark).skip(1).filter_map(code));
                }
            }
        }
    }

    /// The code at the start of `text`, `vitrine::` being cut off: two words of lower case.
    fn code(text: &str) -> Option<String> {
        let end = text.find(|c: char| !(c.is_ascii_lowercase() || c == '_' || c == ':'))?;
        let ended = text[end..].starts_with(['"', ')']);
        (ended && text[..end].matches("::").count() == 1).then(|| format!("vitrine::{}", &text[..end]))
    }

    #[test]
    fn every_error_code_has_its_explanation_and_no_other_has() {
        let mut used = BTreeSet::new();
        codes_in(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut used);
        let explained: Vec<&str> = explanations().map(|(code, _)| code).collect();
        assert!(used.len() > 50, "{used:?}");
        assert!(explained.is_sorted());
        assert_eq!(used.iter().map(String::as_str).collect::<Vec<_>>(), explained);
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
