//! Flash is erased only while the lamps are dark or steady: a fade of a minute, in which all that wants to be written comes due.

use std::ops::Range;

use vitrine_exhibit::events::Event;
use vitrine_exhibit::inputs;
use vitrine_exhibit::ledger::LedgerRecord;
use vitrine_exhibit::plan::Plan;
use vitrine_exhibit::units::{Milliseconds, UtcSeconds};
use vitrine_protocol::status::ClockSource;
use vitrine_protocol::{Request, Response};
use vitrine_storage::map::{CLOCK, LEDGER, LOG, LOG_ENTRY_BYTES, SECTOR_BYTES};
use vitrine_storage::mock::MockFlash;
use vitrine_storage::{Ledger, Ring, TwoSlots};

use crate::bench::{Bench, Erase, LAMP_ENABLE, MILLISECOND, SECOND};
use crate::exhibit::plan;
use crate::hosts::Host;
use crate::room::battery_clock;

/// Entries of the log in a sector: payload, number and checksum.
const LOG_SECTOR: u32 = SECTOR_BYTES / (LOG_ENTRY_BYTES as u32 + 8);

/// Records of the ledger in a sector.
const LEDGER_SECTOR: u32 = LEDGER.appends_per_round() / ((LEDGER.end() - LEDGER.start()) / SECTOR_BYTES);

/// Records of the ledger for a start and the first light.
const FIRST_LIGHT: u32 = 4;

/// The board's queue of events.
const QUEUE: u32 = 64;

/// From the first view's pair to the second's the lamps fade over nine tenths of their range, in steps that round down.
const FADE: u64 = 59 * SECOND;

/// The slowest fade that a plan may have. Who is nobody in particular is shown the first view's pair.
fn slow_plan() -> Plan {
    let mut plan = plan();
    plan.viewer.fade = Milliseconds(60_000);
    plan.neutral = plan.views.first().expect("a view").emphasis;
    plan
}

/// A ledger in whose first sector there is room for so many records more.
fn ledger_with_room(records: u32) -> Vec<u8> {
    let mut flash = MockFlash::new(LEDGER.start(), LEDGER.end());
    let (mut ledger, _) = Ledger::open(&mut flash).expect("readable");
    for sequence in 1..=LEDGER_SECTOR - records {
        ledger.store(&mut flash, &LedgerRecord { sequence, ..LedgerRecord::default() }).expect("stored");
    }
    flash.bytes_mut().to_vec()
}

/// Holds a view, so that the lamps fade to its pair.
fn hold(bench: &mut Bench, host: &mut Host, view: u8) {
    let request = inputs::Request::Hold { view, lease: Milliseconds(600_000) };
    assert_eq!(host.ask(bench, &Request::Exhibit(request)), Ok(Response::Done));
}

/// Has so many events logged: re-arms that change nothing.
pub(crate) fn events(bench: &mut Bench, host: &mut Host, count: u32) {
    for _ in 0..count {
        host.patiently(bench, &Request::Exhibit(inputs::Request::Rearm)).expect("power");
        bench.run(10 * MILLISECOND);
    }
}

pub(crate) fn of(erases: &[Erase], place: impl Region) -> usize {
    erases.iter().filter(|erase| place.addresses().contains(&erase.start)).count()
}

/// Where something lies in flash.
pub(crate) trait Region {
    fn addresses(&self) -> Range<u32>;
}

impl<const N: usize> Region for Ring<N> {
    fn addresses(&self) -> Range<u32> {
        self.start()..self.end()
    }
}

impl Region for TwoSlots {
    fn addresses(&self) -> Range<u32> {
        self.start()..self.end()
    }
}

/// Sets the clock, which a record of the ledger takes note of.
pub(crate) fn set_clock(bench: &mut Bench, host: &mut Host) {
    let set = host.patiently(bench, &Request::SetClock { now: UtcSeconds(1_795_348_900) });
    assert!(matches!(set, Some(Response::Clock(_))), "{set:?}");
}

/// The newest record of the ledger in the board's flash.
fn newest_record(bench: &mut Bench) -> u32 {
    let mut flash = MockFlash::new(LEDGER.start(), LEDGER.end());
    let bytes = bench.flash_read(LEDGER.start(), LEDGER.end() - LEDGER.start());
    flash.bytes_mut().copy_from_slice(&bytes);
    Ledger::open(&mut flash).expect("readable").1.expect("a record").sequence
}

/// How many more entries the log takes without an erase: the rest of its sector, and the one that is erased ahead.
pub(crate) fn room(log_next: u32) -> u32 {
    2 * LOG_SECTOR - (log_next - 1) % LOG_SECTOR
}

/// A board at the first pair of the slow plan, its ledger short before a sector's end: as far from it at the power's coming as
/// `records` says.
fn at_the_first_pair(records: u32) -> (Bench, Host) {
    let mut bench = Bench::with_image("vitrine-pico-bench.elf");
    battery_clock(&mut bench);
    bench.flash_write(LEDGER.start(), &ledger_with_room(records));
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    host.upload(&mut bench, &slow_plan());
    bench.run(6 * SECOND);
    let erases = bench.erases();
    assert!(erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
    assert!(of(&erases, LEDGER) >= 1 && of(&erases, LOG) >= 1, "{erases:?}");
    (bench, host)
}

#[test]
fn nothing_is_erased_in_a_fade_and_what_waits_for_its_end_is_not_lost() {
    let (mut bench, mut host) = at_the_first_pair(FIRST_LIGHT);
    let before = host.status(&mut bench);
    let (record, began) = (newest_record(&mut bench), bench.now);
    let sent = room(before.log_next) + QUEUE / 2;
    hold(&mut bench, &mut host, 1);
    bench.run(200 * MILLISECOND);
    events(&mut bench, &mut host, sent);
    set_clock(&mut bench, &mut host);
    bench.run(began + FADE - SECOND - bench.now);
    let erases = bench.erases();
    assert!(erases.is_empty(), "{erases:?}");
    let end = host.status(&mut bench);
    assert_eq!(end.log_next, before.log_next + room(before.log_next), "the log waits for a sector");
    assert_eq!(end.snapshot.dark, None);
    let records = newest_record(&mut bench) - record;
    assert!(records >= 1, "{records} reservations came due");

    bench.run(3 * SECOND);
    let erases = bench.erases();
    assert!(erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
    assert!(of(&erases, LOG) >= 1 && of(&erases, CLOCK) == 1, "{erases:?}");
    assert_eq!(host.status(&mut bench).clock.source, ClockSource::Battery, "the clock was set in the end");
    let entries = host.log(&mut bench, before.log_next);
    let rearmed: Vec<_> = entries.iter().filter(|entry| entry.event == Event::Rearmed).collect();
    assert_eq!(rearmed.len() as u32, sent);
    let in_fade = before.snapshot.uptime_ms / 1_000..=end.snapshot.uptime_ms / 1_000;
    for entry in rearmed {
        assert!(in_fade.contains(&u64::from(entry.uptime_s)), "{entry:?} tells when it was written");
    }
    assert_eq!(bench.peek("VITRINE_LOST_EVENTS"), 0);
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn events_beyond_the_queue_are_counted_and_the_log_tells_how_many() {
    let (mut bench, mut host) = at_the_first_pair(FIRST_LIGHT);
    let before = host.status(&mut bench).log_next;
    let sent = room(before) + QUEUE + 20;
    hold(&mut bench, &mut host, 1);
    bench.run(200 * MILLISECOND);
    events(&mut bench, &mut host, sent);
    assert!(bench.erases().is_empty());
    bench.run(FADE);
    let erases = bench.erases();
    assert!(erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
    let entries = host.log(&mut bench, before);
    let rearmed = entries.iter().filter(|entry| entry.event == Event::Rearmed).count() as u32;
    let told = |event| if let Event::EventsLost(count) = event { count } else { 0 };
    let lost: u32 = entries.iter().map(|entry| told(entry.event)).sum();
    assert!((10..=20).contains(&lost), "{lost} lost");
    assert_eq!(rearmed + lost, sent);
    assert_eq!(bench.peek("VITRINE_LOST_EVENTS"), u64::from(lost));
}

#[test]
fn a_fade_with_more_records_than_there_is_room_for_stands_still_for_an_erase_instead_of_going_dark() {
    // One record is left in its sector, and the next is erased ahead.
    let (mut bench, mut host) = at_the_first_pair(FIRST_LIGHT + 1);
    let room = 1 + LEDGER_SECTOR;
    let (first, began) = (newest_record(&mut bench), bench.now);
    hold(&mut bench, &mut host, 1);
    bench.run(200 * MILLISECOND);
    bench.edges();
    for _ in 0..room + 10 {
        set_clock(&mut bench, &mut host);
        let dark = host.status(&mut bench).snapshot.dark;
        assert_eq!(dark, None, "after {} records", newest_record(&mut bench) - first);
        bench.run(900 * MILLISECOND);
    }
    assert!(bench.now - began < FADE, "the fade is over");
    let records = newest_record(&mut bench) - first;
    assert!(records > room, "{records} records");
    let erases = bench.erases();
    assert!(of(&erases, LEDGER) >= 1, "{erases:?}");
    assert!(erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
    assert!(!bench.edges().iter().any(|edge| edge.pin == LAMP_ENABLE), "dark for a moment");
    assert_eq!(bench.take_resets(), 0);
    println!("{records} records in a fade, {} erases", erases.len());
}
