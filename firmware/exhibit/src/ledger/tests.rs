use super::*;
use crate::events::{Event, Events};
use crate::limits;
use crate::units::UtcSeconds;
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

/// A ledger in this day, with the record that waits at every start, and its flash.
fn in_day(day: u32) -> (DoseLedger, Flash) {
    let record = LedgerRecord { day, sequence: 1, ..LedgerRecord::default() };
    (DoseLedger::new(record, false), Flash { record, delay: 0, waited: 0 })
}

fn hours(hours: u32) -> Milliseconds {
    Milliseconds(hours * 3_600_000)
}

/// Midnight of this day, and some hours, in Greenwich.
fn at(day: u32, hour: u32) -> Option<UtcSeconds> {
    Some(UtcSeconds(i64::from(day) * 86_400 + i64::from(hour) * 3_600))
}

/// The ledger runs on to a moment of the clock; gives the day that it is in.
fn run(
    ledger: &mut DoseLedger,
    flash: &mut Flash,
    now: Option<UtcSeconds>,
    set: bool,
    elapsed: Milliseconds,
) -> u32 {
    let mut events = Events::default();
    ledger.book(PerLamp::default(), FULL, elapsed);
    ledger.clock(now, set, elapsed, &mut events);
    flash.step(ledger);
    ledger.day(now.map(|now| (now.0 / 86_400) as u32));
    flash.step(ledger);
    ledger.spent().day
}

#[test]
fn days_follow_midnight_for_years() {
    let (mut ledger, mut flash) = in_day(20_000);
    run(&mut ledger, &mut flash, at(20_000, 13), false, TICK);
    run(&mut ledger, &mut flash, at(20_000, 23), false, hours(10));
    for day in 20_001..20_800 {
        for hour in 0..24 {
            assert_eq!(run(&mut ledger, &mut flash, at(day, hour), false, hours(1)), day, "{hour}");
        }
    }
}

#[test]
fn days_follow_midnight_where_the_power_is_cut_every_night() {
    let (mut ledger, mut flash) = in_day(20_000);
    run(&mut ledger, &mut flash, at(20_000, 13), false, TICK);
    for day in 20_001..20_800 {
        run(&mut ledger, &mut flash, at(day - 1, 18), false, hours(5));
        ledger.reserve(FULL);
        flash.step(&mut ledger);
        ledger = DoseLedger::new(flash.record, false);
        flash.step(&mut ledger);
        // Some mornings are earlier than others.
        assert_eq!(run(&mut ledger, &mut flash, at(day, 10 - day % 3), false, TICK), day);
        run(&mut ledger, &mut flash, at(day, 13), false, hours(3 + day % 3));
    }
}

#[test]
fn a_clock_set_forward_again_and_again_gives_one_day_more_and_no_third() {
    let (mut ledger, mut flash) = in_day(20_000);
    run(&mut ledger, &mut flash, at(20_000, 12), false, TICK);
    for day in 20_001..20_100 {
        let now = run(&mut ledger, &mut flash, at(day, 12), true, Milliseconds(10_000));
        assert!(now <= 20_001, "{now}");
    }
    assert_eq!(run(&mut ledger, &mut flash, at(20_100, 12), false, hours(21)), 20_001);
    assert_eq!(run(&mut ledger, &mut flash, at(20_100, 14), false, hours(2)), 20_100);
}

#[test]
fn minutes_before_midnight_set_again_and_again_give_no_days() {
    let (mut ledger, mut flash) = in_day(20_000);
    let mut begun = 0;
    for day in 20_001..20_050 {
        let before = run(&mut ledger, &mut flash, at(day - 1, 23), true, TICK);
        begun += u32::from(run(&mut ledger, &mut flash, at(day, 0), false, hours(1)) != before);
    }
    // Two of the 49 hours' days, and the one that may be early.
    assert!(begun <= 3, "{begun}");
}

#[test]
fn a_power_cut_after_a_setting_proves_no_time() {
    let (mut ledger, mut flash) = in_day(20_000);
    run(&mut ledger, &mut flash, at(20_000, 12), false, TICK);
    for day in 20_001..20_030 {
        run(&mut ledger, &mut flash, at(day, 12), true, Milliseconds(10_000));
        ledger = DoseLedger::new(flash.record, false);
        flash.step(&mut ledger);
        assert!(run(&mut ledger, &mut flash, at(day, 12), false, Milliseconds(10_000)) <= 20_001);
        // Nor does a host that sets the clock as the first thing after a start.
        ledger = DoseLedger::new(flash.record, false);
        flash.step(&mut ledger);
        assert!(run(&mut ledger, &mut flash, at(day + 1, 11), true, TICK) <= 20_001);
    }
}

#[test]
fn a_jump_is_told_and_a_drift_is_not() {
    let (mut ledger, mut flash) = in_day(20_000);
    let mut told = std::vec::Vec::new();
    let mut show = |ledger: &mut DoseLedger, second: i64, elapsed: Milliseconds| {
        let mut events = Events::default();
        ledger.clock(Some(UtcSeconds(1_777_629_600 + second)), false, elapsed, &mut events);
        told.extend(events.iter());
        flash.step(ledger);
    };
    show(&mut ledger, 0, TICK);
    // A second in an hour, for a year.
    for hour in 1..8_760 {
        show(&mut ledger, hour * 3_601, hours(1));
    }
    show(&mut ledger, 0, TICK);
    assert_eq!(told, [Event::ClockJumped { seconds: -8_759 * 3_601 }]);
}

#[test]
fn a_clock_set_back_gives_no_second_day() {
    let (mut ledger, mut flash) = in_day(20_000);
    flash.step(&mut ledger);
    ledger.day(Some(19_999));
    assert_eq!(ledger.to_store(), None);
    ledger.book(PerLamp::default(), FULL, hours(24));
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
    let days = if cfg!(miri) { 30 } else { 30 * 365 };
    for _ in 0..days {
        for _ in 0..steps_a_day / 1_000 {
            ledger.book(lamps, PerLamp::new(Irradiance(30_000), Irradiance(30_000)), Milliseconds(500_000));
        }
    }
    let ms = days * (steps_a_day / 1_000) * 500_000_u64;
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
