//! How much memory a design will use, known beforehand.

use super::joint;
use super::request::{DesignRequest, DesignSettings, Method, OpticsModel, Tone};
use crate::stack::Stack;
use crate::volume::CHANNELS;

/// Bytes of a value.
const VALUE: f64 = size_of::<f32>() as f64;
/// The program itself with its threads.
const PROGRAM_MIB: f64 = 24.0;
const MIB: f64 = 1024.0 * 1024.0;
/// Pictures of all colours that measuring one view takes beside what it returns, with what the program keeps of memory
/// that it has used before.
const MEASURED_PICTURES: f64 = 12.0;
/// Pictures of all colours that every thread above two holds.
const THREAD_PICTURES: f64 = 1.0;
/// What the system has not had back of the solver's memory, at most, when the colours are put together.
const KEPT_MIB: f64 = 24.0;
/// More threads than this find no more to do at once.
const MOST_BUSY_THREADS: usize = 8;
/// Bytes of a film pixel in its file at most, as a part of the pixel's bytes in the volume.
const FILE_PART: f64 = 0.25;
/// Copies of the films' files while the page is made: they themselves, and the page with them in base64 as it grows.
const PAGE_COPIES: f64 = 5.0;
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

/// The most is used while the lamps are settled on smaller films, while one colour is solved and the others wait, when all
/// are put together, while the views are measured, or while films and page are written.
fn predicted(stack: &Stack, settings: &DesignSettings, views: usize, apart: bool) -> f64 {
    let plane = VALUE * stack.film_len() as f64;
    let picture = CHANNELS as f64 * plane;
    let volume = stack.films as f64 * picture;
    let colour = volume / CHANNELS as f64;
    let views = views as f64;
    let threads = rayon::current_num_threads();
    let busy = (threads.clamp(2, MOST_BUSY_THREADS) - 2) as f64;
    // Of every view, its pattern, and one colour of it in the values in which films add up.
    let wanted = views * (picture + plane);
    let solving = match settings.method {
        Method::Product => volume + views * picture,
        Method::LeastSquares => {
            // Two pictures of a view that move, the structure's weights, and a moment's means of the pattern and its square.
            let answers = 5.0 * views * plane;
            let parts = if apart { 0.0 } else { solver_parts(stack, settings) };
            let start = joint::start_part(stack) * volume;
            let settling = start * (1.25 + parts / CHANNELS as f64);
            // Those that wait are smaller films yet, or have 16 bits.
            let waiting = (2.0 / 3.0 * start).max(colour);
            let one = colour * (1.0 + parts) + waiting + answers + 3.0 * plane;
            // The last colour is where it belongs, and the others come out of their 16 bits.
            let together = volume + colour + (colour * parts + answers).min(KEPT_MIB * MIB);
            settling.max(one).max(together) + THREAD_PICTURES * busy * picture
        }
    };
    let light = if emits_ink(stack, settings) { 0.0 } else { volume };
    // Of every view, what it shows.
    let measuring = volume + light + views * picture + (MEASURED_PICTURES + THREAD_PICTURES * busy) * picture;
    // The films in ink and in glow, and as many colours at once as there are threads, with a copy to go back to.
    let halftoning = if settings.levels.is_some() {
        let at_once = threads.min(CHANNELS) as f64;
        2.0 * volume + at_once * (colour * (1.0 + solver_parts(stack, settings)) + 5.0 * views * plane)
    } else {
        0.0
    };
    let files = FILE_PART * volume;
    let page = if files > MOST_PAGE_BYTES { files } else { PAGE_COPIES * files };
    let writing = page.max(volume + light + files) + 2.0 * views * picture;
    let most = [solving, measuring, halftoning, writing].into_iter().fold(0.0, f64::max);
    PROGRAM_MIB + (wanted + most) / MIB
}

/// What the optimiser holds beside the films of a colour, as a part of them: where they are and their steps, in half the
/// bytes each, the light where it spreads, and the films after the print's blur where they lie astray beside.
fn solver_parts(stack: &Stack, settings: &DesignSettings) -> f64 {
    let spread = if spreads(stack, settings) { 1.0 } else { 0.0 };
    let crisp = if is_astray(settings) && stack.blur_um > 0.0 { spread } else { 0.0 };
    1.0 + spread + crisp
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::ViewRequest;
    use crate::optics::Direction;
    use crate::picture::Picture;
    use crate::projection::ViewerDistance;

    /// A design of the paper's size, seen in these directions.
    fn request(directions: &[(f64, f64)], settings: DesignSettings) -> DesignRequest {
        let stack = Stack { width_px: 512, height_px: 512, ..Stack::default() };
        let view = |&(horizontal, vertical): &(f64, f64)| {
            ViewRequest::new("view", Picture::new(512, 512), Direction::new(horizontal, vertical))
        };
        let views = directions.iter().map(view).collect();
        DesignRequest {
            stack,
            distance: ViewerDistance::Millimetres(600.0),
            views,
            settings,
            stop: Default::default(),
        }
    }

    #[test]
    fn a_design_of_the_papers_size_takes_at_most_150_mib_on_two_threads() {
        let three = [(30.0, 0.0), (0.0, 0.0), (-30.0, 0.0)];
        let four = [(20.0, -20.0), (-20.0, -20.0), (20.0, 20.0), (-20.0, 20.0)];
        let code = DesignSettings { optics: OpticsModel::Ideal, tone: Tone::Code, ..Default::default() };
        let product = DesignSettings { method: Method::Product, ..Default::default() };
        let two_threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        for settings in [DesignSettings::default(), code, product] {
            for directions in [&three[..], &four] {
                let request = request(directions, settings.clone());
                let mib = two_threads.install(|| predicted_memory_mib(&request));
                assert!((100.0..=150.0).contains(&mib), "{mib} MiB: {directions:?} {settings:?}");
            }
        }
    }
}
