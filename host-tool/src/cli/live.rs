//! `vitrine log --live`: what the firmware tells as it runs, over the link or from a probe, decoded with the image that runs.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
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
    /// The probe's server cannot be reached, or has ended.
    #[error("the probe's RTT server at {address} does not answer")]
    #[diagnostic(
        code(vitrine::log::probe),
        help(
            "start it first, with OpenOCD: rtt setup 0x20000000 0x40000 \"SEGGER RTT\"; rtt start; rtt server start 9090 0"
        )
    )]
    Probe {
        /// Where it should be.
        address: String,
        /// What the operating system says.
        source: std::io::Error,
    },
}

/// Where the firmware's messages come from.
pub(super) enum Source {
    /// The link of all other commands.
    Link {
        /// The controller.
        client: Box<Client>,
        /// Where to go on in its ring.
        place: Option<u16>,
    },
    /// A probe's RTT server, such as OpenOCD's: the bytes as they come.
    Probe {
        /// Its address, HOST:PORT.
        address: String,
        /// The connection.
        stream: TcpStream,
    },
}

impl Source {
    /// The controller at the other end of a link.
    pub(super) fn link(client: Client) -> Self {
        Self::Link { client: Box::new(client), place: None }
    }

    /// The probe whose server listens at HOST:PORT.
    pub(super) fn probe(address: String) -> Result<Self, LiveError> {
        let connected = TcpStream::connect(&address).and_then(|stream| {
            stream.set_read_timeout(Some(PAUSE))?;
            Ok(stream)
        });
        match connected {
            Ok(stream) => Ok(Self::Probe { address, stream }),
            Err(source) => Err(LiveError::Probe { address, source }),
        }
    }

    /// What has come since the last call; waits a little where it is nothing.
    fn read(&mut self) -> Result<Vec<u8>, Report> {
        match self {
            Self::Link { client, place } => {
                let (next, bytes) = client.live(*place)?;
                *place = Some(next);
                if bytes.is_empty() {
                    std::thread::sleep(PAUSE);
                }
                Ok(bytes)
            }
            Self::Probe { address, stream } => {
                let mut bytes = [0; 1024];
                let failed = |source| LiveError::Probe { address: address.clone(), source };
                match stream.read(&mut bytes) {
                    Ok(0) => Err(failed(ErrorKind::ConnectionAborted.into()))?,
                    Ok(count) => Ok(bytes[..count].to_vec()),
                    Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                        Ok(Vec::new())
                    }
                    Err(error) => Err(failed(error))?,
                }
            }
        }
    }
}

/// Prints what the firmware tells until the time is over, or for ever.
pub(super) fn follow(
    mut source: Source,
    image: &Path,
    lasts: Option<Duration>,
    output: Output,
) -> Result<(), Report> {
    let table = table(image)?;
    let mut decoder = table.new_stream_decoder();
    let began = Instant::now();
    let mut begins = true;
    while lasts.is_none_or(|lasts| began.elapsed() < lasts) {
        let bytes = source.read()?;
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
