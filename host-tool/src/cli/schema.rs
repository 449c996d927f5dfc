//! `vitrine schema`: what files and answers look like, for editors and programs.

use clap::Args;
use miette::Report;
use vitrine::config;

use super::output::Output;

/// Print the JSON schema of exhibit.toml, by which editors complete and check it.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine schema > exhibit.schema.json

`vitrine new` writes it beside exhibit.toml, whose first line names it: editors with Taplo or Even Better TOML find it so.")]
pub(super) struct Schema {}

impl Schema {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let schema = config::schema();
        output.result(&schema, || serde_json::to_string_pretty(&schema).unwrap_or_default());
        Ok(())
    }
}
