//! The way to a controller: addresses, transports, the client, and which controllers there are.
//!
//! [`Client`] speaks `vitrine-protocol` over a serial port or TCP alike. It asks, waits, asks again, and holds the
//! greeting against its own version. [`devices`] lists every port with what is behind it, or why it cannot be used.

mod address;
mod client;
mod discovery;
mod error;
mod follow;
mod transport;
mod update;
mod upload;

pub use address::{Address, AddressError};
pub use client::Client;
pub use discovery::{Announcement, Device, choose, devices};
pub use error::LinkError;
pub use follow::{Ask, Follower, Update};
pub use transport::{Serial, Tcp, Transport};
pub use update::{Installed, update};
pub use upload::{Progress, Stage};

#[cfg(test)]
pub(crate) mod tests;
