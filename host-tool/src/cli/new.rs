//! `vitrine new`: starts an exhibit with the bundled photographs, or with one's own.

use std::path::PathBuf;

use clap::Args;
use miette::Report;
use vitrine::plain;
use vitrine::starter;

use super::output::Output;

/// Start an exhibit: a folder with a commented exhibit.toml and pictures.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine new my-exhibit                  three bundled photographs, to be replaced
  vitrine new my-exhibit --from photos    those in photos, by name from the right to the left
  vitrine check my-exhibit/exhibit.toml   says how well each will be seen, and what would help
  vitrine design my-exhibit/exhibit.toml -o build")]
pub(super) struct New {
    /// The folder to make; it must not exist, or be empty.
    folder: PathBuf,
    /// Show the pictures in this folder, by name: 1 to 16 PNG, JPEG, TIFF or WebP files, which are copied.
    #[arg(long, value_name = "PHOTOS")]
    from: Option<PathBuf>,
    /// Only tell which files would be written.
    #[arg(long)]
    dry_run: bool,
}

impl New {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let own = self.from.as_deref().map(starter::own_pictures).transpose()?;
        let (own, left_out) = own.map(|own| (own.pictures, own.left_out)).unzip();
        let left_out: Vec<String> = left_out.unwrap_or_default();
        if !left_out.is_empty() {
            output.note(&format!("left out, being none of PNG, JPEG, TIFF or WebP: {}", left_out.join(", ")));
        }
        let exhibit = self.folder.join("exhibit.toml");
        if self.dry_run {
            starter::check_place(&self.folder)?;
            let pictures = match own {
                Some(own) => own.into_iter().map(|picture| picture.file_name).collect(),
                None => starter::PHOTOGRAPHS.map(|(name, _)| name.to_owned()).to_vec(),
            };
            let names = [vec!["exhibit.toml".to_owned(), starter::SCHEMA_NAME.to_owned()], pictures].concat();
            output.result(
                &serde_json::json!({ "folder": self.folder, "files": names, "left_out": left_out, "written": false }),
                || format!("would write {} into {}", names.join(", "), plain::path(&self.folder)),
            );
            return Ok(());
        }
        let files = match own {
            Some(own) => starter::write_own(&self.folder, own)?,
            None => starter::write(&self.folder)?,
        };
        output.result(
            &serde_json::json!({ "folder": self.folder, "files": files, "left_out": left_out, "written": true }),
            || plain::path(&exhibit),
        );
        output.note(&format!(
            "Next: vitrine check {0}, then vitrine design {0} -o {1}",
            plain::word(&exhibit),
            plain::word(self.folder.join("build"))
        ));
        Ok(())
    }
}
