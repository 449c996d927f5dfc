//! The controller: its state and its one step.
//!
//! ```text
//! viewer sensors -> tracker -> chooser -> fader -> GOVERNOR -> lamps
//! clock -> schedule ---------------^                  ^ interlock, temperatures, dose, supply, ultraviolet
//! hosts, staff key -> requests ----^
//! ```

mod led;
mod requests;
mod snapshot;

pub use self::led::LED_BEAT;
use self::requests::Requests;
pub use self::snapshot::{Presence, Snapshot};
use crate::chooser::Chooser;
use crate::events::{Cuts, DarkReason, Event, Events};
use crate::fader::Fader;
use crate::governor::{Conditions, Governor, LampCommand, Verdict};
use crate::inputs::{Inputs, Request, TemperatureReading};
use crate::interlock::Interlock;
use crate::ledger::{DoseLedger, LedgerRecord, Notices};
use crate::limits;
use crate::plan::calendar::TimeZone;
use crate::plan::{Emphasis, Plan, ValidPlan, ViewerSensor};
use crate::schedule;
use crate::units::{Irradiance, Lamp, Level, Milliseconds, PerLamp, UtcSeconds};
use crate::viewer::{BearingSource, Radar, ThermalPair, Tracker};

/// What the rest of the controller wants of the governor.
#[derive(Clone, Copy, Debug)]
struct Wish {
    target: Emphasis,
    /// The time of the fade to it, over the whole range.
    fade: Milliseconds,
    /// Why dark, where dark is wanted.
    dark: Option<DarkReason>,
}

impl Wish {
    const fn dark(reason: DarkReason, fade: Milliseconds) -> Self {
        Self { target: PerLamp::new(Level::OFF, Level::OFF), fade, dark: Some(reason) }
    }
}

/// What the schedule wants, kept for the second for which it was found.
#[derive(Clone, Copy, Debug)]
struct Opening {
    at: Option<UtcSeconds>,
    level: Level,
    local_day: Option<u32>,
}

/// Everything that the controller keeps from step to step.
#[derive(Clone, Debug)]
pub struct State {
    uptime_ms: u64,
    thermal: ThermalPair,
    radar: Radar,
    tracker: Tracker,
    chooser: Chooser,
    fader: Fader,
    interlock: Interlock,
    governor: Governor,
    ledger: DoseLedger,
    notices: Notices,
    requests: Requests,
    nobody_for: Milliseconds,
    presence: Presence,
    sensor_lost: bool,
    opening: Opening,
    plan: Option<u32>,
    full: PerLamp<Irradiance>,
    /// Time since the last slow step.
    second: Milliseconds,
    /// This step is one.
    is_slow: bool,
    watchdog_latched: bool,
    last: Verdict,
    snapshot: Snapshot,
}

/// The board has room for more, but a state that grows unnoticed ends in a stack that has none.
const _: () = assert!(core::mem::size_of::<State>() < 8 * 1024, "the controller's state has outgrown 8 KiB");

/// One step of the controller: takes what is known now, and gives what the lamps are to do until the next step and
/// what changed. To be called 100 times a second; `elapsed` is the time since the step before.
pub fn step(state: &mut State, inputs: &Inputs<'_>, elapsed: Milliseconds) -> (LampCommand, Events) {
    let mut events = Events::default();
    state.uptime_ms = state.uptime_ms.saturating_add(u64::from(elapsed.0));
    state.second = state.second.plus(elapsed);
    state.is_slow = state.is_slow_step(inputs);
    state.notice_plan(inputs.plan, &mut events);
    state.read_clock(inputs);
    state.keep_ledger(inputs, elapsed, &mut events);
    state.interlock.update(inputs.interlock, elapsed);
    state.take_requests(inputs, elapsed, &mut events);
    state.follow_viewers(inputs, elapsed, &mut events);
    let wish = state.wish(inputs, elapsed, &mut events);
    let wanted = if state.governor.stand_still(inputs.stand_still, elapsed) {
        state.fader.at()
    } else {
        state.fader.advance(wish.target, wish.fade, elapsed)
    };
    let verdict = state.govern(inputs, wish, wanted, elapsed, &mut events);
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
            radar: Radar::new(),
            tracker: Tracker::new(),
            chooser: Chooser::new(),
            fader: Fader::new(),
            interlock: Interlock::new(),
            governor: Governor::new(),
            watchdog_latched: ledger.spent().quick_resets >= limits::QUICK_RESETS,
            ledger,
            notices: Notices::new(),
            requests: Requests::new(),
            nobody_for: Milliseconds(0),
            presence: Presence::Unknown,
            sensor_lost: false,
            opening: Opening { at: None, level: Level::OFF, local_day: None },
            plan: None,
            full: PerLamp::default(),
            second: Milliseconds(1_000),
            is_slow: false,
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

    fn notice_plan(&mut self, plan: Option<&ValidPlan>, events: &mut Events) {
        let fingerprint = plan.map(ValidPlan::fingerprint);
        if fingerprint != self.plan {
            self.plan = fingerprint;
            self.chooser.clear();
            self.requests.end();
            self.opening.at = None;
            events.push(if plan.is_some() { Event::PlanChanged } else { Event::PlanLost });
        }
    }

    fn read_clock(&mut self, inputs: &Inputs<'_>) {
        let now = inputs.now.and_then(schedule::plausible);
        // A new second does not need to fall into a step that has pictures to look at already.
        let has_pictures = self.has_pictures(inputs);
        let late = now.zip(self.opening.at).map(|(now, at)| now.0.abs_diff(at.0));
        if late.is_some_and(|late| late == 0 || late == 1 && has_pictures) {
            return;
        }
        let zone = inputs.plan.map_or(TimeZone::default(), |plan| plan.calendar.time_zone);
        let level = match (inputs.plan, now) {
            (Some(plan), Some(now)) => schedule::level_at(&plan.calendar, now),
            (Some(plan), None) if !plan.calendar.needs_clock() => Level::FULL,
            _ => Level::OFF,
        };
        let local_day = now.map(|now| schedule::local_time(&zone, now).day);
        self.opening = Opening { at: now, level, local_day };
    }

    fn has_pictures(&self, inputs: &Inputs<'_>) -> bool {
        self.thermal.is_busy() || inputs.thermal.iter().any(Option::is_some)
    }

    /// Once a second, or a little later where pictures come; what is slow to reckon is reckoned then.
    fn is_slow_step(&self, inputs: &Inputs<'_>) -> bool {
        let has_pictures = self.has_pictures(inputs);
        self.second.0 >= 2_000 || self.second.0 >= 1_000 && !has_pictures
    }

    fn keep_ledger(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) {
        let before = *self.ledger.spent();
        if inputs.stored.is_some_and(|stored| self.ledger.stored(stored)) {
            tell_day(&before, events);
            events.push(Event::DayBegan);
        }
        // What was lit until now was lit under the calibration of the step before.
        self.ledger.book(self.last.command.irradiance(), self.full, elapsed);
        if let Some(plan) = inputs.plan {
            self.full = PerLamp::new(plan.lamps.top.full_level, plan.lamps.bottom.full_level);
        }
        let now = inputs.now.and_then(schedule::plausible);
        self.ledger.clock(now, inputs.clock_was_set, elapsed, events);
        self.ledger.day(self.opening.local_day);
        if let Some(plan) = inputs.plan.filter(|_| self.is_slow) {
            self.notices.update(self.ledger.spent(), plan.limits.life_dose, events);
        }
        // A latch is a person's to clear: dark minutes are none in which it ran well.
        if self.uptime_ms >= u64::from(limits::RAN_WELL.0) && !self.watchdog_latched {
            self.ledger.ran_well();
        }
    }

    fn take_requests(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) {
        if self.requests.pass(elapsed) {
            events.push(Event::LeaseLapsed);
        }
        if self.requests.staff_key(inputs.staff_key, elapsed) {
            self.rearm(events);
        }
        for request in inputs.requests {
            match *request {
                Request::Rearm => self.rearm(events),
                Request::NewStack => {
                    self.ledger.new_stack();
                    events.push(Event::NewStack);
                }
                Request::Hold { view, .. }
                    if inputs.plan.is_none_or(|plan| usize::from(view) >= plan.views.len()) =>
                {
                    events.push(Event::NoSuchView(view));
                }
                leased => self.requests.take(leased),
            }
        }
    }

    fn rearm(&mut self, events: &mut Events) {
        let rearmed = self.interlock.rearm();
        if rearmed {
            self.watchdog_latched = false;
            self.governor.rearm();
        }
        events.push(if rearmed { Event::Rearmed } else { Event::RearmRefused });
    }

    fn follow_viewers(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) {
        let seen_warm = self.thermal.take(inputs.thermal, elapsed);
        let seen_moving = self.radar.take(inputs.radar, elapsed);
        let by_radar = match inputs.plan.map_or(ViewerSensor::Either, |plan| plan.viewer.sensor) {
            // The radar stands in for thermal sensors that are not fitted or have failed.
            ViewerSensor::Either => !self.thermal.is_sound() && self.radar.is_sound(),
            ViewerSensor::Thermal => false,
            ViewerSensor::Radar => true,
        };
        self.tracker.update(if by_radar { seen_moving } else { seen_warm }.as_ref(), elapsed);
        let lost = if by_radar { !self.radar.is_sound() } else { !self.thermal.is_sound() };
        let somebody = self.tracker.longest().is_some();
        // Who is blind does not know that nobody is there.
        self.nobody_for = if somebody || lost { Milliseconds(0) } else { self.nobody_for.plus(elapsed) };
        let was = self.presence;
        self.presence = self.presence_now(inputs.plan, somebody, lost);
        self.tell_presence(was, lost, events);
    }

    /// With one sensor lost a viewer before the other is still followed, but nobody can be said to be absent.
    fn presence_now(&self, plan: Option<&ValidPlan>, somebody: bool, lost: bool) -> Presence {
        let Some(timings) = plan.map(|plan| &plan.presence) else { return Presence::Unknown };
        if somebody {
            Presence::Somebody
        } else if lost {
            Presence::Unknown
        } else if self.nobody_for < timings.hold {
            Presence::JustGone
        } else if self.nobody_for < timings.hold.plus(timings.idle) {
            Presence::Idle
        } else {
            Presence::Empty
        }
    }

    fn tell_presence(&mut self, was: Presence, lost: bool, events: &mut Events) {
        // A sensor that is still learning its background after a start is not lost.
        let lost = lost && self.uptime_ms >= u64::from(limits::SENSOR_START.0);
        if lost != self.sensor_lost {
            self.sensor_lost = lost;
            events.push(if lost { Event::ViewerSensorLost } else { Event::ViewerSensorBack });
        }
        match (was == Presence::Somebody, self.presence == Presence::Somebody) {
            (false, true) => events.push(Event::ViewerCame),
            (true, false) => events.push(Event::ViewersGone),
            _ => {}
        }
    }

    fn wish(&mut self, inputs: &Inputs<'_>, elapsed: Milliseconds, events: &mut Events) -> Wish {
        let Some(plan) = inputs.plan else {
            return Wish::dark(DarkReason::NoPlan, limits::FASTEST_FADE);
        };
        let before = self.view(plan);
        let (pair, fade) = self.choose_pair(plan, elapsed);
        if self.view(plan) != before
            && let Some(view) = self.view(plan)
        {
            events.push(Event::ViewChosen(view));
        }
        let asked_to_light = self.requests.opens() || self.requests.held_view().is_some();
        let level = match self.opening.level {
            Level::OFF if asked_to_light => Level::FULL,
            level => level,
        };
        if self.requests.is_staff_dark() {
            Wish::dark(DarkReason::StaffKey, plan.presence.fade)
        } else if self.requests.is_host_dark() {
            Wish::dark(DarkReason::HostRequest, plan.presence.fade)
        } else if level == Level::OFF {
            Wish::dark(DarkReason::Closed, plan.presence.fade)
        } else if self.presence == Presence::Empty && self.requests.held_view().is_none() {
            Wish::dark(DarkReason::NobodyThere, plan.presence.fade)
        } else {
            Wish { target: pair.map(|lamp| lamp.scaled(level)), fade, dark: None }
        }
    }

    fn choose_pair(&mut self, plan: &Plan, elapsed: Milliseconds) -> (Emphasis, Milliseconds) {
        let chosen = match self.presence {
            Presence::Somebody | Presence::JustGone => self.chooser.choose(plan, &self.tracker, elapsed),
            Presence::Idle | Presence::Empty | Presence::Unknown => {
                self.chooser.clear();
                None
            }
        };
        let held = self.requests.held_view().and_then(|view| plan.views.get(usize::from(view)));
        if let Some(view) = held {
            return (view.emphasis, plan.viewer.fade);
        }
        match self.presence {
            Presence::Somebody | Presence::JustGone => (chosen.unwrap_or(plan.neutral), plan.viewer.fade),
            Presence::Unknown => (plan.neutral, plan.presence.fade),
            Presence::Idle | Presence::Empty => {
                let idle = plan.neutral.map(|level| level.scaled(plan.presence.idle_level));
                (idle, plan.presence.fade)
            }
        }
    }

    fn view(&self, plan: &Plan) -> Option<u8> {
        self.requests.held_view().or_else(|| self.chooser.view(plan))
    }

    fn govern(
        &mut self,
        inputs: &Inputs<'_>,
        wish: Wish,
        wanted: Emphasis,
        elapsed: Milliseconds,
        events: &mut Events,
    ) -> Verdict {
        let irradiance =
            |pair: Emphasis| pair.zip(self.full).map(|(level, full)| level.of(full).min(limits::CEILING));
        let (target, wanted_irradiance) = (irradiance(wish.target), irradiance(wanted));
        // Both lamps are reserved for alike, so that a change of view never waits for the flash.
        let demand = [target.top, target.bottom, wanted_irradiance.top, wanted_irradiance.bottom];
        let most = demand.into_iter().max().unwrap_or_default().max(limits::IDLE_FLOOR);
        self.ledger.reserve(PerLamp::new(most, most));
        let conditions = Conditions {
            plan: inputs.plan.map(core::ops::Deref::deref),
            interlock: self.interlock.state(),
            boards: inputs.boards,
            enclosure: inputs.enclosure,
            supply: inputs.supply,
            ultraviolet: inputs.ultraviolet,
            clock_is_valid: self.opening.at.is_some(),
            uptime_ms: self.uptime_ms,
            watchdog_latched: self.watchdog_latched,
            // A wish for dark fades first: the governor hears of it when nothing is wanted any more.
            wants_dark: wish.dark.filter(|_| wanted == Emphasis::default()),
            reserved: self.ledger.covers(wanted_irradiance),
            accounts: self.ledger.spent().lamps,
        };
        let verdict = self.governor.decide(wanted, &conditions, elapsed, events);
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
        let (lit_s, full_s) = (self.snapshot.lit_s, self.snapshot.full_s);
        self.snapshot = self.take_snapshot(inputs);
        (self.snapshot.lit_s, self.snapshot.full_s) = (lit_s, full_s);
        if self.is_slow {
            self.second = Milliseconds(0);
            let seconds = |ms: u64| (ms / 1_000).min(u64::from(u32::MAX)) as u32;
            let lamps = self.ledger.spent().lamps;
            self.snapshot.lit_s = lamps.map(|account| seconds(account.lit_ms));
            self.snapshot.full_s = lamps.map(|account| seconds(account.full_ms));
        }
    }

    fn take_snapshot(&self, inputs: &Inputs<'_>) -> Snapshot {
        let spent = self.ledger.spent();
        Snapshot {
            uptime_ms: self.uptime_ms,
            now: self.opening.at,
            presence: self.presence,
            bearing: self.chooser.bearing(),
            viewers: self.tracker.viewers().count() as u8,
            view: inputs.plan.and_then(|plan| self.view(plan)),
            levels: self.last.command.levels(),
            irradiance: self.last.command.irradiance(),
            enabled: self.last.command.is_enabled(),
            dark: self.last.dark,
            cuts: self.last.cuts,
            boards: inputs.boards.map(|reading| reading.and_then(TemperatureReading::celsius)),
            enclosure: inputs.enclosure,
            supply: inputs.supply,
            ultraviolet: self.governor.ultraviolet(),
            interlock: self.interlock.state(),
            day_dose: PerLamp::new(spent.lamps.top.day, spent.lamps.bottom.day),
            life_dose: PerLamp::new(spent.lamps.top.life, spent.lamps.bottom.life),
            lit_s: PerLamp::default(),
            full_s: PerLamp::default(),
            power_cycles: spent.power_cycles,
            watchdog_resets: spent.watchdog_resets,
            lease: self.requests.lease(),
            ultraviolet_lost: self.governor.is_ultraviolet_sensor_lost(),
            viewer_sensor_lost: self.sensor_lost,
        }
    }
}

/// Tells what both lamps gave in a day that has ended; nothing of the time before a clock was first valid.
fn tell_day(ended: &LedgerRecord, events: &mut Events) {
    const UJ_PER_J: u64 = 1_000_000;
    const MS_PER_H: u64 = 3_600_000;
    let within = |value: u64| u32::try_from(value).unwrap_or(u32::MAX);
    if ended.day == 0 {
        return;
    }
    for lamp in [Lamp::Top, Lamp::Bottom] {
        let account = ended.lamps.get(lamp);
        events.push(Event::DayDose {
            lamp,
            day: ended.day,
            joules_m2: within(account.day.0.div_ceil(UJ_PER_J)),
            lit_hours: within(account.lit_ms / MS_PER_H),
        });
    }
}

#[cfg(test)]
mod tests;
