//! The lamp supply's voltage.

use crate::limits;
use crate::units::{Milliseconds, Millivolts};

/// How long the supply has been within its bounds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Supply {
    sound_for: Milliseconds,
}

impl Supply {
    /// Takes the supply as it reads now: one bad reading counts at once, a good one after a while.
    pub(super) fn update(&mut self, supply: Option<Millivolts>, elapsed: Milliseconds) {
        let within = |supply: Millivolts| (limits::SUPPLY_LEAST..=limits::SUPPLY_MOST).contains(&supply);
        self.sound_for =
            if supply.is_some_and(within) { self.sound_for.plus(elapsed) } else { Milliseconds(0) };
    }

    pub(super) fn is_sound(&self) -> bool {
        self.sound_for >= limits::SUPPLY_SETTLED
    }
}
