//! How often a host may ask: a bucket of requests that fills slowly, so that a flood costs the controller little.

/// Requests that may come at once.
pub const BURST: u32 = 64;

/// The time in which one more request may come, in ms.
pub const REFILL_MS: u64 = 4;

/// A bucket of requests of one link.
#[derive(Clone, Copy, Debug)]
pub struct Bucket {
    requests: u32,
    filled_at_ms: u64,
}

impl Bucket {
    /// A full bucket.
    pub const fn new() -> Self {
        Self { requests: BURST, filled_at_ms: 0 }
    }

    /// Takes one request at `now_ms`, or says in how many ms there will be one.
    pub fn take(&mut self, now_ms: u64) -> Result<(), u32> {
        self.fill(now_ms);
        match self.requests.checked_sub(1) {
            Some(rest) => {
                self.requests = rest;
                Ok(())
            }
            None => {
                let waited = now_ms.saturating_sub(self.filled_at_ms).min(REFILL_MS);
                Err(u32::try_from(REFILL_MS - waited).unwrap_or(u32::MAX))
            }
        }
    }

    fn fill(&mut self, now_ms: u64) {
        let fresh = now_ms.saturating_sub(self.filled_at_ms) / REFILL_MS;
        if fresh == 0 {
            return;
        }
        self.requests = u32::try_from(fresh).unwrap_or(u32::MAX).saturating_add(self.requests).min(BURST);
        self.filled_at_ms =
            if self.requests == BURST { now_ms } else { self.filled_at_ms.saturating_add(fresh * REFILL_MS) };
    }
}

impl Default for Bucket {
    fn default() -> Self {
        Self::new()
    }
}
