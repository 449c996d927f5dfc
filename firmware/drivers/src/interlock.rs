//! The two-channel interlock: two loops through the door switches, each closed to ground.
//!
//! A loop counts as closed only when it was read and read low. High, broken and unreadable are open: what cannot be
//! seen to be safe is not safe.

use embedded_hal::digital::InputPin;

/// What both loops read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loops {
    /// Loop A was seen closed.
    pub a_closed: bool,
    /// Loop B was seen closed.
    pub b_closed: bool,
}

impl Loops {
    /// Both loops open.
    pub const OPEN: Self = Self { a_closed: false, b_closed: false };

    /// Tells whether both loops were seen closed.
    pub fn both_closed(self) -> bool {
        self.a_closed && self.b_closed
    }
}

/// The inputs of both loops.
pub struct Interlock<A, B> {
    loop_a: A,
    loop_b: B,
}

impl<A: InputPin, B: InputPin> Interlock<A, B> {
    /// Takes both inputs, which need pull-ups.
    pub fn new(loop_a: A, loop_b: B) -> Self {
        Self { loop_a, loop_b }
    }

    /// Reads both loops; one that cannot be read is open.
    pub fn read(&mut self) -> Loops {
        Loops {
            a_closed: self.loop_a.is_low().unwrap_or(false),
            b_closed: self.loop_b.is_low().unwrap_or(false),
        }
    }

    /// Gives the inputs back.
    pub fn release(self) -> (A, B) {
        (self.loop_a, self.loop_b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};
    extern crate std;
    use std::io::ErrorKind;

    fn read(a: Transaction, b: Transaction) -> Loops {
        let mut interlock = Interlock::new(Mock::new(&[a]), Mock::new(&[b]));
        let loops = interlock.read();
        let (mut a, mut b) = interlock.release();
        a.done();
        b.done();
        loops
    }

    fn low() -> Transaction {
        Transaction::get(State::Low)
    }

    fn high() -> Transaction {
        Transaction::get(State::High)
    }

    #[test]
    fn only_low_is_closed() {
        assert!(read(low(), low()).both_closed());
        assert_eq!(read(high(), low()), Loops { a_closed: false, b_closed: true });
        assert_eq!(read(low(), high()), Loops { a_closed: true, b_closed: false });
        assert_eq!(read(high(), high()), Loops::OPEN);
    }

    #[test]
    fn a_loop_that_cannot_be_read_is_open() {
        let broken = Transaction::get(State::Low).with_error(MockError::Io(ErrorKind::NotConnected));
        assert_eq!(read(broken, low()), Loops { a_closed: false, b_closed: true });
    }
}
