//! `vitrine log --live`: what the firmware tells as it runs, decoded with the image that runs.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use defmt_decoder::{DecodeError, Table};
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::link::Client;

use super::output::Output;

/// How often the controller is asked.
const PAUSE: Duration = Duration::from_millis(100);

/// Why there is nothing to decode with.
#[derive(Debug, Error, Diagnostic)]
pub(super) enum LiveError {
    /// The file cannot be read.
    #[error("the image {} cannot be read", path.display())]
    #[diagnostic(
        code(vitrine::log::image),
        help("give the ELF file of the image that the board runs: firmware/build.sh prints its path")
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file has no table of messages.
    #[error("{} is no image with messages: {reason}", path.display())]
    #[diagnostic(
        code(vitrine::log::no_messages),
        help("give the ELF file of the image that the board runs: firmware/build.sh prints its path")
    )]
    NoMessages {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// Prints what the controller tells until the time is over, or for ever.
pub(super) fn follow(
    mut client: Client,
    image: &Path,
    lasts: Option<Duration>,
    output: Output,
) -> Result<(), Report> {
    let table = table(image)?;
    let mut decoder = table.new_stream_decoder();
    let began = Instant::now();
    let (mut place, mut begins) = (None, true);
    while lasts.is_none_or(|lasts| began.elapsed() < lasts) {
        let (next, bytes) = client.live(place)?;
        place = Some(next);
        // Where nothing was written yet there are zeros, each of which would end an empty message.
        let blank = if begins { bytes.iter().take_while(|byte| **byte == 0).count() } else { 0 };
        begins &= blank == bytes.len();
        decoder.received(&bytes[blank..]);
        loop {
            match decoder.decode() {
                Ok(frame) => tell(&frame.display(false).to_string(), output),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => tell("(some messages were missed)", output),
            }
        }
        if bytes.is_empty() {
            std::thread::sleep(PAUSE);
        }
    }
    Ok(())
}

fn tell(message: &str, output: Output) {
    output.line(&serde_json::json!({ "message": message }), || message.to_owned());
}

fn table(image: &Path) -> Result<Table, LiveError> {
    let path = || image.to_owned();
    let bytes = std::fs::read(image).map_err(|source| LiveError::Unreadable { path: path(), source })?;
    let no_messages = |reason: String| LiveError::NoMessages { path: path(), reason };
    let table = Table::parse(&bytes).map_err(|error| no_messages(error.to_string()))?;
    table.ok_or_else(|| no_messages("it was built without defmt".to_owned()))
}
