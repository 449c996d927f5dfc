//! What must hold in every step of millions, whatever happens to the exhibit.

use std::hint::black_box;

use vitrine_exhibit::events::Event;
use vitrine_exhibit::governor::LampCommand;
use vitrine_exhibit::inputs::{Contact, Inputs, InterlockLoops, Request, TemperatureReading};
use vitrine_exhibit::ledger::StoredReservation;
use vitrine_exhibit::limits;
use vitrine_exhibit::plan::calendar::{MinuteOfDay, ScheduleRule, Weekdays};
use vitrine_exhibit::plan::{Between, Policy, ValidPlan};
use vitrine_exhibit::schedule;
use vitrine_exhibit::units::{
    CentiCelsius, Irradiance, Level, Milliseconds, Millivolts, PerLamp, UtcSeconds,
};
use vitrine_exhibit::viewer::{PIXELS, RadarFrame, RadarTarget, ThermalFrame};
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

    fn any(&mut self) -> u64 {
        self.below(u64::MAX)
    }

    fn rarely(&mut self) -> bool {
        self.below(500) == 0
    }

    fn mostly_closed(&mut self) -> Contact {
        if self.rarely() { Contact::Open } else { Contact::Closed }
    }

    fn any_board(&mut self) -> Option<TemperatureReading> {
        if self.rarely() { self.board() } else { Some(TemperatureReading::Celsius(CentiCelsius(3_000))) }
    }

    /// Pixels of any sixteen bits, or of a narrower range.
    fn pixels(&mut self) -> [i16; PIXELS] {
        let spread = 1 << self.below(16);
        std::array::from_fn(|_| (self.below(spread) as i64 - spread as i64 / 2) as i16)
    }

    fn radar(&mut self) -> RadarFrame {
        (0..self.below(4)).map(|_| RadarTarget { x_mm: self.any() as i16, y_mm: self.any() as i16 }).collect()
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
        match self.below(20) {
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
            12..15 => bench.requests.push(self.request()),
            _ => self.set_right(bench),
        }
    }

    /// Somebody puts everything in order, with whatever plan.
    fn set_right(&mut self, bench: &mut Bench) {
        let sound = Bench::new();
        (bench.loops, bench.boards, bench.supply) = (sound.loops, sound.boards, sound.supply);
        (bench.clock, bench.eyes, bench.flash_works) = (sound.clock, sound.eyes, true);
        bench.plan = Some(plan(self));
        let lease = Milliseconds(self.below(60_000) as u32);
        bench.requests.extend([Request::Rearm, Request::Open { lease }]);
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
    for seed in 1..=40 {
        lit += story(seed * 7_919, 50_000).1;
    }
    println!("lit in {lit} of 2,000,000 steps");
    assert!(lit > 400_000, "the stories are all dark: {lit}");
}

#[test]
fn the_same_story_gives_the_same_light() {
    assert!(story(4_711, 20_000) == story(4_711, 20_000));
}

#[test]
#[should_panic(expected = "overflow")]
fn arithmetic_is_checked() {
    black_box(black_box(u8::MAX) + 1);
}

/// Whatever all inputs say, at any rate: no panic, and no light that they do not allow.
#[test]
fn any_input_is_taken() {
    const STEPS: u32 = 1_000_000;
    let mut fate = Fate(99);
    let mut state = State::new(Bench::new().flash, false);
    let mut plan = plan(&mut fate);
    let (mut lit, mut before) = (0_u32, LampCommand::DARK);
    for number in 0..STEPS {
        if fate.below(5_000) == 0 {
            plan = self::plan(&mut fate);
        }
        let picture = fate.below(20) == 0;
        let pixels = fate.pixels();
        let (left, right) = (ThermalFrame::left(pixels), ThermalFrame::right(pixels));
        let radar = fate.radar();
        let requests = [fate.request(), Request::Rearm];
        let inputs = Inputs {
            plan: Some(&plan).filter(|_| fate.below(2_000) > 0),
            thermal: [Some(&left).filter(|_| picture), Some(&right).filter(|_| picture && fate.below(3) > 0)],
            radar: Some(&radar).filter(|_| fate.below(20) == 0),
            interlock: InterlockLoops { a: fate.mostly_closed(), b: fate.mostly_closed() },
            boards: PerLamp::new(fate.any_board(), fate.any_board()),
            enclosure: fate.rarely().then(|| CentiCelsius(fate.any() as i16)),
            supply: Some(Millivolts(if fate.rarely() { fate.any() as u16 } else { 24_000 })),
            ultraviolet: fate.rarely().then(|| Irradiance(fate.any() as u32)),
            now: Some(UtcSeconds(if fate.rarely() { fate.any() as i64 } else { 1_777_629_600 })),
            clock_was_set: fate.rarely(),
            requests: &requests[..fate.below(3) as usize],
            staff_key: fate.rarely(),
            stored: state.ledger().to_store().map(|record| StoredReservation { sequence: record.sequence }),
            stand_still: fate.below(2) == 0,
        };
        let elapsed = Milliseconds(if fate.rarely() { fate.any() as u32 >> fate.below(32) } else { 10 });
        let (command, _) = step(&mut state, &inputs, elapsed);
        allow(command, before, &inputs, elapsed).unwrap_or_else(|error| panic!("step {number}: {error}"));
        lit += u32::from(command.is_enabled());
        before = command;
    }
    println!("lit in {lit} of {STEPS} steps");
    assert!(lit > STEPS / 20, "all dark: {lit}");
}

/// What the inputs of a step allow of its light.
fn allow(
    command: LampCommand,
    before: LampCommand,
    inputs: &Inputs<'_>,
    elapsed: Milliseconds,
) -> Result<(), String> {
    if command == LampCommand::DARK {
        return Ok(());
    }
    let Some(plan) = inputs.plan else { return Err("light without a plan".into()) };
    let cool = |board: Option<TemperatureReading>| {
        board.and_then(TemperatureReading::celsius).is_some_and(|now| now < limits::BOARD_CUT)
    };
    let most = command.irradiance().top.max(command.irradiance().bottom);
    let stride = (elapsed.0.min(100) * 65_535 / limits::FASTEST_FADE.0) as u16 + 1;
    let rises = command.levels().zip(before.levels()).map(|(now, before)| now.0.saturating_sub(before.0));
    let rules = [
        (inputs.interlock == InterlockLoops { a: Contact::Closed, b: Contact::Closed }, "an open interlock"),
        (cool(inputs.boards.top) && cool(inputs.boards.bottom), "a hot or unknown board"),
        (
            inputs.supply.is_some_and(|now| (limits::SUPPLY_LEAST..=limits::SUPPLY_MOST).contains(&now)),
            "no supply",
        ),
        (
            inputs.now.and_then(schedule::plausible).is_some() || !plan.calendar.needs_clock(),
            "an invalid clock",
        ),
        (inputs.enclosure.is_none_or(|air| air < limits::ENCLOSURE_CUT), "hot air"),
        (most <= plan.limits.ceiling && most <= limits::CEILING, "too bright"),
        (rises.top.max(rises.bottom) <= stride, "too fast"),
    ];
    rules.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, why)| Err(format!("light with {why}")))
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
