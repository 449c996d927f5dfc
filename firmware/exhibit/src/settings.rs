//! What belongs to the board and its place, whatever plan it runs: settings made on the spot.
//!
//! They correct what sensors say, so that a wrong one can make heat look like coolness: they change over a local cable
//! only, and with confirmation (`vitrine_protocol`), and each lies within bounds beyond which no sound part lies.

use core::fmt;

use heapless::String;
use serde::{Deserialize, Serialize};

use crate::units::{CentiDegrees, Irradiance};
use crate::viewer::ThermalFrame;

/// What is at the far end of the service port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ServicePort {
    /// A computer beside the exhibit.
    #[default]
    Cable,
    /// A serial server or a radio: hosts there may only ask for less.
    Network,
}

/// The settings of one controller.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// What staff call this exhibit's place, such as "Hall 3, left case".
    pub place: String<32>,
    /// What the service port leads to.
    pub service_port: ServicePort,
    /// Beta of the top lamp board's NTC in kelvin, from its data sheet: 2,000 to 6,000.
    pub top_beta_kelvin: u16,
    /// Beta of the bottom lamp board's NTC in kelvin: 2,000 to 6,000.
    pub bottom_beta_kelvin: u16,
    /// The lamp supply over what its divider gives, in thousandths: 5,000 to 20,000.
    pub supply_divider_permille: u16,
    /// What the ultraviolet sensor's reading is multiplied by, in thousandths: 500 to 2,000. Its own tolerance, and the
    /// window or baffle before it.
    pub ultraviolet_gain_permille: u16,
    /// By how much the left viewer sensor is yawed to the left and the right one to the right: 10 to 25 degrees.
    pub viewer_yaw: CentiDegrees,
    /// By how much both viewer sensors are pitched up: -30 to 30 degrees.
    pub viewer_pitch: CentiDegrees,
    /// How far each viewer sensor stands beside the stack's middle, in mm: 0 to 100.
    pub viewer_beside_mm: u16,
}

impl Default for Settings {
    /// The parts of hardware/parts.csv, wired as in hardware/wiring.md.
    fn default() -> Self {
        Self {
            place: String::new(),
            service_port: ServicePort::Cable,
            top_beta_kelvin: 3_950,
            bottom_beta_kelvin: 3_950,
            supply_divider_permille: 11_000,
            ultraviolet_gain_permille: 1_000,
            viewer_yaw: CentiDegrees(2_500),
            viewer_pitch: CentiDegrees(0),
            viewer_beside_mm: 20,
        }
    }
}

/// Why settings are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SettingsError {
    /// A beta is not within 2,000 to 6,000 K.
    Beta,
    /// The divider is not within 5 to 20.
    Divider,
    /// The ultraviolet sensor's gain is not within 0.5 to 2.
    UltravioletGain,
    /// The viewer sensors' yaw is not within 10 to 25 degrees.
    ViewerYaw,
    /// The viewer sensors' pitch is not within -30 to 30 degrees.
    ViewerPitch,
    /// The viewer sensors stand more than 100 mm beside the stack.
    ViewerPlace,
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Beta => "a lamp board's beta is not within 2000 to 6000 K",
            Self::Divider => "the supply's divider is not within 5 to 20",
            Self::UltravioletGain => "the ultraviolet sensor's gain is not within 0.5 to 2",
            Self::ViewerYaw => "the viewer sensors' yaw is not within 10 to 25 degrees",
            Self::ViewerPitch => "the viewer sensors' pitch is not within -30 to 30 degrees",
            Self::ViewerPlace => "the viewer sensors stand more than 100 mm beside the stack",
        })
    }
}

impl core::error::Error for SettingsError {}

impl Settings {
    /// Refuses settings that no sound board has.
    ///
    /// # Errors
    /// The first fault found.
    pub fn check(&self) -> Result<(), SettingsError> {
        let within = |value: u16, least: u16, most: u16| (least..=most).contains(&value);
        let betas = [self.top_beta_kelvin, self.bottom_beta_kelvin];
        let rules = [
            (betas.into_iter().all(|beta| within(beta, 2_000, 6_000)), SettingsError::Beta),
            (within(self.supply_divider_permille, 5_000, 20_000), SettingsError::Divider),
            (within(self.ultraviolet_gain_permille, 500, 2_000), SettingsError::UltravioletGain),
            ((1_000..=2_500).contains(&self.viewer_yaw.0), SettingsError::ViewerYaw),
            ((-3_000..=3_000).contains(&self.viewer_pitch.0), SettingsError::ViewerPitch),
            (within(self.viewer_beside_mm, 0, 100), SettingsError::ViewerPlace),
        ];
        rules.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Puts a picture of the left or the right viewer sensor where that sensor really looks.
    pub const fn placed(&self, frame: ThermalFrame) -> ThermalFrame {
        let side = frame.yaw.0.signum();
        ThermalFrame {
            yaw: CentiDegrees(side * self.viewer_yaw.0),
            right_mm: side * self.viewer_beside_mm as i16,
            pitch: self.viewer_pitch,
            ..frame
        }
    }

    /// Corrects what the ultraviolet sensor reads; rounded up.
    pub fn ultraviolet(&self, reading: Irradiance) -> Irradiance {
        let corrected = u64::from(reading.0) * u64::from(self.ultraviolet_gain_permille);
        Irradiance(u32::try_from(corrected.div_ceil(1_000)).unwrap_or(u32::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Spoil = fn(&mut Settings);

    #[test]
    fn the_defaults_are_sound() {
        assert_eq!(Settings::default().check(), Ok(()));
    }

    /// A plan is designed for sensors that stand as the defaults say.
    #[test]
    fn the_defaults_leave_pictures_and_readings_alone() {
        let settings = Settings::default();
        for frame in [ThermalFrame::left([7; 64]), ThermalFrame::right([7; 64])] {
            assert_eq!(settings.placed(frame), frame);
        }
        assert_eq!(settings.ultraviolet(Irradiance(5_900)), Irradiance(5_900));
    }

    #[test]
    fn pictures_and_readings_are_corrected() {
        let settings = Settings {
            viewer_yaw: CentiDegrees(2_000),
            viewer_pitch: CentiDegrees(500),
            viewer_beside_mm: 45,
            ultraviolet_gain_permille: 1_250,
            ..Settings::default()
        };
        let left = settings.placed(ThermalFrame::left([7; 64]));
        assert_eq!((left.yaw.0, left.right_mm, left.pitch.0), (-2_000, -45, 500));
        let right = settings.placed(ThermalFrame::right([7; 64]));
        assert_eq!((right.yaw.0, right.right_mm, right.pitch.0), (2_000, 45, 500));
        assert_eq!(settings.ultraviolet(Irradiance(100)), Irradiance(125));
        assert_eq!(settings.ultraviolet(Irradiance(u32::MAX)), Irradiance(u32::MAX));
    }

    #[test]
    fn each_bound_is_kept() {
        let cases: [(Spoil, SettingsError); 8] = [
            (|settings| settings.top_beta_kelvin = 1_999, SettingsError::Beta),
            (|settings| settings.bottom_beta_kelvin = 6_001, SettingsError::Beta),
            (|settings| settings.supply_divider_permille = 4_999, SettingsError::Divider),
            (|settings| settings.ultraviolet_gain_permille = 2_001, SettingsError::UltravioletGain),
            (|settings| settings.viewer_yaw.0 = 999, SettingsError::ViewerYaw),
            (|settings| settings.viewer_pitch.0 = -3_001, SettingsError::ViewerPitch),
            (|settings| settings.viewer_pitch.0 = i16::MIN, SettingsError::ViewerPitch),
            (|settings| settings.viewer_beside_mm = 101, SettingsError::ViewerPlace),
        ];
        for (spoil, error) in cases {
            let mut settings = Settings::default();
            spoil(&mut settings);
            assert_eq!(settings.check(), Err(error));
        }
    }
}
