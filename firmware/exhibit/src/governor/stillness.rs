//! Lamps that stand still for a moment, so that flash can be erased while somebody never stops moving them.

use crate::limits;
use crate::units::Milliseconds;

/// Stands still when asked, but never for long and never again soon: it holds up what cuts a lamp as well.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stillness {
    held: Milliseconds,
    free_for: Milliseconds,
}

impl Stillness {
    /// Lets time pass; tells whether the lamps stand still in this step.
    pub(super) fn update(&mut self, asked: bool, elapsed: Milliseconds) -> bool {
        self.free_for = self.free_for.minus(elapsed);
        let began = self.held.0 > 0;
        if asked && self.free_for.0 == 0 && self.held.plus(elapsed) <= limits::STILL_FOR {
            self.held = self.held.plus(elapsed);
            return true;
        }
        if began {
            *self = Self { held: Milliseconds(0), free_for: limits::STILL_AGAIN_AFTER };
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Milliseconds = Milliseconds(10);

    #[test]
    fn who_asks_for_ever_gets_a_second_in_eleven() {
        let mut stillness = Stillness::default();
        let still = (0..3_300).filter(|_| stillness.update(true, STEP)).count();
        assert_eq!(still, 300);
    }

    #[test]
    fn a_moment_that_is_not_used_up_ends_all_the_same() {
        let mut stillness = Stillness::default();
        assert!(stillness.update(true, STEP));
        assert!(!stillness.update(false, STEP));
        let free = (0..2_000).take_while(|_| !stillness.update(true, STEP)).count();
        assert_eq!(free, 999);
    }
}
