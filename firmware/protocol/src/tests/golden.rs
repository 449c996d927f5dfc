//! The bytes of every message. Other versions depend on them: when this test fails, a message has changed, and so
//! will the fingerprint. If that is meant, raise [`crate::VERSION`] where the meaning changed, and write the file
//! anew with `VITRINE_BLESS=1 cargo test -p vitrine-protocol golden`.

use std::{format, fs, path::Path, string::String, vec, vec::Vec};

use serde::Serialize;
use vitrine_exhibit::{
    Presence,
    events::{Cut, DarkReason, Event, ProgramEnd},
    inputs,
    interlock::InterlockState,
    plan::PlanError,
    settings::SettingsError,
    units::UtcSeconds,
};

use super::samples::{self, every_variant};
use crate::{
    Refusal, Request,
    firmware::{ImageFault, Outcome, Progress},
    frame::{self, Deframer},
    message::{Chunk, LogEntry, LogPage, Reply, Response},
    plan_file::{self, MAX_PLAN_BYTES},
    status::{ClockSource, ClockState},
};

fn messages() -> String {
    let mut lines = Vec::new();
    for request in every_variant::<Request>().into_iter().chain(requests()) {
        line(&mut lines, "request", &request);
    }
    for response in responses() {
        line(&mut lines, "reply", &Reply::Ok(response));
    }
    for refusal in every_variant::<Refusal>() {
        line(&mut lines, "reply", &Reply::Err(refusal));
    }
    every_variant::<inputs::Request>().iter().for_each(|value| line(&mut lines, "exhibit request", value));
    every_variant::<DarkReason>().iter().for_each(|value| line(&mut lines, "dark", value));
    every_variant::<Cut>().iter().for_each(|value| line(&mut lines, "cut", value));
    every_variant::<Event>().iter().for_each(|value| line(&mut lines, "event", value));
    every_variant::<Presence>().iter().for_each(|value| line(&mut lines, "presence", value));
    every_variant::<InterlockState>().iter().for_each(|value| line(&mut lines, "interlock", value));
    every_variant::<ClockSource>().iter().for_each(|value| line(&mut lines, "clock source", value));
    every_variant::<ProgramEnd>().iter().for_each(|value| line(&mut lines, "program end", value));
    every_variant::<SettingsError>().iter().for_each(|value| line(&mut lines, "settings error", value));
    every_variant::<Progress>().iter().for_each(|value| line(&mut lines, "progress", value));
    every_variant::<Outcome>().iter().for_each(|value| line(&mut lines, "outcome", value));
    every_variant::<ImageFault>().iter().for_each(|value| line(&mut lines, "image fault", value));
    every_variant::<PlanError>().iter().for_each(|value| line(&mut lines, "plan error", value));
    let plan = super::plan_file::small();
    let mut buffer = [0; MAX_PLAN_BYTES];
    let bytes = plan_file::encode(&plan, &mut buffer).expect("fits");
    line_of(&mut lines, "plan", &plan, bytes);
    lines.concat()
}

fn line<T: Serialize>(lines: &mut Vec<String>, kind: &str, value: &T) {
    let mut buffer = [0; 512];
    let bytes = postcard::to_slice(value, &mut buffer).expect("fits");
    line_of(lines, kind, value, bytes);
}

fn line_of<T: Serialize>(lines: &mut Vec<String>, kind: &str, value: &T, bytes: &[u8]) {
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    let words = serde_json::to_string(value).expect("plain data");
    lines.push(format!("{kind} {words}\n    {hex}\n"));
}

fn requests() -> Vec<Request> {
    vec![
        Request::Hello { version: 1, fingerprint: 0x1234_5678 },
        Request::SetClock { now: UtcSeconds(1_795_379_862) },
        Request::BeginUpload { length: 401, crc: 0xcafe_f00d },
        Request::UploadChunk { offset: 256, bytes: Chunk::from_slice(&[0, 1, 0xff]).expect("short") },
        Request::CommitUpload { crc: 0xcafe_f00d },
        Request::ReadPlan { offset: 512 },
        Request::ReadLog { from: 1_000 },
        Request::ChangeSettings(samples::settings()),
        Request::Confirm { code: 0xfeed_0123 },
        Request::BeginUpdate { length: 150_256, crc: 0xcafe_f00d },
    ]
}

fn responses() -> Vec<Response> {
    let mut page = LogPage { oldest: 17, next: 20, ..LogPage::default() };
    page.entries
        .push(LogEntry {
            sequence: 18,
            time: Some(UtcSeconds(1_795_379_862)),
            uptime_s: 3_600,
            event: Event::ViewChosen(2),
        })
        .expect("room for one");
    vec![
        Response::Hello(samples::hello()),
        Response::Status(samples::status()),
        Response::Clock(samples::clock()),
        Response::Clock(ClockState::default()),
        Response::Upload { received: 256 },
        Response::Committed { crc: 0xcafe_f00d },
        Response::PlanPart { length: 401, offset: 256, bytes: Chunk::from_slice(&[7, 0]).expect("short") },
        Response::Done,
        Response::Log(page),
        Response::Settings(samples::settings()),
        Response::Confirm { code: 0xfeed_0123 },
        Response::Live { next: 700, bytes: Chunk::from_slice(&[7, 0]).expect("short") },
        Response::Firmware(samples::firmware()),
    ]
}

#[test]
fn messages_keep_their_bytes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/messages.txt");
    let messages = messages();
    if std::env::var_os("VITRINE_BLESS").is_some() {
        fs::write(&path, &messages).expect("golden file written");
    }
    let golden = fs::read_to_string(&path).expect("golden file read");
    for (now, then) in messages.lines().zip(golden.lines()) {
        assert_eq!(now, then, "a message has changed");
    }
    assert_eq!(messages.lines().count(), golden.lines().count(), "a message has come or gone");
}

#[test]
fn every_response_is_among_the_golden_ones() {
    let golden: Vec<_> = responses().iter().map(core::mem::discriminant).collect();
    for response in every_variant::<Response>() {
        assert!(golden.contains(&core::mem::discriminant(&response)), "{response:?} has no sample");
    }
}

/// The greeting is frozen in all versions: these bytes may never change.
#[test]
fn the_greeting_is_frozen() {
    let request = Request::Hello { version: 1, fingerprint: 0x1234_5678 };
    let frame = frame::encode(0x0102, &request).expect("fits");
    let expected = b"\x03\x82\x02\x0b\x01\xf8\xac\xd1\x91\x01\x54\x81\x3c\xcb\x00";
    assert_eq!(frame[..], expected[..]);
    let reply = Reply::Ok(Response::Hello(samples::hello()));
    let frame = frame::encode(0x0102, &reply).expect("fits");
    let mut deframer = Deframer::new();
    let mut body = None;
    for byte in frame {
        if let Some(found) = deframer.push(byte) {
            body = Some(found.expect("whole").to_vec());
        }
    }
    let expected =
        b"\x82\x02\x00\x00\x01\xf8\xac\xd1\x91\x01\x10E660C0D1C7591B28\x050.1.0\x11Three photographs";
    assert_eq!(body.as_deref(), Some(&expected[..]));
}

/// The messages of an update are frozen in all versions: these bytes may never change, or a host could not update an older
/// controller.
#[test]
fn an_update_is_frozen() {
    let bytes = |message: &dyn Fn(&mut [u8]) -> usize| {
        let mut buffer = [0; 512];
        let used = message(&mut buffer);
        buffer[..used].to_vec()
    };
    let request =
        |request: Request| bytes(&|buffer| postcard::to_slice(&request, buffer).expect("fits").len());
    let reply = |reply: Reply| bytes(&|buffer| postcard::to_slice(&reply, buffer).expect("fits").len());
    let part = Chunk::from_slice(&[1, 2]).expect("short");
    assert_eq!(request(Request::BeginUpdate { length: 300, crc: 7 }), FROZEN_BEGIN);
    assert_eq!(request(Request::UploadChunk { offset: 256, bytes: part }), [5, 0x80, 2, 2, 1, 2]);
    assert_eq!(request(Request::CommitUpload { crc: 7 }), [6, 7]);
    assert_eq!(request(Request::Firmware), FROZEN_FIRMWARE);
    assert_eq!(request(Request::Restart), FROZEN_RESTART);
    assert_eq!(reply(Ok(Response::Upload { received: 300 })), [0, 3, 0xac, 2]);
    assert_eq!(reply(Ok(Response::Committed { crc: 7 })), [0, 4, 7]);
    assert_eq!(reply(Ok(Response::Done)), [0, 6]);
    let state = reply(Ok(Response::Firmware(samples::firmware())));
    assert_eq!(state[..8], *b"\0\x0b\x050.2.0");
    assert_eq!(state[8..40], core::array::from_fn::<u8, 32, _>(|i| i as u8));
    assert_eq!(state[40..], [0, 1]);
}

const FROZEN_FIRMWARE: [u8; 1] = [14];
const FROZEN_BEGIN: [u8; 4] = [15, 0xac, 2, 7];
const FROZEN_RESTART: [u8; 1] = [16];
