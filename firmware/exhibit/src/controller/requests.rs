//! What hosts and the staff key ask for, while it lasts.

use crate::inputs::Request;
use crate::limits;
use crate::units::Milliseconds;

/// Shorter presses of the staff key are bounces.
const SHORTEST_PRESS: Milliseconds = Milliseconds(50);
/// A press of this length re-arms; a shorter one turns staff's dark on or off.
const LONG_PRESS: Milliseconds = Milliseconds(2_000);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Nothing,
    Hold(u8),
    Dark,
    Open,
}

/// The last leased request, and the staff key.
#[derive(Clone, Debug)]
pub(super) struct Requests {
    asked: Asked,
    lease: Milliseconds,
    staff_dark: bool,
    pressed_for: Milliseconds,
}

impl Requests {
    pub(super) const fn new() -> Self {
        Self {
            asked: Asked::Nothing,
            lease: Milliseconds(0),
            staff_dark: false,
            pressed_for: Milliseconds(0),
        }
    }

    /// Lets time pass; tells whether a lease ran out.
    pub(super) fn pass(&mut self, elapsed: Milliseconds) -> bool {
        self.lease = self.lease.minus(elapsed);
        let lapsed = self.lease.0 == 0 && self.asked != Asked::Nothing;
        if lapsed {
            self.asked = Asked::Nothing;
        }
        lapsed
    }

    /// Takes a request that carries a lease, or ends it.
    pub(super) fn take(&mut self, request: Request) {
        let (asked, lease) = match request {
            Request::Hold { view, lease } => (Asked::Hold(view), lease),
            Request::Dark { lease } => (Asked::Dark, lease),
            Request::Open { lease } => (Asked::Open, lease),
            Request::Release => (Asked::Nothing, Milliseconds(0)),
            Request::Rearm | Request::NewStack => return,
        };
        self.asked = asked;
        self.lease = lease.min(limits::LONGEST_LEASE);
    }

    /// Takes the staff key as it reads now; tells whether a long press asks for a re-arm.
    pub(super) fn staff_key(&mut self, pressed: bool, elapsed: Milliseconds) -> bool {
        if pressed {
            let before = self.pressed_for;
            self.pressed_for = before.plus(elapsed);
            return before < LONG_PRESS && self.pressed_for >= LONG_PRESS;
        }
        if self.pressed_for >= SHORTEST_PRESS && self.pressed_for < LONG_PRESS {
            self.staff_dark = !self.staff_dark;
        }
        self.pressed_for = Milliseconds(0);
        false
    }

    /// Ends what a host asked for: its view may not be there any more.
    pub(super) fn end(&mut self) {
        self.take(Request::Release);
    }

    pub(super) const fn held_view(&self) -> Option<u8> {
        match self.asked {
            Asked::Hold(view) => Some(view),
            _ => None,
        }
    }

    pub(super) const fn is_host_dark(&self) -> bool {
        matches!(self.asked, Asked::Dark)
    }

    pub(super) const fn opens(&self) -> bool {
        matches!(self.asked, Asked::Open)
    }

    pub(super) const fn is_staff_dark(&self) -> bool {
        self.staff_dark
    }

    pub(super) const fn lease(&self) -> Milliseconds {
        self.lease
    }
}
