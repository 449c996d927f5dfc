//! What the pins did: edges, and the duty they make.

/// A change of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Simulated ns.
    pub(crate) at: u64,
    pub(crate) pin: u8,
    pub(crate) high: bool,
}

/// One period of the dimming PWM: 500 Hz.
pub(crate) const PERIOD_NS: u64 = 2_000_000;

/// The duty of a pin over the last `periods` whole periods before `until`, 0 to 1. `edges` must reach back so far, and
/// tell the level before; a pin without edges has the level `resting`.
pub(crate) fn duty(edges: &[Edge], pin: u8, until: u64, periods: u64, resting: bool) -> f64 {
    let from = until - periods * PERIOD_NS;
    let mut level =
        edges.iter().rfind(|edge| edge.pin == pin && edge.at <= from).map_or(resting, |edge| edge.high);
    let mut since = from;
    let mut high_ns = 0;
    for edge in edges.iter().filter(|edge| edge.pin == pin && edge.at > from && edge.at <= until) {
        if level {
            high_ns += edge.at - since;
        }
        (level, since) = (edge.high, edge.at);
    }
    if level {
        high_ns += until - since;
    }
    high_ns as f64 / (periods * PERIOD_NS) as f64
}
