//! `vitrine firmware keygen`: makes a key that signs firmware.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::firmware::SecretKey;
use vitrine::plain;

use super::WriteFailure;
use crate::cli::output::Output;

/// Make a key of your own: boards built with its public part run only what its secret part has signed.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine firmware keygen --secret exhibit.secret.pem --public exhibit.public.pem

Keep the secret part where only those reach it who may change the firmware of your exhibits, and a \
copy of it elsewhere: if it is lost, boards can only be given new firmware by opening them.")]
pub(super) struct Keygen {
    /// Where the secret part goes; the file must not be there yet.
    #[arg(long, value_name = "FILE")]
    secret: PathBuf,
    /// Where the public part goes; the file must not be there yet.
    #[arg(long, value_name = "FILE")]
    public: PathBuf,
    /// Only tell which files would be written.
    #[arg(long)]
    dry_run: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum KeygenFailure {
    #[error("{} is there already", path.display())]
    #[diagnostic(
        code(vitrine::firmware::key_exists),
        help("a key is never overwritten: give another name, or move that file away yourself")
    )]
    Exists { path: PathBuf },
}

impl Keygen {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let key = if self.dry_run {
            self.look()?;
            None
        } else {
            Some(self.make()?.fingerprint())
        };
        let told = serde_json::json!({
            "secret": self.secret,
            "public": self.public,
            "key": key,
            "written": key.is_some(),
        });
        output.result(&told, || {
            let (secret, public) = (plain::path(&self.secret), plain::path(&self.public));
            match &key {
                Some(key) => format!("key {key}: keep {secret} secret; {public} goes into boards"),
                None => format!("a key would be made: {secret} to keep secret, {public} for boards"),
            }
        });
        Ok(())
    }

    /// Whether both files could be written.
    fn look(&self) -> Result<(), KeygenFailure> {
        let there = [&self.secret, &self.public].into_iter().find(|path| path.exists());
        there.map_or(Ok(()), |path| Err(KeygenFailure::Exists { path: path.clone() }))
    }

    fn make(&self) -> Result<SecretKey, Report> {
        let key = SecretKey::generate()?;
        let (secret, public) = (key.secret_pem()?, key.public_pem()?);
        write_new(&self.secret, &secret, true)?;
        if let Err(failure) = write_new(&self.public, &public, false) {
            // Half of a pair is of no use; it was not there before.
            let _ = std::fs::remove_file(&self.secret);
            return Err(failure);
        }
        Ok(key)
    }
}

fn write_new(path: &Path, text: &str, for_owner_alone: bool) -> Result<(), Report> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if for_owner_alone {
        use std::os::unix::fs::OpenOptionsExt;
        options.mode(0o600);
    }
    #[cfg(not(unix))]
    let _ = for_owner_alone;
    let written = options.open(path).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    written.map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => KeygenFailure::Exists { path: path.to_owned() }.into(),
        _ => WriteFailure::Write { path: path.to_owned(), source }.into(),
    })
}
