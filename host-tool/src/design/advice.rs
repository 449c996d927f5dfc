//! Advice: what to change so that the views show their patterns better, and by how much.
//!
//! Every change is tried on a design in small; its gain is the difference to the same design without it.

use serde::{Serialize, Serializer};
use vitrine_exhibit::units::Lamp;

use super::adapt::adapt;
use super::optimise::Lighting;
use super::request::{DesignError, DesignRequest, Progress, ViewRequest};
use super::scale::reduced;
use super::{Method, design_unwatched};
use crate::optics::Direction;
use crate::picture::Picture;

/// Side, in pixels, of the designs on which changes are tried.
const SIDE_PX: usize = 40;
/// Side, in pixels, of the designs on which the many pairings of pictures and directions are compared.
const PAIRING_SIDE_PX: usize = 24;
/// The most iterations of a design on which a change is tried.
const TRIAL_ITERATIONS: usize = 20;
/// Side, in pixels, of the pictures that are adapted for a trial.
const ADAPTED_SIDE_PX: usize = 256;
/// How similar adapted pictures stay when advice tries them.
const ADAPTED_SIMILARITY: f64 = 0.9;
/// A change that gains less than this, in dB, is not worth a word.
const LEAST_GAIN_DB: f64 = 0.1;
/// Exposures that are tried for each picture, as factors of its light.
const EXPOSURES: [f32; 4] = [0.5, 0.7, 1.4, 2.0];

/// One change with what it is expected to gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// What to change.
    pub change: Change,
    /// What the mean of the views' PSNR gains, in dB, each against its (changed) pattern.
    pub gain_db: f64,
    /// What the least view's PSNR gains, in dB.
    pub least_gain_db: f64,
}

/// A change to an exhibit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Change {
    /// Show the pictures in these directions.
    Directions {
        /// Each view with its direction.
        views: Vec<Placement>,
    },
    /// Let `adapt` fit the pictures to what the stack can show.
    Adapt {
        /// Structural similarity of the adapted pictures to the given ones, mean over views.
        similarity: f64,
    },
    /// Expose pictures anew.
    Exposure {
        /// The views whose exposure changes.
        views: Vec<Exposed>,
    },
    /// Multiply the slopes of all directions.
    Angles {
        /// Each view with its direction.
        views: Vec<Placement>,
    },
    /// Change the gap between two films.
    Spacer {
        /// The new gap in mm.
        spacer_mm: f64,
    },
    /// Want less light for more quality.
    Brightness {
        /// The new `brightness`.
        brightness: f64,
    },
    /// Leave a view out; the gain is that of the others.
    LeaveOut {
        /// The view.
        id: String,
    },
}

/// A view in a direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Placement {
    /// The view's name.
    pub id: String,
    /// Angle to the right of the stack's normal.
    pub horizontal_deg: f64,
    /// Angle above the stack's normal.
    pub vertical_deg: f64,
    /// The only lamp under which it is shown, where its direction has pages.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "by_name")]
    pub lamp: Option<Lamp>,
}

/// The lamp as exhibit.toml names it.
fn name(lamp: Lamp) -> &'static str {
    match lamp {
        Lamp::Top => "top",
        Lamp::Bottom => "bottom",
    }
}

fn by_name<S: Serializer>(lamp: &Option<Lamp>, serializer: S) -> Result<S::Ok, S::Error> {
    lamp.map(name).serialize(serializer)
}

/// A view with a new exposure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exposed {
    /// The view's name.
    pub id: String,
    /// What its light is multiplied by.
    pub factor: f32,
}

/// Tries changes and returns those that gain, the best first.
///
/// # Errors
/// As [`design`](super::design).
pub fn advise(request: &DesignRequest, report: &mut dyn FnMut(Progress)) -> Result<Vec<Advice>, DesignError> {
    request.check()?;
    let mut small = reduced(request, SIDE_PX);
    small.settings.iterations = small.settings.iterations.min(TRIAL_ITERATIONS);
    let (before, lighting) = Outcome::about(&small, &[])?;
    let trial = Trial { before, lighting, small };
    let mut advice = Vec::new();
    let mut tried = |step: usize| report(Progress::at("trying changes", step, 4));
    tried(0);
    advice.extend(trial.directions(request)?);
    tried(1);
    advice.extend(trial.adapted(request)?);
    tried(2);
    advice.extend(trial.exposures()?);
    tried(3);
    advice.extend(trial.angles()?);
    for factor in [1.5, 2.0] {
        let spacer_mm = (request.stack.spacer_mm.max(request.stack.film_mm) * factor * 100.0).round() / 100.0;
        let mut changed = trial.small.clone();
        changed.stack.spacer_mm = spacer_mm;
        advice.extend(trial.of(Change::Spacer { spacer_mm }, &changed)?);
    }
    if request.settings.method != Method::Product {
        let mut changed = trial.small.clone();
        changed.settings.brightness = (request.settings.brightness * 0.6 * 100.0).round().max(1.0) / 100.0;
        let change = Change::Brightness { brightness: changed.settings.brightness };
        advice.extend(trial.of(change, &changed)?);
    }
    advice.extend(trial.leaving_out()?);
    advice.retain(|advice| advice.gain_db >= LEAST_GAIN_DB);
    advice.sort_by(|a, b| b.gain_db.total_cmp(&a.gain_db));
    Ok(advice)
}

/// What a design in small reaches: the PSNR of each view in dB.
struct Outcome(Vec<f64>);

impl Outcome {
    /// What `request` reaches from lightings that are near the best, if any; and its own lighting.
    fn about(request: &DesignRequest, known: &[Lighting]) -> Result<(Self, Option<Lighting>), DesignError> {
        let (design, lighting) = design_unwatched(request, known)?;
        Ok((Self(design.views.iter().map(|view| view.quality.psnr_db).collect()), lighting))
    }

    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len().max(1) as f64
    }

    fn least(&self) -> f64 {
        self.0.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn without(&self, view: usize) -> Self {
        Self(self.0.iter().enumerate().filter(|(index, _)| *index != view).map(|(_, db)| *db).collect())
    }

    fn gain_over(&self, before: &Self, change: Change) -> Advice {
        Advice { change, gain_db: self.mean() - before.mean(), least_gain_db: self.least() - before.least() }
    }
}

/// The request in small, and what it reaches unchanged.
struct Trial {
    small: DesignRequest,
    before: Outcome,
    lighting: Option<Lighting>,
}

impl Trial {
    fn of(&self, change: Change, changed: &DesignRequest) -> Result<Option<Advice>, DesignError> {
        if changed.check().is_err() {
            return Ok(None);
        }
        Ok(Some(self.outcome(changed)?.gain_over(&self.before, change)))
    }

    /// What a changed request reaches, lit much as before.
    fn outcome(&self, changed: &DesignRequest) -> Result<Outcome, DesignError> {
        Ok(Outcome::about(changed, self.lighting.as_slice())?.0)
    }

    /// Finds which picture goes best to which direction, and to which lamp where directions have pages: the two that
    /// gain most change places, as long as any gain.
    fn directions(&self, request: &DesignRequest) -> Result<Option<Advice>, DesignError> {
        let mut coarse = reduced(request, PAIRING_SIDE_PX);
        coarse.settings.iterations = self.small.settings.iterations;
        let views = coarse.views.len();
        let quality = |order: &[usize]| {
            Ok::<_, DesignError>(Outcome::about(&placed(&coarse, order), &self.lit(order))?.0.mean())
        };
        let unchanged: Vec<usize> = (0..views).collect();
        let mut best = (quality(&unchanged)?, unchanged.clone());
        loop {
            let (before, from) = best.clone();
            for (one, other) in twos(views) {
                let mut order = from.clone();
                order.swap(one, other);
                let reached = quality(&order)?;
                if reached > best.0 {
                    best = (reached, order);
                }
            }
            if best.0 <= before {
                break;
            }
        }
        if best.1 == unchanged {
            return Ok(None);
        }
        let changed = placed(&self.small, &best.1);
        let change = Change::Directions { views: placements(&changed.views) };
        let (reached, _) = Outcome::about(&changed, &self.lit(&best.1))?;
        Ok(Some(reached.gain_over(&self.before, change)))
    }

    /// The lamps stay where they are, or go with the pictures.
    fn lit(&self, order: &[usize]) -> Vec<Lighting> {
        let lightings = self.lighting.iter();
        lightings.flat_map(|lighting| [lighting.clone(), lighting.of_views(order)]).collect()
    }

    fn adapted(&self, request: &DesignRequest) -> Result<Option<Advice>, DesignError> {
        let adapted = adapt(&reduced(request, ADAPTED_SIDE_PX), ADAPTED_SIMILARITY, &mut |_| ())?;
        let change = Change::Adapt { similarity: adapted.mean_similarity() };
        self.of(change, &reduced(&adapted.request, SIDE_PX))
    }

    /// Exposes one picture after the other anew, as long as that gains. A darker picture errs less without
    /// being shown better, so errors are held against each picture's own light.
    fn exposures(&self) -> Result<Option<Advice>, DesignError> {
        let loudness =
            |request: &DesignRequest| request.views.iter().map(|view| level_db(&view.pattern)).collect();
        let given: Vec<f64> = loudness(&self.small);
        let judge = |changed: &DesignRequest| {
            let mut outcome = self.outcome(changed)?;
            let levels: Vec<f64> = loudness(changed);
            for ((db, level), given) in outcome.0.iter_mut().zip(levels).zip(&given) {
                *db += level - given;
            }
            Ok::<_, DesignError>(outcome)
        };
        let mut best = (self.before.0.clone(), self.small.clone());
        let mut factors = vec![1.0f32; self.small.views.len()];
        for (index, chosen) in factors.iter_mut().enumerate() {
            let given = self.small.views[index].pattern.clone();
            for factor in EXPOSURES {
                let mut changed = best.1.clone();
                changed.views[index].pattern = exposed(&given, factor);
                let reached = judge(&changed)?;
                if reached.mean() > Outcome(best.0.clone()).mean() {
                    best = (reached.0, changed);
                    *chosen = factor;
                }
            }
        }
        let views: Vec<Exposed> = factors
            .iter()
            .zip(&self.small.views)
            .filter(|(factor, _)| **factor != 1.0)
            .map(|(&factor, view)| Exposed { id: view.id.clone(), factor })
            .collect();
        let change = Change::Exposure { views };
        Ok(factors
            .iter()
            .any(|factor| *factor != 1.0)
            .then(|| Outcome(best.0).gain_over(&self.before, change)))
    }

    /// Opens all angles: slopes half as large again.
    fn angles(&self) -> Result<Option<Advice>, DesignError> {
        let mut changed = self.small.clone();
        for view in &mut changed.views {
            let wider = |degrees: f64| (degrees.to_radians().tan() * 1.5).atan().to_degrees().round();
            let Direction { horizontal_deg, vertical_deg } = view.direction;
            view.direction = Direction::new(wider(horizontal_deg), wider(vertical_deg));
        }
        self.of(Change::Angles { views: placements(&changed.views) }, &changed)
    }

    fn leaving_out(&self) -> Result<Vec<Advice>, DesignError> {
        if self.small.views.len() < 3 {
            return Ok(Vec::new());
        }
        (0..self.small.views.len())
            .map(|index| {
                let mut changed = self.small.clone();
                let left_out = changed.views.remove(index);
                let order: Vec<usize> = (0..self.small.views.len()).filter(|view| *view != index).collect();
                let lit = self.lighting.iter().map(|lighting| lighting.of_views(&order));
                let (reached, _) = Outcome::about(&changed, &lit.collect::<Vec<_>>())?;
                Ok(reached.gain_over(&self.before.without(index), Change::LeaveOut { id: left_out.id }))
            })
            .collect()
    }
}

/// Puts the picture of view `order[i]` into direction i.
fn placed(request: &DesignRequest, order: &[usize]) -> DesignRequest {
    let views = order.iter().zip(&request.views);
    let views = views
        .map(|(&from, place)| ViewRequest {
            direction: place.direction,
            lamp: place.lamp,
            ..request.views[from].clone()
        })
        .collect();
    DesignRequest { views, ..request.clone() }
}

fn placements(views: &[ViewRequest]) -> Vec<Placement> {
    views
        .iter()
        .map(|view| Placement {
            id: view.id.clone(),
            horizontal_deg: view.direction.horizontal_deg,
            vertical_deg: view.direction.vertical_deg,
            lamp: view.lamp,
        })
        .collect()
}

/// Mean square of a picture's values in dB.
fn level_db(picture: &Picture) -> f64 {
    let sum: f64 = picture.values().iter().map(|&value| f64::from(value).powi(2)).sum();
    10.0 * (sum / picture.values().len().max(1) as f64).max(1e-12).log10()
}

fn exposed(picture: &Picture, factor: f32) -> Picture {
    picture.decoded().map(|light| (light * factor).min(1.0)).encoded()
}

/// All choices of two of `count` things.
fn twos(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |first| (first + 1..count).map(move |second| (first, second)))
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let place = |view: &Placement| {
            let lamp = view.lamp.map_or_else(String::new, |lamp| format!(" under the {} lamp", name(lamp)));
            format!("{} to {:.0} deg, {:.0} deg{lamp}", view.id, view.horizontal_deg, view.vertical_deg)
        };
        let list = |views: &[Placement]| views.iter().map(place).collect::<Vec<_>>().join("; ");
        match self {
            Self::Directions { views } => write!(f, "give the pictures other directions: {}", list(views)),
            Self::Adapt { similarity } => {
                write!(
                    f,
                    "set adapt = true in [design]; the pictures keep an SSIM of {similarity:.2} to what they were"
                )
            }
            Self::Exposure { views } => {
                let one = |view: &Exposed| format!("{} x {:.1}", view.id, view.factor);
                let all: Vec<String> = views.iter().map(one).collect();
                write!(f, "expose the pictures anew (light): {}", all.join(", "))
            }
            Self::Angles { views } => write!(f, "open the angles: {}", list(views)),
            Self::Spacer { spacer_mm } => write!(f, "set spacer_mm = {spacer_mm} in [stack]"),
            Self::Brightness { brightness } => {
                write!(f, "set brightness = {brightness} in [design]: less light")
            }
            Self::LeaveOut { id } => write!(f, "leave out {id}; the gain is the other views'"),
        }
    }
}
