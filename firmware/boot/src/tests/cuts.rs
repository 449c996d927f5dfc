//! Power that goes at any step of an update, of going back, of a restoration and of the confirmation: at every byte
//! programmed and every slice erased, with erases that tear in three orders, and steps that leave nothing or garbage.
//!
//! `VITRINE_CUT_STRIDE` says how many cuts are tried: every n-th; 1 tries all.

use std::{println, string::String, vec::Vec};

use vitrine_protocol::firmware::{Outcome, Progress};
use vitrine_storage::mock::{EraseOrder, LastStep, MockFlash};

use super::bench::{LAYOUT, Remembering, boot, flash_with, image, put, stage, tearing};
use crate::{start, store_progress};

/// Images that end in their second sector.
const LENGTH: usize = 4_000;

/// A number without common factors with the flash's sizes, so that the cuts tried fall everywhere.
const USUAL_STRIDE: u64 = 101;

fn stride() -> usize {
    let wanted = std::env::var("VITRINE_CUT_STRIDE").ok().and_then(|text| text.parse().ok());
    usize::try_from(wanted.unwrap_or(USUAL_STRIDE)).unwrap_or(1).max(1)
}

/// What goes on while the power goes. `Err` is what a lost power leaves.
type Course = fn(&mut MockFlash, &Remembering) -> Result<(), ()>;

/// A start with whatever it does.
fn starts(flash: &mut MockFlash, key: &Remembering) -> Result<(), ()> {
    start(flash, &LAYOUT, key).map(drop).map_err(drop)
}

fn stages(flash: &mut MockFlash, key: &Remembering) -> Result<(), ()> {
    stage(flash, key, &image("2.0.0", LENGTH)).map_err(drop)
}

fn confirms(flash: &mut MockFlash, _: &Remembering) -> Result<(), ()> {
    store_progress(flash, &LAYOUT, Progress::Settled(Outcome::Confirmed)).map_err(drop)
}

/// Lets the power go at every step (every `stride`-th) of a course that begins with `flash`, and again while what follows is
/// on its way; then hands the flash to `judge` with the power back. Gives the number of cuts.
fn cut_everywhere(
    flash: &MockFlash,
    key: &Remembering,
    course: Course,
    judge: &dyn Fn(&mut MockFlash, &str),
) -> u64 {
    let mut cuts = 0;
    for (turn, (order, last_step)) in
        EraseOrder::ALL.into_iter().flat_map(|order| LastStep::ALL.map(|step| (order, step))).enumerate()
    {
        let before = tearing(flash, order, last_step);
        let mut whole = before.clone();
        course(&mut whole, key).expect("with power");
        let steps = whole.steps() - before.steps();
        for cut in (0..steps).skip(turn % stride()).step_by(stride()) {
            let mut once = before.clone();
            once.cut_after(cut);
            assert_eq!(course(&mut once, key), Err(()), "cut {cut} of {steps} came too late");
            once.power_on();
            // The start that follows is cut as well, somewhere.
            let mut twice = once.clone();
            twice.cut_after(1 + cut.wrapping_mul(97) % (steps + 1));
            let _ = starts(&mut twice, key);
            twice.power_on();
            for (mut flash, what) in [(once, "one cut"), (twice, "two cuts")] {
                judge(&mut flash, &std::format!("{what} at {cut} of {steps}, {order:?}, {last_step:?}"));
                cuts += 1;
            }
        }
    }
    cuts
}

/// Starts until nothing is under way any more, at most so often; gives the versions that ran, each time whole.
fn versions(flash: &mut MockFlash, key: &Remembering, starts: usize) -> Vec<String> {
    (0..starts).map(|_| boot(flash, key).0).collect()
}

struct Bench {
    key: Remembering,
    /// The old image runs.
    settled: MockFlash,
    /// The new one is to be installed.
    wanted: MockFlash,
    /// The new one runs on trial.
    on_trial: MockFlash,
}

fn bench() -> Bench {
    let key = Remembering::new();
    let settled = flash_with(&image("1.0.0", LENGTH + 40));
    let mut wanted = settled.clone();
    stages(&mut wanted, &key).expect("staged");
    let mut on_trial = wanted.clone();
    assert_eq!(boot(&mut on_trial, &key), ("2.0.0".into(), true));
    Bench { key, settled, wanted, on_trial }
}

#[test]
fn cuts_while_an_image_is_sent_leave_the_old_one_running() {
    let Bench { key, settled, .. } = bench();
    let cuts = cut_everywhere(&settled, &key, stages, &|flash, what| {
        let ran = versions(flash, &key, 2);
        // A cut after the last byte of the progress has come too late: the update is wanted.
        assert!(ran == ["1.0.0", "1.0.0"] || ran == ["2.0.0", "1.0.0"], "{what}: {ran:?}");
        stages(flash, &key).expect("staged at last");
        assert_eq!(boot(flash, &key), ("2.0.0".into(), true), "{what}");
    });
    println!("sending: {cuts} cuts");
    assert!(cuts > 10_000 / stride() as u64);
}

#[test]
fn cuts_while_an_update_is_installed_leave_the_old_image_or_the_new_one() {
    let Bench { key, wanted, .. } = bench();
    let cuts = cut_everywhere(&wanted, &key, starts, &|flash, what| {
        // Nobody confirms: sooner or later the old image runs for good, and until then one of the two, whole.
        let ran = versions(flash, &key, 4);
        assert!(ran.iter().all(|version| version == "1.0.0" || version == "2.0.0"), "{what}: {ran:?}");
        assert_eq!(ran[2..], ["1.0.0", "1.0.0"], "{what}");
    });
    println!("installing: {cuts} cuts");
    assert!(cuts > 20_000 / stride() as u64);
}

#[test]
fn cuts_while_going_back_leave_the_old_image() {
    let Bench { key, on_trial, .. } = bench();
    let cuts = cut_everywhere(&on_trial, &key, starts, &|flash, what| {
        assert_eq!(versions(flash, &key, 2), ["1.0.0", "1.0.0"], "{what}");
    });
    println!("going back: {cuts} cuts");
    assert!(cuts > 10_000 / stride() as u64);
}

#[test]
fn cuts_while_an_update_confirms_itself_leave_it_or_go_back() {
    let Bench { key, on_trial, .. } = bench();
    let cuts = cut_everywhere(&on_trial, &key, confirms, &|flash, what| {
        let ran = versions(flash, &key, 3);
        assert!(ran.iter().all(|version| *version == ran[0]), "{what}: {ran:?}");
    });
    println!("confirming: {cuts} cuts");
    assert!(cuts > 100 / stride() as u64);
}

#[test]
fn cuts_while_a_damaged_image_is_replaced_leave_the_old_one() {
    let Bench { key, on_trial, .. } = bench();
    let mut damaged = on_trial;
    confirms(&mut damaged, &key).expect("confirmed");
    put(&mut damaged, LAYOUT.active, &image("2.0.0", LENGTH)[..2_000]);
    let cuts = cut_everywhere(&damaged, &key, starts, &|flash, what| {
        assert_eq!(versions(flash, &key, 2), ["1.0.0", "1.0.0"], "{what}");
    });
    println!("restoring: {cuts} cuts");
    assert!(cuts > 5_000 / stride() as u64);
}
