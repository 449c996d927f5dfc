use std::vec::Vec;

use proptest::prelude::*;
use vitrine_exhibit::{
    inputs,
    limits::LONGEST_LEASE,
    units::{Milliseconds, UtcSeconds},
};

use super::controller::{LAMPS_IN_MOTION, MOST, Memory, bytes};
use crate::{
    FINGERPRINT, Link, Reach, Refusal, Request, Server, VERSION,
    frame::{self, Deframer},
    message::{Chunk, Reply, Response},
    plan_file,
    rate::{BURST, REFILL_MS},
    server::UPLOAD_SILENCE_MS,
};

/// A server with its controller and a few links.
pub(super) struct Bench {
    server: Server,
    pub(super) links: Vec<Link>,
    pub(super) memory: Memory,
    pub(super) now_ms: u64,
    sequence: u16,
}

impl Bench {
    /// Links that have greeted.
    pub(super) fn new(links: u8) -> Self {
        Self::reaching(links, Reach::Cable)
    }

    /// Links of one reach that have greeted.
    pub(super) fn reaching(links: u8, reach: Reach) -> Self {
        let mut bench = Self {
            server: Server::new(),
            links: (0..links).map(|number| Link::new(number, reach)).collect(),
            memory: Memory::default(),
            now_ms: 0,
            sequence: 0,
        };
        for link in 0..links.into() {
            let reply = bench.ask(link, &Request::Hello { version: VERSION, fingerprint: FINGERPRINT });
            assert!(matches!(reply, Ok(Response::Hello(_))));
        }
        bench
    }

    /// Sends a request; the time moves on so that the rate is not the subject.
    pub(super) fn ask(&mut self, link: usize, request: &Request) -> Reply {
        self.now_ms += REFILL_MS;
        self.ask_at_once(link, request)
    }

    fn ask_at_once(&mut self, link: usize, request: &Request) -> Reply {
        self.sequence = self.sequence.wrapping_add(1);
        let frame = frame::encode(self.sequence, request).expect("fits");
        let replies = self.send(link, &frame);
        let [(sequence, reply)] = <[_; 1]>::try_from(replies).expect("one answer to one request");
        assert_eq!(sequence, self.sequence);
        reply
    }

    /// Sends any bytes; gives the answers.
    fn send(&mut self, link: usize, bytes: &[u8]) -> Vec<(u16, Reply)> {
        let mut replies = Vec::new();
        for byte in bytes {
            if let Some(incoming) = self.links[link].push(*byte, self.now_ms) {
                let frame = self.server.answer(&incoming, self.now_ms, &mut self.memory);
                let mut deframer = Deframer::new();
                for byte in frame {
                    if let Some(body) = deframer.push(byte) {
                        replies.push(frame::decode(body.expect("whole")).expect("a reply"));
                    }
                }
            }
        }
        replies
    }

    pub(super) fn begin(&mut self, link: usize, plan: &[u8]) -> Reply {
        self.ask(link, &Request::BeginUpload { length: plan.len() as u32, crc: plan_file::crc(plan) })
    }

    pub(super) fn chunk(&mut self, link: usize, plan: &[u8], range: core::ops::Range<usize>) -> Reply {
        let offset = range.start as u32;
        self.ask(
            link,
            &Request::UploadChunk { offset, bytes: Chunk::from_slice(&plan[range]).expect("fits") },
        )
    }

    pub(super) fn commit(&mut self, link: usize, plan: &[u8]) -> Reply {
        self.ask(link, &Request::CommitUpload { crc: plan_file::crc(plan) })
    }

    pub(super) fn upload(&mut self, link: usize, plan: &[u8]) {
        assert_eq!(self.begin(link, plan), received(0));
        for start in (0..plan.len()).step_by(256) {
            let end = plan.len().min(start + 256);
            assert_eq!(self.chunk(link, plan, start..end), received(end));
        }
        assert_eq!(self.commit(link, plan), committed(plan));
    }
}

pub(super) fn received(bytes: usize) -> Reply {
    Ok(Response::Upload { received: bytes as u32 })
}

pub(super) fn committed(plan: &[u8]) -> Reply {
    Ok(Response::Committed { crc: plan_file::crc(plan) })
}

#[test]
fn a_stranger_hears_version_and_fingerprint_until_it_greets() {
    let mut bench = Bench::new(1);
    bench.links[0].reset();
    let refusal = Err(Refusal::Unacquainted { version: VERSION, fingerprint: FINGERPRINT });
    assert_eq!(bench.ask(0, &Request::Status), refusal);
    let hello = bench.ask(0, &Request::Hello { version: VERSION, fingerprint: FINGERPRINT ^ 1 });
    let Ok(Response::Hello(hello)) = hello else { panic!("{hello:?}") };
    assert_eq!((hello.version, hello.fingerprint), (VERSION, FINGERPRINT));
    assert_eq!(bench.ask(0, &Request::Status), refusal);
    bench.ask(0, &Request::Hello { version: VERSION, fingerprint: FINGERPRINT }).expect("greeted");
    assert!(matches!(bench.ask(0, &Request::Status), Ok(Response::Status(_))));
}

#[test]
fn a_request_of_another_version_is_answered_and_changes_nothing() {
    let mut bench = Bench::new(1);
    let frame = frame::encode(77, &(200_u8, 5_u32)).expect("fits");
    assert_eq!(bench.send(0, &frame), [(77, Err(Refusal::UnknownRequest))]);
    assert!(bench.memory.asked.is_empty());
}

#[test]
fn an_upload_becomes_the_plan_and_is_read_back() {
    let mut bench = Bench::new(1);
    let plan = bytes(1_000);
    bench.upload(0, &plan);
    let mut read = Vec::new();
    loop {
        let reply = bench.ask(0, &Request::ReadPlan { offset: read.len() as u32 });
        let Ok(Response::PlanPart { length, bytes, .. }) = reply else { panic!("{reply:?}") };
        assert_eq!(length, 1_000);
        if bytes.is_empty() {
            break;
        }
        read.extend_from_slice(&bytes);
    }
    assert_eq!(read, plan);
}

#[test]
fn every_request_of_an_upload_may_come_twice() {
    let mut bench = Bench::new(1);
    let plan = bytes(600);
    for _ in 0..2 {
        assert_eq!(bench.begin(0, &plan), received(0));
    }
    assert_eq!(bench.memory.begun, 1);
    for range in [0..256, 0..256, 200..300, 256..512, 0..256, 512..600, 512..600] {
        bench.chunk(0, &plan, range).expect("accepted");
    }
    assert_eq!(bench.memory.staged, plan);
    for _ in 0..2 {
        assert_eq!(bench.commit(0, &plan), committed(&plan));
    }
}

#[test]
fn the_old_plan_stays_until_the_commit_verifies() {
    let mut bench = Bench::new(1);
    let old = bytes(300);
    bench.upload(0, &old);
    let new = bytes(500);
    bench.begin(0, &new).expect("begun");
    bench.chunk(0, &new, 0..256).expect("accepted");
    assert_eq!(bench.commit(0, &new), Err(Refusal::Incomplete { received: 256, length: 500 }));
    let mut damaged = new.clone();
    damaged[300] ^= 1;
    bench.chunk(0, &damaged, 256..500).expect("accepted");
    assert!(matches!(bench.commit(0, &new), Err(Refusal::Checksum { .. })));
    assert_eq!(bench.memory.active.as_ref(), Some(&old));
    assert_eq!(bench.commit(0, &new), Err(Refusal::NoUpload), "a failed upload has to begin anew");
    bench.upload(0, &new);
    assert_eq!(bench.memory.active.as_ref(), Some(&new));
}

#[test]
fn chunks_that_cannot_be_right_are_refused() {
    let mut bench = Bench::new(1);
    let plan = bytes(500);
    assert_eq!(bench.chunk(0, &plan, 0..256), Err(Refusal::NoUpload));
    bench.begin(0, &plan).expect("begun");
    assert_eq!(bench.chunk(0, &plan, 100..200), Err(Refusal::Gap { expected: 0 }));
    bench.chunk(0, &plan, 0..256).expect("accepted");
    let past = Request::UploadChunk { offset: 256, bytes: Chunk::from_slice(&[0; 245]).expect("fits") };
    assert_eq!(bench.ask(0, &past), Err(Refusal::PastEnd { length: 500 }));
    for length in [0, MOST + 1] {
        let begin = Request::BeginUpload { length, crc: 0 };
        assert_eq!(bench.ask(0, &begin), Err(Refusal::PlanLength { most: MOST }));
    }
}

#[test]
fn flash_that_is_not_to_be_erased_now_costs_nothing_but_time() {
    let mut bench = Bench::new(1);
    let plan = bytes(300);
    bench.memory.refusal = Some(LAMPS_IN_MOTION);
    assert_eq!(bench.begin(0, &plan), Err(LAMPS_IN_MOTION));
    assert_eq!(bench.begin(0, &plan), received(0));
    bench.memory.refusal = Some(LAMPS_IN_MOTION);
    assert_eq!(bench.chunk(0, &plan, 0..256), Err(LAMPS_IN_MOTION));
    assert_eq!(bench.chunk(0, &plan, 0..256), received(256));
    assert_eq!(bench.chunk(0, &plan, 256..300), received(300));
    bench.memory.refusal = Some(LAMPS_IN_MOTION);
    assert_eq!(bench.commit(0, &plan), Err(LAMPS_IN_MOTION));
    assert_eq!(bench.commit(0, &plan), committed(&plan));
}

#[test]
fn flash_that_fails_ends_the_upload() {
    let mut bench = Bench::new(1);
    let plan = bytes(300);
    bench.begin(0, &plan).expect("begun");
    bench.memory.refusal = Some(Refusal::StorageFailed);
    assert_eq!(bench.chunk(0, &plan, 0..256), Err(Refusal::StorageFailed));
    assert_eq!(bench.chunk(0, &plan, 0..256), Err(Refusal::NoUpload));
    bench.upload(0, &plan);
}

#[test]
fn a_second_host_waits_for_silence_and_goes_on_where_the_first_stopped() {
    let mut bench = Bench::new(2);
    let plan = bytes(600);
    bench.begin(0, &plan).expect("begun");
    bench.chunk(0, &plan, 0..256).expect("accepted");
    assert!(matches!(bench.begin(1, &plan), Err(Refusal::OtherUpload { .. })));
    assert_eq!(bench.chunk(1, &plan, 256..512), Err(Refusal::NoUpload));
    bench.now_ms += UPLOAD_SILENCE_MS;
    assert_eq!(bench.begin(1, &plan), received(256));
    assert_eq!(bench.chunk(0, &plan, 256..512), Err(Refusal::NoUpload));
    bench.chunk(1, &plan, 256..512).expect("accepted");
    bench.chunk(1, &plan, 512..600).expect("accepted");
    assert_eq!(bench.commit(1, &plan), committed(&plan));
    assert_eq!(bench.memory.begun, 1);
}

#[test]
fn a_host_that_has_gone_leaves_its_upload_to_the_next() {
    let mut bench = Bench::new(3);
    let plan = bytes(600);
    bench.begin(0, &plan).expect("begun");
    bench.chunk(0, &plan, 0..256).expect("accepted");
    bench.server.link_closed(2);
    assert!(matches!(bench.begin(1, &plan), Err(Refusal::OtherUpload { .. })));
    bench.server.link_closed(0);
    assert_eq!(bench.begin(1, &plan), received(256));
    assert!(matches!(bench.begin(2, &plan), Err(Refusal::OtherUpload { .. })));
}

#[test]
fn leases_are_neither_zero_nor_endless() {
    let mut bench = Bench::new(1);
    let refused = Err(Refusal::Lease { most: LONGEST_LEASE });
    for lease in [0, LONGEST_LEASE.0 + 1, u32::MAX].map(Milliseconds) {
        assert_eq!(bench.ask(0, &Request::Exhibit(inputs::Request::Hold { view: 0, lease })), refused);
        assert_eq!(bench.ask(0, &Request::Exhibit(inputs::Request::Dark { lease })), refused);
        assert_eq!(bench.ask(0, &Request::Exhibit(inputs::Request::Open { lease })), refused);
    }
    assert!(bench.memory.asked.is_empty());
    let dark = inputs::Request::Dark { lease: LONGEST_LEASE };
    for request in [dark, inputs::Request::Release, inputs::Request::Rearm] {
        assert_eq!(bench.ask(0, &Request::Exhibit(request)), Ok(Response::Done));
    }
    assert_eq!(bench.memory.asked, [dark, inputs::Request::Release, inputs::Request::Rearm]);
}

#[test]
fn only_plausible_times_are_set() {
    let mut bench = Bench::new(1);
    for now in [0, i64::MIN, i64::MAX, 1_704_067_199, 4_102_444_800].map(UtcSeconds) {
        assert_eq!(bench.ask(0, &Request::SetClock { now }), Err(Refusal::ImplausibleTime));
    }
    let now = UtcSeconds(1_795_379_862);
    let reply = bench.ask(0, &Request::SetClock { now });
    assert!(matches!(reply, Ok(Response::Clock(clock)) if clock.now == Some(now)));
}

#[test]
fn a_flood_of_requests_is_told_when_to_come_again() {
    let mut bench = Bench::new(2);
    bench.now_ms += 1_000;
    let answers: Vec<_> = (0..3 * BURST).map(|_| bench.ask_at_once(0, &Request::Status)).collect();
    let served = answers.iter().filter(|reply| reply.is_ok()).count();
    assert_eq!(served, BURST as usize);
    assert_eq!(bench.links[0].faults().too_many, 2 * BURST);
    assert!(bench.ask_at_once(1, &Request::Status).is_ok(), "other links are not held up");
    let Err(Refusal::TooManyRequests { retry }) = bench.ask_at_once(0, &Request::Status) else { panic!() };
    bench.now_ms += u64::from(retry.0);
    assert!(bench.ask_at_once(0, &Request::Status).is_ok());
}

#[test]
fn damage_is_counted_and_not_answered() {
    let mut bench = Bench::new(1);
    let mut noise = std::vec![0x33; 1_000];
    noise.push(0);
    noise.extend_from_slice(&[1, 2, 3, 4, 0, 9, 9, 0]);
    assert_eq!(bench.send(0, &noise), []);
    let faults = bench.links[0].faults();
    assert_eq!((faults.too_long, faults.damaged), (1, 2));
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic_or_change_the_plan(
        stream in prop::collection::vec(any::<u8>(), 0..3_000),
        messages in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 0..20),
    ) {
        let mut bench = Bench::new(1);
        let plan = bytes(300);
        bench.upload(0, &plan);
        bench.send(0, &stream);
        bench.send(0, &[0]);
        for message in messages {
            // Well framed, but any message within.
            let mut body = message;
            body.extend_from_slice(&plan_file::crc(&body).to_le_bytes());
            let mut frame = cobs_of(&body);
            frame.push(0);
            bench.now_ms += REFILL_MS;
            bench.send(0, &frame);
        }
        prop_assert_eq!(bench.memory.active.as_ref(), Some(&plan));
        let hello = Request::Hello { version: VERSION, fingerprint: FINGERPRINT };
        prop_assert!(bench.ask(0, &hello).is_ok());
    }

    #[test]
    fn chunks_in_any_order_and_number_end_in_the_plan_or_in_a_refusal(
        pieces in prop::collection::vec((0_usize..600, 1_usize..256), 0..60),
    ) {
        let mut bench = Bench::new(1);
        let plan = bytes(600);
        bench.begin(0, &plan).expect("begun");
        let mut have = 0;
        for (start, length) in pieces {
            let range = start..(start + length).min(600);
            let end = range.end;
            match bench.chunk(0, &plan, range) {
                Ok(Response::Upload { received }) => {
                    prop_assert!(start <= have);
                    have = have.max(end);
                    prop_assert_eq!(received as usize, have);
                }
                Err(Refusal::Gap { expected }) => {
                    prop_assert!(start > have);
                    prop_assert_eq!(expected as usize, have);
                }
                other => prop_assert!(false, "{:?}", other),
            }
        }
        prop_assert_eq!(&bench.memory.staged[..], &plan[..have]);
        prop_assert_eq!(bench.commit(0, &plan).is_ok(), have == 600);
    }
}

pub(super) fn cobs_of(body: &[u8]) -> Vec<u8> {
    let mut frame = std::vec![0; body.len() + body.len() / 254 + 2];
    let used = cobs::try_encode(body, &mut frame).expect("large enough");
    frame.truncate(used);
    frame
}
