//! Advice: what to change so that the views show their patterns better, and by how much.
//!
//! Every change is tried on a design in small; its gain is the difference to the same design without it.

use serde::Serialize;

use super::adapt::adapt;
use super::request::{DesignError, DesignRequest, ViewRequest};
use super::scale::reduced;
use super::{Method, design};
use crate::optics::Direction;
use crate::picture::Picture;

/// Side, in pixels, of the designs on which changes are tried.
const SIDE_PX: usize = 40;
/// Side, in pixels, of the designs on which the many pairings of pictures and directions are compared.
const PAIRING_SIDE_PX: usize = 24;
/// Up to this many views every pairing is tried; beyond it, pictures are swapped two by two.
const MOST_VIEWS_PERMUTED: usize = 4;
/// The most iterations of a design on which a change is tried.
const TRIAL_ITERATIONS: usize = 60;
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
/// As [`design`].
pub fn advise(request: &DesignRequest) -> Result<Vec<Advice>, DesignError> {
    request.check()?;
    let mut small = reduced(request, SIDE_PX);
    small.settings.iterations = small.settings.iterations.min(TRIAL_ITERATIONS);
    let trial = Trial { before: Outcome::of(&small)?, small };
    let mut advice = Vec::new();
    advice.extend(trial.directions(request)?);
    advice.extend(trial.adapted(request)?);
    advice.extend(trial.exposures()?);
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
    fn of(request: &DesignRequest) -> Result<Self, DesignError> {
        let design = design(request, &mut |_| ())?;
        Ok(Self(design.views.iter().map(|view| view.quality.psnr_db).collect()))
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
}

impl Trial {
    fn of(&self, change: Change, changed: &DesignRequest) -> Result<Option<Advice>, DesignError> {
        if changed.check().is_err() {
            return Ok(None);
        }
        Ok(Some(Outcome::of(changed)?.gain_over(&self.before, change)))
    }

    /// Finds which picture goes best to which direction.
    fn directions(&self, request: &DesignRequest) -> Result<Option<Advice>, DesignError> {
        let mut coarse = reduced(request, PAIRING_SIDE_PX);
        coarse.settings.iterations = self.small.settings.iterations;
        let views = coarse.views.len();
        let quality = |order: &[usize]| Ok::<_, DesignError>(Outcome::of(&placed(&coarse, order))?.mean());
        let unchanged: Vec<usize> = (0..views).collect();
        let mut best = (quality(&unchanged)?, unchanged.clone());
        let candidates = if views <= MOST_VIEWS_PERMUTED { permutations(views) } else { swaps(views) };
        for order in candidates {
            let reached = quality(&order)?;
            if reached > best.0 {
                best = (reached, order);
            }
        }
        if best.1 == unchanged {
            return Ok(None);
        }
        let changed = placed(&self.small, &best.1);
        self.of(Change::Directions { views: placements(&changed.views) }, &changed)
    }

    fn adapted(&self, request: &DesignRequest) -> Result<Option<Advice>, DesignError> {
        let adapted = adapt(request, ADAPTED_SIMILARITY, &mut |_| ())?;
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
            let mut outcome = Outcome::of(changed)?;
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
                let reached = Outcome::of(&changed)?;
                Ok(reached.gain_over(&self.before.without(index), Change::LeaveOut { id: left_out.id }))
            })
            .collect()
    }
}

/// Puts the picture of view `order[i]` into direction i.
fn placed(request: &DesignRequest, order: &[usize]) -> DesignRequest {
    let views = order.iter().zip(&request.views);
    let views = views
        .map(|(&from, place)| ViewRequest { direction: place.direction, ..request.views[from].clone() })
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

/// All orders of `count` things but the first one, in which nothing moves.
fn permutations(count: usize) -> Vec<Vec<usize>> {
    let mut orders = vec![Vec::new()];
    for _ in 0..count {
        orders = orders
            .into_iter()
            .flat_map(|order: Vec<usize>| {
                let rest: Vec<usize> = (0..count).filter(|next| !order.contains(next)).collect();
                rest.into_iter().map(move |next| [order.clone(), vec![next]].concat())
            })
            .collect();
    }
    orders.remove(0);
    orders
}

/// All orders in which two of `count` things change places.
fn swaps(count: usize) -> Vec<Vec<usize>> {
    let mut orders = Vec::new();
    for first in 0..count {
        for second in first + 1..count {
            let mut order: Vec<usize> = (0..count).collect();
            order.swap(first, second);
            orders.push(order);
        }
    }
    orders
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let place = |view: &Placement| {
            format!("{} to {:.0} deg, {:.0} deg", view.id, view.horizontal_deg, view.vertical_deg)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_tried_once_and_the_unchanged_one_not_at_all() {
        let mut orders = permutations(4);
        assert_eq!(orders.len(), 23);
        orders.sort();
        orders.dedup();
        assert_eq!(orders.len(), 23);
        assert!(!orders.contains(&vec![0, 1, 2, 3]));
        assert_eq!(swaps(5).len(), 10);
    }
}
