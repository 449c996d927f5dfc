//! A million malformed frames: none makes the server panic, answer what was not asked, or touch the plan.

use std::{println, vec::Vec};

use vitrine_exhibit::{inputs, units::Milliseconds};

use super::{
    controller::{Memory, bytes},
    server::cobs_of,
};
use crate::{
    FINGERPRINT, Link, Reach, Request, Server, VERSION,
    frame::{self, Deframer, MAX_BODY, MAX_FRAME},
    message::{Chunk, Reply, Response},
    plan_file,
};

const FRAMES: u32 = if cfg!(miri) { 200 } else { 1_000_000 };

/// Numbers that look random and are the same in every run (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }

    fn fill(&mut self, frame: &mut Vec<u8>, length: usize) {
        frame.extend((0..length).map(|_| self.next() as u8));
    }
}

/// Whole frames of well-formed requests, to be damaged.
fn whole() -> Vec<Vec<u8>> {
    let plan = bytes(600);
    let lease = Milliseconds(1_000);
    let requests = [
        Request::Hello { version: VERSION, fingerprint: FINGERPRINT },
        Request::Status,
        Request::SetClock { now: vitrine_exhibit::units::UtcSeconds(1_795_379_862) },
        Request::BeginUpload { length: 600, crc: plan_file::crc(&plan) },
        Request::UploadChunk { offset: 0, bytes: Chunk::from_slice(&plan[..256]).expect("fits") },
        Request::CommitUpload { crc: plan_file::crc(&plan) },
        Request::Exhibit(inputs::Request::Dark { lease }),
        Request::ReadLog { from: 70_000 },
    ];
    (1..)
        .zip(&requests)
        .map(|(number, request)| frame::encode(number, request).expect("fits").to_vec())
        .collect()
}

/// A frame that is wrong in one of the ways in which frames go wrong.
fn malformed(whole: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut frame = whole[random.below(whole.len())].clone();
    match random.below(8) {
        0 => {
            let place = random.below(frame.len() - 1);
            frame[place] ^= 1 << random.below(8);
        }
        1 => frame.truncate(random.below(frame.len() - 1)),
        2 => {
            let place = random.below(frame.len() - 1);
            frame.remove(place);
        }
        3 => {
            let place = random.below(frame.len());
            frame.insert(place, random.next() as u8);
        }
        4 => {
            frame.clear();
            let length = random.below(60);
            random.fill(&mut frame, length);
        }
        5 => {
            // The CRC fits, the message is noise.
            let mut body = Vec::new();
            let length = random.below(40);
            random.fill(&mut body, length);
            body.extend_from_slice(&plan_file::crc(&body).to_le_bytes());
            frame = cobs_of(&body);
        }
        6 => {
            frame.pop();
            frame.extend_from_slice(&whole[random.below(whole.len())]);
        }
        _ if random.below(16) == 0 => {
            let length = MAX_FRAME + random.below(MAX_BODY);
            frame.clear();
            random.fill(&mut frame, length);
        }
        _ => frame.swap(0, 1),
    }
    frame.push(0);
    frame
}

#[test]
fn a_million_malformed_frames_do_no_harm() {
    let mut random = Random(5);
    let (mut server, mut memory) = (Server::new(), Memory::default());
    let plan = bytes(300);
    memory.active = Some(plan.clone());
    let mut link = Link::new(0, Reach::Cable);
    let whole = whole();
    let (mut now_ms, mut answers) = (0_u64, 0_u32);
    for number in 0..FRAMES {
        for byte in malformed(&whole, &mut random) {
            if let Some(incoming) = link.push(byte, now_ms) {
                let answer = server.answer(&incoming, now_ms, &mut memory);
                assert!(answer.len() <= MAX_FRAME && answer.last() == Some(&0));
                answers += 1;
            }
        }
        // 20 frames a millisecond: a flood.
        now_ms += u64::from(number % 20 == 0);
        if number % 10_000 == 0 {
            now_ms += 1_000;
            greet(&mut server, &mut link, &mut memory, now_ms);
        }
    }
    println!("{FRAMES} malformed frames, {answers} answered, {:?}", link.faults());
    assert_eq!(memory.active, Some(plan));
    assert!(link.faults().damaged > FRAMES / 2);
    assert!(answers < FRAMES / 4, "what is damaged is not answered");
}

/// A whole greeting is answered, whatever came before.
fn greet(server: &mut Server, link: &mut Link, memory: &mut Memory, now_ms: u64) {
    let hello = Request::Hello { version: VERSION, fingerprint: FINGERPRINT };
    let mut replies = Vec::new();
    for byte in frame::encode(9, &hello).expect("fits") {
        if let Some(incoming) = link.push(byte, now_ms) {
            let mut deframer = Deframer::new();
            for byte in server.answer(&incoming, now_ms, memory) {
                if let Some(body) = deframer.push(byte) {
                    replies.push(frame::decode::<Reply>(body.expect("whole")));
                }
            }
        }
    }
    assert!(matches!(replies[..], [Some((9, Ok(Response::Hello(_))))]), "{replies:?}");
}
