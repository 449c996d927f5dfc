//! Wall time of the design engine on the bundled photographs: `cargo bench -p vitrine`.
//!
//! Figures of a machine that does other things beside swing twofold: `benches/instructions.sh` counts instead.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{FOUR, THREE, request};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use vitrine::design::{DesignSettings, Method, OpticsModel, Tone, design, product};
use vitrine::optics::{Direction, ideal_weights};
use vitrine::projection::{ViewerDistance, back_project, project};
use vitrine::stack::Stack;
use vitrine::volume::{CHANNELS, Volume};

fn main() {
    divan::main();
}

/// The settings of the paper's simulation; the optimiser stops within 0.1 dB of its optimum.
fn paper(method: Method, tone: Tone) -> DesignSettings {
    DesignSettings { method, tone, optics: OpticsModel::Ideal, iterations: 20, ..DesignSettings::default() }
}

/// Stacks of `pixels` x `pixels` x films, and how many voxels of one colour they have.
const SIZES: [(usize, usize); 4] = [(256, 20), (512, 20), (1024, 20), (1024, 40)];

fn stack(pixels: usize, films: usize) -> Stack {
    Stack { films, width_px: pixels, height_px: pixels, ..Stack::default() }
}

/// One view's projection about one axis and about both, in voxels a second.
#[divan::bench(args = SIZES.into_iter().flat_map(|size| [(size, 0.0), (size, 20.0)]), sample_count = 5)]
fn forward(bencher: Bencher, ((pixels, films), vertical_deg): ((usize, usize), f64)) {
    let stack = stack(pixels, films);
    let volume = Volume::new(films, pixels, pixels);
    let weights = ideal_weights(&stack);
    let direction = Direction::new(20.0, vertical_deg);
    bencher
        .counter(ItemsCount::new(CHANNELS * films * pixels * pixels))
        .bench(|| project(black_box(&volume), &stack, direction, ViewerDistance::Parallel, &weights));
}

/// The transpose of that.
#[divan::bench(args = [0.0, 20.0], sample_count = 5)]
fn transpose(bencher: Bencher, vertical_deg: f64) {
    let stack = stack(512, 20);
    let volume = Volume::new(20, 512, 512);
    let weights = ideal_weights(&stack);
    let direction = Direction::new(20.0, vertical_deg);
    let picture = project(&volume, &stack, direction, ViewerDistance::Parallel, &weights);
    bencher
        .counter(ItemsCount::new(CHANNELS * 20 * 512 * 512))
        .bench(|| back_project(black_box(&picture), &stack, direction, ViewerDistance::Parallel, &weights));
}

/// The paper's Eq. 1 once its patterns are read.
#[divan::bench(args = ["three", "four"], sample_count = 10)]
fn equation_1(bencher: Bencher, views: &str) {
    let views = if views == "three" { &THREE[..] } else { &FOUR[..] };
    let wanted = request(views, 512, paper(Method::Product, Tone::Code));
    bencher.bench(|| product(black_box(&wanted), &mut |_| ()));
}

/// A design of films that absorb, seen from arm's length, with all errors of hands and viewers expected.
#[divan::bench(args = [("three", 256), ("three", 512), ("four", 512)], sample_count = 3)]
fn robust_design(bencher: Bencher, (views, pixels): (&str, usize)) {
    let views = if views == "three" { &THREE[..] } else { &FOUR[..] };
    let settings = DesignSettings { optics: OpticsModel::Stack, ..paper(Method::LeastSquares, Tone::Linear) };
    let mut wanted = request(views, pixels, settings);
    wanted.distance = ViewerDistance::Millimetres(600.0);
    bencher.bench(|| design(black_box(&wanted), &mut |_| ()));
}

/// A whole design in code values, from patterns to measures, at growing size.
#[divan::bench(args = [("three", 256), ("three", 512), ("three", 1024), ("four", 512)], sample_count = 3)]
fn whole_design(bencher: Bencher, (views, pixels): (&str, usize)) {
    let views = if views == "three" { &THREE[..] } else { &FOUR[..] };
    let wanted = request(views, pixels, paper(Method::LeastSquares, Tone::Code));
    bencher.bench(|| design(black_box(&wanted), &mut |_| ()));
}
