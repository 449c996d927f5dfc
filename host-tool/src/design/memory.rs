//! How much memory a design will use, known beforehand.

use super::request::{DesignRequest, DesignSettings, Method, OpticsModel, Tone};
use crate::stack::Stack;
use crate::volume::CHANNELS;

/// Bytes of a value.
const VALUE: f64 = size_of::<f32>() as f64;
/// The program itself with its threads.
const PROGRAM_MIB: f64 = 24.0;
const MIB: f64 = 1024.0 * 1024.0;
/// The coarse films from which the last ones begin, as a part of those.
const COARSE_PART: f64 = 0.25;
/// Pictures of all colours that measuring one view takes beside what it returns.
const MEASURED_PICTURES: f64 = 15.0;
/// Pictures of all colours that every thread above two holds while views are measured: measured with 1 to 16 threads
/// at 400 x 320 to 768 x 768 pixels; more than eight threads find no more to do at once.
const THREAD_PICTURES: f64 = 4.0;
const MOST_BUSY_THREADS: usize = 8;
/// Bytes of a film pixel in its file at most, as a part of the pixel's bytes in the volume.
const FILE_PART: f64 = 0.25;
/// Copies of the films' files, the page with its copies in base64 among them, while the page is made.
const PAGE_COPIES: f64 = 6.5;
/// Larger films, in bytes, are not put in the page.
const MOST_PAGE_BYTES: f64 = 32.0 * MIB;

/// Returns the most memory that designing `request` and writing its build will use, in MiB.
pub fn predicted_memory_mib(request: &DesignRequest) -> f64 {
    let settings = &request.settings;
    let apart = settings.tone == Tone::Code
        && !spreads(&request.stack, settings)
        && (0..request.views.len()).all(|view| request.rays(view).rows_are_apart())
        && request.views.iter().all(|view| view.mask.is_none());
    predicted(&request.stack, settings, request.views.len(), apart)
}

/// As [`predicted_memory_mib`], before the patterns are read: at most so much.
pub fn predicted_memory_mib_of(stack: &Stack, settings: &DesignSettings, views: usize) -> f64 {
    predicted(stack, settings, views, false)
}

/// The volume is there from the optimiser's last stage until its films are encoded; the most is used while it is
/// solved, while the views are measured, or while the page is made.
fn predicted(stack: &Stack, settings: &DesignSettings, views: usize, apart: bool) -> f64 {
    let plane = VALUE * stack.film_len() as f64;
    let picture = CHANNELS as f64 * plane;
    let volume = stack.films as f64 * picture;
    let views = views as f64;
    // Of every view, its pattern, and one colour of it in the values in which films add up.
    let wanted = views * (picture + plane);
    let solver = if apart {
        // Two pictures that move, the structure's weights, and a moment's means of the pattern and its square.
        5.0 * views * plane
    } else {
        solver_volumes(stack, settings) * volume / CHANNELS as f64 + (5.0 * views + 3.0) * plane
    };
    let solving = match settings.method {
        Method::Product => volume,
        Method::LeastSquares => volume + solver.max(COARSE_PART * volume),
    };
    // Of every view, its target and what it shows under either lamp.
    let light = if emits_ink(stack, settings) { 0.0 } else { volume };
    let threads = rayon::current_num_threads().clamp(2, MOST_BUSY_THREADS) - 2;
    let measured = MEASURED_PICTURES + THREAD_PICTURES * threads as f64;
    let measuring = volume + light + 3.0 * views * picture + measured * picture;
    // A copy is measured before levels are chosen.
    let settling = if settings.levels.is_some() { measuring + volume } else { 0.0 };
    let files = FILE_PART * volume;
    let writing =
        (volume + light + files).max(if files > MOST_PAGE_BYTES { files } else { PAGE_COPIES * files });
    let most = [solving + wanted, measuring + wanted, settling + wanted, writing + 1.5 * wanted];
    PROGRAM_MIB + most.into_iter().fold(0.0, f64::max) / MIB
}

/// What the optimiser holds beside the volume, one colour at a time: the look ahead, the steps in half the bytes, the
/// light where it spreads, and the volume after the print's blur where films lie astray beside.
fn solver_volumes(stack: &Stack, settings: &DesignSettings) -> f64 {
    let spread = if spreads(stack, settings) { 1.0 } else { 0.0 };
    let crisp = if is_astray(settings) && stack.blur_um > 0.0 { spread } else { 0.0 };
    1.5 + spread + crisp
}

/// Whether the films' expected light spreads.
fn spreads(stack: &Stack, settings: &DesignSettings) -> bool {
    settings.optics == OpticsModel::Stack && (is_astray(settings) || stack.blur_um > 0.0)
}

fn is_astray(settings: &DesignSettings) -> bool {
    let errors = [
        settings.misplacement_um,
        settings.spacing_um,
        settings.direction_error_deg,
        settings.distance_error_part,
    ];
    errors.iter().any(|error| *error > 0.0)
}

/// Whether the films' light is their ink itself.
fn emits_ink(stack: &Stack, settings: &DesignSettings) -> bool {
    settings.optics == OpticsModel::Ideal
        || (stack.blur_um == 0.0 && stack.ink_absorbance == 0.0 && stack.ink_yields == [1.0; CHANNELS])
}
