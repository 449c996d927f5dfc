//! Panasonic AMG8833 "Grid-EYE": 8 x 8 thermal pixels, ten frames a second.
//!
//! A frame is one burst of 128 bytes from register 0x80, about 3 ms at 400 kHz, and not 64 short reads. A pixel is
//! 12 bits in two's complement, 0.25 °C a step, low byte first (data sheet ADI8000C59, "Temperature register").

use embedded_hal_async::i2c::I2c;

/// Pixels of a frame.
pub const PIXELS: usize = 64;

/// Bytes of a frame on the bus.
pub const FRAME_BYTES: usize = 2 * PIXELS;

const POWER_CONTROL: u8 = 0x00;
const RESET: u8 = 0x01;
const FRAME_RATE: u8 = 0x02;
const INTERRUPT_CONTROL: u8 = 0x03;
const FIRST_PIXEL: u8 = 0x80;

const POWER_NORMAL: u8 = 0x00;
const INITIAL_RESET: u8 = 0x3f;
const TEN_FRAMES_A_SECOND: u8 = 0x00;
const INTERRUPT_OFF: u8 = 0x00;

/// What a pixel of this sensor can read at all, with room to spare: -30 to 130 °C.
const PLAUSIBLE_QUARTER_DEGREES: core::ops::RangeInclusive<i16> = -120..=520;

/// Why there is no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError<E> {
    /// The bus failed, or the sensor did not answer.
    Bus(E),
    /// This many bytes are not a frame.
    Length(usize),
    /// A pixel lies outside of what the sensor can read, or the whole frame is what an idle bus would read.
    Implausible,
}

/// One picture: temperatures in quarter degrees Celsius, in the sensor's order of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Quarter degrees Celsius; pixel 0 is the sensor's pixel 1, eight to a row.
    pub quarter_degrees: [i16; PIXELS],
}

impl Frame {
    /// Reads a frame from the bytes of the burst.
    ///
    /// # Errors
    /// [`FrameError::Length`] unless there are 128 bytes; [`FrameError::Implausible`] for what no sensor would send.
    pub fn from_bytes<E>(bytes: &[u8]) -> Result<Self, FrameError<E>> {
        if bytes.len() != FRAME_BYTES {
            return Err(FrameError::Length(bytes.len()));
        }
        let mut quarter_degrees = [0; PIXELS];
        for (pixel, pair) in quarter_degrees.iter_mut().zip(bytes.as_chunks::<2>().0) {
            *pixel = twelve_bits(u16::from_le_bytes(*pair));
        }
        let bus_is_idle = bytes.iter().all(|byte| *byte == 0x00) || bytes.iter().all(|byte| *byte == 0xff);
        let plausible = quarter_degrees.iter().all(|pixel| PLAUSIBLE_QUARTER_DEGREES.contains(pixel));
        if bus_is_idle || !plausible {
            return Err(FrameError::Implausible);
        }
        Ok(Self { quarter_degrees })
    }
}

/// Extends the sign of a 12-bit number in two's complement; the upper four bits do not count.
fn twelve_bits(word: u16) -> i16 {
    (word << 4).cast_signed() >> 4
}

/// One sensor; the bus is lent to each call, as others share it.
#[derive(Clone, Copy, Debug)]
pub struct GridEye {
    address: u8,
}

impl GridEye {
    /// Names the sensor at a bus address, 0x68 or 0x69.
    pub const fn new(address: u8) -> Self {
        Self { address }
    }

    /// Wakes the sensor and sets ten frames a second without interrupts. Frames are good 50 ms later.
    ///
    /// # Errors
    /// What the bus reports.
    pub async fn set_up<Bus: I2c>(&self, bus: &mut Bus) -> Result<(), Bus::Error> {
        for setting in [
            [POWER_CONTROL, POWER_NORMAL],
            [RESET, INITIAL_RESET],
            [FRAME_RATE, TEN_FRAMES_A_SECOND],
            [INTERRUPT_CONTROL, INTERRUPT_OFF],
        ] {
            bus.write(self.address, &setting).await?;
        }
        Ok(())
    }

    /// Reads one frame in one burst.
    ///
    /// # Errors
    /// What the bus reports, or an implausible frame.
    pub async fn read<Bus: I2c>(&self, bus: &mut Bus) -> Result<Frame, FrameError<Bus::Error>> {
        let mut bytes = [0; FRAME_BYTES];
        bus.write_read(self.address, &[FIRST_PIXEL], &mut bytes).await.map_err(FrameError::Bus)?;
        Frame::from_bytes(&bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bus::{block_on, broken, nack};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
    extern crate std;
    use std::vec;

    #[test]
    fn twelve_bits_carry_their_sign() {
        assert_eq!(twelve_bits(0x000), 0);
        assert_eq!(twelve_bits(0x058), 88);
        assert_eq!(twelve_bits(0xfff), -1);
        assert_eq!(twelve_bits(0x800), -2048);
        assert_eq!(twelve_bits(0xf7ff), 2047);
    }

    #[test]
    fn sets_up_and_reads_in_one_burst() {
        let mut bytes = vec![0; FRAME_BYTES];
        for (index, byte) in bytes.iter_mut().enumerate() {
            *byte = if index % 2 == 0 { 0x58 } else { 0x00 };
        }
        bytes[0] = 0xfc;
        bytes[1] = 0x0f;
        let mut bus = Mock::new(&[
            Transaction::write(0x69, vec![0x00, 0x00]),
            Transaction::write(0x69, vec![0x01, 0x3f]),
            Transaction::write(0x69, vec![0x02, 0x00]),
            Transaction::write(0x69, vec![0x03, 0x00]),
            Transaction::write_read(0x69, vec![0x80], bytes),
        ]);
        let sensor = GridEye::new(0x69);
        block_on(sensor.set_up(&mut bus)).unwrap();
        let frame = block_on(sensor.read(&mut bus)).unwrap();
        assert_eq!(frame.quarter_degrees[0], -4);
        assert_eq!(frame.quarter_degrees[63], 88);
        bus.done();
    }

    #[test]
    fn a_silent_sensor_is_an_error() {
        let mut bus = Mock::new(&[
            Transaction::write(0x68, vec![0x00, 0x00]).with_error(nack()),
            Transaction::write_read(0x68, vec![0x80], vec![0; FRAME_BYTES]).with_error(broken()),
        ]);
        let sensor = GridEye::new(0x68);
        assert_eq!(block_on(sensor.set_up(&mut bus)), Err(nack()));
        assert_eq!(block_on(sensor.read(&mut bus)), Err(FrameError::Bus(broken())));
        bus.done();
    }

    #[test]
    fn what_is_no_frame_is_refused() {
        assert_eq!(Frame::from_bytes::<()>(&[0x58; 127]), Err(FrameError::Length(127)));
        assert_eq!(Frame::from_bytes::<()>(&[]), Err(FrameError::Length(0)));
        assert_eq!(Frame::from_bytes::<()>(&[0xff; FRAME_BYTES]), Err(FrameError::Implausible));
        assert_eq!(Frame::from_bytes::<()>(&[0x00; FRAME_BYTES]), Err(FrameError::Implausible));
        let mut one_pixel_off = [0x01; FRAME_BYTES];
        assert!(Frame::from_bytes::<()>(&one_pixel_off).is_ok());
        one_pixel_off[1] = 0x08;
        assert_eq!(Frame::from_bytes::<()>(&one_pixel_off), Err(FrameError::Implausible));
    }
}
