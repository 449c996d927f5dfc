//! The LD2450 radar as a source of bearings: one axis only, and it loses viewers who stand still.

use super::{Bearing, BearingSource, RadarFrame, RadarTarget, Sighting, Sightings};
use crate::angle;
use crate::units::Milliseconds;

/// Bytes of one report.
pub const REPORT_BYTES: usize = 30;
const HEADER: [u8; 4] = [0xAA, 0xFF, 0x03, 0x00];
const TAIL: [u8; 2] = [0x55, 0xCC];
/// A radar without a report for this long is lost; it sends ten a second.
const STALE: Milliseconds = Milliseconds(1_000);
/// Viewers who vanish from the report are believed to stand still for this long.
const STILL: Milliseconds = Milliseconds(5_000);
/// Farther targets are passers-by, in mm.
const FARTHEST_MM: i16 = 4_000;

/// Reads one report of the LD2450 (HLK-LD2450 serial protocol V1.03: header, three targets of x, y, speed and
/// resolution, tail); none where header or tail is wrong.
///
/// The sensor's x is positive towards its own left as it looks out, with the sign in bit 15 set for positive: that is
/// to the right as a viewer facing the stack sees it, where the sensor stands upright above or below the stack.
pub fn parse_report(bytes: &[u8; REPORT_BYTES]) -> Option<RadarFrame> {
    let targets = bytes.strip_prefix(&HEADER)?.strip_suffix(&TAIL)?;
    let word = |low: &u8, high: &u8| {
        let raw = i32::from(u16::from_le_bytes([*low, *high]));
        (if raw >= 0x8000 { raw - 0x8000 } else { -raw }) as i16
    };
    let target = |target: &[u8]| match target {
        [xl, xh, yl, yh, ..] => Some(RadarTarget { x_mm: word(xl, xh), y_mm: word(yl, yh) }),
        _ => None,
    };
    Some(targets.chunks_exact(8).filter_map(target).filter(|target| target.y_mm > 0).collect())
}

/// The radar sensor.
#[derive(Clone, Debug)]
pub struct Radar {
    last: RadarFrame,
    age: Milliseconds,
    empty_for: Milliseconds,
}

impl Default for Radar {
    fn default() -> Self {
        Self::new()
    }
}

impl Radar {
    /// A radar that has reported nothing yet.
    pub const fn new() -> Self {
        Self { last: RadarFrame::new(), age: STALE, empty_for: STILL }
    }
}

impl BearingSource for Radar {
    type Reading<'a> = Option<&'a RadarFrame>;

    fn take(&mut self, reading: Self::Reading<'_>, elapsed: Milliseconds) -> Option<Sightings> {
        self.age = self.age.plus(elapsed);
        self.empty_for = self.empty_for.plus(elapsed);
        let report = reading?;
        self.age = Milliseconds(0);
        if !report.is_empty() {
            self.last.clone_from(report);
            self.empty_for = Milliseconds(0);
        } else if self.empty_for >= STILL {
            self.last.clear();
        }
        let near = self.last.iter().filter(|target| (1..=FARTHEST_MM).contains(&target.y_mm));
        Some(near.map(sighting).collect())
    }

    fn is_sound(&self) -> bool {
        self.age < STALE
    }
}

fn sighting(target: &RadarTarget) -> Sighting {
    let horizontal = angle::arc_tangent(i32::from(target.x_mm), i32::from(target.y_mm));
    Sighting {
        bearing: Bearing::new(horizontal as i16, 0),
        strength: (4_000_000 / i32::from(target.y_mm).max(100)) as u16,
        moves: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the sensor's protocol: one target at x = -782 mm, y = 1,713 mm.
    #[test]
    fn reads_the_example_of_the_protocol() {
        let mut report = [0; REPORT_BYTES];
        report[..4].copy_from_slice(&HEADER);
        report[4..12].copy_from_slice(&[0x0E, 0x03, 0xB1, 0x86, 0x10, 0x00, 0x40, 0x01]);
        report[28..].copy_from_slice(&TAIL);
        let frame = parse_report(&report).unwrap();
        assert_eq!(frame.as_slice(), [RadarTarget { x_mm: -782, y_mm: 1_713 }]);
        let sightings = Radar::new().take(Some(&frame), Milliseconds(10)).unwrap();
        assert!((sightings[0].bearing.horizontal.0 + 2_454).abs() < 15);
    }

    #[test]
    fn refuses_a_report_out_of_step() {
        assert_eq!(parse_report(&[0xAA; REPORT_BYTES]), None);
    }

    #[test]
    fn believes_for_a_while_that_who_vanished_stands_still() {
        let mut radar = Radar::new();
        let there: RadarFrame = [RadarTarget { x_mm: 100, y_mm: 1_000 }].into_iter().collect();
        radar.take(Some(&there), Milliseconds(100));
        let seen = |radar: &mut Radar| radar.take(Some(&RadarFrame::new()), Milliseconds(100)).unwrap().len();
        assert!((0..49).all(|_| seen(&mut radar) == 1));
        assert_eq!(seen(&mut radar), 0);
    }
}
