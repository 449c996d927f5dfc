//! The walk through a simulated exhibit, sound and broken, whose time passes quickly.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use vitrine_exhibit::inputs::TemperatureReading;
use vitrine_exhibit::units::UtcSeconds;
use vitrine_exhibit::viewer::Bearing;

use super::{Person, Sheet, Verdict, walk};
use crate::controller::{Clock, FlashFile, Pace, Served, Surroundings, Viewer, VirtualController, serve};
use crate::link::tests::plan_bytes;
use crate::link::{Address, Client};

/// Does to the simulated exhibit what a person does to a real one; or nothing.
struct Helper<'a> {
    served: &'a Served,
    helps: bool,
    door_is_stuck: bool,
}

impl Person for Helper<'_> {
    fn does(&mut self, what: &str) -> bool {
        let set = |change: &dyn Fn(&mut Surroundings)| change(&mut self.served.controller().surroundings);
        if !self.helps {
            return false;
        }
        if what.contains("Open the door") && !self.door_is_stuck {
            set(&|surroundings| surroundings.set_door(false));
        } else if what.contains("Close the door") {
            set(&|surroundings| surroundings.set_door(true));
        } else if what.contains("staff key") {
            set(&|surroundings| surroundings.staff_key = true);
            thread::sleep(Duration::from_millis(60));
            set(&|surroundings| surroundings.staff_key = false);
        } else if what.contains("Stand") {
            let horizontal = if what.contains("right") { 2_500 } else { -2_500 };
            self.served.controller().set_viewer(Some(Viewer::at(Bearing::new(horizontal, 0))));
        }
        true
    }
}

/// Walks through an exhibit that `prepare` has changed.
fn walked(helps: bool, door_is_stuck: bool, prepare: impl FnOnce(&mut VirtualController)) -> Sheet {
    let now = UtcSeconds(jiff::Timestamp::now().as_second());
    let mut controller =
        VirtualController::new(FlashFile::in_memory(), Clock::Simulated(now)).expect("readable");
    prepare(&mut controller);
    let served = serve(controller, "127.0.0.1:0", Pace::Manual).expect("a free port");
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                served.controller().advance(60);
                thread::sleep(Duration::from_millis(10));
            }
        });
        let mut client = Client::open(&Address::Tcp(served.address().to_string())).expect("greeted");
        client.upload(&plan_bytes("Three photographs"), &mut |_| {}).expect("uploaded");
        // The viewer sensors learn the empty room first.
        while served.controller().time_ms() < 5_000 {
            thread::sleep(Duration::from_millis(10));
        }
        let sheet = walk(&mut client, &mut Helper { served: &served, helps, door_is_stuck });
        ended.store(true, Ordering::Relaxed);
        sheet.expect("walked")
    })
}

fn verdict(sheet: &Sheet, part: &str) -> Verdict {
    sheet.findings.iter().find(|finding| finding.part == part).expect(part).verdict
}

/// Simulated time runs ahead of this computer's in these tests, so the clock is not asked for.
fn failed(sheet: &Sheet) -> Vec<&str> {
    let failed = sheet.findings.iter().filter(|finding| finding.verdict == Verdict::Failed);
    failed.map(|finding| finding.part).filter(|part| *part != "clock").collect()
}

#[test]
fn a_sound_exhibit_passes_every_part_that_it_has() {
    let sheet = walked(true, false, |_| {});
    assert_eq!(failed(&sheet), [""; 0], "{}", sheet.text());
    for part in ["dark", "top lamp", "bottom lamp", "door", "re-arm", "staff key", "visitor, left"] {
        assert_eq!(verdict(&sheet, part), Verdict::Passed, "{}", sheet.text());
    }
    assert!(sheet.text().contains("Three photographs") && sheet.text().contains("Signature"));
}

#[test]
fn what_is_broken_is_found() {
    let sheet = walked(true, true, |controller| {
        controller.surroundings.board_faults.top = Some(TemperatureReading::OpenCircuit);
        controller.surroundings.supply = None;
    });
    let failed = failed(&sheet);
    for part in ["top board", "lamp supply", "top lamp", "bottom lamp", "door"] {
        assert!(failed.contains(&part), "{part}: {}", sheet.text());
    }
    assert_eq!(verdict(&sheet, "bottom board"), Verdict::Passed);
    // Nothing was asked of it: the door's opening never came.
    assert_eq!(verdict(&sheet, "re-arm"), Verdict::NotTried, "{}", sheet.text());
}

#[test]
fn without_a_person_the_rest_is_tried() {
    let sheet = walked(false, false, |_| {});
    assert_eq!(failed(&sheet), [""; 0], "{}", sheet.text());
    for part in ["door", "staff key", "visitor, right"] {
        assert_eq!(verdict(&sheet, part), Verdict::NotTried);
    }
    assert_eq!(verdict(&sheet, "bottom lamp"), Verdict::Passed, "{}", sheet.text());
}
