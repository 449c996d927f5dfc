//! Chooses the view to show: the nearest, without flicker.

use super::Bearing;
use crate::plan::{Plan, View, ViewerSettings};
use crate::units::{CentiDegrees, Milliseconds};

/// Chooses the view nearest to a bearing, with hysteresis, dead zone and dwell.
#[derive(Clone, Debug, Default)]
pub struct Selector {
    chosen: Option<u8>,
    candidate: Option<u8>,
    dwelt: Milliseconds,
    /// Where the candidate was looked for.
    at: Option<Bearing>,
}

impl Selector {
    /// A selector that has chosen nothing.
    pub const fn new() -> Self {
        Self::starting_with(None)
    }

    /// A selector whose choice is made already.
    pub const fn starting_with(view: Option<u8>) -> Self {
        Self { chosen: view, candidate: None, dwelt: Milliseconds(0), at: None }
    }

    /// The index of the chosen view.
    pub const fn chosen(&self) -> Option<u8> {
        self.chosen
    }

    /// Takes the view that is nearest now without waiting for its dwell, and gives it.
    pub const fn hurry(&mut self) -> Option<u8> {
        if self.candidate.is_some() {
            self.take(self.candidate);
        }
        self.chosen
    }

    /// Takes the viewer's bearing and gives the index of the view to show. The first choice is made at once.
    pub fn choose(&mut self, plan: &Plan, bearing: Bearing, elapsed: Milliseconds) -> Option<u8> {
        self.dwelt = self.dwelt.plus(elapsed);
        // Pictures come ten times more slowly than steps: between them nothing needs to be reckoned again.
        if self.at != Some(bearing) {
            self.at = Some(bearing);
            let candidate = self.candidate_at(plan, bearing);
            if candidate != self.candidate {
                (self.candidate, self.dwelt) = (candidate, Milliseconds(0));
            }
        }
        if self.chosen.is_none() || (self.candidate.is_some() && self.dwelt >= plan.viewer.dwell) {
            self.take(self.candidate);
        }
        self.chosen
    }

    /// The view that is clearly nearer than the chosen one, where there is one.
    fn candidate_at(&self, plan: &Plan, bearing: Bearing) -> Option<u8> {
        let among = plan.among_views(bearing);
        let nearest = nearest_view(plan, among);
        let view = |index: Option<u8>| index.and_then(|index| plan.views.get(usize::from(index)));
        match (view(self.chosen), view(nearest)) {
            (Some(current), Some(other)) => nearest.filter(|_| {
                nearest != self.chosen
                    && is_clearly_nearer(other, current, among, &plan.viewer)
                    && !is_in_dead_zone(other, current, bearing, &plan.viewer)
            }),
            _ => nearest,
        }
    }

    const fn take(&mut self, view: Option<u8>) {
        *self = Self::starting_with(view);
    }
}

/// The index of the view nearest to a bearing, the first of those that are equally near.
pub fn nearest_view(plan: &Plan, bearing: Bearing) -> Option<u8> {
    plan.views.iter().zip(0_u8..).min_by_key(|(view, _)| distance(view, bearing)).map(|(_, index)| index)
}

fn is_clearly_nearer(other: &View, current: &View, bearing: Bearing, settings: &ViewerSettings) -> bool {
    let gain = distance(current, bearing).saturating_sub(distance(other, bearing));
    gain > u32::from(settings.hysteresis.0.unsigned_abs())
}

/// Tells whether the viewer stands about the axis between two views on either side of it.
fn is_in_dead_zone(other: &View, current: &View, bearing: Bearing, settings: &ViewerSettings) -> bool {
    let opposite = |a: CentiDegrees, b: CentiDegrees| (a.0 < 0) != (b.0 < 0) && a.0 != 0 && b.0 != 0;
    let on_the_axis = |at: CentiDegrees| at.0.unsigned_abs() < settings.dead_zone.0.unsigned_abs();
    opposite(current.horizontal, other.horizontal) && on_the_axis(bearing.horizontal)
        || opposite(current.vertical, other.vertical) && on_the_axis(bearing.vertical)
}

fn distance(view: &View, bearing: Bearing) -> u32 {
    view.bearing().distance(bearing)
}
