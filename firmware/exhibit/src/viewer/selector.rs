//! Chooses the view to show: the nearest, without flicker.

use super::Bearing;
use crate::plan::{Plan, View};
use crate::units::Milliseconds;

/// Chooses the view nearest to a bearing, with hysteresis, dwell and a least hold.
#[derive(Clone, Debug, Default)]
pub struct Selector {
    chosen: Option<u8>,
    held: Milliseconds,
    candidate: Option<u8>,
    dwelt: Milliseconds,
}

impl Selector {
    /// A selector that has chosen nothing.
    pub const fn new() -> Self {
        Self { chosen: None, held: Milliseconds(0), candidate: None, dwelt: Milliseconds(0) }
    }

    /// Forgets its choice.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// The index of the chosen view.
    pub const fn chosen(&self) -> Option<u8> {
        self.chosen
    }

    /// Takes the viewer's bearing and gives the index of the view to show.
    pub fn choose(&mut self, plan: &Plan, bearing: Bearing, elapsed: Milliseconds) -> Option<u8> {
        self.held = self.held.plus(elapsed);
        let nearest = nearest_view(plan, bearing);
        let Some(current) = self.chosen.and_then(|chosen| plan.views.get(usize::from(chosen))) else {
            self.take(nearest);
            return self.chosen;
        };
        let candidate = nearest.filter(|nearest| {
            let other = plan.views.get(usize::from(*nearest));
            let gain =
                other.map_or(0, |other| distance(current, bearing).saturating_sub(distance(other, bearing)));
            Some(*nearest) != self.chosen && gain > u32::from(plan.viewer.hysteresis.0.unsigned_abs())
        });
        self.dwelt = if candidate == self.candidate { self.dwelt.plus(elapsed) } else { Milliseconds(0) };
        self.candidate = candidate;
        if candidate.is_some() && self.dwelt >= plan.viewer.dwell && self.held >= plan.viewer.least_hold {
            self.take(candidate);
        }
        self.chosen
    }

    fn take(&mut self, view: Option<u8>) {
        *self = Self { chosen: view, ..Self::new() };
    }
}

/// The index of the view nearest to a bearing, the first of those that are equally near.
pub fn nearest_view(plan: &Plan, bearing: Bearing) -> Option<u8> {
    plan.views.iter().zip(0_u8..).min_by_key(|(view, _)| distance(view, bearing)).map(|(_, index)| index)
}

fn distance(view: &View, bearing: Bearing) -> u32 {
    Bearing { horizontal: view.horizontal, vertical: view.vertical }.distance(bearing)
}
