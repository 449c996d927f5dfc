//! The controller: its state, its one step, and what it tells of itself.

use serde::{Deserialize, Serialize};

use crate::events::{Cuts, DarkReason, Event, Events};
use crate::fader::Fader;
use crate::governor::{Conditions, Governor, LampCommand, Verdict};
use crate::inputs::{Inputs, Request};
use crate::interlock::{Interlock, InterlockState};
use crate::ledger::{DoseLedger, LedgerRecord};
use crate::limits;
use crate::plan::{Emphasis, Plan, ValidPlan};
use crate::units::{
    CentiCelsius, Dose, Irradiance, Lamp, Level, Milliseconds, Millivolts, PerLamp, UtcSeconds,
};
use crate::viewer::{Bearing, BearingSource, Selector, ThermalPair, Tracker};

/// Whether somebody is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Presence {
    /// Somebody is there.
    Somebody,
    /// The last viewer has just gone; the view is kept.
    JustGone,
    /// Nobody is there: the idle glow.
    Idle,
    /// Nobody has been there for a while: dark.
    #[default]
    Empty,
    /// The viewer sensors give nothing credible: the neutral pair.
    Unknown,
}

/// What the controller tells of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Time since the start in ms.
    pub uptime_ms: u64,
    /// The clock.
    pub now: Option<UtcSeconds>,
    /// Whether somebody is there.
    pub presence: Presence,
    /// Where the viewer stands who decides.
    pub bearing: Option<Bearing>,
    /// How many viewers are followed.
    pub viewers: u8,
    /// The index of the view that is shown.
    pub view: Option<u8>,
    /// Both lamps' levels.
    pub levels: PerLamp<Level>,
    /// Both lamps' irradiance on their nearest films.
    pub irradiance: PerLamp<Irradiance>,
    /// Whether the lamps' drivers are enabled.
    pub enabled: bool,
    /// Why the lamps are dark, where they are.
    pub dark: Option<DarkReason>,
    /// The cuts at work.
    pub cuts: PerLamp<Cuts>,
    /// Both lamp boards' temperatures, where their sensors give one.
    pub boards: PerLamp<Option<CentiCelsius>>,
    /// The enclosure's air.
    pub enclosure: Option<CentiCelsius>,
    /// The lamp supply.
    pub supply: Option<Millivolts>,
    /// The last reading of the ultraviolet sensor.
    pub ultraviolet: Option<Irradiance>,
    /// The interlock.
    pub interlock: InterlockState,
    /// Both lamps' dose in the ledger's day.
    pub day_dose: PerLamp<Dose>,
    /// Both lamps' dose in the stack's life.
    pub life_dose: PerLamp<Dose>,
    /// Both lamps' time lit in seconds.
    pub lit_s: PerLamp<u32>,
    /// Both lamps' time lit in seconds, as if at full level.
    pub full_s: PerLamp<u32>,
    /// Starts of the controller.
    pub power_cycles: u32,
    /// Starts after the watchdog or a fault.
    pub watchdog_resets: u32,
    /// What is left of a host's hold, dark or open.
    pub lease: Milliseconds,
}

/// What a host asked for last, while its lease runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Asked {
    #[default]
    Nothing,
    Hold(u8),
    Dark,
    Open,
}

/// Everything that the controller keeps from step to step.
#[derive(Clone, Debug)]
pub struct State {
    uptime_ms: u64,
    thermal: ThermalPair,
    tracker: Tracker,
    selector: Selector,
    fader: Fader,
    interlock: Interlock,
    governor: Governor,
    ledger: DoseLedger,
    asked: Asked,
    lease: Milliseconds,
    staff_dark: bool,
    staff_key: bool,
    nobody_for: Milliseconds,
    presence: Presence,
    plan: Option<u32>,
    full: PerLamp<Irradiance>,
    watchdog_latched: bool,
    last: Verdict,
    snapshot: Snapshot,
}

/// One step of the controller: takes what is known now, and gives what the lamps are to do until the next step and
/// what changed. To be called 100 times a second; `elapsed` is the time since the step before.
pub fn step(state: &mut State, inputs: &Inputs<'_>, elapsed: Milliseconds) -> (LampCommand, Events) {
    let mut events = Events::default();
    state.uptime_ms = state.uptime_ms.saturating_add(u64::from(elapsed.0));
    state.keep_ledger(inputs, elapsed, &mut events);
    state.notice_plan(inputs.plan, &mut events);
    state.interlock.update(inputs.interlock, elapsed);
    state.take_requests(inputs, elapsed, &mut events);
    state.follow_viewers(inputs, elapsed, &mut events);
    let (target, fade, wants_dark) = state.choose(inputs, elapsed, &mut events);
    let wanted = state.fader.advance(target, fade, elapsed);
    let verdict = state.govern(inputs, target, wanted, wants_dark, elapsed);
    state.tell(inputs, verdict, &mut events);
    (verdict.command, events)
}

impl State {
    /// The state at a start.
    ///
    /// `ledger` is the newest ledger record in flash, or the default where there is none. `after_fault`: the
    /// watchdog, a panic or a fault restarted the controller.
    pub fn new(ledger: LedgerRecord, after_fault: bool) -> Self {
        let ledger = DoseLedger::new(ledger, after_fault);
        Self {
            uptime_ms: 0,
            thermal: ThermalPair::new(),
            tracker: Tracker::new(),
            selector: Selector::new(),
            fader: Fader::new(),
            interlock: Interlock::new(),
            governor: Governor::new(),
            watchdog_latched: ledger.spent().quick_resets >= limits::QUICK_RESETS,
            ledger,
            asked: Asked::Nothing,
            lease: Milliseconds(0),
            staff_dark: false,
            staff_key: false,
            nobody_for: Milliseconds(0),
            presence: Presence::Unknown,
            plan: None,
            full: PerLamp::default(),
            last: Verdict { dark: Some(DarkReason::Starting), ..Verdict::default() },
            snapshot: Snapshot::default(),
        }
    }

    /// What the controller tells of itself after its last step.
    pub const fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// The dose ledger, for the flash's owner to store [`DoseLedger::to_store`].
    pub const fn ledger(&self) -> &DoseLedger {
        &self.ledger
    }

    fn keep_ledger(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) {
        if let Some(stored) = inputs.stored {
            self.ledger.stored(stored);
        }
        self.ledger.book(self.last.command.irradiance(), self.full, elapsed);
        if self.ledger.day(inputs.now.map(|now| (now.0 / 86_400).clamp(0, i64::from(u32::MAX)) as u32)) {
            events.push(Event::DayBegan);
        }
        if self.uptime_ms >= u64::from(limits::RAN_WELL.0) {
            self.ledger.ran_well();
        }
    }

    fn notice_plan(&mut self, plan: Option<&ValidPlan>, events: &mut Events) {
        let fingerprint = plan.map(ValidPlan::fingerprint);
        if fingerprint != self.plan {
            self.plan = fingerprint;
            self.selector.clear();
            self.asked = Asked::Nothing;
            events.push(if plan.is_some() { Event::PlanChanged } else { Event::PlanLost });
        }
        if let Some(plan) = plan {
            self.full = PerLamp::new(plan.lamps.top.full_level, plan.lamps.bottom.full_level);
        }
    }

    fn take_requests(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) {
        self.lease = self.lease.minus(elapsed);
        if self.lease.0 == 0 && self.asked != Asked::Nothing {
            self.asked = Asked::Nothing;
            events.push(Event::LeaseLapsed);
        }
        if inputs.staff_key && !self.staff_key {
            self.staff_dark = !self.staff_dark;
        }
        self.staff_key = inputs.staff_key;
        for request in inputs.requests {
            self.take_request(*request, inputs, events);
        }
    }

    fn take_request(&mut self, request: Request, inputs: &Inputs<'_>, events: &mut Events) {
        let mut ask = |asked: Asked, lease: Milliseconds| {
            self.asked = asked;
            self.lease = lease.min(limits::LONGEST_LEASE);
        };
        match request {
            Request::Hold { view, lease } => {
                if inputs.plan.is_some_and(|plan| usize::from(view) < plan.views.len()) {
                    ask(Asked::Hold(view), lease);
                } else {
                    events.push(Event::NoSuchView(view));
                }
            }
            Request::Dark { lease } => ask(Asked::Dark, lease),
            Request::Open { lease } => ask(Asked::Open, lease),
            Request::Release => ask(Asked::Nothing, Milliseconds(0)),
            Request::Rearm => {
                let rearmed = self.interlock.rearm();
                self.watchdog_latched &= !rearmed;
                events.push(if rearmed { Event::Rearmed } else { Event::RearmRefused });
            }
            Request::NewStack => {
                self.ledger.new_stack();
                events.push(Event::NewStack);
            }
        }
    }

    fn follow_viewers(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) {
        let sightings = self.thermal.take(inputs.thermal, elapsed);
        self.tracker.update(sightings.as_ref(), elapsed);
        let was = self.presence;
        let somebody = self.tracker.longest().is_some();
        self.nobody_for = if somebody { Milliseconds(0) } else { self.nobody_for.plus(elapsed) };
        let timings = inputs.plan.map(|plan| &plan.presence);
        self.presence = if !self.thermal.is_sound() {
            Presence::Unknown
        } else if somebody {
            Presence::Somebody
        } else if timings.is_some_and(|timings| self.nobody_for < timings.hold) {
            Presence::JustGone
        } else if timings.is_some_and(|timings| self.nobody_for < timings.hold.plus(timings.idle)) {
            Presence::Idle
        } else {
            Presence::Empty
        };
        match (was, self.presence) {
            (before, now) if before == now => {}
            (_, Presence::Unknown) => events.push(Event::ViewerSensorLost),
            (Presence::Unknown, _) => events.push(Event::ViewerSensorBack),
            (Presence::Somebody, _) => events.push(Event::ViewersGone),
            (_, Presence::Somebody) => events.push(Event::ViewerCame),
            _ => {}
        }
    }

    /// Chooses what is wanted: the pair, the time of the fade to it, and why dark, where dark is wanted.
    fn choose(
        &mut self,
        inputs: &Inputs<'_>,
        elapsed: Milliseconds,
        events: &mut Events,
    ) -> (Emphasis, Milliseconds, Option<DarkReason>) {
        let Some(plan) = inputs.plan else {
            return (Emphasis::default(), limits::FASTEST_FADE, None);
        };
        let before = self.selector.chosen();
        let (target, fade) = self.choose_pair(plan, elapsed);
        if self.selector.chosen() != before
            && let Some(view) = self.selector.chosen()
        {
            events.push(Event::ViewChosen(view));
        }
        let dark = if self.staff_dark {
            Some(DarkReason::StaffKey)
        } else if self.asked == Asked::Dark {
            Some(DarkReason::HostRequest)
        } else {
            None
        };
        if dark.is_some() {
            return (Emphasis::default(), plan.presence.fade, dark);
        }
        (target, fade, (self.presence == Presence::Empty).then_some(DarkReason::NobodyThere))
    }

    fn choose_pair(&mut self, plan: &Plan, elapsed: Milliseconds) -> (Emphasis, Milliseconds) {
        let pair_of = |view: u8| plan.views.get(usize::from(view)).map(|view| view.emphasis);
        if let Asked::Hold(view) = self.asked {
            return (pair_of(view).unwrap_or(plan.neutral), plan.viewer.fade);
        }
        match self.presence {
            Presence::Somebody | Presence::JustGone => {
                let bearing = self.tracker.longest().map(|track| track.bearing);
                let chosen = match bearing {
                    Some(bearing) => self.selector.choose(plan, bearing, elapsed),
                    None => self.selector.chosen(),
                };
                (chosen.and_then(pair_of).unwrap_or(plan.neutral), plan.viewer.fade)
            }
            Presence::Idle => {
                let idle = plan.neutral.map(|level| level.scaled(plan.presence.idle_level));
                (idle, plan.presence.fade)
            }
            Presence::Empty => (Emphasis::default(), plan.presence.fade),
            Presence::Unknown => (plan.neutral, plan.presence.fade),
        }
    }

    fn govern(
        &mut self,
        inputs: &Inputs<'_>,
        target: Emphasis,
        wanted: Emphasis,
        wants_dark: Option<DarkReason>,
        elapsed: Milliseconds,
    ) -> Verdict {
        let irradiance =
            |pair: Emphasis| pair.zip(self.full).map(|(level, full)| level.of(full).min(limits::CEILING));
        let wanted_irradiance = irradiance(wanted);
        // Both lamps are reserved for alike, so that a change of view never waits for the flash.
        let target = irradiance(target);
        let demand = [target.top, target.bottom, wanted_irradiance.top, wanted_irradiance.bottom];
        let most = demand.into_iter().max().unwrap_or_default();
        self.ledger.reserve(PerLamp::new(most, most));
        let nothing_wanted = wanted == Emphasis::default();
        let conditions = Conditions {
            plan: inputs.plan.map(core::ops::Deref::deref),
            interlock: self.interlock.state(),
            boards: inputs.boards,
            enclosure: inputs.enclosure,
            supply: inputs.supply,
            clock_is_valid: inputs.now.is_some(),
            uptime_ms: self.uptime_ms,
            watchdog_latched: self.watchdog_latched,
            // A soft dark fades first: the governor hears of it when nothing is wanted any more.
            wants_dark: wants_dark.filter(|_| nothing_wanted),
            reserved: self.ledger.covers(wanted_irradiance),
            dose: self.ledger.spent().lamps,
        };
        let verdict = self.governor.decide(wanted, &conditions, elapsed);
        if verdict.dark.is_some() {
            self.fader.jump(Emphasis::default());
        }
        verdict
    }

    fn tell(&mut self, inputs: &Inputs<'_>, verdict: Verdict, events: &mut Events) {
        if verdict.dark != self.last.dark {
            events.push(verdict.dark.map_or(Event::Lit, Event::Dark));
        }
        for lamp in [Lamp::Top, Lamp::Bottom] {
            let (now, before) = (verdict.cuts.get(lamp), self.last.cuts.get(lamp));
            for cut in Cuts::ALL {
                match (before.contains(cut), now.contains(cut)) {
                    (false, true) => events.push(Event::CutBegan(lamp, cut)),
                    (true, false) => events.push(Event::CutEnded(lamp, cut)),
                    _ => {}
                }
            }
        }
        self.last = verdict;
        self.snapshot = self.take_snapshot(inputs);
    }

    fn take_snapshot(&self, inputs: &Inputs<'_>) -> Snapshot {
        let spent = self.ledger.spent();
        let seconds = |ms: u64| (ms / 1_000).min(u64::from(u32::MAX)) as u32;
        Snapshot {
            uptime_ms: self.uptime_ms,
            now: inputs.now,
            presence: self.presence,
            bearing: self.tracker.longest().map(|track| track.bearing),
            viewers: self.tracker.tracks().len() as u8,
            view: if let Asked::Hold(view) = self.asked { Some(view) } else { self.selector.chosen() },
            levels: self.last.command.levels(),
            irradiance: self.last.command.irradiance(),
            enabled: self.last.command.is_enabled(),
            dark: self.last.dark,
            cuts: self.last.cuts,
            boards: inputs.boards.map(|reading| reading.and_then(crate::inputs::TemperatureReading::celsius)),
            enclosure: inputs.enclosure,
            supply: inputs.supply,
            ultraviolet: inputs.ultraviolet,
            interlock: self.interlock.state(),
            day_dose: PerLamp::new(spent.lamps.top.day, spent.lamps.bottom.day),
            life_dose: PerLamp::new(spent.lamps.top.life, spent.lamps.bottom.life),
            lit_s: PerLamp::new(seconds(spent.lamps.top.lit_ms), seconds(spent.lamps.bottom.lit_ms)),
            full_s: PerLamp::new(seconds(spent.lamps.top.full_ms), seconds(spent.lamps.bottom.full_ms)),
            power_cycles: spent.power_cycles,
            watchdog_resets: spent.watchdog_resets,
            lease: self.lease,
        }
    }
}

impl Default for Snapshot {
    /// What is told before the first step.
    fn default() -> Self {
        Self {
            uptime_ms: 0,
            now: None,
            presence: Presence::Unknown,
            bearing: None,
            viewers: 0,
            view: None,
            levels: PerLamp::default(),
            irradiance: PerLamp::default(),
            enabled: false,
            dark: Some(DarkReason::Starting),
            cuts: PerLamp::default(),
            boards: PerLamp::default(),
            enclosure: None,
            supply: None,
            ultraviolet: None,
            interlock: InterlockState::Open,
            day_dose: PerLamp::default(),
            life_dose: PerLamp::default(),
            lit_s: PerLamp::default(),
            full_s: PerLamp::default(),
            power_cycles: 0,
            watchdog_resets: 0,
            lease: Milliseconds(0),
        }
    }
}

#[cfg(test)]
mod tests;
