//! A room with people in it, as two Grid-EYE thermal sensors see it.
//!
//! Bodies are upright warm rectangles that face the sensors; each pixel gives the mean temperature over its square of
//! 7.5 by 7.5 degrees, with 0.16 °C of noise, in steps of 0.25 °C. The room is at 22 °C, unless [`Climate`] says
//! otherwise. Lengths are in metres; the stack's middle and both sensors are 1.3 m above the floor.

mod body;

use serde::Deserialize;

pub use self::body::{Body, Kind, Waypoint};
use vitrine_exhibit::viewer::{COLUMNS, PIXELS, REPORT_BYTES, ROWS, RadarFrame, RadarTarget, ThermalFrame};

/// Temperature of the room in °C.
pub const ROOM_C: f64 = 22.0;
/// Height of the sensors above the floor in m.
pub const SENSOR_HEIGHT_M: f64 = 1.3;
/// Standard deviation of a pixel's noise in °C.
pub const NOISE_C: f64 = 0.16;
/// Width of a pixel in degrees.
const PIXEL_DEG: f64 = 7.5;
/// Half of what the radar sees to either side, in degrees; how far it sees; the slowest that it sees; its noise.
const RADAR_HALF_DEG: f64 = 60.0;
const RADAR_FARTHEST_M: f64 = 6.0;
const RADAR_LEAST_M_S: f64 = 0.1;
const RADAR_NOISE_M: f64 = 0.03;

/// One of the two sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The sensor that looks to the left, to negative angles.
    Left,
    /// The sensor that looks to the right.
    Right,
}

/// A warm rectangle as a sensor sees it, in degrees, with what it adds to the room's temperature.
#[derive(Clone, Copy, Debug)]
pub struct WarmArea {
    /// Azimuths of its edges.
    pub azimuth: [f64; 2],
    /// Elevations of its lower and upper edge.
    pub elevation: [f64; 2],
    /// Temperature above the room's.
    pub above_c: f64,
    /// Distance, to know what hides what.
    pub distance_m: f64,
}

/// What a room and the sensors in it are like.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Climate {
    /// Standard deviation of a pixel's noise in °C.
    pub noise_c: f64,
    /// How much warmer the room gets in a minute, in °C.
    pub warms_c_per_min: f64,
    /// How far each sensor stands beside the stack's middle, in mm.
    pub beside_mm: i16,
}

impl Default for Climate {
    fn default() -> Self {
        Self { noise_c: NOISE_C, warms_c_per_min: 0.0, beside_mm: ThermalFrame::RIGHT_MM }
    }
}

/// The room.
#[derive(Clone, Debug)]
pub struct Room {
    /// Everything warm in it.
    pub bodies: Vec<Body>,
    /// What it is like.
    pub climate: Climate,
    noise: Noise,
}

impl Room {
    /// An empty room; the same seed gives the same noise.
    pub fn new(seed: u64) -> Self {
        Self { bodies: Vec::new(), climate: Climate::default(), noise: Noise(seed | 1) }
    }

    /// What a sensor sees at a time in seconds.
    pub fn frame(&mut self, side: Side, time_s: f64) -> ThermalFrame {
        let (make, sign): (fn([i16; PIXELS]) -> ThermalFrame, f64) = match side {
            Side::Left => (ThermalFrame::left, -1.0),
            Side::Right => (ThermalFrame::right, 1.0),
        };
        let at_m = sign * f64::from(self.climate.beside_mm) / 1_000.0;
        let room_c = ROOM_C + self.climate.warms_c_per_min * time_s / 60.0;
        let yaw = sign * f64::from(ThermalFrame::YAW.0) / 100.0;
        let mut areas: Vec<WarmArea> =
            self.bodies.iter().flat_map(|body| body.seen_from(at_m, time_s)).collect();
        areas.sort_by(|a, b| b.distance_m.total_cmp(&a.distance_m));
        let mut pixels = [0_i16; PIXELS];
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let (row, column) = (index / COLUMNS, index % COLUMNS);
            let left = yaw + (column as f64 - COLUMNS as f64 / 2.0) * PIXEL_DEG;
            let bottom = (ROWS as f64 / 2.0 - 1.0 - row as f64) * PIXEL_DEG;
            let celsius = areas.iter().fold(room_c, |behind, area| {
                let part = overlap(area.azimuth, left) * overlap(area.elevation, bottom);
                behind * (1.0 - part) + (room_c + area.above_c) * part
            });
            *pixel = ((celsius + self.climate.noise_c * self.noise.next()) * 4.0).round() as i16;
        }
        let frame = make(pixels);
        ThermalFrame { right_mm: frame.right_mm.signum() * self.climate.beside_mm, ..frame }
    }

    /// What an LD2450 radar above the stack reports at a time in seconds: the three nearest of those who move, within
    /// 60 degrees and 6 m, to some centimetres. It loses those who stand.
    pub fn radar(&mut self, time_s: f64) -> RadarFrame {
        let moving = self.bodies.iter().filter_map(|body| {
            let ([x, z], [x_before, z_before]) = (body.position(time_s)?, body.position(time_s - 0.2)?);
            let slow = (x - x_before).hypot(z - z_before) < 0.2 * RADAR_LEAST_M_S;
            let in_sight = x.abs() < z * RADAR_HALF_DEG.to_radians().tan() && x.hypot(z) < RADAR_FARTHEST_M;
            (!slow && in_sight).then_some([x, z])
        });
        let mut moving: Vec<[f64; 2]> = moving.collect();
        moving.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
        moving.truncate(3);
        let mut millimetres =
            |metres: f64| ((metres + RADAR_NOISE_M * self.noise.next()) * 1_000.0).round() as i16;
        let targets = moving.into_iter();
        targets.map(|[x, z]| RadarTarget { x_mm: millimetres(x), y_mm: millimetres(z).max(1) }).collect()
    }
}

/// The bytes of a radar's report, as they come over its wire: header, three targets, tail; positive numbers have bit 15
/// set.
pub fn radar_bytes(report: &RadarFrame) -> Vec<u8> {
    let word = |mm: i16| (mm.unsigned_abs() | if mm >= 0 { 0x8000 } else { 0 }).to_le_bytes();
    let mut bytes = vec![0xAA, 0xFF, 0x03, 0x00];
    for target in report {
        bytes.extend(word(target.x_mm));
        bytes.extend(word(target.y_mm));
        // Speed and resolution, which nobody reads.
        bytes.extend([0x10, 0x00, 0x40, 0x01]);
    }
    bytes.resize(REPORT_BYTES - 2, 0);
    bytes.extend([0x55, 0xCC]);
    bytes
}

/// The part of a pixel that begins at an angle which lies between two edges.
fn overlap(edges: [f64; 2], from: f64) -> f64 {
    let within = edges[1].min(from + PIXEL_DEG) - edges[0].max(from);
    (within / PIXEL_DEG).clamp(0.0, 1.0)
}

/// Noise of unit variance: the sum of twelve uniform numbers from a xorshift generator.
#[derive(Clone, Debug)]
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
