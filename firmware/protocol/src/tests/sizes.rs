//! The largest messages fit a frame.

use vitrine_exhibit::inputs;

use super::samples::{every_variant, firmware, largest_log_page, largest_settings, largest_status};
use crate::{
    MAX_FRAME, Refusal, Request,
    frame::encode,
    message::{Chunk, Reply, Response},
};

fn chunk() -> Chunk {
    let mut chunk = Chunk::new();
    chunk.resize(chunk.capacity(), 0xff).expect("its own capacity");
    chunk
}

#[test]
fn the_largest_requests_fit() {
    for request in [
        Request::UploadChunk { offset: u32::MAX, bytes: chunk() },
        Request::ChangeSettings(largest_settings()),
        Request::Hello { version: u16::MAX, fingerprint: u32::MAX },
    ] {
        encode(u16::MAX, &request).expect("fits");
    }
    for request in every_variant::<inputs::Request>() {
        encode(u16::MAX, &Request::Exhibit(request)).expect("fits");
    }
}

#[test]
fn the_largest_responses_fit() {
    for response in [
        Response::Status(largest_status()),
        Response::PlanPart { length: u32::MAX, offset: u32::MAX, bytes: chunk() },
        Response::Log(largest_log_page()),
        Response::Settings(largest_settings()),
        Response::Firmware(firmware()),
    ] {
        let frame = encode(u16::MAX, &Reply::Ok(response)).expect("fits");
        assert!(frame.len() <= MAX_FRAME);
    }
    for refusal in every_variant::<Refusal>() {
        encode(u16::MAX, &Reply::Err(refusal)).expect("fits");
    }
}
