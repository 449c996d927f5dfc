//! However the program ends, the lamps are dark first. Tried on the bench image, whose tasks end badly on demand.

use vitrine_exhibit::events::{DarkReason, Event, ProgramEnd};
use vitrine_exhibit::inputs;
use vitrine_protocol::{Request, Response};

use crate::bench::{Bench, LAMP_PINS, MICROSECOND, MILLISECOND, SECOND};
use crate::exhibit::{lit_on, neutral_on};
use crate::hosts::Host;
use crate::room::Room;
use crate::signals::Edge;

/// The tasks of the image, by their bit at the watchdog.
const TASKS: [(&str, u32); 10] = [
    ("controller", 0),
    ("lamps", 1),
    ("sensors", 2),
    ("analog", 3),
    ("store", 4),
    ("usb", 5),
    ("serial", 6),
    ("radar", 7),
    ("front", 8),
    ("USB device", 9),
];

const PANIC: u32 = 1;
const HARD_FAULT: u32 = 2;
const ENDLESS_LOOP: u32 = 3;
const SILENCE: u32 = 4;

/// Rises on the bench image when a task begins to end badly.
const END_PIN: u8 = 17;

fn bench_image() -> Bench {
    Bench::with_image("vitrine-pico-bench.elf")
}

/// How a task ended.
struct End {
    /// From the last instruction before the bad end to the last of the lamps' lines being low, in ns.
    dark_after: u64,
    resets: usize,
    log: Vec<String>,
    /// What the event log says of it.
    kept: Option<(ProgramEnd, u32)>,
}

/// Asks a task to end badly and runs on, over the reset.
fn end_badly(action: u32, task: u32) -> End {
    let (mut bench, _host) = neutral_on(bench_image());
    bench.log();
    bench.edges();
    // Some periods of the lamps' dimming, so that their last fall is not taken for the reset's.
    bench.run(5 * MILLISECOND);
    bench.poke("VITRINE_BENCH", action << 16 | 1 << task);
    bench.run(800 * MILLISECOND);
    let edges = bench.edges();
    let began = edges.iter().find(|edge| edge.pin == END_PIN && edge.high).expect("it ended").at;
    // Of a line that is low already, a reset may be told as one more fall.
    let last_fall = |pin: u8| {
        let of_pin: Vec<&Edge> = edges.iter().filter(|edge| edge.pin == pin).collect();
        assert!(!of_pin.last().is_some_and(|edge| edge.high), "GP{pin} is high");
        let falls = of_pin.windows(2).filter(|pair| pair[0].high && !pair[1].high).map(|pair| pair[1].at);
        let only = of_pin.first().filter(|edge| !edge.high).map(|edge| edge.at);
        falls.max().or(only).map(|at| at.max(began))
    };
    let dark = LAMP_PINS.into_iter().filter_map(last_fall).max().expect("the lamps were lit");
    let resets = bench.take_resets();
    bench.run(SECOND);
    assert!(bench.is_dark(), "dark for the two seconds after a start");
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let next = host.status(&mut bench).log_next;
    let from = next.saturating_sub(8);
    let Ok(Response::Log(page)) = host.ask(&mut bench, &Request::ReadLog { from }) else { panic!("no log") };
    let kept = page.entries.iter().find_map(|entry| match entry.event {
        Event::ProgramEnded { end, at } => Some((end, at)),
        _ => None,
    });
    End { dark_after: dark - began, resets, log: bench.log(), kept }
}

#[test]
fn a_panic_in_any_task_is_dark_at_once_and_told_after_the_reset() {
    let mut longest = 0;
    for (name, task) in TASKS {
        let end = end_badly(PANIC, task);
        assert!(end.dark_after <= 20 * MICROSECOND, "{name}: {} ns", end.dark_after);
        assert_eq!(end.resets, 1, "{name}");
        let told =
            end.log.iter().any(|line| line.contains("the bench asked for it") && line.contains("hooks.rs"));
        assert!(told, "{name}: {:#?}", end.log);
        assert!(matches!(end.kept, Some((ProgramEnd::Panic, 1..))), "{name}: {:?}", end.kept);
        longest = longest.max(end.dark_after);
    }
    println!("panic to dark: at most {longest} ns");
}

#[test]
fn a_hard_fault_in_any_task_is_dark_at_once_and_told_after_the_reset() {
    let mut longest = 0;
    for (name, task) in TASKS {
        let end = end_badly(HARD_FAULT, task);
        assert!(end.dark_after <= 20 * MICROSECOND, "{name}: {} ns", end.dark_after);
        assert_eq!(end.resets, 1, "{name}");
        assert!(end.log.iter().any(|line| line.contains("hard fault at 0x1")), "{name}: {:#?}", end.log);
        let in_flash = |at: u32| at >> 28 == 1;
        assert!(
            matches!(end.kept, Some((ProgramEnd::HardFault, at)) if in_flash(at)),
            "{name}: {:?}",
            end.kept
        );
        longest = longest.max(end.dark_after);
    }
    println!("hard fault to dark: at most {longest} ns");
}

#[test]
fn an_endless_loop_in_any_task_is_dark_within_half_a_second() {
    let mut longest = 0;
    for (name, task) in TASKS {
        let end = end_badly(ENDLESS_LOOP, task);
        assert!(end.dark_after <= 500 * MILLISECOND, "{name}: {} ns", end.dark_after);
        assert_eq!(end.resets, 1, "{name}");
        assert_eq!(end.kept, Some((ProgramEnd::Hang, 0)), "{name}");
        longest = longest.max(end.dark_after);
    }
    println!("endless loop to dark: at most {} ms", longest / MILLISECOND);
}

/// The other tasks run on, the watchdog's among them: it is not fed for want of one. A task that had just checked in is missed
/// only after the others have, within a tenth of a second.
#[test]
fn a_task_that_waits_for_ever_is_missed_by_the_watchdog() {
    let mut longest = 0;
    for (name, task) in TASKS {
        let end = end_badly(SILENCE, task);
        assert!(end.dark_after <= 600 * MILLISECOND, "{name}: {} ns", end.dark_after);
        assert_eq!(end.resets, 1, "{name}");
        assert_eq!(end.kept, Some((ProgramEnd::Hang, 0)), "{name}");
        longest = longest.max(end.dark_after);
    }
    println!("a task that waits for ever to dark: at most {} ms", longest / MILLISECOND);
}

/// Three times the lamps were lit before a viewer when a task hung; then they stay dark until somebody re-arms.
#[test]
fn the_third_hang_in_ten_minutes_latches_dark_over_power_cuts_until_a_rearm() {
    let (mut bench, mut room) = lit_on(bench_image());
    for hang in 1..=3 {
        room.live(&mut bench, 5 * SECOND);
        assert!(lights(&mut bench, &mut room), "lit before hang {hang}");
        bench.poke("VITRINE_BENCH", ENDLESS_LOOP << 16 | 1 << 2);
        bench.run(600 * MILLISECOND);
        assert_eq!(bench.take_resets(), 1, "hang {hang}");
    }
    // As long as the two starts before took to light the lamps, and longer.
    for after in ["the third hang", "a power cut"] {
        room.live(&mut bench, 10 * SECOND);
        assert!(!lights(&mut bench, &mut room), "dark after {after}");
        let address = bench.listen();
        let mut host = Host::greet(&mut bench, &address);
        let status = host.status(&mut bench);
        assert_eq!(status.snapshot.dark, Some(DarkReason::WatchdogResets), "after {after}");
        assert_eq!(status.snapshot.watchdog_resets, 3);
        let entries = host.log(&mut bench, 1);
        let told = |event| entries.iter().filter(|entry| entry.event == event).count();
        assert_eq!(told(Event::ProgramEnded { end: ProgramEnd::Hang, at: 0 }), 3, "{entries:?}");
        assert!(told(Event::Dark(DarkReason::WatchdogResets)) >= 1, "{entries:?}");
        bench.power_off();
        bench.power_on();
    }

    room.live(&mut bench, 3 * SECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let rearmed = host.ask(&mut bench, &Request::Exhibit(inputs::Request::Rearm));
    assert_eq!(rearmed, Ok(Response::Done));
    room.live(&mut bench, 8 * SECOND);
    assert!(
        lights(&mut bench, &mut room),
        "lit after the re-arm: {:?}",
        host.status(&mut bench).snapshot.dark
    );
}

/// Whether any lamp's line rises within a tenth of a second.
fn lights(bench: &mut Bench, room: &mut Room) -> bool {
    bench.edges();
    room.live(bench, 100 * MILLISECOND);
    bench.edges().iter().any(|edge| edge.high && LAMP_PINS.contains(&edge.pin))
}
