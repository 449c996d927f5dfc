//! From levels, linear in irradiance, to the counts of the dimming PWM.

use crate::plan::{BelowFloor, LampCalibration};
use crate::units::Level;

/// The PWM counter's top: 500 Hz at 125 MHz with a divider of 4.
pub const PWM_TOP: u16 = 62_499;
/// The count at which the output is always high.
pub const PWM_FULL: u16 = PWM_TOP + 1;
/// The driver's least duty, 1 %, in counts.
pub const PWM_FLOOR: u16 = PWM_FULL / 100;

/// Gives the PWM counts for a level by the lamp's calibration, 0 to [`PWM_FULL`], rounded down, before the driver's floor.
pub fn counts(lamp: &LampCalibration, level: Level) -> u16 {
    let part = match segment(lamp, level) {
        Some(((from_level, from_duty), (to_level, to_duty))) => {
            let span = u32::from(to_level - from_level).max(1);
            let risen = u32::from(level.0 - from_level) * u32::from(to_duty - from_duty);
            from_duty + (risen / span) as u16
        }
        None => level.0,
    };
    (u32::from(part) * u32::from(PWM_FULL) / 65_535) as u16
}

type Point = (u16, u16);

fn segment(lamp: &LampCalibration, level: Level) -> Option<(Point, Point)> {
    let pairs = lamp.curve.iter().zip(lamp.curve.iter().skip(1));
    let found = pairs.into_iter().find(|(from, to)| from.level <= level && level <= to.level);
    found.map(|(from, to)| ((from.level.0, from.duty), (to.level.0, to.duty)))
}

/// Brings counts below the driver's floor to what the driver can give.
#[derive(Clone, Copy, Debug, Default)]
pub struct FloorDither {
    owed: u16,
}

impl FloorDither {
    /// Gives counts of 0 or not below [`PWM_FLOOR`].
    pub const fn apply(&mut self, below_floor: BelowFloor, counts: u16) -> u16 {
        if counts >= PWM_FLOOR || counts == 0 {
            self.owed = 0;
            return counts;
        }
        match below_floor {
            BelowFloor::Cut => 0,
            BelowFloor::Dither => {
                self.owed += counts;
                if self.owed < PWM_FLOOR {
                    return 0;
                }
                self.owed -= PWM_FLOOR;
                PWM_FLOOR
            }
        }
    }
}
