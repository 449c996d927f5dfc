use vitrine_exhibit::{
    events::{Event, LogEntry},
    ledger::{LampAccount, LedgerRecord},
    units::{Dose, Lamp, PerLamp, UtcSeconds},
};

use crate::{
    EventLog, Ledger,
    map::{FLASH_BYTES, IMAGE_END, LEDGER},
    mock::MockFlash,
};

fn flash() -> MockFlash {
    MockFlash::new(IMAGE_END, FLASH_BYTES)
}

#[test]
fn the_newest_ledger_record_is_found_after_a_start() {
    let mut flash = flash();
    let (mut ledger, record) = Ledger::open(&mut flash).expect("readable");
    assert_eq!(record, None);
    for sequence in 1..=2 * LEDGER.appends_per_round() {
        let record = LedgerRecord { sequence, power_cycles: sequence / 3, ..LedgerRecord::default() };
        ledger.store(&mut flash, &record).expect("stored");
        let (_, found) = Ledger::open(&mut flash).expect("readable");
        assert_eq!(found, Some(record));
    }
}

#[test]
fn the_largest_ledger_record_fits() {
    let account =
        LampAccount { day: Dose(u64::MAX), life: Dose(u64::MAX), lit_ms: u64::MAX, full_ms: u64::MAX };
    let record = LedgerRecord {
        sequence: u32::MAX,
        day: u32::MAX,
        lamps: PerLamp::new(account, account),
        power_cycles: u32::MAX,
        watchdog_resets: u32::MAX,
        quick_resets: u8::MAX,
        stacks: u16::MAX,
        day_ms: u32::MAX,
        early_ms: u32::MAX,
        clock_s: u32::MAX,
    };
    let mut flash = flash();
    let (mut ledger, _) = Ledger::open(&mut flash).expect("readable");
    ledger.store(&mut flash, &record).expect("fits");
    assert_eq!(Ledger::open(&mut flash).expect("readable").1, Some(record));
}

#[test]
fn logged_events_are_read_by_their_number() {
    let mut flash = flash();
    let mut log = EventLog::open(&mut flash).expect("readable");
    assert_eq!((log.oldest(), log.next()), (1, 1));
    // The last time to which a clock can be set.
    let time = Some(UtcSeconds(4_102_444_799));
    let event =
        Event::DayDose { lamp: Lamp::Bottom, day: u32::MAX, joules_m2: u32::MAX, lit_hours: u32::MAX };
    for number in 1..=3 {
        assert_eq!(log.append(&mut flash, time, u32::MAX, event), Ok(number));
    }
    let log = EventLog::open(&mut flash).expect("readable");
    assert_eq!((log.oldest(), log.next()), (1, 4));
    assert_eq!(log.read(&mut flash, 2), Ok(Some(LogEntry { sequence: 2, time, uptime_s: u32::MAX, event })));
    assert_eq!(log.read(&mut flash, 4), Ok(None));
}

#[test]
fn what_comes_with_every_visitor_is_not_kept() {
    use vitrine_exhibit::events::DarkReason::{Closed, InterlockOpen, NobodyThere, Starting};
    let mut flash = flash();
    let mut log = EventLog::open(&mut flash).expect("readable");
    let visit =
        [Event::ViewerCame, Event::Lit, Event::ViewChosen(1), Event::ViewersGone, Event::Dark(NobodyThere)];
    let mut events = std::vec![Event::Dark(Starting), Event::Dark(NobodyThere)];
    events.extend(visit.repeat(3));
    events.extend([Event::Dark(InterlockOpen), Event::Dark(NobodyThere)]);
    events.extend(visit.repeat(3));
    events.push(Event::Dark(Closed));
    for event in events {
        log.keep(&mut flash, None, 0, event).expect("kept or not");
    }
    let kept: std::vec::Vec<_> = (log.oldest()..log.next())
        .map(|sequence| log.read(&mut flash, sequence).expect("readable").expect("kept").event)
        .collect();
    let dark = Event::Dark;
    assert_eq!(kept, [dark(Starting), Event::Lit, dark(InterlockOpen), Event::Lit, dark(Closed)]);
}
