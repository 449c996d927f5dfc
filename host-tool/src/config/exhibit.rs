//! An exhibit as exhibit.toml resolves to: every default filled in, every value checked.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::ink::InkSettings;
use super::object::ObjectSettings;
use super::problem::Problems;
use super::reader::TableReader;

/// Everything exhibit.toml says about one exhibit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exhibit {
    /// The exhibit's name.
    pub name: String,
    /// The films and the gaps between them.
    pub stack: StackSettings,
    /// Where the viewer stands.
    pub viewer: ViewerSettings,
    /// The views, in the order of the file.
    pub views: Vec<ViewSettings>,
    /// The model that stands in the stack, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<ObjectSettings>,
    /// How the volume is computed.
    pub design: DesignSettings,
    /// How the films are printed.
    pub print: PrintSettings,
    /// The two lamps.
    pub lamps: LampSettings,
    /// How viewers are followed.
    pub visitors: VisitorSettings,
    /// What happens when nobody is there.
    pub presence: PresenceSettings,
    /// When the exhibit is lit; always, when empty.
    pub schedule: Vec<ScheduleRule>,
    /// The time zone and the closed days.
    pub calendar: CalendarSettings,
    /// What the stack may be given.
    pub limits: LimitSettings,
}

/// The stack's geometry and absorption.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackSettings {
    /// Number of films.
    pub films: u32,
    /// Width of the picture on a film.
    pub width_mm: f64,
    /// Width and height of a film in pixels.
    pub pixels: [u32; 2],
    /// Thickness of a film.
    pub film_mm: f64,
    /// Thickness of the gap between two films.
    pub spacer_mm: f64,
    /// Refractive index between the films: 1 is air.
    pub index: f64,
    /// Part of the UV that passes a film, 0..=1.
    pub tau_uv: f64,
    /// Part of the visible light that passes a film, 0..=1.
    pub tau_visible: f64,
    /// Part of the UV that passes a spacer, 0..=1.
    pub spacer_tau_uv: f64,
    /// Part of the visible light that passes a spacer, 0..=1.
    pub spacer_tau_visible: f64,
    /// How far the light of a print dot spreads in its film: the standard deviation along each axis.
    pub blur_um: f64,
    /// Light of the red, green and blue ink where they glow alike, 0..=1.
    pub ink_yields: [f64; 3],
    /// Absorbance of full ink for the lamps' ultraviolet, by the natural logarithm.
    pub ink_absorbance: f64,
}

impl StackSettings {
    /// The distance from one film to the next.
    pub fn film_pitch_mm(&self) -> f64 {
        self.film_mm + self.spacer_mm
    }
}

/// Where the viewer stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewerSettings {
    /// Distance of the eye from the middle of the stack; `None` for parallel rays.
    pub distance_mm: Option<f64>,
    /// What a pattern's edges are held to.
    pub frame: FrameSetting,
}

/// What a pattern's edges are held to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameSetting {
    /// The picture fills the film.
    Film,
    /// The picture is resampled so that the oblique viewer sees it undistorted.
    Viewer,
}

/// One `[[view]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewSettings {
    /// The view's name: letters, digits, `-` and `_`, at most 24.
    pub id: String,
    /// The picture, relative to exhibit.toml; `None` for a view of the object alone.
    pub pattern: Option<PathBuf>,
    /// Angle to the right of the stack's normal.
    pub horizontal_deg: f64,
    /// Angle above the stack's normal.
    pub vertical_deg: f64,
    /// How much this view counts against the others.
    pub weight: f64,
    /// Distance of this view's eye from the middle of the stack; `None` for parallel rays.
    pub distance_mm: Option<f64>,
    /// A picture that is bright where errors matter more, relative to exhibit.toml.
    pub mask: Option<PathBuf>,
    /// The only lamp under which this view is shown, where two views share a direction.
    pub lamp: Option<LampSetting>,
}

/// One of the two lamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LampSetting {
    /// The lamp on the viewer's side.
    Top,
    /// The lamp behind the stack.
    Bottom,
}

/// How the volume is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignSettings {
    /// The way from patterns to a volume.
    pub method: MethodSetting,
    /// Which optics the design reckons with.
    pub optics: OpticsSetting,
    /// In which values light adds up.
    pub tone: ToneSetting,
    /// Wanted white as a part of what full ink gives, 0..=1.
    pub brightness: f64,
    /// Expected misplacement of each film along each axis.
    pub misplacement_um: f64,
    /// Expected error of each gap between two films.
    pub spacing_um: f64,
    /// Expected error of the viewer's direction along each axis.
    pub direction_error_deg: f64,
    /// Expected error of the viewer's distance, as a part of it.
    pub distance_error_part: f64,
    /// What is added to the patterns' black before white is brought back to 1: T becomes (T + p) / (1 + p).
    pub pedestal: f64,
    /// The largest ratio between the apparent whites of two views.
    pub white_ratio: f64,
    /// How much the optimiser looks at structure beside the squared error; what suits the tone where left out.
    pub structure: Option<f64>,
    /// How much more the worse views count, 0..=1.
    pub balance: f64,
    /// The most iterations of the optimiser.
    pub iterations: u32,
    /// The optimiser stops when ten iterations gain less than this.
    pub tolerance_db: f64,
    /// The most memory that a design may use; `None` for as much as there is.
    pub memory_mib: Option<u32>,
    /// Whether the pictures are adapted to each other before they are designed for.
    pub adapt: bool,
    /// The structural similarity that an adapted picture keeps to the given one, 0..=1.
    pub adapt_similarity: f64,
}

/// The way from patterns to a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MethodSetting {
    /// Bounded least squares.
    LeastSquares,
    /// The product of the patterns, Eq. 1 of the paper.
    Product,
}

/// Which optics the design reckons with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OpticsSetting {
    /// Films absorb, as `[stack]` says.
    Stack,
    /// No absorption, as in the paper's simulation.
    Ideal,
}

/// In which values light adds up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToneSetting {
    /// Patterns are decoded from sRGB to linear light.
    Linear,
    /// Code values add up, as in the paper.
    Code,
}

/// How the films are printed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrintSettings {
    /// Dots per inch along the film's width.
    pub dpi_x: f64,
    /// Dots per inch along the film's height.
    pub dpi_y: f64,
    /// Names of the three fluorescent inks, for R, G and B.
    pub inks: [String; 3],
    /// The ink levels that the printer lays at a dot, from none to full; `None` for any.
    pub levels: Option<u16>,
    /// Whether registration marks are printed.
    pub marks: bool,
    /// The paper to print on, by its name.
    pub paper: String,
    /// How film values become ink.
    pub ink: InkSettings,
    /// Whether sheets are printed mirrored, on the back of the film.
    pub mirrored: bool,
    /// Diameter of the pins that hold the films.
    pub pin_mm: f64,
    /// What full ink of one channel takes: 1,440 x 720 drops an inch of 6 pl, which is assumed, lay 9.6 ml/m2.
    pub ink_ml_m2: f64,
}

impl Default for PrintSettings {
    /// As where exhibit.toml says nothing.
    fn default() -> Self {
        super::tables::print(TableReader::new("[print]", None, 0..0), Path::new(""), &mut Problems::default())
    }
}

/// The two lamps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LampSettings {
    /// Irradiance of one lamp at full level on the nearest film, measured at commissioning.
    pub irradiance_w_m2: f64,
    /// The most irradiance of one lamp.
    pub ceiling_w_m2: f64,
    /// The driver's curve: pairs of duty and level, both 0..=1, rising; linear when empty.
    pub calibration: Vec<[f64; 2]>,
    /// What is done with duties below the driver's floor of 1 %.
    pub below_floor: BelowFloorSetting,
    /// What the ultraviolet sensor reads under the top lamp alone and under the bottom lamp alone at full level; `None`
    /// where it was not measured: the lamps' light is not watched then.
    pub ultraviolet_at_full_w_m2: Option<[f64; 2]>,
}

/// What is done with duties below the driver's floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BelowFloorSetting {
    /// The lamp is off.
    Cut,
    /// The floor's duty is given now and then, so that the mean is right.
    Dither,
}

/// How viewers are followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VisitorSettings {
    /// Which sensors tell where viewers stand.
    pub sensor: SensorSetting,
    /// Whose view is shown where several viewers stand at different views.
    pub policy: PolicySetting,
    /// What happens to the lamps while a viewer walks from one view to the next.
    pub between: BetweenSetting,
    /// How much nearer another view must be before it is chosen.
    pub hysteresis_deg: f64,
    /// How long it must have been nearer.
    pub dwell_s: f64,
    /// The least time that a chosen view is kept.
    pub least_hold_s: f64,
    /// Within this angle of an axis the choice between views on either side of it does not change.
    pub dead_zone_deg: f64,
    /// How long each viewer's view is shown where they alternate.
    pub turn_s: f64,
    /// What turns the pages of a direction: two views under a lamp each.
    pub paging: PagingSetting,
    /// How long a page is shown where time turns it.
    pub page_s: f64,
    /// How far the viewer has to move to the side where a step turns the page.
    pub step_deg: f64,
    /// The time of a change from one lamp pair to another, over the whole range.
    pub fade_s: f64,
}

/// What turns the pages of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PagingSetting {
    /// Time.
    Time,
    /// The viewer's step to the side.
    Step,
}

/// Which sensors tell where viewers stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SensorSetting {
    /// The thermal pair; the radar stands in where it is lost or not fitted.
    Either,
    /// The thermal pair alone.
    Thermal,
    /// The radar alone.
    Radar,
}

/// Whose view is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PolicySetting {
    /// Who has been there longest.
    First,
    /// Who stands nearest.
    Nearest,
    /// All: one lamp pair for all their views.
    Shared,
    /// Each in turn.
    Alternating,
}

/// What happens between views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BetweenSetting {
    /// The nearest view's pair is kept until another is nearer.
    Nearest,
    /// The pair follows the viewer on a smooth path.
    Smooth,
}

/// What happens when nobody is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PresenceSettings {
    /// How long the last view is kept after the last viewer has gone.
    pub hold_s: f64,
    /// How long the idle glow is kept after that; then dark.
    pub idle_s: f64,
    /// The time of the fade to the idle glow and to dark, over the whole range.
    pub fade_s: f64,
    /// The part of the neutral pair that is the idle glow, 0..=1.
    pub idle_level: f64,
    /// For how many hours of a day somebody is expected before the exhibit; `None` where nobody can tell.
    pub expected_h_a_day: Option<f64>,
}

/// A rule that lights the exhibit on some days from one time to another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduleRule {
    /// Monday to Sunday: whether the rule holds on that day.
    pub days: [bool; 7],
    /// Start, in minutes after local midnight.
    pub from_minute: u16,
    /// End, in minutes after local midnight; at or before the start, it is on the next day.
    pub to_minute: u16,
    /// First day on which the rule holds.
    pub first: Option<jiff::civil::Date>,
    /// Last day on which the rule holds.
    pub last: Option<jiff::civil::Date>,
    /// The part of the light that is given, 0..=1.
    pub level: f64,
}

/// The time zone and the closed days.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalendarSettings {
    /// A name of the IANA time zone database.
    pub time_zone: String,
    /// Days on which the exhibit stays dark.
    pub closed: Vec<jiff::civil::Date>,
}

/// What the stack may be given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitSettings {
    /// The most dose of one lamp in a day.
    pub daily_dose_j_m2: f64,
    /// The most dose of one lamp in the stack's life.
    pub life_dose_j_m2: f64,
    /// The longest time lit without a rest.
    pub continuous_s: f64,
    /// The rest after it.
    pub rest_s: f64,
}
