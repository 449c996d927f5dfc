//! Where a controller is: a serial port, or `tcp:HOST:PORT`.

use std::{fmt, str::FromStr};

/// Where a controller is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Address {
    /// A serial port by its path or name, as in `/dev/ttyACM0` or `COM3`.
    Serial(String),
    /// A TCP port by `HOST:PORT`, as in `127.0.0.1:7470` or `[::1]:7470`.
    Tcp(String),
}

/// Why a text is no address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum AddressError {
    /// Nothing there.
    #[error("the address is empty")]
    #[diagnostic(
        code(vitrine::link::address),
        help("give a serial port, as in /dev/ttyACM0, or tcp:HOST:PORT")
    )]
    Empty,
    /// `tcp:` without host and port.
    #[error("`{0}` has no port between 0 and 65535 behind its last colon")]
    #[diagnostic(code(vitrine::link::address), help("write tcp:HOST:PORT, as in tcp:127.0.0.1:7470"))]
    Port(String),
}

impl FromStr for Address {
    type Err = AddressError;

    /// `tcp:HOST:PORT`, or `tcp:PORT` on this computer; everything else is a serial port.
    fn from_str(text: &str) -> Result<Self, AddressError> {
        if text.is_empty() {
            return Err(AddressError::Empty);
        }
        let Some(place) = text.strip_prefix("tcp:") else {
            return Ok(Self::Serial(text.to_owned()));
        };
        let (host, port) = place.rsplit_once(':').unwrap_or(("127.0.0.1", place));
        let host = if host.is_empty() { "127.0.0.1" } else { host };
        let port: u16 = port.parse().map_err(|_| AddressError::Port(text.to_owned()))?;
        Ok(Self::Tcp(format!("{host}:{port}")))
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(port) => f.write_str(port),
            Self::Tcp(place) => write!(f, "tcp:{place}"),
        }
    }
}
