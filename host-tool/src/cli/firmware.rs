//! `vitrine firmware`: building, signing and installing the controller's firmware.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::firmware::SecretKey;

use super::output::Output;

mod build;
mod keygen;
mod sign;
mod update;

/// Build, sign and install the controller's firmware.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine firmware keygen --secret exhibit.secret.pem --public exhibit.public.pem
  vitrine firmware build --key exhibit.secret.pem -o firmware-0.2.0
  vitrine firmware update firmware-0.2.0/firmware.signed

A board runs only what is signed with its key, and goes back to what ran before when new firmware \
does not show within a minute that it works.")]
pub(super) struct Firmware {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    Build(build::Build),
    Sign(sign::Sign),
    Keygen(keygen::Keygen),
    Update(update::Update),
}

impl Firmware {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        match self.task {
            Task::Build(task) => task.run(output),
            Task::Sign(task) => task.run(output),
            Task::Keygen(task) => task.run(output),
            Task::Update(task) => task.run(output),
        }
    }
}

/// Which key signs.
#[derive(Args)]
struct Signing {
    /// The secret key's file; without it the development key, with which anybody can sign.
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// The firmware's version, as it will tell it.
    #[arg(long, value_name = "VERSION", default_value = env!("CARGO_PKG_VERSION"), value_parser = version)]
    version: String,
}

impl Signing {
    /// Reads the key, and warns of one that is no secret.
    fn key(&self, output: Output) -> Result<SecretKey, Report> {
        let key = match &self.key {
            Some(path) => SecretKey::read(path)?,
            None => SecretKey::development(),
        };
        if key.is_development() {
            output.note(DEVELOPMENT_WARNING);
        }
        Ok(key)
    }
}

const DEVELOPMENT_WARNING: &str = "warning: this is signed with the development key, whose secret part is published. Anybody \
                                   can sign for a board that takes it: never for an exhibit. `vitrine firmware keygen` makes a \
                                   key of your own.";

#[derive(Debug, Error, Diagnostic)]
enum WriteFailure {
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code(vitrine::firmware::write),
        help("look at the folder, the disk's free space and the permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
}

/// Versions fit the 24 bytes of a header, and can be told in a terminal.
fn version(text: &str) -> Result<String, String> {
    let fits = (1..=24).contains(&text.len())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || ".-+".contains(letter));
    if fits {
        Ok(text.to_owned())
    } else {
        Err("give 1 to 24 letters, digits, dots, dashes and plus signs".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_fit_a_header() {
        for good in ["0.1.0", "1.2.3-rc1", "2026.11+abc"] {
            assert_eq!(version(good).as_deref(), Ok(good));
        }
        for wrong in ["", "a version", "0.1.0\u{7}", "ü", &"1".repeat(25)] {
            assert!(version(wrong).is_err(), "{wrong}");
        }
    }
}
