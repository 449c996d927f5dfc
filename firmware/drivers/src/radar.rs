//! HLK-LD2450, the radar that can stand in for the thermal pair, over a serial port at 256,000 baud, 8N1.
//!
//! It sends a report of 30 bytes ten times a second, unasked: AA FF 03 00, three targets of 8 bytes, 55 CC (serial
//! protocol V1.03). Whatever else comes, noise or a report cut short, is skipped byte by byte until one is whole again.

use embedded_io_async::Read;
use vitrine_exhibit::viewer::{REPORT_BYTES, RadarFrame, parse_report};

/// The port's speed.
pub const BAUD: u32 = 256_000;

/// Bytes read from the port at once.
const CHUNK_BYTES: usize = 32;

/// Why there is no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RadarError<E> {
    /// The port failed: a break, noise, bytes that were not taken in time.
    Port(E),
    /// The port has ended.
    Ended,
}

/// Finds reports in what the radar sends.
#[derive(Clone, Debug, Default)]
pub struct Radar {
    window: [u8; REPORT_BYTES],
    chunk: [u8; CHUNK_BYTES],
    from: usize,
    to: usize,
}

impl Radar {
    /// A radar that has sent nothing yet.
    pub const fn new() -> Self {
        Self { window: [0; REPORT_BYTES], chunk: [0; CHUNK_BYTES], from: 0, to: 0 }
    }

    /// Waits for the next whole report.
    ///
    /// # Errors
    /// What the port reports; the next call goes on with the next report.
    pub async fn read<Port: Read>(&mut self, port: &mut Port) -> Result<RadarFrame, RadarError<Port::Error>> {
        loop {
            while let Some(byte) = self.next_byte() {
                if let Some(report) = self.push(byte) {
                    return Ok(report);
                }
            }
            (self.from, self.to) = (0, 0);
            self.to = port.read(&mut self.chunk).await.map_err(RadarError::Port)?;
            if self.to == 0 {
                return Err(RadarError::Ended);
            }
        }
    }

    fn next_byte(&mut self) -> Option<u8> {
        let byte = self.chunk.get(self.from..self.to)?.first().copied()?;
        self.from += 1;
        Some(byte)
    }

    /// Takes a byte; gives a report when it ends one.
    fn push(&mut self, byte: u8) -> Option<RadarFrame> {
        self.window.rotate_left(1);
        if let Some(last) = self.window.last_mut() {
            *last = byte;
        }
        let report = parse_report(&self.window)?;
        // Nothing of it belongs to the next one.
        self.window = [0; REPORT_BYTES];
        Some(report)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bus::block_on;
    use embedded_io_async::{ErrorKind, ErrorType};
    use proptest::prelude::*;
    use vitrine_exhibit::viewer::RadarTarget;
    extern crate std;
    use std::collections::VecDeque;
    use std::vec::Vec;

    /// A port that gives what was sent piece by piece, with an error where a piece is none.
    struct Port(VecDeque<Option<Vec<u8>>>);

    impl ErrorType for Port {
        type Error = ErrorKind;
    }

    impl Read for Port {
        async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
            let Some(piece) = self.0.pop_front() else { return Ok(0) };
            let Some(mut bytes) = piece else { return Err(ErrorKind::Other) };
            let taken = bytes.len().min(buffer.len());
            buffer[..taken].copy_from_slice(&bytes[..taken]);
            if taken < bytes.len() {
                self.0.push_front(Some(bytes.split_off(taken)));
            }
            Ok(taken)
        }
    }

    /// A report of one target, as the sensor sends it: positive numbers have bit 15 set.
    fn report(x_mm: i16, y_mm: i16) -> Vec<u8> {
        let word = |mm: i16| {
            let raw = if mm >= 0 { mm.unsigned_abs() | 0x8000 } else { mm.unsigned_abs() };
            raw.to_le_bytes()
        };
        let mut bytes = std::vec![0xAA, 0xFF, 0x03, 0x00];
        bytes.extend(word(x_mm));
        bytes.extend(word(y_mm));
        bytes.extend([0; 20]);
        bytes.extend([0x55, 0xCC]);
        bytes
    }

    /// Everything that a radar reports until its port ends, and how many errors came between.
    fn all(pieces: Vec<Option<Vec<u8>>>) -> (Vec<(i16, i16)>, usize) {
        let (mut port, mut radar) = (Port(pieces.into()), Radar::new());
        let (mut found, mut errors) = (Vec::new(), 0);
        loop {
            match block_on(radar.read(&mut port)) {
                Ok(frame) => found.extend(frame.iter().map(|RadarTarget { x_mm, y_mm }| (*x_mm, *y_mm))),
                Err(RadarError::Port(_)) => errors += 1,
                Err(RadarError::Ended) => return (found, errors),
            }
        }
    }

    #[test]
    fn reports_are_found_however_they_are_cut_into_pieces() {
        let bytes = [report(-782, 1_713), report(300, 900)].concat();
        for size in 1..bytes.len() {
            let pieces = bytes.chunks(size).map(|piece| Some(piece.to_vec())).collect();
            assert_eq!(all(pieces), (std::vec![(-782, 1_713), (300, 900)], 0), "pieces of {size}");
        }
    }

    #[test]
    fn a_report_cut_short_is_skipped_and_the_next_one_found() {
        for length in 0..REPORT_BYTES {
            let bytes = [&report(1, 1)[..length], &report(-200, 1_500)].concat();
            assert_eq!(all(std::vec![Some(bytes)]).0, [(-200, 1_500)], "{length} bytes");
        }
    }

    #[test]
    fn an_error_of_the_port_ends_nothing() {
        let (first, second) = (report(10, 1_000), report(20, 1_000));
        let pieces = std::vec![
            Some(first[..12].to_vec()),
            None,
            Some(first[15..].to_vec()),
            None,
            Some(second.clone()),
            Some(second),
        ];
        assert_eq!(all(pieces), (std::vec![(20, 1_000), (20, 1_000)], 2));
    }

    #[test]
    fn an_empty_room_is_a_report_without_targets() {
        let mut empty = report(0, 0);
        empty[4..28].fill(0);
        let mut port = Port([Some(empty)].into());
        assert_eq!(block_on(Radar::new().read(&mut port)), Ok(RadarFrame::new()));
    }

    proptest! {
        /// However much noise comes before, of two reports one at least is found.
        #[test]
        fn noise_hides_one_report_at_most(noise: Vec<u8>, x_mm in -3_000_i16..3_000, y_mm in 1_i16..6_000) {
            let bytes = [noise, report(x_mm, y_mm), report(x_mm, y_mm)].concat();
            let (found, _) = all(std::vec![Some(bytes)]);
            prop_assert!(found.contains(&(x_mm, y_mm)), "{found:?}");
        }
    }
}
