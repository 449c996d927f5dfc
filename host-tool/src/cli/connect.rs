//! Which controller a command speaks to.

use clap::Args;
use miette::Report;
use vitrine::link::{Address, Client, LinkError, choose};

/// Where the controller is.
#[derive(Args)]
pub(super) struct To {
    /// A serial port, or tcp:HOST:PORT; not needed when there is only one controller.
    #[arg(long = "to", value_name = "PORT")]
    address: Option<Address>,
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
