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
        let way = |from: Level, to: Level| i64::from(to.0) - i64::from(from.0);
        let ways = PerLamp::new(way(self.at.top, target.top), way(self.at.bottom, target.bottom));
        let longer = ways.top.abs().max(ways.bottom.abs());
        let stride = i64::from(elapsed.0) * 65_535 / i64::from(fade.0.max(1));
        if longer <= stride {
            self.at = target;
        } else {
            let moved = |from: Level, way: i64| Level((i64::from(from.0) + way * stride / longer) as u16);
            self.at = PerLamp::new(moved(self.at.top, ways.top), moved(self.at.bottom, ways.bottom));
        }
        self.at
    }
}
