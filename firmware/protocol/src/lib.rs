//! What host and controller say to each other; both ends compile this crate.
//!
//! # Wire format
//!
//! The same bytes travel over USB CDC, UART and TCP:
//!
//! ```text
//!            ┌────────────────────────────────┬─────────────────┐
//!  body      │ postcard( sequence, message )  │ CRC-32, LE, of  │   at most MAX_BODY bytes
//!            │                                │ what precedes   │
//!            └────────────────────────────────┴─────────────────┘
//!            ┌──────────────────────────────────────────┬───────┐
//!  frame     │ COBS( body )                             │ 0x00  │   at most MAX_FRAME bytes
//!            └──────────────────────────────────────────┴───────┘
//! ```
//!
//! - The host asks ([`Request`]), the controller answers each request once ([`Reply`]) and never speaks unasked.
//! - `sequence` is chosen by the host and echoed. A host that hears nothing sends the same frame again: every
//!   request may be repeated without harm.
//! - 0x00 occurs only as the end of a frame, so that either side, whatever it heard before, understands the next
//!   whole frame. Empty frames are ignored: a host sends one 0x00 to end what others left unfinished.
//! - The CRC is CRC-32/ISO-HDLC, as in zip and PNG.
//!
//! # Versions
//!
//! The first request is [`Request::Hello`]. Its encoding, that of [`Hello`], of the envelope and of the frame are
//! frozen in every version, so that any host can name any controller; and so are the few messages of a firmware update
//! ([`Request::is_of_an_update`]), so that any host can update any controller. Everything else may change with [`VERSION`];
//! [`FINGERPRINT`] is computed at compile time from the golden bytes of all messages and of a plan
//! (`golden/messages.txt`), which a test holds against the types: when a field moves, the fingerprint moves with it.
//!
//! # What a host may not do
//!
//! No message raises a limit of the firmware, and what overrides the exhibit's course carries a lease and lapses. What
//! else asks for more than the exhibit gives now is taken over a local cable only, and some of it in two steps: the answer
//! is a code, which the host has to send back ([`Request::Confirm`]).
//!
//! | asked | over a network | over a cable |
//! |---|---|---|
//! | status, clock, plan, log and settings to read; dark; release; a plan that asks for no more | yes | yes |
//! | a view to hold, light outside the hours, re-arm, the clock to set, signed firmware, a restart | no | yes |
//! | a plan that asks for more (`vitrine_exhibit::plan::Bounds`), a new stack, settings | no | confirmed |
//!
//! A link is a cable where its wire ends beside the exhibit: USB, and the service port unless its setting says otherwise.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

mod fingerprint;
pub mod firmware;
pub mod frame;
pub mod message;
pub mod plan_file;
pub mod rate;
pub mod refusal;
pub mod server;
pub mod status;
#[cfg(test)]
mod tests;

pub use fingerprint::FINGERPRINT;
pub use frame::{Deframer, FrameError, MAX_BODY, MAX_FRAME};
pub use message::{Hello, Reply, Request, Response};
pub use refusal::Refusal;
pub use server::{Controller, Link, Reach, Server};
pub use status::Status;

/// The version of the messages. It grows when a message changes its meaning or its layout.
pub const VERSION: u16 = 4;

/// The most bytes of a plan or an image in one message.
pub const MAX_CHUNK: usize = 256;

/// The controller's USB vendor and product numbers, by which a host finds it: pid.codes' pair for tests, to be
/// replaced by a pair of one's own before boards are sold.
pub const USB_IDS: (u16, u16) = (0x1209, 0x0001);

/// The controller's USB product name, which tells it from other devices with the same numbers.
pub const USB_PRODUCT: &str = "Vitrine controller";
