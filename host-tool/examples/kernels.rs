//! Runs one kernel of the design engine or of printing some times over: `kernels NAME REPEATS`, for `benches/instructions.sh`,
//! which counts its instructions.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{FOUR, THREE, request};
use vitrine::chart::{Chart, Patch, Shape};
use vitrine::design::{DesignRequest, DesignSettings, Method, OpticsModel, Tone, design, product};
use vitrine::ink::{Halftone, Inks, Screens, Separator, SheetInks};
use vitrine::optics::{Direction, ideal_weights};
use vitrine::print::{Arrangement, ChartFilm, Formats, PrintJob, PrintRequest, Resolution, TiffForm};
use vitrine::projection::{ViewerDistance, back_project, project};
use vitrine::stack::Stack;
use vitrine::volume::Volume;
use vitrine_exhibit::units::Lamp;

const PIXELS: usize = 64;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().expect("a kernel");
    let repeats: usize = arguments.next().and_then(|text| text.parse().ok()).expect("a number of repeats");
    let kernel = kernel(&name);
    (0..repeats).for_each(|_| kernel());
}

fn kernel(name: &str) -> Box<dyn Fn()> {
    let stack = Stack { width_px: PIXELS, height_px: PIXELS, ..Stack::default() };
    let weights = ideal_weights(&stack);
    let direction = Direction::new(20.0, -20.0);
    let mut volume = Volume::new(stack.films, PIXELS, PIXELS);
    volume.values_mut().fill(0.5);
    match name {
        "project" => Box::new(move || {
            black_box(project(&volume, &stack, direction, ViewerDistance::Parallel, &weights));
        }),
        "back-project" => {
            let picture = project(&volume, &stack, direction, ViewerDistance::Parallel, &weights);
            Box::new(move || {
                black_box(back_project(&picture, &stack, direction, ViewerDistance::Parallel, &weights));
            })
        }
        "product" => {
            let wanted = request(&THREE, PIXELS, settings(Method::Product, Tone::Code));
            Box::new(move || {
                black_box(product(&wanted, &mut |_| ()));
            })
        }
        "design-three-code" => designed(solved(&THREE, Tone::Code)),
        "design-four-code" => designed(solved(&FOUR, Tone::Code)),
        "design-three-linear" => designed(solved(&THREE, Tone::Linear)),
        // Films that absorb, a viewer at arm's length, and all errors of hands and viewers; lamps are held, for the search
        // for them would be most of it.
        "design-three-built" => {
            let mut wanted = solved(&THREE, Tone::Linear);
            wanted.views.iter_mut().for_each(|view| view.lamp = Some(Lamp::Top));
            wanted.settings.optics = OpticsModel::Stack;
            wanted.distance = ViewerDistance::Millimetres(600.0);
            designed(wanted)
        }
        "print-error-diffusion" => printed(Halftone::ErrorDiffusion),
        "print-blue-noise" => printed(Halftone::BlueNoise),
        other => panic!("no kernel is called {other}"),
    }
}

fn settings(method: Method, tone: Tone) -> DesignSettings {
    // As many iterations every time, so that a better stop does not hide a slower kernel.
    let (iterations, tolerance_db) = (20, 1e-6);
    DesignSettings {
        method,
        tone,
        optics: OpticsModel::Ideal,
        iterations,
        tolerance_db,
        ..DesignSettings::default()
    }
}

fn solved(views: &[(&str, f64, f64)], tone: Tone) -> DesignRequest {
    request(views, PIXELS, settings(Method::LeastSquares, tone))
}

fn designed(wanted: DesignRequest) -> Box<dyn Fn()> {
    Box::new(move || {
        black_box(design(&wanted, &mut |_| ()).expect("a design"));
    })
}

/// One film, as TIFF and PDF, on a printer whose dots are four times as close along its width as along its height.
fn printed(halftone: Halftone) -> Box<dyn Fn()> {
    const DPI: Resolution = Resolution { dpi_x: 1440.0, dpi_y: 360.0 };
    let film = ChartFilm::new(&shades()).expect("a film");
    let screens = Screens::new(halftone, 2, DPI.dpi_x / DPI.dpi_y);
    let inks = SheetInks::new(Some(Separator::new(&Inks::default())), Some(screens));
    // One film of two has no assembly sheet, and neither that nor marks are to hide what dots take.
    let job = PrintJob::new(PrintRequest {
        stack: Stack { films: 2, ..film.stack().clone() },
        films: vec![0],
        exhibit: "Shades".into(),
        volume_blake3: film.blake3(),
        inks: ["red", "green", "blue"].map(str::to_owned),
        resolution: DPI,
        arrangement: Arrangement::Each,
        marks: false,
        mirrored: false,
        pin_mm: 2.0,
        profiles: None,
    });
    let job = job.expect("a film that fits its sheet");
    let formats = Formats { tiff: Some(TiffForm::Fitting), pdf: true };
    let folder = tempfile::tempdir().expect("a folder");
    Box::new(move || {
        let place = folder.path().join("sheets");
        black_box(job.write(&place, formats, &|_| film.rows(), &inks, &mut |_, _| ()).expect("sheets"));
    })
}

/// Square shades of a mm, none like the one beside it.
fn shades() -> Chart {
    const SIDE: usize = 35;
    let shade = |index: usize, step: usize| (index * step % 97) as f32 / 240.0;
    let patches = (0..SIDE * SIDE).map(|index| Patch {
        x_mm: (index % SIDE) as f64 + 0.5,
        y_mm: (index / SIDE) as f64 + 0.5,
        size_mm: 1.0,
        shape: Shape::Square,
        coverages: [shade(index, 41), shade(index, 29), shade(index, 59)],
    });
    Chart { width_mm: SIDE as f64, height_mm: SIDE as f64, patches: patches.collect() }
}
