//! What the tests of the bus drivers share.

extern crate std;

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};

/// Runs a future of the mock bus, which is always ready.
pub(crate) fn block_on<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => panic!("the mock bus never waits"),
    }
}

/// Nobody answers at the address.
pub(crate) fn nack() -> ErrorKind {
    ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address)
}

/// The bus itself fails.
pub(crate) fn broken() -> ErrorKind {
    ErrorKind::Bus
}
