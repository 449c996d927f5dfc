//! `vitrine firmware sign`: makes an ELF file a signed image.

use std::path::PathBuf;

use clap::Args;
use miette::Report;
use vitrine::build_folder::write_file;
use vitrine::firmware::{SignedImage, image, sign};
use vitrine::plain;

use super::{Signing, WriteFailure};
use crate::cli::output::Output;

/// Sign the firmware that firmware/build.sh has built, for an update.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine firmware sign target/firmware/vitrine-pico.elf --key exhibit.secret.pem -o firmware.signed
  vitrine firmware sign target/firmware/vitrine-pico.elf --version 0.2.0-rc1 -o firmware.signed")]
pub(super) struct Sign {
    /// The firmware's ELF file.
    image: PathBuf,
    #[command(flatten)]
    signing: Signing,
    /// Where the signed image goes.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Only tell what would be signed.
    #[arg(long)]
    dry_run: bool,
}

impl Sign {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let image = image(&self.image)?;
        let key = self.signing.key(output)?;
        let bytes = sign(&image, &self.signing.version, &key);
        if !self.dry_run {
            write_file(&self.output, &bytes)
                .map_err(|source| WriteFailure::Write { path: self.output.clone(), source })?;
        }
        let told = serde_json::json!({
            "file": self.output,
            "version": self.signing.version,
            "bytes": bytes.len(),
            "blake3": SignedImage::from_bytes(bytes.clone()).ok().map(|signed| signed.digest()),
            "key": key.fingerprint(),
            "development_key": key.is_development(),
            "written": !self.dry_run,
        });
        output.result(&told, || {
            let done = if self.dry_run { "would be signed" } else { "is signed" };
            let (version, key) = (&self.signing.version, key.fingerprint());
            format!(
                "{}: firmware {version}, {} bytes, {done} with the key {key}",
                plain::path(&self.output),
                bytes.len()
            )
        });
        Ok(())
    }
}
