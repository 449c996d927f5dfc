//! Frames: COBS( postcard(envelope) + CRC-32 ) ended by 0x00, and the deframer that finds them in any stream.

use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;
use serde::{Serialize, de::DeserializeOwned};

/// The checksum of frames and of whatever is uploaded.
pub const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The most bytes of a body, its CRC included.
pub const MAX_BODY: usize = 400;

/// The most bytes of a frame, its final 0x00 included: COBS adds one byte, and one more for every 254.
pub const MAX_FRAME: usize = MAX_BODY + 1 + MAX_BODY / 254 + 1;

const CRC_BYTES: usize = 4;

/// Why the bytes between two 0x00 are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// More bytes than any frame has.
    TooLong,
    /// The COBS code is broken.
    Stuffing,
    /// The CRC does not fit: damaged or torn on the way.
    Checksum,
}

/// Why a message could not be put into a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge;

/// A frame ready to be sent, its final 0x00 included.
pub type Frame = Vec<u8, MAX_FRAME>;

/// Puts a message with its sequence number into a frame.
pub fn encode<M: Serialize>(sequence: u16, message: &M) -> Result<Frame, TooLarge> {
    let mut body = [0; MAX_BODY];
    let used =
        postcard::to_slice_crc32(&(sequence, message), &mut body, CRC.digest()).map_err(|_| TooLarge)?.len();
    let body = body.get(..used).ok_or(TooLarge)?;
    let mut frame = Frame::new();
    frame.resize_default(MAX_FRAME).map_err(|_| TooLarge)?;
    let stuffed = cobs::try_encode(body, &mut frame).map_err(|_| TooLarge)?;
    frame.truncate(stuffed);
    frame.push(0).map_err(|_| TooLarge)?;
    Ok(frame)
}

/// Reads a body that [`Deframer::push`] found. `None` if it is no such message, or has bytes left over.
pub fn decode<M: DeserializeOwned>(body: &[u8]) -> Option<(u16, M)> {
    let (envelope, rest) = postcard::take_from_bytes(body).ok()?;
    rest.is_empty().then_some(envelope)
}

/// Reads only the sequence number of a body, to answer a message of another version.
pub fn decode_sequence(body: &[u8]) -> Option<u16> {
    postcard::take_from_bytes(body).ok().map(|(sequence, _)| sequence)
}

/// Finds frames in a stream of bytes. Whatever came before, the first whole frame after a 0x00 is found.
#[derive(Debug, Default)]
pub struct Deframer {
    bytes: Vec<u8, MAX_FRAME>,
    state: State,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Collecting,
    /// The last push ended a frame; its body is still in the buffer.
    Delivered,
    /// More bytes came than fit: all is dropped up to the next 0x00.
    Overflowed,
}

impl Deframer {
    /// Nothing received.
    pub const fn new() -> Self {
        Self { bytes: Vec::new(), state: State::Collecting }
    }

    /// Takes the next byte. At the end of a frame it gives the body without its CRC, or says why there is none.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if self.state == State::Delivered {
            self.reset();
        }
        if byte != 0 {
            if self.bytes.push(byte).is_err() {
                self.state = State::Overflowed;
            }
            return None;
        }
        if self.state == State::Overflowed {
            self.reset();
            return Some(Err(FrameError::TooLong));
        }
        if self.bytes.is_empty() {
            return None;
        }
        self.state = State::Delivered;
        Some(unstuff_and_verify(&mut self.bytes))
    }

    /// Forgets a frame begun.
    pub fn reset(&mut self) {
        self.bytes.clear();
        self.state = State::Collecting;
    }
}

fn unstuff_and_verify(bytes: &mut [u8]) -> Result<&[u8], FrameError> {
    let length = cobs::decode_in_place(bytes).map_err(|_| FrameError::Stuffing)?;
    let (message, checksum) = bytes
        .get(..length)
        .and_then(|body| body.split_last_chunk::<CRC_BYTES>())
        .ok_or(FrameError::Checksum)?;
    if CRC.checksum(message) == u32::from_le_bytes(*checksum) {
        Ok(message)
    } else {
        Err(FrameError::Checksum)
    }
}
