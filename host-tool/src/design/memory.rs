//! How much memory a design will use, known beforehand.

use super::request::{DesignRequest, DesignSettings, Method, OpticsModel};
use crate::stack::Stack;
use crate::volume::CHANNELS;

/// Bytes of a value.
const VALUE: f64 = size_of::<f32>() as f64;
/// Values per voxel of one channel that the optimiser holds beside the volume: the look ahead and the steps.
const SOLVER_VALUES: f64 = 2.0;
/// Values that it holds beside them where light spreads: the light, and the volume without the print's blur.
const SPREAD_VALUES: f64 = 1.0;
const CRISP_VALUES: f64 = 1.0;
/// Bytes per voxel that a written film takes at most: its file, and the page's copy of it in base64.
const FILM_BYTES: f64 = 3.0 * (1.0 + 1.0 + 4.0 / 3.0 * 2.0);
/// Values per pixel and channel of one view: its pattern and target, what it shows under either lamp and under
/// three pairs, with room for measures.
const VIEW_VALUES: f64 = 16.0;
/// The program itself with its threads.
const PROGRAM_MIB: f64 = 24.0;
const MIB: f64 = 1024.0 * 1024.0;

/// Returns the most memory that designing `request` and writing its build will use, in MiB.
pub fn predicted_memory_mib(request: &DesignRequest) -> f64 {
    predicted_memory_mib_of(&request.stack, &request.settings, request.views.len())
}

/// As [`predicted_memory_mib`], before the patterns are read.
pub fn predicted_memory_mib_of(stack: &Stack, settings: &DesignSettings, views: usize) -> f64 {
    let pixels = stack.film_len() as f64;
    let voxels = pixels * stack.films as f64;
    let volume = CHANNELS as f64 * VALUE * voxels;
    let solving = match settings.method {
        Method::LeastSquares => solver_values(stack, settings) * VALUE * voxels,
        Method::Product => 0.0,
    };
    let writing = FILM_BYTES * voxels;
    let views = views as f64 * VIEW_VALUES * CHANNELS as f64 * VALUE * pixels;
    PROGRAM_MIB + (volume + solving.max(writing) + views) / MIB
}

fn solver_values(stack: &Stack, settings: &DesignSettings) -> f64 {
    let errors = [
        settings.misplacement_um,
        settings.spacing_um,
        settings.direction_error_deg,
        settings.distance_error_part,
    ];
    let (astray, blurred) = (errors.iter().any(|error| *error > 0.0), stack.blur_um > 0.0);
    let crisp = if astray && blurred { CRISP_VALUES } else { 0.0 };
    match settings.optics {
        OpticsModel::Stack if astray || blurred => SOLVER_VALUES + SPREAD_VALUES + crisp,
        _ => SOLVER_VALUES,
    }
}
