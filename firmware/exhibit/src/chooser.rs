//! Whose view is shown, and under which pair: the plan's policy.
//!
//! Every viewer has a selector of their own, so that one viewer's hysteresis never depends on another's steps. The
//! policy then says which viewer decides. A view once shown is kept for the plan's least hold. Views that share a
//! direction are its pages: they are turned while somebody stands there, by time or by the viewer's step.

use heapless::Vec;

use crate::plan::{Between, Emphasis, MAX_VIEWS, Paging, Plan, Policy, mean};
use crate::units::{Level, Milliseconds};
use crate::viewer::{Bearing, MAX_TRACKS, Selector, Track, Tracker, nearest_view};

/// Another viewer must be nearer by this many eighths of the present one's signal before `Policy::Nearest` turns.
const NEARER_EIGHTHS: u32 = 10;

/// One viewer's own selector.
#[derive(Clone, Debug)]
struct Own {
    number: u8,
    selector: Selector,
}

/// Chooses the viewer, the view and the pair.
#[derive(Clone, Debug, Default)]
pub struct Chooser {
    own: Vec<Own, MAX_TRACKS>,
    /// The number of the viewer who decides.
    decider: Option<u8>,
    bearing: Option<Bearing>,
    /// The view that is shown, the first page of its direction.
    shown: Option<u8>,
    shown_for: Milliseconds,
    turn_for: Milliseconds,
    page: u8,
    page_for: Milliseconds,
    /// Where the viewer who decides stood after the page was turned.
    page_at: Option<Bearing>,
}

impl Chooser {
    /// A chooser that shows nothing.
    pub const fn new() -> Self {
        Self {
            own: Vec::new(),
            decider: None,
            bearing: None,
            shown: None,
            shown_for: Milliseconds(0),
            turn_for: Milliseconds(0),
            page: 0,
            page_for: Milliseconds(0),
            page_at: None,
        }
    }

    /// Forgets everybody and what is shown.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// Where the viewer stands who decides.
    pub const fn bearing(&self) -> Option<Bearing> {
        self.bearing
    }

    /// The index of the view that is shown, with its page.
    pub fn view(&self, plan: &Plan) -> Option<u8> {
        let shown = self.shown?;
        pages(plan, shown).nth(usize::from(self.page)).or(Some(shown))
    }

    /// Takes the viewers as they stand now and gives the pair for them; none before anybody has come.
    pub fn choose(&mut self, plan: &Plan, tracker: &Tracker, elapsed: Milliseconds) -> Option<Emphasis> {
        self.shown_for = self.shown_for.plus(elapsed);
        self.turn_for = self.turn_for.plus(elapsed);
        self.select_for_each(plan, tracker, elapsed);
        self.page_for = self.page_for.plus(elapsed);
        if let Some(decider) = self.decide(plan, tracker) {
            self.bearing = Some(decider.bearing());
            let free = self.shown.is_none() || self.shown_for >= plan.viewer.least_hold;
            if free && self.own_view(decider.number) != self.shown {
                self.show(decider.number);
            }
        } else {
            self.bearing = None;
        }
        self.turn_page(plan);
        self.pair(plan)
    }

    /// Shows a viewer's view: the one that is nearest now, for the viewer may have moved on while the last was held.
    fn show(&mut self, number: u8) {
        let own = self.own.iter_mut().find(|own| own.number == number);
        let nearest = own.and_then(|own| own.selector.hurry());
        if nearest != self.shown {
            (self.shown, self.shown_for) = (nearest, Milliseconds(0));
            self.open_page(0);
        }
    }

    fn select_for_each(&mut self, plan: &Plan, tracker: &Tracker, elapsed: Milliseconds) {
        self.own.retain(|own| tracker.viewers().any(|track| track.number == own.number));
        for track in tracker.viewers() {
            if !self.own.iter().any(|own| own.number == track.number) {
                // Who comes back after a moment unseen, or follows somebody, begins with what is shown.
                let own = Own { number: track.number, selector: Selector::starting_with(self.shown) };
                // There are never more viewers than tracks.
                let _ = self.own.push(own);
            }
            if let Some(own) = self.own.iter_mut().find(|own| own.number == track.number) {
                own.selector.choose(plan, track.bearing(), elapsed);
            }
        }
    }

    /// Gives the viewer who decides by the plan's policy.
    fn decide<'a>(&mut self, plan: &Plan, tracker: &'a Tracker) -> Option<&'a Track> {
        let present = self.decider.and_then(|number| tracker.viewers().find(|track| track.number == number));
        let decider = match plan.viewer.policy {
            Policy::First | Policy::Shared => tracker.longest(),
            Policy::Nearest => match (present, tracker.nearest()) {
                (Some(present), Some(other))
                    if u32::from(other.strength) * 8 < u32::from(present.strength) * NEARER_EIGHTHS =>
                {
                    Some(present)
                }
                (_, nearest) => nearest,
            },
            Policy::Alternating => self.next_in_turn(plan, present, tracker),
        };
        if decider.map(|track| track.number) != self.decider {
            self.decider = decider.map(|track| track.number);
            self.turn_for = Milliseconds(0);
            // Another viewer stands elsewhere without having taken a step.
            self.page_at = None;
        }
        decider
    }

    fn next_in_turn<'a>(
        &self,
        plan: &Plan,
        present: Option<&'a Track>,
        tracker: &'a Tracker,
    ) -> Option<&'a Track> {
        let Some(present) = present else { return tracker.longest() };
        if self.turn_for < plan.viewer.turn {
            return Some(present);
        }
        let elsewhere = |track: &&Track| self.own_view(track.number) != self.own_view(present.number);
        let others = || tracker.viewers().filter(elsewhere);
        let after = others().filter(|track| track.number > present.number).min_by_key(|track| track.number);
        after.or_else(|| others().min_by_key(|track| track.number)).or(Some(present))
    }

    fn own_view(&self, number: u8) -> Option<u8> {
        self.own.iter().find(|own| own.number == number).and_then(|own| own.selector.chosen())
    }

    fn open_page(&mut self, page: u8) {
        (self.page, self.page_for, self.page_at) = (page, Milliseconds(0), self.bearing);
    }

    fn turn_page(&mut self, plan: &Plan) {
        let count = self.shown.map_or(1, |shown| pages(plan, shown).count()) as u8;
        if self.page_at.is_none() || self.page_for < plan.viewer.least_hold {
            // The step that turned the page may not be at its end yet: the next one begins there.
            self.page_at = self.bearing;
        }
        let over = match plan.viewer.paging {
            Paging::Time => self.page_for >= plan.viewer.page,
            Paging::Step => self.has_stepped(plan),
        };
        if count > 1 && over {
            self.open_page((self.page + 1) % count);
        }
    }

    /// A step to the side: heights are seen too coarsely to tell a step from a nod.
    fn has_stepped(&self, plan: &Plan) -> bool {
        let way = |(from, to): (Bearing, Bearing)| to.horizontal.0.abs_diff(from.horizontal.0);
        let moved = self.page_at.zip(self.bearing).map_or(0, way);
        moved >= plan.viewer.step.0.unsigned_abs()
    }

    fn pair(&self, plan: &Plan) -> Option<Emphasis> {
        let view = plan.views.get(usize::from(self.view(plan)?))?;
        if plan.viewer.policy == Policy::Shared && self.own.len() > 1 {
            return Some(self.shared(plan));
        }
        match (plan.viewer.between, self.bearing) {
            (Between::Smooth, Some(bearing)) => Some(smooth(plan, bearing)),
            _ => Some(view.emphasis),
        }
    }

    /// The pair for all views that somebody looks at: of one view its own, of two the plan's pair for both, of more
    /// the mean of the pairs for each two.
    fn shared(&self, plan: &Plan) -> Emphasis {
        let mut looked_at: Vec<u8, MAX_VIEWS> = Vec::new();
        for own in &self.own {
            let chosen = own.selector.chosen();
            // Whoever stands where the shown view is sees the page that is turned up.
            let seen = if chosen == self.shown { self.view(plan) } else { chosen };
            if let Some(view) = seen.filter(|view| !looked_at.contains(view)) {
                // There are never more views than there is room for.
                let _ = looked_at.push(view);
            }
        }
        if let [view] = looked_at[..] {
            return plan.views.get(usize::from(view)).map_or(plan.neutral, |view| view.emphasis);
        }
        let each_two = looked_at.iter().enumerate().flat_map(|(index, &one)| {
            looked_at.iter().skip(index + 1).filter_map(move |&other| plan.shared_pair(one, other))
        });
        mean(each_two)
    }
}

/// The indices of all views in the direction of one of them, in the plan's order.
pub fn pages(plan: &Plan, view: u8) -> impl Iterator<Item = u8> {
    let direction = plan.views.get(usize::from(view)).map(|view| view.bearing());
    let same = plan.views.iter().zip(0_u8..).filter(move |(view, _)| Some(view.bearing()) == direction);
    same.map(|(_, index)| index)
}

/// The pair for a bearing between views: from the nearest view's pair to that of the second nearest direction along
/// a smooth step of the way from one to the other.
pub fn smooth(plan: &Plan, bearing: Bearing) -> Emphasis {
    let bearing = plan.among_views(bearing);
    let view = |index: u8| plan.views.get(usize::from(index));
    let Some(nearest) = nearest_view(plan, bearing).and_then(view) else { return plan.neutral };
    let others = plan.views.iter().filter(|view| view.bearing() != nearest.bearing());
    let Some(second) = others.min_by_key(|view| view.bearing().distance(bearing)) else {
        return nearest.emphasis;
    };
    let part = smooth_step(part_of_way(nearest.bearing(), second.bearing(), bearing));
    nearest.emphasis.zip(second.emphasis).map(|(from, to)| {
        let way = i64::from(to.0) - i64::from(from.0);
        Level((i64::from(from.0) + way * part / ONE) as u16)
    })
}

/// One, in parts of the way.
const ONE: i64 = 4_096;

/// How far a bearing lies along the way from one direction to another, 0 to [`ONE`].
fn part_of_way(from: Bearing, to: Bearing, at: Bearing) -> i64 {
    let leg = |a: Bearing, b: Bearing| {
        let h = i64::from(b.horizontal.0) - i64::from(a.horizontal.0);
        let v = i64::from(b.vertical.0) - i64::from(a.vertical.0);
        (h, v)
    };
    let (way, gone) = (leg(from, to), leg(from, at));
    let square = (way.0 * way.0 + way.1 * way.1).max(1);
    ((gone.0 * way.0 + gone.1 * way.1) * ONE / square).clamp(0, ONE)
}

/// `3 t² - 2 t³`.
const fn smooth_step(part: i64) -> i64 {
    part * part * (3 * ONE - 2 * part) / (ONE * ONE)
}

#[cfg(test)]
mod tests;
