//! Stopping a design before its end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks designs to stop. Clones ask the same designs: keep one, and give another to the request.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks. A design that is under way ends within one iteration with
    /// [`DesignError::Stopped`](super::DesignError::Stopped), and so does every later one.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody has asked.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
