use std::{vec, vec::Vec};

use proptest::prelude::*;

use crate::{
    FrameError, MAX_FRAME, Request,
    frame::{self, Deframer},
    message::Chunk,
};

/// All that a deframer says of a stream.
fn all_of(stream: &[u8]) -> Vec<Result<Vec<u8>, FrameError>> {
    let mut deframer = Deframer::new();
    stream.iter().filter_map(|byte| deframer.push(*byte).map(|found| found.map(<[u8]>::to_vec))).collect()
}

fn requests_in(stream: &[u8]) -> Vec<(u16, Request)> {
    all_of(stream).into_iter().flatten().filter_map(|body| frame::decode(&body)).collect()
}

fn sample(offset: u32, length: usize) -> Request {
    let mut bytes = Chunk::new();
    bytes.extend((0..length).map(|i| (i * 37) as u8));
    Request::UploadChunk { offset, bytes }
}

#[test]
fn a_message_survives_its_frame() {
    for length in [0, 1, 100, 250, 251, 252, 253, 254, 255, 256] {
        let request = sample(7, length);
        let frame = frame::encode(300, &request).expect("fits");
        assert_eq!(requests_in(&frame), [(300, request)]);
        assert_eq!(frame.iter().filter(|byte| **byte == 0).count(), 1);
    }
}

#[test]
fn empty_frames_are_ignored() {
    assert_eq!(all_of(&[0, 0, 0]), []);
}

#[test]
fn a_half_frame_costs_itself_and_what_is_joined_to_it() {
    let whole = frame::encode(1, &Request::Status).expect("fits");
    for kept in 1..whole.len() - 1 {
        let mut stream = whole[..kept].to_vec();
        stream.extend_from_slice(&whole);
        stream.extend_from_slice(&whole);
        assert_eq!(requests_in(&stream), [(1, Request::Status)], "after {kept} bytes");
        let mut ended = whole[..kept].to_vec();
        ended.push(0);
        ended.extend_from_slice(&whole);
        assert_eq!(requests_in(&ended), [(1, Request::Status)], "after {kept} bytes and an end");
    }
}

#[test]
fn a_flood_without_an_end_is_dropped_and_the_next_frame_is_found() {
    let whole = frame::encode(1, &Request::Status).expect("fits");
    for length in [MAX_FRAME - 1, MAX_FRAME, MAX_FRAME + 1, 100_000] {
        let mut stream = vec![0x55; length];
        stream.push(0);
        stream.extend_from_slice(&whole);
        let found = all_of(&stream);
        assert_eq!(found.len(), 2, "{length} bytes");
        let expected = if length > MAX_FRAME { FrameError::TooLong } else { FrameError::Stuffing };
        assert!(found[0] == Err(expected) || found[0] == Err(FrameError::Checksum), "{length}: {found:?}");
        assert!(found[1].is_ok());
    }
}

#[test]
fn every_flipped_bit_is_noticed() {
    let whole = frame::encode(1, &sample(99, 40)).expect("fits");
    for byte in 0..whole.len() {
        for bit in 0..8 {
            let mut damaged = whole.clone();
            damaged[byte] ^= 1 << bit;
            damaged.push(0).expect("room");
            assert_eq!(requests_in(&damaged), [], "bit {bit} of byte {byte}");
        }
    }
}

#[test]
fn bytes_left_over_behind_a_message_are_no_message() {
    let mut body = [0; 64];
    let length = postcard::to_slice(&(5_u16, Request::Status, 1_u8), &mut body).expect("fits").len();
    assert_eq!(frame::decode::<Request>(&body[..length]), None);
    assert_eq!(frame::decode_sequence(&body[..length]), Some(5));
}

proptest! {
    #[test]
    fn no_stream_makes_it_panic_or_lose_a_later_frame(
        noise in prop::collection::vec(any::<u8>(), 0..2_000),
        sequence in any::<u16>(),
        length in 0_usize..=256,
    ) {
        let request = sample(3, length);
        let mut stream = noise;
        stream.push(0);
        stream.extend_from_slice(&frame::encode(sequence, &request).expect("fits"));
        let last = requests_in(&stream).pop();
        prop_assert_eq!(last, Some((sequence, request)));
    }

    #[test]
    fn frames_between_noise_are_all_found(
        pieces in prop::collection::vec((prop::collection::vec(1_u8.., 0..40), 0_usize..100), 1..20),
    ) {
        let mut stream = Vec::new();
        let mut expected = Vec::new();
        for (number, (noise, length)) in pieces.iter().enumerate() {
            stream.extend_from_slice(noise);
            stream.push(0);
            let request = sample(number as u32, *length);
            stream.extend_from_slice(&frame::encode(number as u16, &request).expect("fits"));
            expected.push((number as u16, request));
        }
        let found: Vec<_> = requests_in(&stream);
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn a_frame_cut_anywhere_gives_nothing_or_itself(length in 0_usize..=256, cut in any::<prop::sample::Index>()) {
        let request = sample(0, length);
        let whole = frame::encode(9, &request).expect("fits");
        let mut part = whole[..cut.index(whole.len())].to_vec();
        part.push(0);
        for found in requests_in(&part) {
            prop_assert_eq!(found, (9, request.clone()));
        }
    }
}
