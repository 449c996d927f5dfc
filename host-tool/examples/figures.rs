//! Prints what the design engine reaches on the bundled photographs, row by row:
//!
//! ```text
//! cargo run --release -p vitrine --example figures [ROW ...] [--pixels 512] [--structure X] [--brightness X]
//! ```
//!
//! Rows are `code-three`, `code-four`, `linear-three`, `linear-four` (ideal optics, parallel rays),
//! `films-three`, `films-four` (films 0.82/0.90, own lamps, code values), `six-pages` (the same for two pictures in
//! each of three directions, one under each lamp: the four photographs, and two of them turned upside down),
//! `built-three`, `built-four` (films, a viewer at 600 mm and all errors of hands and viewers expected; figures are
//! those of 16 stacks with films misplaced by 68 µm), `built-linear-three`, `built-linear-four` (the same in light) and
//! any of them with `-product` behind, for the paper's Eq. 1. Without a row, all are printed.
//!
//! `--misplaced-alone` designs for misplaced films and no other error, `--careless` for none; `--levels N` for a printer
//! that knows N ink levels, and `--rounded N` rounds each film of a continuous design by itself.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{FOUR, THREE, photo, request};
use vitrine::design::{
    Design, DesignRequest, DesignSettings, HandErrors, Method, OpticsModel, SEED, STACKS, Tone, ViewRequest,
    as_built, built_by_hand, design,
};
use vitrine::optics::Direction;
use vitrine::projection::ViewerDistance;
use vitrine::volume::{CHANNELS, InkDepth};
use vitrine_exhibit::units::Lamp;

const ROWS: [&str; 9] = [
    "code-three",
    "code-four",
    "linear-three",
    "linear-four",
    "films-three",
    "films-four",
    "six-pages",
    "built-three",
    "built-four",
];

fn main() {
    let mut rows = Vec::new();
    let mut pixels = None;
    let mut rounded = None;
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
        request.views = six_pages(pixels);
    }
    request
}

/// Two pictures in each of three directions.
fn six_pages(pixels: usize) -> Vec<ViewRequest> {
    let page = |name: &str, degrees: f64, lamp: Lamp, turned: bool| {
        let mut pattern = photo(name, pixels);
        if turned {
            (0..CHANNELS).for_each(|channel| pattern.channel_mut(channel).reverse());
        }
        let id = format!("{name}{}", if turned { "-turned" } else { "" });
        ViewRequest { lamp: Some(lamp), ..ViewRequest::new(id, pattern, Direction::new(degrees, 0.0)) }
    };
    vec![
        page("astronaut", 30.0, Lamp::Top, false),
        page("coffee", 30.0, Lamp::Bottom, false),
        page("cat", 0.0, Lamp::Top, false),
        page("rocket", 0.0, Lamp::Bottom, false),
        page("astronaut", -30.0, Lamp::Top, true),
        page("coffee", -30.0, Lamp::Bottom, true),
    ]
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
