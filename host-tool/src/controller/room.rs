//! A viewer in front of the stack, and what the two thermal sensors see of one.

use vitrine_exhibit::{
    units::CentiDegrees,
    viewer::{Bearing, COLUMNS, PIXELS, ROWS, ThermalFrame},
};

/// The room in quarters of a degree: 22 °C.
const ROOM: f64 = 88.0;
/// How much warmer a pixel is that a viewer fills, in quarters of a degree: 6 °C.
const WARMTH: f64 = 24.0;
/// Half the width of a viewer's warm part, in mm.
const HALF_WIDTH_MM: f64 = 160.0;
/// From the top of the head down to the waist, in mm.
const HEIGHT_MM: f64 = 800.0;
/// Width of a pixel in degrees.
const PIXEL: f64 = 7.5;
/// Parts of a pixel over which the viewer's share of it is summed, in each direction.
const PARTS: usize = 5;

/// Standard deviation of a pixel's noise, in quarters of a degree: 0.16 °C. A sensor without noise counts as frozen.
const NOISE: f64 = 0.64;

/// Somebody in front of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewer {
    /// Where, seen from the stack's middle; the vertical angle is that of the top of the head.
    pub bearing: Bearing,
    /// How far from the stack, in mm.
    pub distance_mm: f64,
}

impl Viewer {
    /// A viewer at 1.2 m.
    pub const fn at(bearing: Bearing) -> Self {
        Self { bearing, distance_mm: 1_200.0 }
    }
}

/// The sensors' noise; the same from run to run.
#[derive(Clone, Debug)]
pub struct Noise {
    state: u64,
    deviation: f64,
}

impl Noise {
    /// Noise as the sensors have it.
    pub const fn new() -> Self {
        Self { state: 0, deviation: NOISE }
    }

    /// No noise.
    pub const fn none() -> Self {
        Self { state: 0, deviation: 0.0 }
    }

    /// The next value in quarters of a degree: the sum of four uniform numbers, scaled to the deviation.
    fn next(&mut self) -> f64 {
        let sum: f64 = (0..4).map(|_| self.uniform() - 0.5).sum();
        sum * 3.0_f64.sqrt() * self.deviation
    }

    /// SplitMix64, as a number from 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl Default for Noise {
    fn default() -> Self {
        Self::new()
    }
}

/// What the left and the right sensor see.
pub fn thermal_frames(viewer: Option<Viewer>, noise: &mut Noise) -> [ThermalFrame; 2] {
    let mut frames = [ThermalFrame::left([0; PIXELS]), ThermalFrame::right([0; PIXELS])];
    for frame in &mut frames {
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let share = viewer.map_or(0.0, |viewer| share_of_pixel(viewer, frame, row, column));
                frame.pixels[row * COLUMNS + column] = (ROOM + WARMTH * share + noise.next()).round() as i16;
            }
        }
    }
    frames
}

/// The part of a pixel that a viewer fills, 0 to 1.
fn share_of_pixel(viewer: Viewer, sensor: &ThermalFrame, row: usize, column: usize) -> f64 {
    let degrees = |angle: CentiDegrees| f64::from(angle.0) / 100.0;
    let bearing = degrees(viewer.bearing.horizontal).to_radians();
    let right_mm = viewer.distance_mm * bearing.sin() - f64::from(sensor.right_mm);
    let ahead_mm = viewer.distance_mm * bearing.cos();
    let azimuth = right_mm.atan2(ahead_mm).to_degrees();
    let half_width = (HALF_WIDTH_MM / viewer.distance_mm).atan().to_degrees();
    let top = degrees(viewer.bearing.vertical);
    let bottom = top - (HEIGHT_MM / viewer.distance_mm).atan().to_degrees();
    let part_of = |index: usize, part: usize, cells: usize| {
        (index as f64 - cells as f64 / 2.0 + (part as f64 + 0.5) / PARTS as f64) * PIXEL
    };
    let columns = (0..PARTS)
        .filter(|part| (degrees(sensor.yaw) + part_of(column, *part, COLUMNS) - azimuth).abs() <= half_width)
        .count();
    let rows = (0..PARTS)
        .filter(|part| {
            let elevation = degrees(sensor.pitch) - part_of(row, *part, ROWS);
            (bottom..=top).contains(&elevation)
        })
        .count();
    (columns * rows) as f64 / (PARTS * PARTS) as f64
}

/// Where a viewer is over time: stations with times, the way between them straight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walk {
    stations: Vec<(u64, Option<Viewer>)>,
    repeats: bool,
}

impl Walk {
    /// Nobody, ever.
    pub const fn nobody() -> Self {
        Self { stations: Vec::new(), repeats: false }
    }

    /// Stations as (ms after the start, who is there), in rising order. Where one has nobody, the viewer appears at
    /// the next, or disappears at this one. With `repeats` it begins anew at the last station's time.
    pub fn new(stations: Vec<(u64, Option<Viewer>)>, repeats: bool) -> Self {
        Self { stations, repeats }
    }

    /// A visitor who comes 6 s after the start, walks from left to right and back, and goes; again every 90 s.
    pub fn back_and_forth() -> Self {
        let at = |horizontal| Some(Viewer::at(Bearing::new(horizontal, 500)));
        Self::new(
            vec![
                (0, None),
                (6_000, at(-3_500)),
                (12_000, at(-3_000)),
                (22_000, at(0)),
                (30_000, at(0)),
                (40_000, at(3_000)),
                (46_000, at(3_200)),
                (58_000, at(-3_000)),
                (60_000, None),
                (90_000, None),
            ],
            true,
        )
    }

    /// Who is there at this time.
    pub fn at(&self, ms: u64) -> Option<Viewer> {
        let end = self.stations.last()?.0;
        let ms = if self.repeats && end > 0 { ms % end } else { ms };
        let next = self.stations.iter().position(|(time, _)| *time > ms);
        let (before_ms, before) = match next {
            Some(0) => return None,
            Some(next) => self.stations[next - 1],
            None => return self.stations.last()?.1,
        };
        let (after_ms, after) = self.stations[next?];
        let (Some(from), Some(to)) = (before, after) else { return before };
        let share = (ms - before_ms) as f64 / (after_ms - before_ms).max(1) as f64;
        let between = |from: f64, to: f64| from + (to - from) * share;
        let angle = |from: CentiDegrees, to: CentiDegrees| between(from.0.into(), to.0.into()).round() as i16;
        Some(Viewer {
            bearing: Bearing::new(
                angle(from.bearing.horizontal, to.bearing.horizontal),
                angle(from.bearing.vertical, to.bearing.vertical),
            ),
            distance_mm: between(from.distance_mm, to.distance_mm),
        })
    }
}
