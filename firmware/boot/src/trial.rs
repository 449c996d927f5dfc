//! Whether a new image stays: it has a minute to show that it works.

use vitrine_exhibit::limits::{SUPPLY_LEAST, SUPPLY_MOST};
use vitrine_exhibit::units::{Milliseconds, Millivolts};

/// An image that has not confirmed itself by then restarts, and the boot loader goes back.
pub const LONGEST: Milliseconds = Milliseconds(60_000);

/// So long an image runs at least before it confirms itself: every task has shown by then that it keeps running.
pub const SHORTEST: Milliseconds = Milliseconds(1_000);

/// What speaks for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Health {
    /// The lamps are dark: whoever cuts the power now, or an erase that takes long, keeps no lamp lit.
    pub dark: bool,
    /// The lamp supply; without it most of what could go wrong cannot show.
    pub supply: Option<Millivolts>,
    /// Every task has checked in with the watchdog.
    pub all_checked_in: bool,
}

/// Whether the lamp supply is within its bounds.
pub fn is_supplied(supply: Option<Millivolts>) -> bool {
    supply.is_some_and(|supply| (SUPPLY_LEAST..=SUPPLY_MOST).contains(&supply))
}

/// What is to be done about an image on trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Look again.
    Wait,
    /// It has shown that it works: it stays.
    Confirm,
    /// It has not, in all its time: restart, and the boot loader goes back.
    GoBack,
}

impl Health {
    /// Judges an image that has run for so long.
    pub fn judge(self, uptime: Milliseconds) -> Verdict {
        if uptime >= LONGEST {
            Verdict::GoBack
        } else if uptime >= SHORTEST && self.dark && is_supplied(self.supply) && self.all_checked_in {
            Verdict::Confirm
        } else {
            Verdict::Wait
        }
    }
}
