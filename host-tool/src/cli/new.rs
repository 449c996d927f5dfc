//! `vitrine new`: starts an exhibit with the bundled photographs.

use std::path::PathBuf;

use clap::Args;
use miette::Report;
use vitrine::starter;

use super::output::Output;

/// Start an exhibit: a folder with a commented exhibit.toml and three photographs.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  vitrine new my-exhibit\n  vitrine design my-exhibit/exhibit.toml -o build"
)]
pub(super) struct New {
    /// The folder to make; it must not exist, or be empty.
    folder: PathBuf,
}

impl New {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let files = starter::write(&self.folder)?;
        let exhibit = self.folder.join("exhibit.toml");
        output.result(&serde_json::json!({ "folder": self.folder, "files": files }), || {
            exhibit.display().to_string()
        });
        output.note(&format!(
            "Next: vitrine design {} -o {}",
            exhibit.display(),
            self.folder.join("build").display()
        ));
        Ok(())
    }
}
