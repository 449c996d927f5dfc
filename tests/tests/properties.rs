//! What must hold in every step of a million, whatever happens to the exhibit.

use vitrine_exhibit::events::Event;
use vitrine_exhibit::governor::LampCommand;
use vitrine_exhibit::inputs::{Contact, Inputs, InterlockLoops, Request, TemperatureReading};
use vitrine_exhibit::ledger::StoredReservation;
use vitrine_exhibit::plan::calendar::{MinuteOfDay, ScheduleRule, Weekdays};
use vitrine_exhibit::plan::{Between, Policy, ValidPlan};
use vitrine_exhibit::units::{CentiCelsius, Level, Milliseconds, Millivolts, UtcSeconds};
use vitrine_exhibit::viewer::{PIXELS, ThermalFrame};
use vitrine_exhibit::{State, step};
use vitrine_tests::bench::{Bench, EyeHealth, standard_plan};
use vitrine_tests::room::Body;

/// A small generator: the same seed tells the same story (Marsaglia's xorshift64).
struct Fate(u64);

impl Fate {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }

    fn contact(&mut self) -> Contact {
        if self.below(5) == 0 { Contact::Open } else { Contact::Closed }
    }

    fn board(&mut self) -> Option<TemperatureReading> {
        match self.below(12) {
            0 => None,
            1 => Some(TemperatureReading::OpenCircuit),
            2 => Some(TemperatureReading::Shorted),
            3 => Some(TemperatureReading::Celsius(CentiCelsius(self.below(65_536) as i16))),
            _ => Some(TemperatureReading::Celsius(CentiCelsius((2_000 + self.below(5_500)) as i16))),
        }
    }

    fn request(&mut self) -> Request {
        let lease = Milliseconds(self.below(8_000) as u32);
        match self.below(8) {
            0 => Request::Hold { view: self.below(5) as u8, lease },
            1 => Request::Dark { lease },
            2 => Request::Open { lease },
            3 => Request::Release,
            4 => Request::NewStack,
            _ => Request::Rearm,
        }
    }

    /// Something happens.
    fn strike(&mut self, bench: &mut Bench) {
        match self.below(14) {
            0 => bench.loops.a = self.contact(),
            1 => bench.loops.b = self.contact(),
            2 => bench.boards.top = self.board(),
            3 => bench.boards.bottom = self.board(),
            4 => bench.supply = Some(Millivolts(if self.below(4) == 0 { 9_000 } else { 24_000 })),
            5 => bench.clock = self.clock(),
            6 => bench.plan = (self.below(4) > 0).then(|| plan(self)),
            7 => bench.eyes = [self.eye(), self.eye()],
            8 => bench.room.bodies = vec![Body::standing(self.below(100) as f64 - 50.0, 1.5)],
            9 => bench.staff_key = !bench.staff_key,
            10 => bench.flash_works = self.below(4) > 0,
            11 => bench.restart(self.below(6) == 0),
            _ => bench.requests.push(self.request()),
        }
    }

    fn clock(&mut self) -> Option<UtcSeconds> {
        (self.below(4) > 0).then_some(UtcSeconds(1_777_629_600 + self.below(90_000) as i64))
    }

    fn eye(&mut self) -> EyeHealth {
        [EyeHealth::Dead, EyeHealth::Frozen, EyeHealth::Garbage, EyeHealth::Sound, EyeHealth::Sound]
            [self.below(5) as usize]
    }
}

fn plan(fate: &mut Fate) -> ValidPlan {
    let mut plan = standard_plan();
    plan.limits.ceiling.0 = 1 + fate.below(20_000) as u32;
    plan.lamps.top.full_level.0 = 1 + fate.below(50_000) as u32;
    plan.lamps.bottom.full_level.0 = 1 + fate.below(50_000) as u32;
    let rule = ScheduleRule {
        days: Weekdays::ALL,
        from: MinuteOfDay(fate.below(1_440) as u16),
        to: MinuteOfDay(fate.below(1_441) as u16),
        first: None,
        last: None,
        level: Level(fate.below(65_536) as u16),
    };
    plan.calendar.rules.push(rule).expect("one fits");
    for view in &mut plan.views {
        view.horizontal.0 = fate.below(16_001) as i16 - 8_000;
        view.vertical.0 = fate.below(16_001) as i16 - 8_000;
        view.emphasis.top.0 = 1 + fate.below(65_535) as u16;
        view.emphasis.bottom.0 = fate.below(65_536) as u16;
    }
    plan.viewer.policy =
        [Policy::First, Policy::Nearest, Policy::Shared, Policy::Alternating][fate.below(4) as usize];
    plan.viewer.between = [Between::Nearest, Between::Smooth][fate.below(2) as usize];
    plan.presence.idle_level.0 = fate.below(65_536) as u16;
    plan.limits.continuous = Milliseconds(1_000 + fate.below(599_001) as u32);
    plan.limits.daily_dose.0 = 1 + fate.below(30_000_000_000);
    plan.lamps.top.ultraviolet_at_full.0 = fate.below(50_001) as u32;
    ValidPlan::new(plan).expect("within all bounds")
}

/// Light needs both contacts closed, a valid plan, the time where the plan wants it, and the dwell after a start.
fn check_light(bench: &Bench, steps_since_start: u32) -> Result<(), String> {
    let closed = bench.loops.a == Contact::Closed && bench.loops.b == Contact::Closed;
    let clock = bench.plan.as_ref().is_some_and(|plan| bench.clock.is_some() || !plan.calendar.needs_clock());
    if bench.command != LampCommand::DARK && !(closed && clock && steps_since_start >= 200) {
        return Err(format!("light at {:.2} s: closed {closed}, clock {clock}", bench.time_s()));
    }
    Ok(())
}

fn story(seed: u64, steps: u32) -> (Vec<LampCommand>, u64) {
    let (mut fate, mut bench) = (Fate(seed), Bench::new());
    let mut commands = Vec::new();
    let (mut since_start, mut lit) = (0_u32, 0_u64);
    for number in 0..steps {
        let power_cycles = bench.snapshot().power_cycles;
        if fate.below(150) == 0 {
            fate.strike(&mut bench);
        }
        bench.step().unwrap_or_else(|error| panic!("seed {seed}, step {number}: {error}"));
        since_start = if bench.snapshot().uptime_ms <= 10 || power_cycles == 0 { 1 } else { since_start + 1 };
        check_light(&bench, since_start).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        lit += u64::from(bench.command.is_enabled());
        commands.push(bench.command);
    }
    (commands, lit)
}

#[test]
fn a_million_steps_of_bad_luck_never_light_a_lamp_wrongly() {
    let mut lit = 0;
    for seed in 1..=20 {
        lit += story(seed * 7_919, 50_000).1;
    }
    println!("lit in {lit} of 1,000,000 steps");
    assert!(lit > 50_000, "the stories are all dark: {lit}");
}

#[test]
fn the_same_story_gives_the_same_light() {
    assert!(story(4_711, 20_000) == story(4_711, 20_000));
}

/// Any sixteen-bit readings, at any rate, are taken without a panic, and cost the lamps nothing but their light.
#[test]
fn any_picture_is_taken() {
    let mut fate = Fate(99);
    let mut bench = Bench::new();
    let plan = bench.plan.take().expect("there is one");
    let mut state = State::new(bench.flash, false);
    for _ in 0..50_000 {
        let spread = 1 << fate.below(16);
        let pixels: [i16; PIXELS] =
            std::array::from_fn(|_| (fate.below(spread) as i64 - spread as i64 / 2) as i16);
        let (left, right) = (ThermalFrame::left(pixels), ThermalFrame::right(pixels));
        let inputs = Inputs {
            plan: Some(&plan),
            thermal: [Some(&left), Some(&right).filter(|_| fate.below(3) > 0)],
            ..Inputs::default()
        };
        let (command, _) =
            step(&mut state, &inputs, Milliseconds(fate.below(u64::from(u32::MAX)) as u32 >> fate.below(32)));
        assert_eq!(command, LampCommand::DARK);
    }
}

/// No path from an event to light: what the controller tells of light agrees with what it commands.
#[test]
fn events_and_commands_agree() {
    let (mut fate, mut bench) = (Fate(31), Bench::new());
    let mut told_lit = false;
    for _ in 0..100_000 {
        if fate.below(200) == 0 {
            let restarted = bench.snapshot().power_cycles;
            fate.strike(&mut bench);
            told_lit &= restarted == bench.snapshot().power_cycles && bench.snapshot().uptime_ms > 0;
        }
        for event in bench.step().expect("what must always hold") {
            match event {
                Event::Lit => told_lit = true,
                Event::Dark(_) => told_lit = false,
                _ => {}
            }
        }
        assert_eq!(told_lit, bench.command.is_enabled(), "at {:.2} s", bench.time_s());
    }
}

/// Thirty years in hours, half of them with an open door: every counter goes on counting, none runs over.
#[test]
fn thirty_years_of_steps_overflow_nothing() {
    let mut fate = Fate(1_996);
    let mut bench = Bench::new();
    let plan = bench.plan.take().expect("there is one");
    let mut state = State::new(bench.flash, false);
    let hours = 30 * 365 * 24;
    let mut before = (0, 0);
    for hour in 0..hours {
        let stored = state.ledger().to_store().map(|record| StoredReservation { sequence: record.sequence });
        let contact = if fate.below(2) == 0 { Contact::Open } else { Contact::Closed };
        let inputs = Inputs {
            plan: Some(&plan),
            interlock: InterlockLoops { a: Contact::Closed, b: contact },
            boards: bench.boards,
            supply: bench.supply,
            now: Some(UtcSeconds(1_777_629_600 + i64::from(hour) * 3_600)),
            requests: &[Request::Rearm, Request::Hold { view: 0, lease: Milliseconds(u32::MAX) }],
            stored,
            ..Inputs::default()
        };
        step(&mut state, &inputs, Milliseconds(3_600_000));
        let spent = state.ledger().spent();
        let now = (spent.lamps.top.life.0, spent.lamps.top.lit_ms);
        assert!(now >= before, "hour {hour}");
        before = now;
    }
    assert_eq!(state.snapshot().uptime_ms, u64::from(hours as u32) * 3_600_000);
    println!("{} hours lit, {} J/m2", before.1 / 3_600_000, before.0 / 1_000_000);
    assert!(before.1 > 0);
}
