//! `vitrine man`: the man pages.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use miette::{Diagnostic, Report};
use serde_json::json;
use thiserror::Error;
use vitrine::build_folder::write_file;
use vitrine::plain;

use super::Cli;
use super::output::Output;

/// The longest line of a page's source, as mandoc advises.
const LONGEST_LINE: usize = 80;

/// Write the man pages into a folder.
#[derive(Args)]
#[command(after_help = "Examples:\n  vitrine man ~/.local/share/man/man1\n  vitrine man . --dry-run")]
pub(super) struct Man {
    /// The folder, which must exist.
    folder: PathBuf,
    /// Only tell which pages would be written.
    #[arg(long)]
    dry_run: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum ManFailure {
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code(vitrine::man::write),
        help("look at the folder, the disk's free space and the permissions")
    )]
    Write { path: PathBuf, source: std::io::Error },
}

impl Man {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let mut written = Vec::new();
        let mut command = Cli::command().disable_help_subcommand(true);
        command.build();
        let today = jiff::Timestamp::now().strftime("%Y-%m-%d").to_string();
        for page in pages(&command) {
            let man = clap_mangen::Man::new(page.clone());
            let path = self.folder.join(man.get_filename());
            let title = man.get_filename().trim_end_matches(".1").to_uppercase();
            let man = man
                .title(title)
                .date(&today)
                .source(concat!("vitrine ", env!("CARGO_PKG_VERSION")))
                .manual("Vitrine");
            let write = |source| ManFailure::Write { path: path.clone(), source };
            let mut text = Vec::new();
            man.render(&mut text).map_err(write)?;
            if !self.dry_run {
                write_file(&path, mended(&String::from_utf8_lossy(&text)).as_bytes()).map_err(write)?;
            }
            written.push(path);
        }
        output.result(&json!({ "files": written, "written": !self.dry_run }), || {
            written.iter().map(plain::path).collect::<Vec<_>>().join("\n")
        });
        Ok(())
    }
}

/// A command and all commands within it.
fn pages(command: &clap::Command) -> Vec<&clap::Command> {
    std::iter::once(command).chain(command.get_subcommands().flat_map(pages)).collect()
}

/// A page's source without what `mandoc -T lint` warns of: breaks around an empty line, spaces at a line's end, long lines.
fn mended(roff: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    for line in roff.lines().map(str::trim_end) {
        let last = lines.last().copied().unwrap_or_default();
        match (last, line) {
            // A blank line breaks by itself.
            (".br" | "", ".br") => {}
            (".br", "") => {
                lines.pop();
                lines.push(".sp");
            }
            (".sp", ".br") | (_, "") if last == ".sp" => {}
            _ => lines.push(line),
        }
    }
    let mut text: String = lines.into_iter().map(folded).collect();
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}

/// A line that goes on in the next where it is too long for one; a request ends with its line.
fn folded(line: &str) -> String {
    let mut folded = String::new();
    let mut rest = line;
    // The backslash that lets it go on has room, too.
    while rest.len() >= LONGEST_LINE && !line.starts_with('.') {
        let fits = rest.char_indices().take_while(|(at, _)| *at < LONGEST_LINE - 1);
        let spaces = fits.filter(|(at, letter)| *letter == ' ' && !rest[..*at].trim().is_empty());
        let Some((space, _)) = spaces.last() else { break };
        let (first, then) = rest.split_at(space + 1);
        folded += first;
        folded += "\\\n";
        rest = then;
    }
    folded + rest + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaks_spaces_and_long_lines_are_mended() {
        let roff = ".SH A  \nShort \n.br\n\n.br\nnext\n.sp\n.br\nlast\n\n";
        assert_eq!(mended(roff), ".SH A\nShort\n.sp\nnext\n.sp\nlast\n");
        let long = format!("  {}", "some words ".repeat(20));
        let folded = mended(&long);
        assert!(folded.lines().all(|line| line.len() <= LONGEST_LINE), "{folded}");
        assert_eq!(folded.replace("\\\n", "").trim_end(), long.trim_end());
        let word = "x".repeat(100);
        assert_eq!(mended(&word), format!("{word}\n"), "a word is not torn");
    }
}
