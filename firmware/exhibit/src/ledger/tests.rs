use super::*;
use crate::events::{Event, Events};
use crate::limits;
use proptest::prelude::*;

const TICK: Milliseconds = Milliseconds(10);
const FULL: PerLamp<Irradiance> = PerLamp::new(Irradiance(10_000), Irradiance(10_000));

/// A flash that writes what it is asked to, after some steps.
struct Flash {
    record: LedgerRecord,
    delay: u32,
    waited: u32,
}

impl Flash {
    fn step(&mut self, ledger: &mut DoseLedger) {
        let Some(record) = ledger.to_store() else { return };
        self.waited += 1;
        if self.waited > self.delay {
            self.waited = 0;
            self.record = *record;
            ledger.stored(StoredReservation { sequence: record.sequence });
        }
    }
}

proptest! {
    /// Whatever is lit for however long, and whenever the power is cut: the record in flash never says less than
    /// what the lamps have given, and never more than a reservation and the steps between.
    #[test]
    fn a_power_cut_only_over_counts(
        runs in prop::collection::vec((0_u32..20_000, 0_u32..20_000, 1_u32..9_000, 0_u32..20), 1..12)
    ) {
        let mut flash = Flash { record: LedgerRecord::default(), delay: 0, waited: 0 };
        let mut given = PerLamp::new(0_u64, 0_u64);
        let mut allowance = 0_u64;
        for (top, bottom, steps, delay) in runs {
            let mut ledger = DoseLedger::new(flash.record, false);
            flash.delay = delay;
            let lamps = PerLamp::new(Irradiance(top), Irradiance(bottom));
            let mut lit = PerLamp::default();
            for _ in 0..steps {
                ledger.book(lit, FULL, TICK);
                given.top += u64::from(lit.top.0) * 10;
                given.bottom += u64::from(lit.bottom.0) * 10;
                ledger.reserve(lamps);
                flash.step(&mut ledger);
                lit = if ledger.covers(lamps) { lamps } else { PerLamp::default() };
            }
            allowance += u64::from(top.max(bottom)) * u64::from(RESERVATION.0);
            prop_assert!(flash.record.lamps.top.life.0 >= given.top);
            prop_assert!(flash.record.lamps.bottom.life.0 >= given.bottom);
            prop_assert!(flash.record.lamps.top.life.0 <= given.top + allowance);
        }
    }
}

#[test]
fn a_new_day_begins_only_once_it_is_in_flash() {
    let mut ledger = DoseLedger::new(LedgerRecord::default(), false);
    let mut flash = Flash { record: LedgerRecord::default(), delay: 0, waited: 0 };
    ledger.day(Some(20_000));
    flash.step(&mut ledger);
    ledger.day(Some(20_000));
    flash.step(&mut ledger);
    assert_eq!(ledger.spent().day, 20_000);
    ledger.reserve(FULL);
    flash.step(&mut ledger);
    ledger.book(FULL, FULL, Milliseconds(5_000));
    assert_eq!(ledger.spent().lamps.top.day, Dose(50_000_000));
    ledger.day(Some(20_001));
    assert_eq!(ledger.spent().lamps.top.day, Dose(50_000_000));
    assert!(ledger.covers(FULL));
    flash.step(&mut ledger);
    assert_eq!((ledger.spent().day, ledger.spent().lamps.top.day), (20_001, Dose(0)));
    assert_eq!(ledger.spent().lamps.top.life, Dose(50_000_000));
    // The new day's record holds all that is still reserved, and the lamps need not go dark for it.
    assert_eq!(flash.record.lamps.top.day, Dose(550_000_000));
    assert!(ledger.covers(FULL));
}

#[test]
fn a_clock_set_back_gives_no_second_day() {
    let mut ledger =
        DoseLedger::new(LedgerRecord { day: 20_000, sequence: 1, ..LedgerRecord::default() }, false);
    let mut flash = Flash { record: LedgerRecord::default(), delay: 0, waited: 0 };
    flash.step(&mut ledger);
    ledger.day(Some(19_999));
    assert_eq!(ledger.to_store(), None);
    ledger.book(PerLamp::default(), FULL, Milliseconds(DAY_MS));
    ledger.day(Some(19_999));
    assert_eq!(ledger.to_store().map(|record| record.day), Some(19_999));
}

#[test]
fn resets_that_follow_quickly_are_counted_until_it_ran_well() {
    let mut record = LedgerRecord::default();
    for count in 1..=3 {
        let ledger = DoseLedger::new(record, true);
        record = *ledger.to_store().unwrap();
        assert_eq!((record.quick_resets, record.power_cycles), (count, u32::from(count)));
    }
    let mut ledger = DoseLedger::new(record, false);
    assert_eq!(ledger.spent().quick_resets, limits::QUICK_RESETS);
    ledger.ran_well();
    assert_eq!(ledger.to_store().map(|record| record.quick_resets), Some(0));
}

/// Full light, ten hours a day, for thirty years: nothing overflows, and no microjoule is lost.
#[test]
fn thirty_years_neither_overflow_nor_drift() {
    let mut ledger = DoseLedger::new(LedgerRecord::default(), false);
    let lamps = PerLamp::new(Irradiance(20_000), Irradiance(3));
    let steps_a_day = 10 * 3_600 * 2;
    for _ in 0..30 * 365 {
        for _ in 0..steps_a_day / 1_000 {
            ledger.book(lamps, PerLamp::new(Irradiance(30_000), Irradiance(30_000)), Milliseconds(500_000));
        }
    }
    let ms = 30 * 365 * (steps_a_day / 1_000) * 500_000_u64;
    let account = ledger.spent().lamps;
    assert_eq!(account.top.life, Dose(20_000 * ms));
    assert_eq!(account.bottom.life, Dose(3 * ms));
    assert_eq!(account.top.full_ms, ms * 2 / 3);
    assert_eq!(account.bottom.full_ms, ms / 10_000);
    assert_eq!(account.top.lit_ms, ms);
}

#[test]
fn notices_come_once_each() {
    let mut notices = Notices::new();
    let mut record = LedgerRecord::default();
    let told = |notices: &mut Notices, record: &LedgerRecord| {
        let mut events = Events::default();
        notices.update(record, Dose(1_000), &mut events);
        events.iter().collect::<std::vec::Vec<_>>()
    };
    assert_eq!(told(&mut notices, &record), []);
    record.lamps.top.life = Dose(750);
    assert_eq!(told(&mut notices, &record), [Event::LifeDoseUsed(Lamp::Top, 75)]);
    assert_eq!(told(&mut notices, &record), []);
    record.lamps.top.life = Dose(1_000);
    record.lamps.bottom.full_ms = 4_000 * 3_600_000;
    assert_eq!(
        told(&mut notices, &record),
        [
            Event::LifeDoseUsed(Lamp::Top, 90),
            Event::LifeDoseUsed(Lamp::Top, 100),
            Event::LampHours(Lamp::Bottom, 4_000)
        ]
    );
}
