//! What is asked of the design engine.

use std::borrow::Cow;

use thiserror::Error;

use vitrine_exhibit::units::Lamp;

use super::as_built::HandErrors;
use super::stop::Stop;
use crate::emission::Emission;
use crate::optics::{Direction, LampPair};
use crate::picture::{Picture, srgb_decode};
use crate::projection::{Rays, ViewerDistance};
use crate::stack::{Stack, StackError};
use crate::volume::InkDepth;

/// How the volume is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The bounded optimiser: the ink in 0..=1 whose views differ least from their patterns.
    #[default]
    LeastSquares,
    /// The paper's Eq. 1: every voxel is the product of the patterns' pixels on whose rays it lies.
    Product,
}

/// Which optics the design reckons with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpticsModel {
    /// The stack's own: films and spacers absorb UV and visible light, and lamps stand on either side.
    #[default]
    Stack,
    /// The paper's simulation: nothing absorbs, every film has the weight 1.
    Ideal,
}

/// In which values films add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Light adds up: patterns are decoded from sRGB, and what is seen is encoded again.
    #[default]
    Linear,
    /// Code values add up, as in the paper.
    Code,
}

impl Tone {
    /// The weight of structure along rows of code values, where every row is a problem of its own.
    pub const ROW_STRUCTURE: f64 = 0.5;

    /// The weight of structure at which similarity gains most and the squared error loses less than 0.1 dB: light
    /// needs more, for dark specks cost it little.
    pub fn structure(self) -> f64 {
        match self {
            Self::Linear => 6.0,
            Self::Code => 1.0,
        }
    }
}

/// One view: a direction with its pattern.
#[derive(Clone, Debug)]
pub struct ViewRequest {
    /// The view's name.
    pub id: String,
    /// The picture to show, sRGB code values, as large as a film.
    pub pattern: Picture,
    /// The viewer's direction.
    pub direction: Direction,
    /// How much this view's errors count beside the others', greater than 0.
    pub weight: f64,
    /// How far this view's viewer stands; `None` for the request's distance.
    pub distance: Option<ViewerDistance>,
    /// How much each pixel's errors count beside the others', 0..=1 (row, column), as many as the pattern has
    /// pixels; `None` where all count alike. See [`ViewRequest::pixel_weights`].
    pub mask: Option<Vec<f32>>,
    /// The only lamp under which this view is shown, where two views share a direction; `None` for the pair
    /// that shows it best.
    pub lamp: Option<Lamp>,
}

/// What black in a mask counts as a part of white: places without any weight would fill with anything.
const LEAST_WEIGHT: f32 = 0.1;

/// Everything the design depends on.
#[derive(Clone, Debug)]
pub struct DesignRequest {
    /// The stack.
    pub stack: Stack,
    /// The viewer's distance from the middle of the stack.
    pub distance: ViewerDistance,
    /// The views, at least one.
    pub views: Vec<ViewRequest>,
    /// How to design.
    pub settings: DesignSettings,
    /// Asks the design to stop.
    pub stop: Stop,
}

/// Settings of the design; `Default` is what exhibit.toml leaves out.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignSettings {
    /// How the volume is computed.
    pub method: Method,
    /// Which optics are reckoned with.
    pub optics: OpticsModel,
    /// In which values films add up.
    pub tone: Tone,
    /// Wanted white, as a part of what full ink on every film gives under the view's own lamps, 0..=1.
    pub brightness: f64,
    /// Expected error of each film's place along each axis, in µm; like the next three the standard deviation of a
    /// normal error, and not reckoned with under ideal optics.
    pub misplacement_um: f64,
    /// Expected error of each gap between two films, in µm.
    pub spacing_um: f64,
    /// Expected error of the viewer's direction along each axis, in degrees.
    pub direction_error_deg: f64,
    /// Expected error of the viewer's distance, as a part of it; nothing for parallel rays.
    pub distance_error_part: f64,
    /// The largest ratio between the apparent whites of two views; brighter views' lamps are dimmed to keep it.
    pub white_ratio: f64,
    /// How much the optimiser looks at structure beside the squared error, 0 or greater; `None` for what suits:
    /// [`Tone::structure`], or [`Tone::ROW_STRUCTURE`] where every row of code values is a problem of its own. There
    /// structure is looked at along rows alone, so that they stay apart.
    pub structure: Option<f64>,
    /// How much more the worse views count, 0..=1: 0 is the least error in all, 1 much the same in each.
    pub balance: f64,
    /// The optimiser stops when ten iterations gain less than this, in dB.
    pub tolerance_db: f64,
    /// The most iterations of the optimiser.
    pub iterations: usize,
    /// The evenly spaced ink levels that the printer knows, 2 or more; `None` for any ink.
    pub levels: Option<u16>,
    /// Bits in which the volume is written.
    pub ink_depth: InkDepth,
}

impl Default for DesignSettings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            optics: OpticsModel::default(),
            tone: Tone::default(),
            brightness: 0.4,
            misplacement_um: 68.0,
            // Acrylic sheet of half a millimetre is sold within a tenth of its thickness: two standard deviations.
            spacing_um: 25.0,
            // Who leans from one foot to the other moves by some 20 mm at arm's length.
            direction_error_deg: 1.0,
            // Visitors keep a distance within a fifth: two standard deviations.
            distance_error_part: 0.1,
            white_ratio: 2.0,
            structure: None,
            balance: 0.15,
            tolerance_db: 0.05,
            iterations: 120,
            levels: None,
            ink_depth: InkDepth::default(),
        }
    }
}

/// How far a design is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: &'static str,
    /// Steps done in this stage.
    pub done: usize,
    /// Steps of this stage, at most.
    pub total: usize,
    /// Mean quality of the views so far in dB, where it is known.
    pub quality_db: Option<f64>,
    /// What the last ten iterations of the optimiser have gained of it in dB.
    pub gained_db: Option<f64>,
}

impl Progress {
    /// So many steps of a stage are done, and the quality is not known.
    pub fn at(stage: &'static str, done: usize, total: usize) -> Self {
        Self { stage, done, total, quality_db: None, gained_db: None }
    }

    /// As this, with the mean quality of the views.
    pub fn reaching(self, quality_db: f64) -> Self {
        Self { quality_db: Some(quality_db), ..self }
    }
}

/// Why there is no design.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DesignError {
    /// The stack is impossible.
    #[error("[stack] {0}")]
    Stack(#[from] StackError),
    /// There is nothing to show.
    #[error("there is no view; add a [[view]] with an id, a pattern and its angles")]
    NoViews,
    /// A view's pattern has another size than the films.
    #[error(
        "the pattern of view {id} has {found_width} x {found_height} pixels, but the films have \
         {width} x {height}; read it with this size"
    )]
    PatternSize {
        /// The view.
        id: String,
        /// Columns of the pattern.
        found_width: usize,
        /// Rows of the pattern.
        found_height: usize,
        /// Columns of the films.
        width: usize,
        /// Rows of the films.
        height: usize,
    },
    /// A view's mask has another size than the films.
    #[error("the mask of view {id} has {found} pixels, but the films have {wanted}; read it with their size")]
    MaskSize {
        /// The view.
        id: String,
        /// Pixels of the mask.
        found: usize,
        /// Pixels of a film.
        wanted: usize,
    },
    /// A number of a view or of the settings is out of its range.
    #[error("{field} of {place} is {value}, but must be {allowed}")]
    Range {
        /// The field, by its name in exhibit.toml.
        field: &'static str,
        /// The view or table it stands in.
        place: String,
        /// The value it has.
        value: f64,
        /// The values it may have, in words.
        allowed: &'static str,
    },
    /// The request's [`Stop`] was asked.
    #[error("the design was stopped")]
    Stopped,
}

impl DesignRequest {
    /// Checks that the request can be met.
    ///
    /// # Errors
    /// Names the first field that stands against it.
    pub fn check(&self) -> Result<(), DesignError> {
        let stack = self.stack.clone().checked()?;
        if self.views.is_empty() {
            return Err(DesignError::NoViews);
        }
        for view in &self.views {
            view.check(&stack)?;
        }
        self.settings.check()?;
        check_distance(&stack, self.distance, || "[viewer]".into())
    }

    /// Ends what is done for this request, where it is asked to stop.
    pub(super) fn go_on(&self) -> Result<(), DesignError> {
        if self.stop.is_asked() { Err(DesignError::Stopped) } else { Ok(()) }
    }

    /// Returns the rays of the view of this index from its viewer's eye through the stack.
    pub fn rays(&self, view: usize) -> Rays {
        self.misplaced_rays(view, &[])
    }

    /// As [`DesignRequest::rays`], with film k moved by `shifts_mm[k]` (x to the right, y up).
    pub fn misplaced_rays(&self, view: usize, shifts_mm: &[(f64, f64)]) -> Rays {
        let view = &self.views[view];
        Rays::misplaced(&self.stack, view.direction, view.distance.unwrap_or(self.distance), shifts_mm)
    }

    /// As [`DesignRequest::rays`], for a view that need not be one of the request's.
    pub(super) fn rays_of(&self, view: &ViewRequest) -> Rays {
        Rays::misplaced(&self.stack, view.direction, view.distance.unwrap_or(self.distance), &[])
    }

    /// Returns how the films turn ink into light, in the optics of the design.
    pub fn emission(&self) -> Emission {
        match self.settings.optics {
            OpticsModel::Stack => Emission::of(&self.stack),
            OpticsModel::Ideal => Emission::default(),
        }
    }

    /// Returns one channel of each pattern in the values in which films add up.
    pub(super) fn channel_targets(&self, channel: usize) -> Vec<Cow<'_, [f32]>> {
        let codes = self.views.iter().map(|view| view.pattern.channel(channel));
        match self.settings.tone {
            Tone::Linear => {
                codes.map(|codes| codes.iter().map(|&code| srgb_decode(code)).collect()).collect()
            }
            Tone::Code => codes.map(Cow::Borrowed).collect(),
        }
    }

    /// Returns the patterns in the values in which films add up.
    pub fn targets(&self) -> Vec<Picture> {
        self.views.iter().map(|view| self.target(view).into_owned()).collect()
    }

    /// Returns a view's pattern in the values in which films add up.
    pub(super) fn target<'a>(&self, view: &'a ViewRequest) -> Cow<'a, Picture> {
        match self.settings.tone {
            Tone::Linear => Cow::Owned(view.pattern.decoded()),
            Tone::Code => Cow::Borrowed(&view.pattern),
        }
    }
}

impl ViewRequest {
    /// An ordinary view of weight 1: at the request's distance, without a mask, under the pair that shows it best.
    pub fn new(id: impl Into<String>, pattern: Picture, direction: Direction) -> Self {
        Self { id: id.into(), pattern, direction, weight: 1.0, distance: None, mask: None, lamp: None }
    }

    /// The lamp pair that the view is held to, where it is.
    pub fn held_pair(&self) -> Option<LampPair> {
        self.lamp.map(|lamp| match lamp {
            Lamp::Top => LampPair::TOP,
            Lamp::Bottom => LampPair::BOTTOM,
        })
    }

    /// Returns what the errors of each pixel count, 1 in the mean, where there is a mask: white counts ten times
    /// as much as black.
    pub fn pixel_weights(&self) -> Option<Vec<f32>> {
        let share = self.mask_share() as f32;
        Some(self.mask.as_ref()?.iter().map(|value| share * mask_weight(value)).collect())
    }

    /// What the weights of the mask's pixels are multiplied by, so that they are 1 in the mean; 1 without a mask.
    pub(super) fn mask_share(&self) -> f64 {
        let Some(mask) = &self.mask else { return 1.0 };
        let sum: f64 = mask.iter().map(|value| f64::from(mask_weight(value))).sum();
        mask.len() as f64 / sum.max(1e-9)
    }

    fn check(&self, stack: &Stack) -> Result<(), DesignError> {
        let range = |field, value, allowed| {
            Err(DesignError::Range { field, place: format!("view {}", self.id), value, allowed })
        };
        if (self.pattern.width(), self.pattern.height()) != (stack.width_px, stack.height_px) {
            return Err(DesignError::PatternSize {
                id: self.id.clone(),
                found_width: self.pattern.width(),
                found_height: self.pattern.height(),
                width: stack.width_px,
                height: stack.height_px,
            });
        }
        let Direction { horizontal_deg, vertical_deg } = self.direction;
        for (field, value) in [("horizontal_deg", horizontal_deg), ("vertical_deg", vertical_deg)] {
            if !(-80.0..=80.0).contains(&value) {
                return range(field, value, "-80 to 80");
            }
        }
        if !(self.weight > 0.0 && self.weight.is_finite()) {
            return range("weight", self.weight, "greater than 0");
        }
        match &self.mask {
            Some(mask) if mask.len() != stack.film_len() => {
                return Err(DesignError::MaskSize {
                    id: self.id.clone(),
                    found: mask.len(),
                    wanted: stack.film_len(),
                });
            }
            _ => {}
        }
        self.distance
            .map_or(Ok(()), |distance| check_distance(stack, distance, || format!("view {}", self.id)))
    }
}

/// The weight of a pixel where the mask has this value.
fn mask_weight(value: &f32) -> f32 {
    LEAST_WEIGHT + (1.0 - LEAST_WEIGHT) * value.clamp(0.0, 1.0)
}

fn check_distance(
    stack: &Stack,
    distance: ViewerDistance,
    place: impl FnOnce() -> String,
) -> Result<(), DesignError> {
    match distance {
        ViewerDistance::Millimetres(value) if !(value.is_finite() && value > stack.depth_mm()) => {
            let allowed = "\"parallel\", or greater than the depth of the stack";
            Err(DesignError::Range { field: "distance_mm", place: place(), value, allowed })
        }
        _ => Ok(()),
    }
}

impl DesignSettings {
    /// The settings for a design that expects these errors of hands and viewers.
    pub fn expecting(self, errors: HandErrors) -> Self {
        Self {
            misplacement_um: errors.misplacement_um,
            spacing_um: errors.spacing_um,
            direction_error_deg: errors.direction_deg,
            distance_error_part: errors.distance_part,
            ..self
        }
    }

    fn check(&self) -> Result<(), DesignError> {
        let range = |field, value, allowed| {
            Err(DesignError::Range { field, place: "[design]".into(), value, allowed })
        };
        if !(self.brightness > 0.0 && self.brightness <= 1.0) {
            return range("brightness", self.brightness, "greater than 0 and at most 1");
        }
        if !(0.0..=10_000.0).contains(&self.misplacement_um) {
            return range("misplacement_um", self.misplacement_um, "0 to 10000");
        }
        if !(0.0..=10_000.0).contains(&self.spacing_um) {
            return range("spacing_um", self.spacing_um, "0 to 10000");
        }
        if !(0.0..=20.0).contains(&self.direction_error_deg) {
            return range("direction_error_deg", self.direction_error_deg, "0 to 20");
        }
        if !(0.0..=0.3).contains(&self.distance_error_part) {
            return range("distance_error_part", self.distance_error_part, "0 to 0.3");
        }
        if !(self.white_ratio >= 1.0 && self.white_ratio <= 1000.0) {
            return range("white_ratio", self.white_ratio, "1 to 1000");
        }
        if let Some(structure) = self.structure.filter(|structure| !(0.0..=100.0).contains(structure)) {
            return range("structure", structure, "0 to 100");
        }
        if !(0.0..=1.0).contains(&self.balance) {
            return range("balance", self.balance, "0 to 1");
        }
        if !(self.tolerance_db > 0.0 && self.tolerance_db <= 10.0) {
            return range("tolerance_db", self.tolerance_db, "greater than 0 and at most 10");
        }
        if !(1..=100_000).contains(&self.iterations) {
            return range("iterations", self.iterations as f64, "1 to 100000");
        }
        Ok(())
    }
}
