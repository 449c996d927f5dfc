//! Prints what the design engine reaches on the bundled photographs, row by row:
//!
//! ```text
//! cargo run --release -p vitrine --example figures [ROW ...] [--pixels 512] [--structure X] [--brightness X]
//! ```
//!
//! Rows are `code-three`, `code-four`, `linear-three`, `linear-four` (ideal optics, parallel rays),
//! `films-three`, `films-four` (films 0.82/0.90, own lamps, code values), `built-three`, `built-four` (the same
//! for a viewer at 600 mm and films misplaced by 68 µm, as built) and any of them with `-product` behind, for
//! the paper's Eq. 1. Without a row, all are printed.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{FOUR, THREE, request};
use vitrine::design::{
    Design, DesignRequest, DesignSettings, Method, OpticsModel, SEED, STACKS, Tone, as_built, design,
};
use vitrine::projection::ViewerDistance;
use vitrine::volume::InkDepth;

const ROWS: [&str; 8] = [
    "code-three",
    "code-four",
    "linear-three",
    "linear-four",
    "films-three",
    "films-four",
    "built-three",
    "built-four",
];

fn main() {
    let mut rows = Vec::new();
    let mut pixels = None;
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
            "--iterations" => settings.iterations = number() as usize,
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
        let mut solved = 0.0;
        let found = design(&wanted, &mut |progress| {
            if progress.stage == "measuring the views" {
                solved = begin.elapsed().as_secs_f64();
            }
        })
        .expect("a design");
        print(&row, &wanted, &found);
        println!("  {solved:>6.2} {:>6.2}", begin.elapsed().as_secs_f64());
    }
}

fn wanted(row: &str, pixels: Option<usize>, settings: &DesignSettings) -> DesignRequest {
    let views = if row.contains("four") { &FOUR[..] } else { &THREE[..] };
    let built = row.starts_with("built");
    let ideal = !built && !row.starts_with("films");
    let settings = DesignSettings {
        method: if row.ends_with("product") { Method::Product } else { Method::LeastSquares },
        optics: if ideal { OpticsModel::Ideal } else { OpticsModel::Stack },
        tone: if row.starts_with("linear") { Tone::Linear } else { Tone::Code },
        misplacement_um: if built { 68.0 } else { 0.0 },
        ..settings.clone()
    };
    let pixels = pixels.unwrap_or(if built { 256 } else { 512 });
    let distance = if built { ViewerDistance::Millimetres(600.0) } else { ViewerDistance::Parallel };
    DesignRequest { distance, ..request(views, pixels, settings) }
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
    }
    print!("{row:<16} {mean:>7.2} {least:>9.2}  {ssim:.4}  {mean_light:.3} ({least_light:.3})");
}
