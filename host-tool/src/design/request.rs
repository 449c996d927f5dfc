//! What is asked of the design engine.

use thiserror::Error;

use crate::optics::Direction;
use crate::picture::Picture;
use crate::projection::ViewerDistance;
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
}

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
    /// Expected error of each film's place along each axis, in µm; not reckoned with under ideal optics.
    pub misplacement_um: f64,
    /// How much the optimiser looks at structure beside the squared error, 0 or greater; 1 is balanced.
    pub structure: f64,
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
            structure: 1.0,
            balance: 0.15,
            tolerance_db: 0.05,
            iterations: 40,
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
}

/// Why a request cannot be met.
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
        if let ViewerDistance::Millimetres(distance) = self.distance {
            let least = stack.depth_mm();
            if !(distance.is_finite() && distance > least) {
                return Err(DesignError::Range {
                    field: "distance_mm",
                    place: "[viewer]".into(),
                    value: distance,
                    allowed: "\"parallel\", or greater than the depth of the stack",
                });
            }
        }
        Ok(())
    }

    /// Returns the patterns in the values in which films add up.
    pub fn targets(&self) -> Vec<Picture> {
        let tone = self.settings.tone;
        let target = |view: &ViewRequest| match tone {
            Tone::Linear => view.pattern.decoded(),
            Tone::Code => view.pattern.clone(),
        };
        self.views.iter().map(target).collect()
    }
}

impl ViewRequest {
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
        Ok(())
    }
}

impl DesignSettings {
    fn check(&self) -> Result<(), DesignError> {
        let range = |field, value, allowed| {
            Err(DesignError::Range { field, place: "[design]".into(), value, allowed })
        };
        if !(self.brightness > 0.0 && self.brightness <= 1.0) {
            return range("brightness", self.brightness, "greater than 0 and at most 1");
        }
        if !(self.misplacement_um >= 0.0 && self.misplacement_um <= 10_000.0) {
            return range("misplacement_um", self.misplacement_um, "0 to 10000");
        }
        if !(self.structure >= 0.0 && self.structure <= 100.0) {
            return range("structure", self.structure, "0 to 100");
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
