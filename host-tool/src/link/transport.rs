//! Bytes to and from a controller.

use std::{
    io::{self, Read, Write},
    net::{TcpStream, ToSocketAddrs},
    time::Duration,
};

use serialport::SerialPort;

use super::{Address, LinkError};

const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// USB CDC does not care; the service UART runs at this rate.
const BAUD: u32 = 115_200;

/// A plain stream of bytes in both directions.
pub trait Transport: Send {
    /// Sends all bytes.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;
    /// Waits at most so long for bytes; 0 if none came.
    fn receive(&mut self, bytes: &mut [u8], patience: Duration) -> io::Result<usize>;
}

/// Opens the transport of an address.
pub(super) fn open(address: &Address) -> Result<Box<dyn Transport>, LinkError> {
    let opened: io::Result<Box<dyn Transport>> = match address {
        Address::Serial(port) => Serial::open(port).map(|port| Box::new(port) as Box<dyn Transport>),
        Address::Tcp(place) => Tcp::connect(place).map(|stream| Box::new(stream) as Box<dyn Transport>),
    };
    opened.map_err(|error| LinkError::from_open(address, error))
}

/// A TCP connection.
#[derive(Debug)]
pub struct Tcp(TcpStream);

impl Tcp {
    /// Connects to `HOST:PORT`.
    pub fn connect(place: &str) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for socket in place.to_socket_addrs().map_err(|_| io::Error::from(io::ErrorKind::NotFound))? {
            match TcpStream::connect_timeout(&socket, CONNECT_TIMEOUT) {
                Ok(stream) => {
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
                    return Ok(Self(stream));
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

impl Transport for Tcp {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }

    fn receive(&mut self, bytes: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.0.set_read_timeout(Some(patience.max(Duration::from_millis(1))))?;
        match self.0.read(bytes) {
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            Err(error) if is_timeout(&error) => Ok(0),
            outcome => outcome,
        }
    }
}

/// A serial port, locked against other programs.
pub struct Serial(Box<dyn SerialPort>);

impl Serial {
    /// Opens a port for this program alone.
    pub fn open(port: &str) -> io::Result<Self> {
        let mut port = serialport::new(port, BAUD)
            .exclusive(true)
            .timeout(WRITE_TIMEOUT)
            .open()
            .map_err(from_serialport)?;
        // A USB CDC device listens once the host says that it is there.
        let _adapters_without_this_line_exist = port.write_data_terminal_ready(true);
        Ok(Self(port))
    }
}

impl Transport for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.set_timeout(WRITE_TIMEOUT)?;
        self.0.write_all(bytes)
    }

    fn receive(&mut self, bytes: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.0.set_timeout(patience.max(Duration::from_millis(1)))?;
        match self.0.read(bytes) {
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            Err(error) if is_timeout(&error) => Ok(0),
            outcome => outcome,
        }
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// The operating system's own word on a port, where serialport keeps it.
fn from_serialport(error: serialport::Error) -> io::Error {
    let kind = match error.kind() {
        serialport::ErrorKind::Io(kind) => kind,
        serialport::ErrorKind::NoDevice | serialport::ErrorKind::Unknown => from_words(&error.description),
        serialport::ErrorKind::InvalidInput => io::ErrorKind::InvalidInput,
    };
    io::Error::new(kind, error.description)
}

/// serialport gives a port that is gone and a port that is taken the same kind: only the words differ.
fn from_words(description: &str) -> io::ErrorKind {
    let description = description.to_ascii_lowercase();
    if description.contains("busy") || description.contains("lock") {
        io::ErrorKind::ResourceBusy
    } else if description.contains("no such") {
        io::ErrorKind::NotFound
    } else {
        io::ErrorKind::Other
    }
}
