//! Flash: what an erase costs, and power that is cut at any of its steps.

use serde_json::json;
use vitrine_exhibit::inputs;
use vitrine_protocol::{Request, Response};

use crate::bench::{Bench, INTERLOCK_A, MICROSECOND, MILLISECOND, SECOND};
use crate::exhibit::{neutral_on, plan};
use crate::hosts::Host;

/// A sector's erase, as the bench's chip makes it.
const ERASE: u64 = 45 * MILLISECOND;

/// An erase stops all interrupts. An interlock that opens meanwhile is obeyed as soon as it ends; until then only the
/// hardware helps (hardware/wiring.md): the third contact in the lamps' supply.
#[test]
fn an_interlock_that_opens_during_an_erase_is_obeyed_right_after_it() {
    let (mut bench, mut host) = neutral_on(Bench::new());
    let mut longest = 0;
    for (attempt, after) in [2, 10, 20, 30, 40].into_iter().enumerate() {
        // An upload that is never finished: its beginning erases a sector. Another length begins anew.
        host.send(&Request::BeginUpload { length: 100 + attempt as u32, crc: 0 });
        let trip = bench.trip(INTERLOCK_A, true, after * MILLISECOND, 2 * ERASE);
        assert!(trip.was_lit && trip.dark, "{after} ms: {:?}", trip.latencies);
        let latency = *trip.latencies.iter().max().expect("three pins");
        assert!(latency <= ERASE + 20 * MICROSECOND, "{after} ms: {latency} ns");
        longest = longest.max(latency);
        bench.pin(INTERLOCK_A, false);
        bench.run(SECOND);
        host.ask(&mut bench, &Request::Exhibit(inputs::Request::Rearm)).expect("re-armed");
        bench.run(SECOND);
    }
    println!("interlock to dark during an erase: at worst {} us", longest / MICROSECOND);
    assert!(longest > 2 * MILLISECOND, "no opening fell into an erase");
    assert_eq!(bench.take_resets(), 0);
}

#[test]
fn a_power_cut_at_any_step_of_an_upload_leaves_the_old_plan_or_the_new_one() {
    let (mut bench, mut host) = neutral_on(Bench::new());
    let old = host.status(&mut bench).plan.expect("a plan").crc;
    bench.power_off();
    bench.call(json!({"op": "flash_save"}));
    let mut other = plan();
    other.name = "Another".try_into().expect("a short name");

    let steps = upload(&mut bench, &other, None).1;
    assert!(steps >= 6, "an upload of {steps} steps is none");
    let (mut kept, mut taken) = (0, 0);
    for step in 1..=steps {
        let order = ["rising", "falling", "shuffled"][step as usize % 3];
        let part = [0.0, 0.3, 0.7, 0.99][step as usize % 4];
        upload(&mut bench, &other, Some((step, part, order)));
        bench.power_on();
        bench.run(100 * MILLISECOND);
        let address = bench.listen();
        let found = Host::greet(&mut bench, &address).status(&mut bench).plan;
        let found = found.unwrap_or_else(|| panic!("no plan after a cut at step {step}, {order}"));
        kept += u32::from(found.crc == old);
        taken += u32::from(found.crc != old);
        assert!(found.crc == old || found.name.as_str() == "Another", "step {step}");
        bench.power_off();
    }
    println!("power cuts at {steps} steps: {kept} kept the old plan, {taken} had the new one");
    assert!(kept > 0);
}

/// Starts from the saved flash and uploads, with a cut or without; tells whether it was done, and the flash's steps.
fn upload(
    bench: &mut Bench,
    plan: &vitrine_exhibit::plan::Plan,
    cut: Option<(u64, f64, &str)>,
) -> (bool, u64) {
    bench.call(json!({"op": "flash_restore"}));
    bench.power_on();
    bench.run(300 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(bench, &address);
    let before = bench.flash_steps();
    if let Some((step, part, order)) = cut {
        bench.cut_at(step, part, order);
    }
    let done = host.try_upload(bench, plan).is_some();
    // The log takes note of the new plan.
    bench.run(50 * MILLISECOND);
    let steps = bench.flash_steps() - before;
    bench.power_off();
    (done, steps)
}

#[test]
fn the_serial_number_is_the_flash_chips() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let request =
        Request::Hello { version: vitrine_protocol::VERSION, fingerprint: vitrine_protocol::FINGERPRINT };
    let Ok(Response::Hello(hello)) = host.ask(&mut bench, &request) else { panic!("no hello") };
    assert_eq!(hello.serial_number.as_str(), "E6616408431F2A29");
}
