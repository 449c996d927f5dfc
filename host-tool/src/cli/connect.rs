//! Which controller a command speaks to.

use clap::Args;
use miette::Report;
use vitrine::link::{Address, Client, LinkError, choose};

/// Where the controller is.
#[derive(Args)]
pub(super) struct To {
    /// A serial port, tcp:HOST:PORT, or how the controller's serial number begins; not needed when there is only one.
    #[arg(long = "to", value_name = "PORT")]
    address: Option<Address>,
}

/// Where the controller is, and whether it is really asked.
#[derive(Args)]
pub(super) struct Sending {
    #[command(flatten)]
    pub(super) to: To,
    /// Only tell what would be sent: the controller is found and greeted, and asked for nothing else.
    #[arg(long)]
    pub(super) dry_run: bool,
}

impl Sending {
    /// Opens the link, greets, and unless it is a dry run does `send`.
    pub(super) fn send(
        self,
        send: impl FnOnce(&mut Client) -> Result<(), LinkError>,
    ) -> Result<Sent, Report> {
        let mut client = self.to.open()?;
        if self.dry_run {
            return Ok(Sent::NotSent);
        }
        send(&mut client)?;
        Ok(Sent::Sent)
    }
}

/// Whether a controller was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sent {
    /// It was.
    Sent,
    /// It would have been, but for --dry-run.
    NotSent,
}

impl Sent {
    /// For JSON.
    pub(super) fn is_sent(self) -> bool {
        self == Self::Sent
    }

    /// The sentence `done`, or that it was not sent.
    pub(super) fn in_words(self, done: String) -> String {
        match self {
            Self::Sent => done,
            Self::NotSent => format!("not sent: {done}"),
        }
    }
}

impl To {
    /// Opens the link and greets.
    pub(super) fn open(self) -> Result<Client, Report> {
        Ok(self.connect()?)
    }

    /// Finds the controller; it may be asked again after the controller has been away.
    pub(super) fn find(&self) -> Result<Address, LinkError> {
        choose(self.address.clone())
    }

    fn connect(self) -> Result<Client, LinkError> {
        Client::open(&self.find()?)
    }
}
