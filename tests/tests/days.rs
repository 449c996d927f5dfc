//! Whoever sets the clock as they like, and cuts the power when they like, wins no days of dose.

use vitrine_exhibit::events::Event;
use vitrine_exhibit::inputs::{Contact, Inputs, InterlockLoops};
use vitrine_exhibit::ledger::{LedgerRecord, StoredReservation};
use vitrine_exhibit::units::{Milliseconds, UtcSeconds};
use vitrine_exhibit::{State, step};
use vitrine_tests::bench::Bench;

const STEP_S: u64 = 300;
const DAY_S: u64 = 86_400;
/// By how much days may begin early in sum: a day, and two hours.
const EARLY_S: u64 = DAY_S + 2 * 3_600;
/// 2026-05-01.
const START: i64 = 1_777_593_600;

/// A controller whose battery clock somebody plays with.
struct Played {
    seed: u64,
    state: State,
    flash: LedgerRecord,
    real_s: u64,
    clock_s: i64,
    was_set: bool,
    days: u64,
}

impl Played {
    fn new(seed: u64) -> Self {
        Self {
            seed,
            state: State::new(LedgerRecord::default(), false),
            flash: LedgerRecord::default(),
            real_s: 0,
            clock_s: START,
            was_set: false,
            days: 0,
        }
    }

    /// Marsaglia's xorshift64.
    fn below(&mut self, bound: u64) -> u64 {
        self.seed ^= self.seed << 13;
        self.seed ^= self.seed >> 7;
        self.seed ^= self.seed << 17;
        self.seed % bound
    }

    fn pass(&mut self, seconds: u64) {
        self.real_s += seconds;
        self.clock_s = self.clock_s.saturating_add_unsigned(seconds);
    }

    /// A step, in which flash takes what the one before wanted stored.
    fn step(&mut self, bench: &Bench, seconds: u64) {
        let wanted = self.state.ledger().to_store().copied();
        self.flash = wanted.unwrap_or(self.flash);
        let inputs = Inputs {
            plan: bench.plan.as_ref(),
            interlock: InterlockLoops { a: Contact::Closed, b: Contact::Closed },
            boards: bench.boards,
            supply: bench.supply,
            now: Some(UtcSeconds(self.clock_s)),
            clock_was_set: std::mem::take(&mut self.was_set),
            stored: wanted.map(|record| StoredReservation { sequence: record.sequence }),
            ..Inputs::default()
        };
        let (_, events) = step(&mut self.state, &inputs, Milliseconds(seconds as u32 * 1_000));
        self.days += events.iter().filter(|event| *event == Event::DayBegan).count() as u64;
    }

    /// What they do next.
    fn play(&mut self, bench: &Bench) {
        match self.below(40) {
            0 => {
                let forward = self.below(4 * DAY_S) as i64 - DAY_S as i64;
                self.clock_s = (self.clock_s + forward).max(START);
                self.was_set = true;
            }
            1 => {
                // To just before a midnight.
                self.clock_s += (DAY_S - self.clock_s.rem_euclid(DAY_S as i64) as u64) as i64 - 400;
                self.was_set = true;
            }
            2 => {
                // What was wanted is in flash: the battery clock is set later than that.
                self.step(bench, 0);
                let away_s = self.below(10 * 3_600);
                self.pass(away_s);
                self.state = State::new(self.flash, false);
                self.step(bench, 0);
            }
            _ => {}
        }
        self.pass(STEP_S);
        self.step(bench, STEP_S);
    }
}

#[test]
fn no_play_with_the_clock_wins_days_of_dose() {
    let bench = Bench::new();
    let mut most = 0;
    for seed in 1..=40 {
        let mut played = Played::new(seed);
        while played.real_s < 40 * DAY_S {
            played.play(&bench);
            let allowed = (played.real_s + EARLY_S) / DAY_S + 1;
            assert!(played.days <= allowed, "seed {seed}: {} days in {} s", played.days, played.real_s);
        }
        most = most.max(played.days);
    }
    println!("at most {most} days in 40");
    assert!(most > 30, "the days do not go on");
}
