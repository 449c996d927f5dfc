//! The door interlock: two contacts that must both be closed, and agree.
//!
//! Every open reading is dark, at once. What it takes to light up again depends on how long the loop was open:
//!
//! - open for two readings on end, 10 ms, or longer: somebody may have opened the door. Both loops must then be closed for
//!   500 ms, and a person must re-arm.
//! - open for less, down to the microseconds that only the board's interrupt sees: nobody opens and closes a door so fast.
//!   It is a bounce, of a knock against the case or of a worn contact; it costs the light of a step and is logged.
//! - a loop that bounces again and again is broken: five times without ten calm seconds between also ask for a re-arm.
//!
//! The board's own interrupt takes the light away within microseconds of any edge; an opening that it alone has seen is
//! handed to the next step as an open reading.

use serde::{Deserialize, Serialize};

use crate::inputs::{Contact, InterlockLoops};
use crate::limits;
use crate::units::Milliseconds;

/// What the interlock allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum InterlockState {
    /// At least one loop is open.
    #[default]
    Open,
    /// Both loops are closed, and a re-arm is needed because they have been open.
    WaitsForRearm,
    /// Both loops are closed and nothing stands against lighting the lamps.
    Armed,
    /// The loops differed for too long; only a re-arm with both closed clears it.
    Disagrees,
}

/// Watches both loops.
#[derive(Clone, Debug, Default)]
pub struct Interlock {
    loops: InterlockLoops,
    open_for: Milliseconds,
    closed_for: Milliseconds,
    differ_for: Milliseconds,
    bounces: u8,
    calm_for: Milliseconds,
    rearm_needed: bool,
    disagreed: bool,
}

impl Interlock {
    /// An interlock that has not been read yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the loops as they read now.
    pub fn update(&mut self, loops: InterlockLoops, elapsed: Milliseconds) {
        let (a, b) = (loops.a == Contact::Closed, loops.b == Contact::Closed);
        let was = (self.loops.a == Contact::Closed, self.loops.b == Contact::Closed);
        let timer = |holds: fn(bool, bool) -> bool, timer: Milliseconds| {
            if holds(a, b) && holds(was.0, was.1) { timer.plus(elapsed) } else { Milliseconds(0) }
        };
        self.open_for = timer(|a, b| !(a && b), self.open_for);
        self.closed_for = timer(|a, b| a && b, self.closed_for);
        self.differ_for = timer(|a, b| a != b, self.differ_for);
        self.count_bounce(was.0 && was.1 && !(a && b), elapsed);
        self.loops = loops;
        self.rearm_needed |= self.open_for >= limits::INTERLOCK_OPEN_AFTER;
        self.rearm_needed |= self.bounces >= limits::INTERLOCK_BOUNCES;
        self.disagreed |= self.differ_for > limits::INTERLOCK_DISAGREEMENT;
    }

    /// Re-arms where both loops have been closed for long enough; tells whether it did.
    pub fn rearm(&mut self) -> bool {
        let ready = self.closed_for >= limits::INTERLOCK_CLOSED_FOR;
        if ready {
            self.rearm_needed = false;
            self.disagreed = false;
            self.bounces = 0;
        }
        ready
    }

    /// What the interlock allows now. A single open reading is obeyed at once; whether it was a bounce only decides
    /// whether a re-arm is needed afterwards.
    pub fn state(&self) -> InterlockState {
        if self.disagreed {
            InterlockState::Disagrees
        } else if !self.both_closed() || (self.closed_for < limits::INTERLOCK_CLOSED_FOR && self.rearm_needed)
        {
            InterlockState::Open
        } else if self.rearm_needed {
            InterlockState::WaitsForRearm
        } else {
            InterlockState::Armed
        }
    }

    /// The loops as last read.
    pub const fn loops(&self) -> InterlockLoops {
        self.loops
    }

    const fn count_bounce(&mut self, opens: bool, elapsed: Milliseconds) {
        if opens {
            self.bounces = self.bounces.saturating_add(1);
            self.calm_for = Milliseconds(0);
            return;
        }
        self.calm_for = self.calm_for.plus(elapsed);
        if self.calm_for.0 >= limits::INTERLOCK_CALM.0 {
            self.bounces = 0;
        }
    }

    fn both_closed(&self) -> bool {
        self.loops.a == Contact::Closed && self.loops.b == Contact::Closed
    }
}
