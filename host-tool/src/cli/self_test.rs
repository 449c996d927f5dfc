//! `vitrine self-test`: walks through the exhibit's hardware and prints a sheet to sign.

use std::io::{BufRead, IsTerminal, Write, stdin};
use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::build_folder::write_file;
use vitrine::self_test::{Person, Verdict, walk};

use super::connect::To;
use super::output::Output;

/// Walk through every part of the hardware, and print a sheet to sign.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine self-test
  vitrine self-test -o sheet.txt --to /dev/ttyACM0
  vitrine self-test --alone --json | jq '.findings[] | select(.verdict == \"failed\")'

It reads sensors, clock, supply and flash, darkens, and lights each lamp by holding views of the exhibit's own plan, never \
brighter than the exhibit does. On a terminal it also asks a person to open the door, press the staff key and stand to \
either side. It takes about a minute, and ends with the exhibit following its viewers. The exit code is 1 when a part fails.")]
pub(super) struct SelfTest {
    /// Ask nobody: what needs a person is not tried. So it is without a terminal, and with --json.
    #[arg(long)]
    alone: bool,
    /// Write the sheet into this file too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Only tell what would be tried.
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    to: To,
}

#[derive(Debug, Error, Diagnostic)]
enum SelfTestFailure {
    #[error("{failed} of {all} parts failed")]
    #[diagnostic(
        code(vitrine::self_test::failed),
        help(
            "the sheet says which; `hardware/wiring.md` and the book's chapter on faults say what to look at"
        )
    )]
    Failed { failed: usize, all: usize },
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code(vitrine::self_test::write),
        help("look at the folder, the disk's free space and the permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
}

const PARTS: &str = "link, plan, event log, clock, lamp supply, temperatures, viewer sensors, interlock, dark, each lamp, \
ultraviolet sensor; with a person: door, re-arm, staff key, visitors to the right and left";

impl SelfTest {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let mut client = self.to.open()?;
        if self.dry_run {
            output.result(&serde_json::json!({ "would_try": PARTS }), || format!("would try: {PARTS}"));
            return Ok(());
        }
        let asks = !self.alone && !output.is_json() && stdin().is_terminal();
        let sheet = if asks { walk(&mut client, &mut AtTerminal)? } else { walk(&mut client, &mut Nobody)? };
        output.result(&sheet, || sheet.text().trim_end().to_owned());
        if let Some(path) = self.output {
            write_file(&path, sheet.text().as_bytes())
                .map_err(|source| SelfTestFailure::Write { path, source })?;
        }
        match sheet.count(Verdict::Failed) {
            0 => Ok(()),
            failed => Err(SelfTestFailure::Failed { failed, all: sheet.findings.len() }.into()),
        }
    }
}

struct Nobody;

impl Person for Nobody {
    fn does(&mut self, _what: &str) -> bool {
        false
    }
}

struct AtTerminal;

impl Person for AtTerminal {
    /// A terminal that fails counts as nobody there.
    fn does(&mut self, what: &str) -> bool {
        is_done(what, &mut stdin().lock(), &mut std::io::stderr())
    }
}

/// Asks until it is Enter, for done, or s, to skip.
fn is_done(what: &str, answers: &mut impl BufRead, questions: &mut impl Write) -> bool {
    if writeln!(questions, "{what}").is_err() {
        return false;
    }
    loop {
        let mut answer = String::new();
        let asked = write!(questions, "  [Enter] done   [s] skip  ").and_then(|()| questions.flush());
        match asked.and_then(|()| answers.read_line(&mut answer)) {
            Ok(1..) => {}
            Ok(0) | Err(_) => return false,
        }
        match answer.trim() {
            "" => return true,
            "s" | "S" => return false,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_enter_is_done_and_only_s_skips() {
        let is_done = |mut answers: &[u8]| is_done("Open the door.", &mut answers, &mut Vec::new());
        assert!(is_done(b"\n") && is_done(b"what\nn\n\n"));
        assert!(!is_done(b"s\n") && !is_done(b"no\nS\n\n"));
        assert!(!is_done(b"no\n") && !is_done(b""));
    }
}
