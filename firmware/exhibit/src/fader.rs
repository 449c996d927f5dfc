//! Moves the pair of levels from one emphasis to another without a jump.

use crate::plan::Emphasis;
use crate::units::{Level, Milliseconds, PerLamp};

/// The pair of levels on its way, linear in irradiance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fader {
    at: Emphasis,
}

impl Fader {
    /// A fader at dark.
    pub const fn new() -> Self {
        Self { at: PerLamp::new(Level::OFF, Level::OFF) }
    }

    /// Where the fader stands.
    pub const fn at(&self) -> Emphasis {
        self.at
    }

    /// Stands at a pair at once: the lamps have been cut to it.
    pub const fn jump(&mut self, to: Emphasis) {
        self.at = to;
    }

    /// Moves towards a pair on a straight line: the lamp with the longer way takes `fade` for the whole range, the
    /// other arrives with it.
    pub fn advance(&mut self, target: Emphasis, fade: Milliseconds, elapsed: Milliseconds) -> Emphasis {
        let ways = self.at.zip(target).map(|(from, to)| from.0.abs_diff(to.0));
        let longer = u32::from(ways.top.max(ways.bottom));
        let stride = elapsed.0.min(65_535) * 65_535 / fade.0.max(1);
        if longer <= stride {
            self.at = target;
            return self.at;
        }
        self.at = self.at.zip(target).map(|(from, to)| {
            // Both factors have 16 bits: the stride is shorter than the longer way.
            let part = (u32::from(from.0.abs_diff(to.0)) * stride / longer) as u16;
            Level(if to > from { from.0.saturating_add(part) } else { from.0.saturating_sub(part) })
        });
        self.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_way_is_straight_and_takes_its_time(
            from: (u16, u16), to: (u16, u16), fade in 300_u32..60_000, elapsed in 1_u32..100
        ) {
            let pair = |(top, bottom)| PerLamp::new(Level(top), Level(bottom));
            let mut fader = Fader { at: pair(from) };
            let longer = u32::from(from.0.abs_diff(to.0).max(from.1.abs_diff(to.1)));
            let stride = elapsed * 65_535 / fade;
            prop_assume!(stride > 0);
            let steps = longer.div_ceil(stride);
            for _ in 0..steps {
                let before = fader.at();
                let now = fader.advance(pair(to), Milliseconds(fade), Milliseconds(elapsed));
                let moved = now.zip(before).map(|(now, before)| u32::from(now.0.abs_diff(before.0)));
                prop_assert!(moved.top <= stride && moved.bottom <= stride);
            }
            prop_assert_eq!(fader.at(), pair(to));
        }
    }
}
