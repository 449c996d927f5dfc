//! Malformed frames by the thousand: random bytes, frames with a few bits wrong, frames that are whole but make no sense.
//!
//! `VITRINE_FRAMES` says how many, `VITRINE_FRAMES_FROM` with which to begin: a frame is made of its number alone, so that
//! a long run can be taken up where it ended.

use serde_json::json;
use vitrine_exhibit::inputs;
use vitrine_exhibit::units::{Milliseconds, UtcSeconds};
use vitrine_protocol::message::Chunk;
use vitrine_protocol::{FINGERPRINT, Reply, Request, Response, VERSION, frame};

use crate::bench::{Bench, LAMP_PINS, MILLISECOND, number_of};

/// Frames sent before the board is asked how it is.
const ROUND: u64 = 500;

/// SplitMix64, as good as random and the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }

    fn bytes(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.next() as u8).collect()
    }
}

/// The frame of a number, with its end.
fn malformed(number: u64) -> Vec<u8> {
    let mut random = Random(number);
    let mut bytes = match number % 4 {
        0 => {
            let length = random.below(120);
            random.bytes(length)
        }
        1 => {
            // Whole by its checksum: the body is what is wrong.
            let length = random.below(60);
            let body: Chunk = random.bytes(length).into_iter().collect();
            frame::encode(number as u16, &body).expect("it fits").to_vec()
        }
        _ => {
            let mut whole = request(&mut random, number as u16);
            if number % 8 == 3 {
                whole.truncate(random.below(whole.len()));
            } else {
                for _ in 0..=random.below(3) {
                    let place = random.below(whole.len());
                    whole[place] ^= 1 << random.below(8);
                }
            }
            whole
        }
    };
    bytes.push(0);
    bytes
}

fn request(random: &mut Random, sequence: u16) -> Vec<u8> {
    let length = random.below(100);
    let request = match random.below(8) {
        0 => Request::Hello { version: VERSION, fingerprint: FINGERPRINT },
        1 => Request::Status,
        2 => Request::SetClock { now: UtcSeconds(random.next() as i64) },
        3 => Request::BeginUpload { length: random.next() as u32, crc: 0 },
        4 => Request::UploadChunk {
            offset: random.next() as u32,
            bytes: random.bytes(length).into_iter().collect(),
        },
        5 => Request::Exhibit(inputs::Request::Open { lease: Milliseconds(random.next() as u32) }),
        6 => {
            Request::Exhibit(inputs::Request::Hold { view: random.next() as u8, lease: Milliseconds(60_000) })
        }
        _ => Request::ReadLog { from: random.next() as u32 },
    };
    frame::encode(sequence, &request).expect("it fits").to_vec()
}

/// Asks the board who it is, over the noise of what it still answers.
fn greets(bench: &mut Bench) -> bool {
    let hello = Request::Hello { version: VERSION, fingerprint: FINGERPRINT };
    (0..20).any(|_| {
        // The rate limit lets one through again soon.
        bench.run(100 * MILLISECOND);
        let mut sent = vec![0];
        sent.extend(frame::encode(0xbeef, &hello).expect("it fits"));
        let mut answers = bench.usb(&sent);
        bench.run(20 * MILLISECOND);
        answers.extend(bench.usb(&[0]));
        let mut deframer = frame::Deframer::new();
        answers.into_iter().any(|byte| {
            let reply = deframer.push(byte).and_then(Result::ok).and_then(frame::decode::<Reply>);
            matches!(reply, Some((0xbeef, Ok(Response::Hello(_)))))
        })
    })
}

#[test]
fn malformed_frames_neither_reset_nor_light_nor_silence_the_board() {
    let (count, from) = (number_of("VITRINE_FRAMES", 4_000), number_of("VITRINE_FRAMES_FROM", 0));
    let began = std::time::Instant::now();
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(100 * MILLISECOND);
    bench.call(json!({"op": "usb_terminal", "ready": true}));
    assert!(greets(&mut bench), "no answer at the beginning");
    bench.edges();
    let mut at = from;
    while at < from + count {
        let end = (at + ROUND).min(from + count);
        let bytes: Vec<u8> = (at..end).flat_map(malformed).collect();
        bench.usb(&bytes);
        let lit = bench.edges().into_iter().find(|edge| edge.high && LAMP_PINS.contains(&edge.pin));
        assert!(lit.is_none(), "{lit:?} among frames {at} to {end}");
        assert_eq!(bench.take_resets(), 0, "a reset among frames {at} to {end}");
        bench.log();
        at = end;
        if (at - from).is_multiple_of(20 * ROUND) {
            assert!(greets(&mut bench), "no answer after frame {at}");
            println!("{at} frames; {:.0} a second", (at - from) as f64 / began.elapsed().as_secs_f64());
        }
    }
    assert!(greets(&mut bench), "no answer at the end");
    println!(
        "frames {from} to {at}: no reset, no light, the link alive; {:.0} a second",
        count as f64 / began.elapsed().as_secs_f64()
    );
}
