//! `vitrine firmware build`: everything that a board is given, from the sources.

use std::env;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::Args;
use miette::{Diagnostic, Report};
use serde_json::{Value, json};
use thiserror::Error;
use vitrine::build_folder::write_file;
use vitrine::firmware::{SecretKey, SignedImage, Sizes, bootloader, image, join, sign, sizes, uf2};
use vitrine::plain;

use super::{Signing, WriteFailure};
use crate::cli::output::Output;

/// Build boot loader and firmware from the sources, sign the firmware, and join both for a first flashing.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine firmware build --key exhibit.secret.pem -o firmware-0.2.0
  vitrine firmware build --version 0.2.0-rc1 -o firmware

Leaves in the folder:
  firmware.uf2      boot loader and firmware, for a new board: hold BOOTSEL, plug it in, copy it
  firmware.bin      the same bytes, for a probe: they belong at 0x10000000
  firmware.signed   the firmware alone, for `vitrine firmware update`
  vitrine-pico.elf, vitrine-bootloader.elf    for probes, and for `vitrine log --live`")]
pub(super) struct Build {
    #[command(flatten)]
    signing: Signing,
    /// The folder of Vitrine's sources; without it the one that the current folder lies in.
    #[arg(long, value_name = "DIR")]
    source: Option<PathBuf>,
    /// The folder for what is built; it is made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Only tell what would be built, signed and written.
    #[arg(long)]
    dry_run: bool,
}

/// What is left in the folder.
const FILES: [&str; 5] =
    ["firmware.uf2", "firmware.bin", "firmware.signed", "vitrine-bootloader.elf", "vitrine-pico.elf"];

#[derive(Debug, Error, Diagnostic)]
enum BuildFailure {
    #[error("there is no firmware/build.sh in {} nor in the folders above it", start.display())]
    #[diagnostic(
        code(vitrine::firmware::no_source),
        help("run this in a clone of Vitrine's sources, or name it with --source")
    )]
    NoSource { start: PathBuf },
    #[error("{} cannot be run", script.display())]
    #[diagnostic(
        code(vitrine::firmware::build_script),
        help("it needs bash; `bash firmware/build.sh` tells more")
    )]
    Script { script: PathBuf, source: io::Error },
    #[error("firmware/build.sh failed")]
    #[diagnostic(code(vitrine::firmware::build_failed), help("its last lines above say why"))]
    Failed,
}

impl Build {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let source = self.source()?;
        let key = self.signing.key(output)?;
        if self.dry_run {
            self.tell_plan(&source, &key, output);
            return Ok(());
        }
        std::fs::create_dir_all(&self.output)
            .map_err(|source| WriteFailure::Write { path: self.output.clone(), source })?;
        build(&source, &key, output)?;
        let built = source.join("target/firmware");
        let elf = ["vitrine-bootloader.elf", "vitrine-pico.elf"].map(|name| built.join(name));
        let [loader, firmware] = [bootloader(&elf[0])?, image(&elf[1])?];
        let signed = sign(&firmware, &self.signing.version, &key);
        let flash = join(&loader, &signed);
        let contents = [uf2(&flash), flash, signed.clone(), read(&elf[0])?, read(&elf[1])?];
        for (name, bytes) in FILES.into_iter().zip(contents) {
            let path = self.output.join(name);
            write_file(&path, &bytes).map_err(|source| WriteFailure::Write { path, source })?;
        }
        let sizes = [sizes(&elf[0])?, sizes(&elf[1])?];
        let told = json!({
            "folder": self.output,
            "version": self.signing.version,
            "blake3": SignedImage::from_bytes(signed).ok().map(|signed| signed.digest()),
            "key": key.fingerprint(),
            "development_key": key.is_development(),
            "boot_loader": as_json(sizes[0]),
            "firmware": as_json(sizes[1]),
            "files": FILES,
            "written": true,
        });
        output.result(&told, || {
            let line = |name: &str, sizes: Sizes| {
                format!("{name:12} {:>7} bytes of flash, {:>6} of static RAM", sizes.flash, sizes.static_ram)
            };
            format!(
                "{}\n{}\n{}: firmware {}, signed with the key {}",
                line("boot loader", sizes[0]),
                line("firmware", sizes[1]),
                plain::path(&self.output),
                self.signing.version,
                key.fingerprint()
            )
        });
        Ok(())
    }

    fn tell_plan(&self, source: &Path, key: &SecretKey, output: Output) {
        let told = json!({
            "folder": self.output,
            "version": self.signing.version,
            "blake3": null,
            "key": key.fingerprint(),
            "development_key": key.is_development(),
            "boot_loader": null,
            "firmware": null,
            "files": FILES,
            "written": false,
        });
        output.result(&told, || {
            format!(
                "{}: firmware {} of the sources in {} would be built, and signed with the key {}: {}",
                plain::path(&self.output),
                self.signing.version,
                plain::path(source),
                key.fingerprint(),
                FILES.join(", ")
            )
        });
    }

    fn source(&self) -> Result<PathBuf, BuildFailure> {
        let start = match &self.source {
            Some(source) => source.clone(),
            None => env::current_dir().unwrap_or_else(|_| PathBuf::from(".")),
        };
        let found = start.ancestors().find(|folder| folder.join("firmware/build.sh").is_file());
        found.map(Path::to_owned).ok_or(BuildFailure::NoSource { start })
    }
}

/// Runs firmware/build.sh with the public key in place; what it tells goes where notes go.
fn build(source: &Path, key: &SecretKey, output: Output) -> Result<(), Report> {
    let script = source.join("firmware/build.sh");
    let mut public = tempfile::NamedTempFile::new()
        .map_err(|source| WriteFailure::Write { path: env::temp_dir(), source })?;
    io::Write::write_all(&mut public, key.public_pem()?.as_bytes())
        .map_err(|source| WriteFailure::Write { path: public.path().to_owned(), source })?;
    let mut command = Command::new("bash");
    command.arg(&script).stdin(Stdio::null()).stdout(Stdio::null());
    if output.is_json() {
        command.stderr(Stdio::null());
    }
    // The development key is what build.sh takes by itself; naming it would build everything anew.
    if key.is_development() {
        command.env_remove("VITRINE_PUBLIC_KEY");
    } else {
        command.env("VITRINE_PUBLIC_KEY", public.path());
    }
    let status = command.status().map_err(|source| BuildFailure::Script { script, source })?;
    if status.success() { Ok(()) } else { Err(BuildFailure::Failed.into()) }
}

fn read(path: &Path) -> Result<Vec<u8>, Report> {
    std::fs::read(path).map_err(|source| WriteFailure::Write { path: path.to_owned(), source }.into())
}

fn as_json(sizes: Sizes) -> Value {
    json!({ "flash_bytes": sizes.flash, "static_ram_bytes": sizes.static_ram })
}
