//! Continuous time and rest: lamps that rest live longer, and so do inks.

use crate::limits;
use crate::plan::{Emphasis, LampCalibration, Plan};
use crate::units::{Level, Milliseconds};

/// Time lit above the idle floor, and the rest after it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rest {
    lit_for: Milliseconds,
    idle_for: Milliseconds,
    rest_left: Milliseconds,
}

impl Rest {
    /// Lets time pass in which the lamps had these levels. Any idle time as long as the rest is a rest.
    pub(super) fn update(&mut self, plan: Option<&Plan>, levels: Emphasis, elapsed: Milliseconds) {
        let Some(plan) = plan else { return };
        self.rest_left = self.rest_left.minus(elapsed);
        if is_above_idle(levels.top, &plan.lamps.top) || is_above_idle(levels.bottom, &plan.lamps.bottom) {
            self.lit_for = self.lit_for.plus(elapsed);
            self.idle_for = Milliseconds(0);
        } else {
            self.idle_for = self.idle_for.plus(elapsed);
        }
        if self.idle_for >= plan.limits.rest {
            self.lit_for = Milliseconds(0);
        }
        if self.rest_left.0 == 0 && self.lit_for >= plan.limits.continuous {
            self.lit_for = Milliseconds(0);
            self.rest_left = plan.limits.rest;
        }
    }

    pub(super) const fn is_resting(&self) -> bool {
        self.rest_left.0 > 0
    }
}

fn is_above_idle(level: Level, lamp: &LampCalibration) -> bool {
    level > Level::not_above(limits::IDLE_FLOOR, lamp.full_level)
}
