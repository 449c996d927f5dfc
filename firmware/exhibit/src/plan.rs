//! The plan: everything about one exhibit that is uploaded to its controller.

mod bounds;
pub mod calendar;
mod check;

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

pub use self::bounds::Bounds;
pub use self::calendar::Calendar;
pub use self::check::{PlanError, ValidPlan};
use crate::units::{CentiDegrees, Dose, Irradiance, Level, Milliseconds, PerLamp};
use crate::viewer::Bearing;

/// The most views a plan holds.
pub const MAX_VIEWS: usize = 16;
/// The most pairs of views that a plan holds: each two of its views.
pub const MAX_SHARED: usize = MAX_VIEWS * (MAX_VIEWS - 1) / 2;
/// The most points of a lamp's calibration curve.
pub const MAX_CURVE: usize = 12;

/// The pair of lamp levels that shows one view at its best.
pub type Emphasis = PerLamp<Level>;

/// A direction with its pattern.
///
/// Views that share a direction are pages of it: the controller turns them in their order (see [`Paging`]).
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct View {
    /// The name that exhibit.toml gives it.
    pub id: String<24>,
    /// Angle to the right of the stack's normal.
    pub horizontal: CentiDegrees,
    /// Angle above the stack's normal.
    pub vertical: CentiDegrees,
    /// The lamp pair under which this view is shown.
    pub emphasis: Emphasis,
}

impl View {
    /// The direction.
    pub const fn bearing(&self) -> Bearing {
        Bearing { horizontal: self.horizontal, vertical: self.vertical }
    }
}

/// What the controller knows of the printed volume.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct VolumeMetadata {
    /// Number of films.
    pub films: u16,
    /// Pixels of a film, left to right.
    pub width_px: u32,
    /// Pixels of a film, top to bottom.
    pub height_px: u32,
    /// Width of the picture on a film, in µm.
    pub width_um: u32,
    /// Distance from film to film, in µm.
    pub film_pitch_um: u32,
    /// BLAKE3 of all film values, to tell which stack belongs to this plan.
    pub blake3: [u8; 32],
}

/// What the plan allows; the firmware's own limits override these.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Limits {
    /// The most irradiance of one lamp on its nearest film.
    pub ceiling: Irradiance,
    /// The most dose of one lamp in a day.
    pub daily_dose: Dose,
    /// The most dose of one lamp in the stack's life.
    pub life_dose: Dose,
    /// The longest time lit without a rest.
    pub continuous: Milliseconds,
    /// The rest after it.
    pub rest: Milliseconds,
}

/// A point of a lamp's calibration curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct CurvePoint {
    /// The level, linear in irradiance.
    pub level: Level,
    /// The duty that gives it, as a part of 65,535.
    pub duty: u16,
}

/// What is done with duties below the driver's floor of 1 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum BelowFloor {
    /// The lamp is off.
    #[default]
    Cut,
    /// The floor's duty is given now and then, so that the mean is right.
    Dither,
}

/// One lamp as measured at commissioning.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct LampCalibration {
    /// Irradiance at full level on the nearest film.
    pub full_level: Irradiance,
    /// Duty against level, rising, from level 0; empty where duty is level.
    pub curve: Vec<CurvePoint, MAX_CURVE>,
    /// What is done below the driver's floor.
    pub below_floor: BelowFloor,
    /// What the ultraviolet sensor reads under this lamp alone at full level; 0 switches its check off.
    pub ultraviolet_at_full: Irradiance,
}

/// Whose view is shown where several viewers stand at different views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Policy {
    /// Who has been there longest.
    #[default]
    First,
    /// Who gives the strongest signal, that is, stands nearest.
    Nearest,
    /// All: the pair that is best for all views looked at (see [`Plan::shared`]).
    Shared,
    /// Each in turn, for `ViewerSettings::turn`.
    Alternating,
}

/// What happens to the pair while a viewer walks from one view to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Between {
    /// The nearest view's pair is kept until another view is nearer.
    #[default]
    Nearest,
    /// The pair follows the bearing along a smooth path through the views' pairs.
    Smooth,
}

/// When the pages of a direction are turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Paging {
    /// After `ViewerSettings::page`, for as long as somebody stands there.
    #[default]
    Time,
    /// When the viewer has moved to the side by `ViewerSettings::step` since the page was turned, or since they came.
    Step,
}

/// Which sensors tell where viewers stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ViewerSensor {
    /// The thermal pair; the radar stands in where it is lost or not fitted.
    #[default]
    Either,
    /// The thermal pair alone.
    Thermal,
    /// The radar alone.
    Radar,
}

/// How viewers are followed.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ViewerSettings {
    /// Which sensors tell where viewers stand.
    pub sensor: ViewerSensor,
    /// Whose view is shown.
    pub policy: Policy,
    /// What happens between views.
    pub between: Between,
    /// How much nearer another view must be before it is chosen.
    pub hysteresis: CentiDegrees,
    /// How long it must have been nearer.
    pub dwell: Milliseconds,
    /// The least time that a chosen view is kept.
    pub least_hold: Milliseconds,
    /// Within this angle of the boundary between views on either side of an axis the choice does not change.
    pub dead_zone: CentiDegrees,
    /// How long each viewer's view is shown under `Policy::Alternating`.
    pub turn: Milliseconds,
    /// When the pages of a direction are turned.
    pub paging: Paging,
    /// How long each page of a direction is shown under `Paging::Time`.
    pub page: Milliseconds,
    /// How far the viewer has to move for the next page under `Paging::Step`.
    pub step: CentiDegrees,
    /// The time of a change from one pair to another, over the whole range.
    pub fade: Milliseconds,
}

/// What happens when nobody is there.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PresenceSettings {
    /// How long the last view is kept after the last viewer has gone.
    pub hold: Milliseconds,
    /// How long the idle glow is kept after that; then dark.
    pub idle: Milliseconds,
    /// The time of the fade to the idle glow and to dark, over the whole range.
    pub fade: Milliseconds,
    /// The part of the neutral pair that is the idle glow.
    pub idle_level: Level,
}

/// The plan of one exhibit.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Plan {
    /// The exhibit's name.
    pub name: String<48>,
    /// The printed volume.
    pub volume: VolumeMetadata,
    /// The views, in the order of exhibit.toml.
    pub views: Vec<View, MAX_VIEWS>,
    /// The pair for nobody in particular.
    pub neutral: Emphasis,
    /// The pair that is best for two views at once, for each two: 0 and 1, 0 and 2 and on, then 1 and 2 and on; or
    /// nothing, and the mean of the two views' pairs serves.
    pub shared: Vec<Emphasis, MAX_SHARED>,
    /// The lamps as measured.
    pub lamps: PerLamp<LampCalibration>,
    /// Limits.
    pub limits: Limits,
    /// How viewers are followed.
    pub viewer: ViewerSettings,
    /// What happens when nobody is there.
    pub presence: PresenceSettings,
    /// When the exhibit is open.
    pub calendar: Calendar,
}

impl Plan {
    /// The bearing nearest to this one within the angles that the views span. Beyond the outermost views, above a row of
    /// views or below it, one more degree tells nothing of which is nearer.
    pub fn among_views(&self, bearing: Bearing) -> Bearing {
        let within = |at: i16, angle: fn(&View) -> i16| {
            let least = self.views.iter().map(angle).min().unwrap_or(at);
            let most = self.views.iter().map(angle).max().unwrap_or(at);
            at.clamp(least, most)
        };
        Bearing::new(
            within(bearing.horizontal.0, |view| view.horizontal.0),
            within(bearing.vertical.0, |view| view.vertical.0),
        )
    }

    /// The pair for two views at once, by their indices in any order.
    pub fn shared_pair(&self, one: u8, other: u8) -> Option<Emphasis> {
        let (first, second) = (usize::from(one.min(other)), usize::from(one.max(other)));
        let [one, other] = [self.views.get(first)?.emphasis, self.views.get(second)?.emphasis];
        if first == second {
            return Some(one);
        }
        // Before those of `first` stand the pairs of all views before it.
        let before = first * (2 * self.views.len() - first - 1) / 2;
        Some(self.shared.get(before + second - first - 1).copied().unwrap_or_else(|| mean([one, other])))
    }
}

/// The mean of lamp pairs, dark where there is none.
pub fn mean(pairs: impl IntoIterator<Item = Emphasis>) -> Emphasis {
    let (mut top, mut bottom, mut count) = (0_u32, 0_u32, 0_u32);
    // Views are few: sums of 16-bit levels do not overflow.
    for pair in pairs {
        top += u32::from(pair.top.0);
        bottom += u32::from(pair.bottom.0);
        count += 1;
    }
    let level = |sum: u32| Level((sum / count.max(1)) as u16);
    PerLamp::new(level(top), level(bottom))
}

impl Default for Limits {
    fn default() -> Self {
        use crate::limits;
        Self {
            ceiling: Irradiance(10_000),
            daily_dose: limits::DAILY_DOSE,
            life_dose: limits::LIFE_DOSE,
            continuous: limits::CONTINUOUS,
            rest: limits::REST,
        }
    }
}

impl Default for LampCalibration {
    /// A lamp of 10 W/m² at full level, driven in proportion to it.
    fn default() -> Self {
        Self {
            full_level: Irradiance(10_000),
            curve: Vec::new(),
            below_floor: BelowFloor::Cut,
            ultraviolet_at_full: Irradiance(0),
        }
    }
}

impl Default for ViewerSettings {
    fn default() -> Self {
        Self {
            sensor: ViewerSensor::Either,
            policy: Policy::First,
            between: Between::Nearest,
            hysteresis: CentiDegrees(400),
            dwell: Milliseconds(600),
            least_hold: Milliseconds(1_500),
            dead_zone: CentiDegrees(500),
            turn: Milliseconds(8_000),
            paging: Paging::Time,
            page: Milliseconds(8_000),
            step: CentiDegrees(600),
            fade: Milliseconds(300),
        }
    }
}

impl Default for PresenceSettings {
    /// 20 s of the last view, 5 min of a tenth of the neutral pair, fades of 2 s.
    fn default() -> Self {
        Self {
            hold: Milliseconds(20_000),
            idle: Milliseconds(300_000),
            fade: Milliseconds(2_000),
            idle_level: Level(6_554),
        }
    }
}

#[cfg(test)]
mod tests;
