use super::*;
use crate::inputs::{Contact, InterlockLoops, TemperatureReading};
use crate::ledger::StoredReservation;
use crate::testing::plan;
use crate::units::{CentiCelsius, Millivolts};
use crate::viewer::{COLUMNS, PIXELS, ThermalFrame};

const TICK: Milliseconds = Milliseconds(10);

/// A controller with everything in order around it.
struct Bench {
    state: State,
    plan: ValidPlan,
    ticks: u32,
    /// Columns of the left and right sensor that are warm.
    warm: [Option<usize>; 2],
    loops: InterlockLoops,
    requests: &'static [Request],
}

impl Bench {
    fn new() -> Self {
        let closed = InterlockLoops { a: Contact::Closed, b: Contact::Closed };
        Self {
            state: State::new(LedgerRecord::default(), false),
            plan: ValidPlan::new(plan()).unwrap(),
            ticks: 0,
            warm: [None, None],
            loops: closed,
            requests: &[],
        }
    }

    fn frame(&self, side: usize) -> [i16; PIXELS] {
        core::array::from_fn(|i| {
            let flicker = ((self.ticks as usize / 10 + i) % 2) as i16;
            if self.warm[side] == Some(i % COLUMNS) && i / COLUMNS > 2 { 120 } else { 88 + flicker }
        })
    }

    fn tick(&mut self) -> (LampCommand, Events) {
        let frames = [ThermalFrame::left(self.frame(0)), ThermalFrame::right(self.frame(1))];
        let due = self.ticks.is_multiple_of(10);
        self.ticks += 1;
        let warm = Some(TemperatureReading::Celsius(CentiCelsius(3_000)));
        let stored = self.state.ledger().to_store().map(|r| StoredReservation { sequence: r.sequence });
        let inputs = Inputs {
            plan: Some(&self.plan),
            thermal: if due { [Some(&frames[0]), Some(&frames[1])] } else { [None, None] },
            interlock: self.loops,
            boards: PerLamp::new(warm, warm),
            supply: Some(Millivolts(24_000)),
            now: Some(UtcSeconds(1_800_000_000)),
            requests: core::mem::take(&mut self.requests),
            stored,
            ..Inputs::default()
        };
        step(&mut self.state, &inputs, TICK)
    }

    fn run(&mut self, ms: u32) -> LampCommand {
        (0..ms / 10).map(|_| self.tick().0).last().unwrap()
    }
}

#[test]
fn stays_dark_for_two_seconds_after_a_start_and_then_glows() {
    let mut bench = Bench::new();
    for _ in 0..199 {
        assert_eq!(bench.tick().0, LampCommand::DARK);
    }
    let command = bench.run(4_000);
    assert!(command.is_enabled());
    assert!(command.levels().top.0 > 0);
}

#[test]
fn shows_each_viewer_the_view_of_their_bearing() {
    for (warm, pair) in [
        ([Some(3), None], PerLamp::new(Level(65_535), Level(0))),
        ([None, Some(4)], PerLamp::new(Level(0), Level(65_535))),
    ] {
        let mut bench = Bench::new();
        bench.run(6_000);
        bench.warm = warm;
        assert_eq!(bench.run(3_000).levels(), pair);
    }
}

#[test]
fn nobody_dims_to_the_idle_glow_and_then_dark() {
    let mut bench = Bench::new();
    bench.run(6_000);
    bench.warm = [Some(3), None];
    bench.run(3_000);
    bench.warm = [None, None];
    assert_eq!(bench.run(15_000).levels().top, Level(65_535));
    let idle = bench.run(12_000).levels();
    assert_eq!(idle, PerLamp::new(Level(3_932), Level(3_932)));
    bench.run(300_000);
    assert_eq!(bench.state.snapshot().dark, Some(DarkReason::NobodyThere));
}

#[test]
fn an_open_door_is_dark_in_the_same_step_and_stays_so_until_a_rearm() {
    let mut bench = Bench::new();
    bench.run(6_000);
    bench.loops.b = Contact::Open;
    assert_eq!(bench.tick().0, LampCommand::DARK);
    bench.run(100);
    bench.loops.b = Contact::Closed;
    assert_eq!(bench.run(2_000), LampCommand::DARK);
    assert_eq!(bench.state.snapshot().dark, Some(DarkReason::InterlockNotArmed));
    bench.requests = &[Request::Rearm];
    assert!(bench.run(1_000).is_enabled());
}

#[test]
fn a_hold_lapses_with_its_lease() {
    let mut bench = Bench::new();
    bench.run(6_000);
    bench.requests = &[Request::Hold { view: 2, lease: Milliseconds(2_000) }];
    assert_eq!(bench.run(1_500).levels(), PerLamp::new(Level(0), Level(65_535)));
    bench.run(1_000);
    assert_ne!(bench.state.snapshot().view, Some(2));
}

#[test]
fn the_state_is_small() {
    assert!(size_of::<State>() < 8 * 1024, "{}", size_of::<State>());
}
