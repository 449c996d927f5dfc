//! The dose ledger and the event log over a year of an exhibit whose power is cut at random moments.

use std::{println, string::String, vec::Vec};

use vitrine_exhibit::{
    events::{Event, Events},
    ledger::{DoseLedger, RESERVATION, StoredReservation},
    units::{Dose, Irradiance, Milliseconds, PerLamp, UtcSeconds},
};

use super::cut_stride;
use crate::{
    Error, EventLog, Ledger,
    map::{FLASH_BYTES, IMAGE_END, LEDGER, LOG, SECTOR_BYTES},
    mock::{EraseOrder, LastStep, MockError, MockFlash, Random},
};

const STEP: Milliseconds = Milliseconds(500);
const FULL: PerLamp<Irradiance> = PerLamp::new(Irradiance(10_000), Irradiance(10_000));
const MOST: Irradiance = Irradiance(10_000);
/// Erases that a sector of such flash chips endures.
const ENDURANCE: f64 = 100_000.0;

type Outcome<T> = Result<T, Error<MockError>>;

/// An exhibit between two starts.
struct Exhibit {
    flash: MockFlash,
    store: Ledger,
    ledger: DoseLedger,
    log: EventLog,
}

/// What was really given and really logged, whatever the flash says.
#[derive(Default)]
struct Truth {
    life: PerLamp<u64>,
    today: PerLamp<u64>,
    day: u32,
    logged: u32,
    /// By how much the ledger's life is above the truth.
    over: PerLamp<u64>,
}

impl Exhibit {
    fn start(mut flash: MockFlash) -> Self {
        let (store, record) = Ledger::open(&mut flash).expect("readable");
        let log = EventLog::open(&mut flash).expect("readable");
        Self { ledger: DoseLedger::new(record.unwrap_or_default(), false), flash, store, log }
    }

    /// One step of a day that is so old; an error is the power's end.
    fn step(
        &mut self,
        (day, of_day): (u32, Milliseconds),
        wanted: PerLamp<Irradiance>,
        truth: &mut Truth,
    ) -> Outcome<()> {
        let now = UtcSeconds(i64::from(day) * 86_400 + i64::from(of_day.0 / 1_000));
        self.ledger.clock(Some(now), false, STEP, &mut Events::default());
        self.ledger.day(Some(day));
        self.ledger.reserve(wanted);
        if let Some(record) = self.ledger.to_store().copied() {
            self.store.store(&mut self.flash, &record)?;
            if self.store.wants_room() {
                self.store.make_room(&mut self.flash)?;
            }
            self.ledger.stored(StoredReservation { sequence: record.sequence });
        }
        if self.ledger.covers(wanted) {
            self.ledger.book(wanted, FULL, STEP);
            truth.give(day, wanted);
        }
        Ok(())
    }

    fn log(&mut self, truth: &mut Truth) -> Outcome<()> {
        let sequence =
            self.log.append(&mut self.flash, Some(UtcSeconds(1_795_379_862)), 7, Event::Rearmed)?;
        assert_eq!(sequence, truth.logged + 1);
        truth.logged = sequence;
        if self.log.wants_room() {
            self.log.make_room(&mut self.flash)?;
        }
        Ok(())
    }

    /// The power is gone and comes back: holds what the flash says against the truth.
    fn restart(mut self, truth: &mut Truth) -> Self {
        self.flash.power_on();
        let restarted = Self::start(self.flash);
        let record = *restarted.ledger.spent();
        let life = record.lamps.map(|account| account.life.0);
        for ((found, given), before) in [
            ((life.top, truth.life.top), truth.over.top),
            ((life.bottom, truth.life.bottom), truth.over.bottom),
        ] {
            assert!(found >= given, "under-counted: {found} of {given}");
            let more = (found - given).saturating_sub(before);
            assert!(more <= MOST.over(RESERVATION).0, "over-counted by {more}, more than one reservation");
        }
        truth.over = PerLamp::new(life.top - truth.life.top, life.bottom - truth.life.bottom);
        if record.day == truth.day {
            let today = record.lamps.map(|account| account.day.0);
            assert!(today.top >= truth.today.top && today.bottom >= truth.today.bottom, "the day's dose");
        }
        let next = restarted.log.next();
        assert!(next == truth.logged + 1 || next == truth.logged + 2, "{next} after {}", truth.logged);
        truth.logged = next - 1;
        restarted
    }

    fn expect_log_gapless(&mut self) {
        let (oldest, next) = (self.log.oldest(), self.log.next());
        assert!(next - oldest >= LOG.kept_at_least().min(next - 1) * 9 / 10);
        for sequence in oldest..next {
            assert!(
                self.log.read(&mut self.flash, sequence).expect("readable").is_some(),
                "entry {sequence}"
            );
        }
    }
}

impl Truth {
    fn give(&mut self, day: u32, given: PerLamp<Irradiance>) {
        if day != self.day {
            self.day = day;
            self.today = PerLamp::default();
        }
        let dose = given.map(|irradiance| irradiance.over(STEP));
        let add = |sum: PerLamp<u64>| PerLamp::new(sum.top + dose.top.0, sum.bottom + dose.bottom.0);
        self.life = add(self.life);
        self.today = add(self.today);
    }
}

/// Somebody's view, an idle glow, or nothing.
fn pair(random: &mut Random) -> PerLamp<Irradiance> {
    match random.below(4) {
        0 => PerLamp::default(),
        1 => PerLamp::new(Irradiance(1_000), Irradiance(1_000)),
        _ => {
            let top = Irradiance(random.below(u64::from(MOST.0) + 1) as u32);
            PerLamp::new(top, MOST)
        }
    }
}

fn wear(flash: &MockFlash, start: u32, end: u32) -> Vec<u32> {
    let sector = |address: u32| ((address - IMAGE_END) / SECTOR_BYTES) as usize;
    flash.erases()[sector(start)..sector(end)].to_vec()
}

fn report(name: &str, erases: &[u32]) -> String {
    let (least, most) = (erases.iter().min().expect("sectors"), erases.iter().max().expect("sectors"));
    let years = ENDURANCE / f64::from(*most);
    std::format!("{name}: {least} to {most} erases a sector in the year, {years:.0} years to {ENDURANCE:.0}")
}

#[test]
fn a_year_of_cuts_at_random_moments_never_under_counts() {
    const FIRST_DAY: u32 = 20_000;
    let mut random = Random(2026);
    let mut cuts = 0_u32;
    let mut orders = EraseOrder::ALL.into_iter().cycle();
    let mut last_steps = LastStep::ALL.into_iter().cycle();
    let flash = MockFlash::new(IMAGE_END, FLASH_BYTES);
    let mut truth = Truth::default();
    let mut exhibit = Exhibit::start(flash);
    for day in FIRST_DAY..FIRST_DAY + if cfg!(miri) { 1 } else { 365 } {
        // 9 to 18 o'clock; then the museum's power is cut, if it was not before.
        let mut left = 9 * 3_600_000 / STEP.0;
        while left > 0 {
            let steps = left.min(1 + random.below(20_000) as u32);
            left -= steps;
            let mut wanted = PerLamp::default();
            let mut outcome = Ok(());
            for step in 0..steps {
                if step % 20 == 0 {
                    wanted = pair(&mut random);
                }
                if step % 800 == 0 {
                    outcome = outcome.and_then(|()| exhibit.log(&mut truth));
                }
                let of_day = Milliseconds(18 * 3_600_000 - (left + steps - step) * STEP.0);
                outcome = outcome.and_then(|()| exhibit.step((day, of_day), wanted, &mut truth));
                if outcome.is_err() {
                    break;
                }
                if step + 200 == steps && random.below(2) == 0 {
                    // Half of the cuts fall into a write.
                    let within = random.below(400);
                    exhibit.flash.cut_after(within);
                }
            }
            assert!(matches!(outcome, Ok(()) | Err(Error::Flash(MockError::PowerLost))), "{outcome:?}");
            cuts += 1;
            exhibit.flash =
                exhibit.flash.tearing(orders.next().expect("endless"), last_steps.next().expect("endless"));
            exhibit = exhibit.restart(&mut truth);
        }
        if day % 30 == 0 {
            exhibit.expect_log_gapless();
        }
    }
    exhibit.expect_log_gapless();
    let ledger = wear(&exhibit.flash, LEDGER.start(), LEDGER.end());
    let log = wear(&exhibit.flash, LOG.start(), LOG.end());
    println!("{cuts} cuts; {} log entries", truth.logged);
    println!("{}", report("ledger", &ledger));
    println!("{}", report("event log", &log));
    let over = Dose(truth.over.bottom);
    println!("over-counted in all: {} of {} J/m2", over.0 / 1_000_000, truth.life.bottom / 1_000_000);
    for erases in [&ledger, &log] {
        assert!(erases.iter().max() <= erases.iter().min().map(|least| least + 60).as_ref());
        assert!(f64::from(*erases.iter().max().expect("sectors")) < ENDURANCE / 30.0);
    }
}

#[test]
fn a_cut_at_any_step_of_any_record_never_under_counts() {
    let stride = cut_stride(5);
    let mut cuts = 0;
    let mut random = Random(1);
    for order in EraseOrder::ALL {
        for last_step in LastStep::ALL {
            let flash = MockFlash::new(IMAGE_END, LEDGER.end()).tearing(order, last_step);
            let (store, _) = Ledger::open(&mut flash.clone()).expect("readable");
            let ledger = DoseLedger::new(Default::default(), false);
            let mut running = (flash, store, ledger, [0_u64; 2]);
            // More than a round of the ring, so that old records lie where new ones go.
            for number in 0..LEDGER.appends_per_round() as usize + 40 {
                let wanted = PerLamp::new(Irradiance(random.below(10_000) as u32), MOST);
                let before = running.clone();
                let steps = minute(&mut running, wanted).expect("power");
                let interesting = number < 3 || number % 32 > 29 || number % 32 < 2;
                let stride = if interesting { stride } else { stride * 23 };
                for cut in (0..steps).skip(number % stride).step_by(stride) {
                    let mut cut_off = before.clone();
                    cut_off.0.cut_after(cut);
                    minute(&mut cut_off, wanted).expect_err("no power");
                    cut_off.0.power_on();
                    let (_, record) = Ledger::open(&mut cut_off.0).expect("readable");
                    let lamps = record.unwrap_or_default().lamps;
                    for (found, given) in
                        [(lamps.top.life.0, cut_off.3[0]), (lamps.bottom.life.0, cut_off.3[1])]
                    {
                        assert!(found >= given, "under-counted: {found} of {given}");
                        assert!(found - given <= 2 * MOST.over(RESERVATION).0, "over-counted");
                    }
                    cuts += 1;
                }
            }
        }
    }
    println!("ledger: {cuts} cuts, nothing under-counted");
}

/// Light for a minute, with at least one record; gives the steps of flash it took.
fn minute(
    (flash, store, ledger, given): &mut (MockFlash, Ledger, DoseLedger, [u64; 2]),
    wanted: PerLamp<Irradiance>,
) -> Outcome<u64> {
    let before = flash.steps();
    for _ in 0..60_000 / STEP.0 {
        ledger.reserve(wanted);
        if let Some(record) = ledger.to_store().copied() {
            store.store(flash, &record)?;
            ledger.stored(StoredReservation { sequence: record.sequence });
            if store.wants_room() {
                store.make_room(flash)?;
            }
        }
        if ledger.covers(wanted) {
            ledger.book(wanted, FULL, STEP);
            given[0] += wanted.top.over(STEP).0;
            given[1] += wanted.bottom.over(STEP).0;
        }
    }
    Ok(flash.steps() - before)
}

#[test]
fn a_new_day_begins_with_the_dose_of_no_earlier_day() {
    let mut exhibit = Exhibit::start(MockFlash::new(IMAGE_END, FLASH_BYTES));
    let mut truth = Truth::default();
    let wanted = PerLamp::new(MOST, MOST);
    for day in [20_000, 20_001, 20_002] {
        for step in 0..7_200 {
            exhibit.step((day, Milliseconds(step * STEP.0)), wanted, &mut truth).expect("power");
        }
        let spent = exhibit.ledger.spent();
        assert_eq!((spent.day, spent.lamps.top.day), (day, Dose(truth.today.top)));
        exhibit = exhibit.restart(&mut truth);
    }
    let lit_steps = truth.life.top / MOST.over(STEP).0;
    assert!(
        (3 * 7_200 - 6..=3 * 7_200).contains(&lit_steps),
        "{lit_steps}: light hardly waits for the flash"
    );
}
