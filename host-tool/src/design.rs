//! The design engine: from patterns to a volume, and to the lamps that show each view at its best.
//!
//! [`design`] takes a [`DesignRequest`] (the stack, the views with their patterns, settings) and returns a
//! [`Design`]: the volume as it will be written, each view's emphasis, and what each view shows with its
//! measures. It does no input or output.

mod adapt;
mod advice;
mod as_built;
mod compatibility;
mod divergence;
mod emphasis;
mod fixed;
mod frontier;
mod halftone;
mod joint;
mod least_squares;
mod memory;
mod optimise;
mod pedestal;
mod product;
mod request;
mod result;
mod robust;
mod scale;
mod sixteen;
mod stop;
mod strips;
mod structure;

pub use adapt::{Adapted, adapt};
pub use advice::{Advice, Change, Exposed, Placement, advise};
pub use as_built::{AsBuilt, HandErrors, SEED, STACKS, ViewAsBuilt, as_built, built_by_hand, misplacements};
pub use compatibility::{Prediction, SharedDetail, ViewPrediction, predict};
pub use emphasis::{LampSums, pair_for_all};
pub use fixed::FixedInk;
pub use frontier::{FrontierPoint, frontier};
pub use memory::{predicted_memory_mib, predicted_memory_mib_of};
pub use pedestal::lifted;
pub use product::product;
pub use request::{
    DesignError, DesignRequest, DesignSettings, Method, OpticsModel, Progress, Tone, ViewRequest,
};
pub use result::{Design, SharedPair, ViewDesign};
pub use stop::Stop;
pub use strips::{PictureRows, Strip, StripDesign, StripRequest, rows_within};

use crate::volume::Volume;
use optimise::Lighting;

/// Designs the volume and the lamp pairs that the request asks for; `report` is told how far it is.
///
/// # Errors
/// When the request cannot be met as it stands, with the field and the remedy, and when it is asked to stop.
pub fn design(request: &DesignRequest, report: &mut dyn FnMut(Progress)) -> Result<Design, DesignError> {
    Ok(design_about(request, None, &[], report)?.0)
}

/// As [`design`], around ink that stays as it is; the patterns must show it where it is seen.
///
/// # Errors
/// As [`design`].
pub fn design_around(
    request: &DesignRequest,
    fixed: Option<&FixedInk>,
    report: &mut dyn FnMut(Progress),
) -> Result<Design, DesignError> {
    Ok(design_about(request, fixed, &[], report)?.0)
}

/// As [`design_about`], where nobody watches: on a thread of the pool, which need not wait for the others every time
/// that work is shared.
fn design_unwatched(
    request: &DesignRequest,
    known: &[Lighting],
) -> Result<(Design, Option<Lighting>), DesignError> {
    rayon::scope(|_| design_about(request, None, known, &mut |_| ()))
}

/// As [`design_around`], from lightings that are known to be near the best, if any; returns the one that was found,
/// where lighting is part of the method.
fn design_about(
    request: &DesignRequest,
    fixed: Option<&FixedInk>,
    known: &[Lighting],
    report: &mut dyn FnMut(Progress),
) -> Result<(Design, Option<Lighting>), DesignError> {
    request.check()?;
    let (mut volume, lighting) = match request.settings.method {
        Method::Product => (product(request, report), None),
        Method::LeastSquares => {
            let (volume, lighting) = joint::solve(request, fixed, known, report);
            (volume, Some(lighting))
        }
    };
    request.go_on()?;
    if let Some(fixed) = fixed {
        fixed.put_into(&mut volume);
    }
    if let Some(levels) = request.settings.levels {
        halftone::halftone(request, &mut volume, fixed, levels, report);
    }
    Ok((finish(request, volume, report)?, lighting))
}

/// Finds the lamps for a volume that is given in what the printer lays, and measures what it shows beside the patterns.
///
/// # Errors
/// As [`design`].
pub fn show(
    request: &DesignRequest,
    volume: Volume,
    report: &mut dyn FnMut(Progress),
) -> Result<Design, DesignError> {
    request.check()?;
    finish(request, volume, report)
}

/// Brings the volume to what is written, finds its lamps and measures it.
fn finish(
    request: &DesignRequest,
    mut volume: Volume,
    report: &mut dyn FnMut(Progress),
) -> Result<Design, DesignError> {
    volume.quantise(request.settings.ink_depth);
    request.go_on()?;
    report(Progress::at("measuring the views", 0, 1));
    let design = Design::of(request, volume);
    request.go_on()?;
    Ok(design)
}
