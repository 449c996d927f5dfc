//! What the sensors see: a room at 22 °C with, perhaps, somebody in it, as the bytes of their registers.

use vitrine_tests::room::Side;

use crate::bench::{Bench, MILLISECOND};

const LEFT_SENSOR: u8 = 0x68;
const RIGHT_SENSOR: u8 = 0x69;
const CLOCK: u8 = 0x51;
const FIRST_PIXEL: u8 = 0x80;

/// The sensors make ten frames a second.
const FRAME: u64 = 100 * MILLISECOND;

/// The sensors' yaw and their degrees a pixel.
const YAW_DEG: f64 = 25.0;
const PIXEL_DEG: f64 = 7.5;

const ROOM_CELSIUS: f64 = 22.0;
const PERSON_CELSIUS: f64 = 28.0;
/// A person a metre and a half away.
const PERSON_WIDTH_DEG: f64 = 8.0;

/// A room in front of the exhibit.
pub(crate) struct Room {
    /// Where somebody stands, in degrees to the right; nobody without.
    pub(crate) person_deg: Option<f64>,
    noise: u32,
}

impl Room {
    pub(crate) fn empty() -> Self {
        Self { person_deg: None, noise: 1 }
    }

    /// Lets the board live in the room for so many nanoseconds, frame by frame.
    pub(crate) fn live(&mut self, bench: &mut Bench, ns: u64) {
        for _ in 0..ns.div_ceil(FRAME) {
            self.show(bench);
            bench.run(FRAME.min(ns));
        }
    }

    /// Gives both sensors their next frame.
    pub(crate) fn show(&mut self, bench: &mut Bench) {
        for (address, yaw) in [(LEFT_SENSOR, -YAW_DEG), (RIGHT_SENSOR, YAW_DEG)] {
            let bytes: Vec<u8> = (0..64).flat_map(|pixel| self.pixel(yaw, pixel)).collect();
            bench.device(address, FIRST_PIXEL, &bytes);
        }
    }

    fn pixel(&mut self, yaw: f64, pixel: u32) -> [u8; 2] {
        let (row, column) = (f64::from(pixel / 8), f64::from(pixel % 8));
        let looks_deg = yaw + (column - 3.5) * PIXEL_DEG;
        let mut celsius = ROOM_CELSIUS + 0.15 * self.gaussian();
        if let Some(person_deg) = self.person_deg
            && row >= 2.0
        {
            let away = (looks_deg - person_deg) / PERSON_WIDTH_DEG;
            celsius += (PERSON_CELSIUS - ROOM_CELSIUS) * (-away * away).exp();
        }
        let quarters = (celsius * 4.0).round() as i16;
        (quarters.cast_unsigned() & 0x0fff).to_le_bytes()
    }

    /// Roughly normal, with a deviation of 1: the sum of twelve uniform numbers.
    fn gaussian(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn uniform(&mut self) -> f64 {
        self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.noise >> 8) / f64::from(1 << 24)
    }
}

/// Shows both sensors the room of the scenarios, as it is at a time in seconds.
pub(crate) fn show(bench: &mut Bench, room: &mut vitrine_tests::room::Room, time_s: f64) {
    for (address, side) in [(LEFT_SENSOR, Side::Left), (RIGHT_SENSOR, Side::Right)] {
        let frame = room.frame(side, time_s);
        let bytes: Vec<u8> = frame
            .pixels
            .iter()
            .flat_map(|quarters| (quarters.cast_unsigned() & 0x0fff).to_le_bytes())
            .collect();
        bench.device(address, FIRST_PIXEL, &bytes);
    }
}

/// Puts the battery clock on the bus: 2026-11-22T12:00:00Z, a Sunday.
pub(crate) fn battery_clock(bench: &mut Bench) {
    battery_clock_at(bench, 1_795_348_800);
}

/// Puts the battery clock on the bus, at so many seconds since 1970. It stands until it is set.
pub(crate) fn battery_clock_at(bench: &mut Bench, utc_seconds: i64) {
    let time = jiff::Timestamp::from_second(utc_seconds).expect("a time").to_zoned(jiff::tz::TimeZone::UTC);
    let fields =
        [time.second(), time.minute(), time.hour(), time.day(), 0, time.month(), (time.year() % 100) as i8];
    let coded = fields.map(|field| (field as u8 / 10) << 4 | (field as u8 % 10));
    bench.device(CLOCK, 0x02, &coded);
}

/// The converter's reading of a 10 kOhm NTC (beta 3950 K) below 10 kOhm.
pub(crate) fn thermistor_reading(celsius: f64) -> u16 {
    let ratio = (3950.0 * (1.0 / (celsius + 273.15) - 1.0 / 298.15)).exp();
    (4095.0 * ratio / (1.0 + ratio)).round() as u16
}
