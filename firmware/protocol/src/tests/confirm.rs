//! What asks for more: over a cable only, and in two steps.

use vitrine_exhibit::{
    inputs,
    settings::{Settings, SettingsError},
    units::{Milliseconds, UtcSeconds},
};

use super::{controller::bytes, samples, server::Bench};
use crate::{
    Refusal, Request,
    message::{Chunk, Reply, Response},
    plan_file,
    server::{CLOCK_REST_MS, CONFIRM_WITHIN_MS, Reach},
};

const NEW_STACK: Request = Request::Exhibit(inputs::Request::NewStack);
const NOW: UtcSeconds = UtcSeconds(1_795_379_862);

fn code(reply: Reply) -> u32 {
    match reply {
        Ok(Response::Confirm { code }) => code,
        other => panic!("no confirmation is wanted: {other:?}"),
    }
}

/// Uploads a plan up to its commit, and gives the answer to that.
fn upload(bench: &mut Bench, plan: &[u8]) -> Reply {
    bench.begin(0, plan).expect("begun");
    for (part, number) in plan.chunks(256).zip(0_u32..) {
        let bytes = Chunk::from_slice(part).expect("short");
        bench.ask(0, &Request::UploadChunk { offset: number * 256, bytes }).expect("taken");
    }
    bench.ask(0, &Request::CommitUpload { crc: plan_file::crc(plan) })
}

#[test]
fn a_new_stack_is_declared_when_it_is_said_twice() {
    let mut bench = Bench::new(1);
    let code = code(bench.ask(0, &NEW_STACK));
    assert_eq!(bench.memory.asked, []);
    let wrong = Request::Confirm { code: code ^ 1 };
    assert_eq!(bench.ask(0, &wrong), Err(Refusal::NothingToConfirm));
    let confirm = Request::Confirm { code };
    assert_eq!(bench.ask(0, &confirm), Ok(Response::Done));
    assert_eq!(bench.memory.asked, [inputs::Request::NewStack]);
    // The answer was lost and the host asks again: no second stack.
    assert_eq!(bench.ask(0, &confirm), Ok(Response::Done));
    assert_eq!(bench.memory.asked.len(), 1);
}

#[test]
fn a_confirmation_is_of_its_link_and_its_time() {
    let mut bench = Bench::new(2);
    let first = code(bench.ask(0, &NEW_STACK));
    assert_eq!(bench.ask(1, &Request::Confirm { code: first }), Err(Refusal::NothingToConfirm));
    assert_eq!(code(bench.ask(0, &NEW_STACK)), first);
    bench.now_ms += CONFIRM_WITHIN_MS + 1;
    assert_eq!(bench.ask(0, &Request::Confirm { code: first }), Err(Refusal::NothingToConfirm));
    let second = code(bench.ask(1, &NEW_STACK));
    assert_ne!(second, first);
    assert_eq!(bench.memory.asked, []);
}

#[test]
fn settings_within_their_bounds_change_when_they_are_confirmed() {
    let mut bench = Bench::new(1);
    assert_eq!(bench.ask(0, &Request::ReadSettings), Ok(Response::Settings(Settings::default())));
    let wrong = Settings { top_beta_kelvin: 1, ..Settings::default() };
    let refused = Err(Refusal::UnfitSettings(SettingsError::Beta));
    assert_eq!(bench.ask(0, &Request::ChangeSettings(wrong)), refused);
    let settings = samples::settings();
    let code = code(bench.ask(0, &Request::ChangeSettings(settings.clone())));
    assert_eq!(bench.memory.settings, Settings::default());
    let done = bench.ask(0, &Request::Confirm { code });
    assert_eq!(done, Ok(Response::Settings(settings.clone())));
    assert_eq!(bench.memory.settings, settings);
}

#[test]
fn a_confirmed_write_that_is_put_off_may_be_confirmed_again() {
    let mut bench = Bench::new(1);
    let code = code(bench.ask(0, &Request::ChangeSettings(samples::settings())));
    bench.memory.refusal = Some(super::controller::LAMPS_IN_MOTION);
    let put_off = bench.ask(0, &Request::Confirm { code });
    assert_eq!(put_off, Err(super::controller::LAMPS_IN_MOTION));
    assert!(bench.ask(0, &Request::Confirm { code }).is_ok());
}

#[test]
fn a_plan_that_asks_for_more_waits_for_its_confirmation() {
    let mut bench = Bench::new(1);
    let plan = bytes(700);
    bench.memory.asks_for_more = true;
    let code = code(upload(&mut bench, &plan));
    assert_eq!(bench.memory.active, None);
    let committed = Ok(Response::Committed { crc: plan_file::crc(&plan) });
    assert_eq!(bench.ask(0, &Request::Confirm { code }), committed);
    assert_eq!(bench.memory.active.as_deref(), Some(&plan[..]));
    // The commit again, and the confirmation again: both are done already.
    assert_eq!(bench.ask(0, &Request::CommitUpload { crc: plan_file::crc(&plan) }), committed);
    assert_eq!(bench.ask(0, &Request::Confirm { code }), committed);
}

#[test]
fn a_network_may_only_ask_for_less() {
    let mut bench = Bench::reaching(1, Reach::Network);
    let lease = Milliseconds(1_000);
    for less in [inputs::Request::Dark { lease }, inputs::Request::Release] {
        assert_eq!(bench.ask(0, &Request::Exhibit(less)), Ok(Response::Done));
    }
    for more in [
        Request::Exhibit(inputs::Request::Hold { view: 0, lease }),
        Request::Exhibit(inputs::Request::Open { lease }),
        Request::Exhibit(inputs::Request::Rearm),
        NEW_STACK,
        Request::SetClock { now: NOW },
        Request::ChangeSettings(Settings::default()),
        Request::Confirm { code: 0 },
    ] {
        assert_eq!(bench.ask(0, &more), Err(Refusal::CableOnly), "{more:?}");
    }
    for reading in [Request::Status, Request::Clock, Request::ReadSettings, Request::ReadLog { from: 0 }] {
        assert!(bench.ask(0, &reading).is_ok(), "{reading:?}");
    }
    let plan = bytes(300);
    bench.memory.asks_for_more = true;
    assert_eq!(upload(&mut bench, &plan), Err(Refusal::CableOnly));
    bench.memory.asks_for_more = false;
    let crc = plan_file::crc(&plan);
    assert_eq!(bench.ask(0, &Request::CommitUpload { crc }), Ok(Response::Committed { crc }));
}

#[test]
fn the_clock_rests_between_settings() {
    let mut bench = Bench::new(1);
    assert!(bench.ask(0, &Request::SetClock { now: NOW }).is_ok());
    let refused = bench.ask(0, &Request::SetClock { now: NOW });
    assert!(matches!(refused, Err(Refusal::TooManyRequests { .. })), "{refused:?}");
    bench.now_ms += CLOCK_REST_MS;
    assert!(bench.ask(0, &Request::SetClock { now: NOW }).is_ok());
}
