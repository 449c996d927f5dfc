//! Erases as long as the flash chip's data sheet allows, and lamps that never come to rest by themselves.

use vitrine_exhibit::events::Event;
use vitrine_protocol::Request;
use vitrine_storage::map::LOG;

use crate::bench::{Bench, Erase, LAMP_ENABLE, MILLISECOND, SECOND};
use crate::exhibit::neutral_on;
use crate::fades::{events, of, room, set_clock};
use crate::hosts::Host;
use crate::room::{battery_clock, thermistor_reading};

/// W25Q16JV: the longest erase of a sector.
const LONGEST_ERASE: u64 = 400 * MILLISECOND;

/// The converter's channels of both lamp boards.
const BOARDS: [u8; 2] = [0, 1];

/// A lit board whose erases take their longest.
fn slow_flash() -> (Bench, Host) {
    let mut bench = Bench::with_image("vitrine-pico-bench.elf");
    battery_clock(&mut bench);
    let (mut bench, host) = neutral_on(bench);
    bench.erase_time(LONGEST_ERASE);
    bench.edges();
    bench.erases();
    (bench, host)
}

/// Whether the drivers were enabled all the time since the last look.
fn stayed_lit(bench: &mut Bench) -> bool {
    !bench.edges().iter().any(|edge| edge.pin == LAMP_ENABLE)
}

#[test]
fn hosts_that_have_one_long_erase_after_the_other_made_never_trip_the_watchdog() {
    let (mut bench, mut host) = slow_flash();
    for length in 1..=20 {
        // An upload of another length begins anew, and erases.
        let began = host.patiently(&mut bench, &Request::BeginUpload { length, crc: 0 });
        assert!(began.is_some());
        if length % 4 == 0 {
            set_clock(&mut bench, &mut host);
        }
        if length % 5 == 0 {
            events(&mut bench, &mut host, 20);
        }
        // At another moment of the watchdog's round each time.
        bench.run(u64::from(length) * 7 * MILLISECOND);
    }
    bench.run(2 * SECOND);
    let erases = bench.erases();
    assert!(erases.len() >= 25, "{} erases", erases.len());
    assert!(erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
    assert_eq!(bench.take_resets(), 0);
    assert!(stayed_lit(&mut bench), "the lamps went out for a moment");
    assert_eq!(bench.peek("VITRINE_LOST_EVENTS"), 0);
}

/// Warm boards whose temperature never stands still: no level lasts for the 50 ms that count as steady.
struct Wavering {
    rounds: u32,
}

impl Wavering {
    /// One round of the converter.
    fn round(&mut self, bench: &mut Bench, meanwhile: impl FnOnce(&mut Bench)) {
        self.rounds += 1;
        for board in BOARDS {
            bench.analog(board, thermistor_reading(70.0 + f64::from(self.rounds % 2) * 0.3));
        }
        let end = bench.now + 50 * MILLISECOND;
        meanwhile(bench);
        bench.run(end.saturating_sub(bench.now));
    }

    fn seconds(&mut self, bench: &mut Bench, seconds: u32) {
        for _ in 0..20 * seconds {
            self.round(bench, |_| {});
        }
    }
}

/// Boards so warm that they are derated, by as much as their sensors waver.
#[test]
fn lamps_that_waver_with_their_temperature_stand_still_for_what_is_due_and_lose_nothing() {
    let (mut bench, mut host) = slow_flash();
    let mut boards = Wavering { rounds: 0 };
    boards.seconds(&mut bench, 2);
    bench.run(2 * SECOND);
    boards.seconds(&mut bench, 1);
    let before = host.status(&mut bench).log_next;
    bench.erases();
    bench.edges();
    let sent = room(before) + 10;
    for _ in 0..sent.div_ceil(2) {
        boards.round(&mut bench, |bench| events(bench, &mut host, 2));
    }
    boards.seconds(&mut bench, 45);
    assert!(bench.erases().is_empty(), "nothing is due that cannot wait for a fade's end");
    boards.seconds(&mut bench, 30);
    let erases = bench.erases();
    assert!(of(&erases, LOG) >= 1, "{erases:?}");
    assert!(erases.iter().all(Erase::is_in_steady_light), "{erases:?}");
    let entries = host.log(&mut bench, before);
    let rearmed = entries.iter().filter(|entry| entry.event == Event::Rearmed).count();
    assert_eq!(rearmed as u32, sent.next_multiple_of(2));
    assert_eq!(bench.peek("VITRINE_LOST_EVENTS"), 0);

    // What a host wants erased gets its turn as well.
    boards.seconds(&mut bench, 1);
    let mut put_off = 0;
    let begin = Request::BeginUpload { length: 100, crc: 0 };
    loop {
        let mut done = false;
        boards.round(&mut bench, |bench| match host.ask(bench, &begin) {
            Ok(_) => done = true,
            Err(refusal) => assert!(refusal.retry().is_some(), "{refusal}"),
        });
        if done {
            break;
        }
        put_off += 1;
        assert!(put_off < 20 * 30, "put off for ever");
    }
    assert!(put_off >= 1, "the lamps were never in motion");
    assert!(stayed_lit(&mut bench), "dark for want of an erase");
    assert_eq!(bench.take_resets(), 0);
}
