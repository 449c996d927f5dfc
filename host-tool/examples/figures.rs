//! Prints what the design engine reaches on the bundled photographs, row by row:
//!
//! ```text
//! cargo run --release -p vitrine --example figures [ROW ...] [--pixels 512] [--structure X] [--brightness X]
//! ```
//!
//! Rows are `code-three`, `code-four`, `linear-three`, `linear-four` (ideal optics, parallel rays),
//! `films-three`, `films-four` (films 0.82/0.90, own lamps, code values), `six-pages` (the same for two pictures in
//! each of three directions, one under each lamp: the four photographs, and cat and rocket turned upside down),
//! `six-alike` (the same with astronaut and coffee turned, which hardly agree, placed as `vitrine check` advises),
//! `built-three`, `built-four` (films, a viewer at 600 mm and all errors of hands and viewers expected; figures are
//! those of 16 stacks with films misplaced by 68 µm), `built-linear-three`, `built-linear-four` (the same in light) and
//! any of them with `-product` behind, for the paper's Eq. 1. Without a row, all are printed.
//!
//! `--within X` looks for the fewest iterations, in tens, that come within X dB of the whole design, and tells the time
//! in which that one was solved: `figures code-three code-four --within 0.1` is how soon the optimum is as good as
//! reached.
//!
//! `--misplaced-alone` designs for misplaced films and no other error, `--careless` for none; `--levels N` for a printer
//! that knows N ink levels, and `--rounded N` rounds each film of a continuous design by itself.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/pages.rs"]
mod pages;

use std::time::Instant;

use common::{FOUR, THREE, request};
use pages::{PAGES, Page, pages};
use vitrine::design::{
    Design, DesignRequest, DesignSettings, HandErrors, Method, OpticsModel, SEED, STACKS, Tone, as_built,
    built_by_hand, design,
};
use vitrine::projection::ViewerDistance;
use vitrine::volume::InkDepth;

/// Pages that hardly agree.
const ALIKE: [Page; 6] = [
    ("coffee", true),
    ("astronaut", false),
    ("rocket", false),
    ("cat", false),
    ("astronaut", true),
    ("coffee", false),
];

const ROWS: [&str; 10] = [
    "code-three",
    "code-four",
    "linear-three",
    "linear-four",
    "films-three",
    "films-four",
    "six-pages",
    "six-alike",
    "built-three",
    "built-four",
];

fn main() {
    let mut rows = Vec::new();
    let mut pixels = None;
    let mut rounded = None;
    let mut within = None;
    let mut settings = DesignSettings::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|text| text.parse::<f64>().ok()).expect("a number");
        match argument.as_str() {
            "--pixels" => pixels = Some(number() as usize),
            "--structure" => settings.structure = Some(number()),
            "--brightness" => settings.brightness = number(),
            "--balance" => settings.balance = number(),
            "--bits" if number() == 16.0 => settings.ink_depth = InkDepth::Sixteen,
            "--bits" => settings.ink_depth = InkDepth::Eight,
            "--misplaced-alone" => settings = settings.expecting(HandErrors::misplaced(68.0)),
            "--careless" => settings = settings.expecting(HandErrors::misplaced(0.0)),
            "--levels" => settings.levels = Some(number() as u16),
            "--rounded" => rounded = Some(number() as f32 - 1.0),
            "--iterations" => settings.iterations = number() as usize,
            "--within" => within = Some(number()),
            "--tolerance" => settings.tolerance_db = number(),
            _ => rows.push(argument),
        }
    }
    if rows.is_empty() {
        rows = ROWS.map(String::from).into();
    }
    println!("row              mean dB  least dB  SSIM    light (least)  solved, measured s");
    for row in rows {
        let wanted = wanted(&row, pixels, &settings);
        let begin = Instant::now();
        let (found, solved) = timed(&wanted);
        let found = match rounded {
            None => found,
            Some(steps) => {
                let mut volume = found.volume;
                volume.values_mut().iter_mut().for_each(|ink| *ink = (*ink * steps).round() / steps);
                Design::of(&wanted, volume)
            }
        };
        print(&row, &wanted, &found);
        println!("  {solved:>6.2} {:>6.2}", begin.elapsed().as_secs_f64());
        if let Some(decibels) = within {
            tell_when_within(&wanted, found.mean_psnr_db() - decibels);
        }
    }
}

/// The design, and the seconds until it was solved.
fn timed(wanted: &DesignRequest) -> (Design, f64) {
    let begin = Instant::now();
    let mut solved = 0.0;
    let found = design(wanted, &mut |progress| {
        if progress.stage == "measuring the views" {
            solved = begin.elapsed().as_secs_f64();
        }
    });
    (found.expect("a design"), solved)
}

/// Prints how many iterations, and seconds, reach so many dB.
fn tell_when_within(wanted: &DesignRequest, enough_db: f64) {
    for iterations in (10..=wanted.settings.iterations).step_by(10) {
        let settings = DesignSettings { iterations, ..wanted.settings.clone() };
        let (found, solved) = timed(&DesignRequest { settings, ..wanted.clone() });
        if found.mean_psnr_db() >= enough_db {
            println!("    {:.2} dB after {iterations} iterations, in {solved:.2} s", found.mean_psnr_db());
            return;
        }
    }
}

fn wanted(row: &str, pixels: Option<usize>, settings: &DesignSettings) -> DesignRequest {
    let built = row.starts_with("built");
    let ideal = !built && !row.starts_with("films") && !row.starts_with("six");
    let errors =
        if built { settings.clone() } else { settings.clone().expecting(HandErrors::misplaced(0.0)) };
    let settings = DesignSettings {
        method: if row.ends_with("product") { Method::Product } else { Method::LeastSquares },
        optics: if ideal { OpticsModel::Ideal } else { OpticsModel::Stack },
        tone: if row.contains("linear") { Tone::Linear } else { Tone::Code },
        ..errors
    };
    let pixels = pixels.unwrap_or(if built { 256 } else { 512 });
    let distance = if built { ViewerDistance::Millimetres(600.0) } else { ViewerDistance::Parallel };
    let views = if row.contains("four") { &FOUR[..] } else { &THREE[..] };
    let mut request = DesignRequest { distance, ..request(views, pixels, settings) };
    if row.starts_with("six") {
        request.views = pages(if row.starts_with("six-alike") { &ALIKE } else { &PAGES }, pixels);
    }
    request
}

fn print(row: &str, wanted: &DesignRequest, found: &Design) {
    let light: Vec<f64> = found.views.iter().map(|view| view.quality.efficiency).collect();
    let mean_light = light.iter().sum::<f64>() / light.len() as f64;
    let least_light = light.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut mean, mut least, mut ssim) = (found.mean_psnr_db(), found.least_psnr_db(), found.mean_ssim());
    if row.starts_with("built") {
        let pairs: Vec<_> = found.views.iter().map(|view| view.emphasis).collect();
        let built = as_built(wanted, &found.volume, &pairs, STACKS, SEED);
        (mean, least, ssim) = (built.mean_psnr_db(), built.least_psnr_db(), built.mean_ssim());
        let hands = built_by_hand(wanted, &found.volume, &pairs, HandErrors::expected(wanted), STACKS, SEED);
        for (what, built) in [("films misplaced alone", built), ("all errors of hands", hands)] {
            println!(
                "    {what}: {:.2} dB, least {:.2}, worst {:.2}; SSIM {:.4}, worst {:.4}",
                built.mean_psnr_db(),
                built.least_psnr_db(),
                built.worst_psnr_db(),
                built.mean_ssim(),
                built.worst_ssim()
            );
        }
    }
    print!("{row:<16} {mean:>7.2} {least:>9.2}  {ssim:.4}  {mean_light:.3} ({least_light:.3})");
}
