//! Faults that come and go: dark for a while each time.

use crate::events::DarkReason;
use crate::limits;
use crate::units::Milliseconds;

/// Keeps lamps dark for a while after a fault that has put them out. A loose wire, or a supply that gives way under their
/// load and recovers without it, would have them flash; and flashing light harms some people.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Calm {
    reason: Option<DarkReason>,
    left: Milliseconds,
}

impl Calm {
    /// Takes why the lamps must be dark now, and whether they were lit until now; tells why they stay dark, if nothing else
    /// makes them.
    pub(super) fn update(
        &mut self,
        was_lit: bool,
        now: Option<DarkReason>,
        elapsed: Milliseconds,
    ) -> Option<DarkReason> {
        self.left = self.left.minus(elapsed);
        let comes_and_goes = matches!(now, Some(DarkReason::Supply | DarkReason::TemperatureSensor(_)));
        if comes_and_goes && (was_lit || self.left.0 > 0) {
            *self = Self { reason: now, left: limits::CALM };
        }
        self.reason.filter(|_| self.left.0 > 0)
    }
}
