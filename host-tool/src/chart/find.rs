//! Finding a chart in a photograph.
//!
//! At several thresholds the bright parts of the green channel are taken apart into connected ones; where one that
//! fills as much of its box as a ring lies about one that fills as much as a disc, there is a corner mark. Of the ways
//! to give four marks to the chart's corners, that is right in which the dot beside the upper left one is where it
//! should be, and nowhere else.

use miette::Diagnostic;
use thiserror::Error;

use super::measure::sample;
use super::{Chart, DOT_RADIUS_MM, Perspective, RING_MM, UPRIGHT_MM};
use crate::picture::Picture;

/// The channel in which marks glow.
const GREEN: usize = 1;
/// The side up to which a photograph is searched as it is; larger ones are halved first, or thirded, and so on.
const SIDE: usize = 1600;
/// Thresholds, as parts of the way from the median to the brightest.
const THRESHOLDS: [f32; 7] = [0.06, 0.1, 0.16, 0.25, 0.36, 0.5, 0.65];
/// Pixels of the smallest part that can be a mark's dot.
const SMALLEST: usize = 9;
/// The most marks that are tried in all combinations.
const MOST: usize = 9;
/// Light of the brightest hundredth below which there is nothing to measure.
const TOO_DARK: f32 = 0.012;
/// Pixels of a mm below which patches cannot be told from their rims.
const COARSEST: f64 = 2.5;

/// Where a chart lies in a photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// From mm on the chart to pixels of the photograph, whose first pixel's middle is (0, 0).
    pub perspective: Perspective,
    /// Pixels of a mm, where the chart is smallest.
    pub pixels_per_mm: f64,
}

/// Why a photograph cannot be measured.
#[derive(Clone, Debug, Error, Diagnostic, PartialEq)]
pub enum ChartError {
    /// Nothing glows.
    #[error(
        "the photograph is too dark: its brightest parts hold {brightest_percent:.1} % of the light that it could"
    )]
    #[diagnostic(
        code("vitrine::chart::too_dark"),
        help("expose longer, or light the chart with more ultraviolet, in an otherwise dark room")
    )]
    TooDark {
        /// The brightest green, in percent.
        brightest_percent: f32,
    },
    /// There is no corner mark.
    #[error("there is no chart in the photograph: none of its four corner marks was found")]
    #[diagnostic(
        code("vitrine::chart::not_found"),
        help(
            "photograph the whole printed chart in sharp focus, filling most of the picture, lit by ultraviolet alone"
        )
    )]
    NotFound,
    /// Corner marks are missing.
    #[error("only {marks} of the chart's four corner marks {} in the photograph", if *marks == 1 { "is" } else { "are" })]
    #[diagnostic(
        code("vitrine::chart::cut_off"),
        help("photograph the whole chart: all four rings at its corners, none cut off, covered or glaring")
    )]
    CutOff {
        /// Marks that were found.
        marks: usize,
    },
    /// Four marks, but not those of this chart.
    #[error("the corner marks in the photograph are not those of this chart")]
    #[diagnostic(
        code("vitrine::chart::another_chart"),
        help(
            "print the chart anew with this version, and keep the dot beside its upper left ring uncovered"
        )
    )]
    AnotherChart,
    /// Another of vitrine's charts.
    #[error("the photograph shows another of vitrine's charts")]
    #[diagnostic(code("vitrine::chart::exchanged"), help("{advice}"))]
    Exchanged {
        /// What the chart is, and how it is measured.
        advice: &'static str,
    },
    /// Too few pixels.
    #[error("the chart is too small in the photograph: {pixels_per_mm:.1} pixels a mm")]
    #[diagnostic(
        code("vitrine::chart::too_small"),
        help("go nearer or take more pixels: at least 2.5 for each mm of the chart")
    )]
    TooSmall {
        /// Pixels of a mm where the chart is smallest.
        pixels_per_mm: f64,
    },
}

/// A corner mark: its middle and the side of its ring's box, in pixels.
#[derive(Clone, Copy, Debug)]
struct Mark {
    at: [f64; 2],
    size: f64,
    /// Thresholds at which it was seen.
    seen: usize,
}

/// Finds `chart` in `light`, a photograph in linear light.
///
/// # Errors
/// Says why it cannot be found.
pub fn find(light: &Picture, chart: &Chart) -> Result<Found, ChartError> {
    let step = light.width().max(light.height()).div_ceil(SIDE).max(1);
    let small = Grey::shrunk(light, step);
    let (median, brightest) = small.range();
    if brightest < TOO_DARK {
        return Err(ChartError::TooDark { brightest_percent: brightest * 100.0 });
    }
    let mut marks: Vec<Mark> = Vec::new();
    for threshold in THRESHOLDS {
        for mark in small.marks(median + threshold * (brightest - median)) {
            gather(&mut marks, mark);
        }
    }
    // A small picture's pixel is `step` of the large one's, with its middle in theirs.
    let large = |at: f64| (at + 0.5) * step as f64 - 0.5;
    for mark in &mut marks {
        *mark = Mark { at: mark.at.map(large), size: mark.size * step as f64, ..*mark };
    }
    marks.sort_by_key(|mark| std::cmp::Reverse(mark.seen));
    marks.truncate(MOST);
    match marks.len() {
        0 => return Err(ChartError::NotFound),
        few @ 1..4 => return Err(ChartError::CutOff { marks: few }),
        _ => {}
    }
    let best = fours(&marks)
        .into_iter()
        .flat_map(|four| ways(four, chart))
        .map(|perspective| (upright(light, chart, &perspective), perspective))
        .max_by(|one, other| one.0.total_cmp(&other.0));
    let Some((contrast, perspective)) = best else { return Err(ChartError::AnotherChart) };
    if contrast < 0.3 {
        return Err(ChartError::AnotherChart);
    }
    let pixels_per_mm = coarsest(chart, &perspective);
    if pixels_per_mm < COARSEST {
        return Err(ChartError::TooSmall { pixels_per_mm });
    }
    Ok(Found { perspective, pixels_per_mm })
}

/// As [`find`], but where the chart `other` lies in the photograph instead, the error gives this `advice`.
///
/// # Errors
/// Says why the chart cannot be found.
pub fn find_rather_than(
    light: &Picture,
    chart: &Chart,
    (other, advice): (&Chart, &'static str),
) -> Result<Found, ChartError> {
    match find(light, chart) {
        Err(ChartError::AnotherChart) if find(light, other).is_ok() => Err(ChartError::Exchanged { advice }),
        found => found,
    }
}

/// Adds a mark, or makes one that was seen already surer.
fn gather(marks: &mut Vec<Mark>, mark: Mark) {
    let near = |other: &&mut Mark| {
        let distance = (other.at[0] - mark.at[0]).hypot(other.at[1] - mark.at[1]);
        distance < 0.3 * mark.size
    };
    match marks.iter_mut().find(near) {
        Some(other) => {
            let seen = other.seen as f64;
            let mean = |old: f64, new: f64| (old * seen + new) / (seen + 1.0);
            *other = Mark {
                at: [mean(other.at[0], mark.at[0]), mean(other.at[1], mark.at[1])],
                size: mean(other.size, mark.size),
                seen: other.seen + 1,
            };
        }
        None => marks.push(mark),
    }
}

/// All choices of four marks of like size, each in the order around their middle.
fn fours(marks: &[Mark]) -> Vec<[[f64; 2]; 4]> {
    let mut fours = Vec::new();
    for set in 0_u32..1 << marks.len() {
        if set.count_ones() != 4 {
            continue;
        }
        let mut four: Vec<Mark> = marks
            .iter()
            .enumerate()
            .filter(|(index, _)| set >> index & 1 == 1)
            .map(|(_, mark)| *mark)
            .collect();
        let sizes = four.iter().map(|mark| mark.size);
        let (least, most) = (sizes.clone().fold(f64::INFINITY, f64::min), sizes.fold(0.0, f64::max));
        if most > 3.0 * least {
            continue;
        }
        let middle = [0, 1].map(|axis| four.iter().map(|mark| mark.at[axis]).sum::<f64>() / 4.0);
        four.sort_by(|one, other| {
            let angle = |mark: &Mark| (mark.at[1] - middle[1]).atan2(mark.at[0] - middle[0]);
            angle(one).total_cmp(&angle(other))
        });
        if let [a, b, c, d] = four.as_slice() {
            fours.push([a.at, b.at, c.at, d.at]);
        }
    }
    fours
}

/// The eight ways in which a chart, turned or seen from its back, may have its corners at `four`.
fn ways(four: [[f64; 2]; 4], chart: &Chart) -> impl Iterator<Item = Perspective> {
    let corners = chart.marks();
    let forth = (0..4).map(move |turn| [0, 1, 2, 3].map(|corner| four[(corner + turn) % 4]));
    let back = (0..4).map(move |turn| [0, 1, 2, 3].map(|corner| four[(4 - corner + turn) % 4]));
    forth.chain(back).filter_map(move |to| Perspective::through(corners, to))
}

/// How much brighter the dot beside the upper left mark is than all places where other ways would have it, as a part
/// of the marks' own brightness.
fn upright(light: &Picture, chart: &Chart, perspective: &Perspective) -> f64 {
    let value = |point: [f64; 2]| f64::from(sample(light, GREEN, perspective.apply(point)));
    let (mut ring, mut others) = (0.0, f64::NEG_INFINITY);
    let dot = chart.upright();
    let middle = [chart.width_mm / 2.0, chart.height_mm / 2.0];
    for [x, y] in chart.marks() {
        let inward = [(middle[0] - x).signum(), (middle[1] - y).signum()];
        ring += value([x + (RING_MM.start + RING_MM.end) / 2.0, y]) / 4.0;
        // Between ring and dot a mark is dark.
        others = others.max(value([x, y + (DOT_RADIUS_MM + RING_MM.start) / 2.0]));
        for place in [[x + UPRIGHT_MM * inward[0], y], [x, y + UPRIGHT_MM * inward[1]]] {
            if place != dot {
                others = others.max(value(place));
            }
        }
    }
    (value(dot) - others) / ring.max(1e-6)
}

/// Pixels of a mm at the corner where they are fewest.
fn coarsest(chart: &Chart, perspective: &Perspective) -> f64 {
    let length = |from: [f64; 2], to: [f64; 2]| {
        let (from, to) = (perspective.apply(from), perspective.apply(to));
        (from[0] - to[0]).hypot(from[1] - to[1])
    };
    let spans = chart
        .marks()
        .map(|[x, y]| length([x - 0.5, y], [x + 0.5, y]).min(length([x, y - 0.5], [x, y + 0.5])));
    spans.into_iter().fold(f64::INFINITY, f64::min)
}

/// A plane of light.
struct Grey {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

/// A connected bright part.
struct Part {
    at: [f64; 2],
    pixels: usize,
    size: [usize; 2],
}

impl Grey {
    /// The green channel, in means of `step` x `step` pixels.
    fn shrunk(light: &Picture, step: usize) -> Self {
        let (width, height) = (light.width() / step, light.height() / step);
        let green = light.channel(GREEN);
        let mut values = vec![0.0; width * height];
        for (row, line) in values.chunks_exact_mut(width.max(1)).enumerate() {
            for (column, value) in line.iter_mut().enumerate() {
                let block = (0..step).flat_map(|y| {
                    let start = (row * step + y) * light.width() + column * step;
                    &green[start..start + step]
                });
                *value = block.sum::<f32>() / (step * step) as f32;
            }
        }
        Self { width, height, values }
    }

    /// The median, and the value that a two-hundredth of all pixels exceed.
    fn range(&self) -> (f32, f32) {
        let mut sorted = self.values.clone();
        if sorted.is_empty() {
            return (0.0, 0.0);
        }
        sorted.sort_unstable_by(f32::total_cmp);
        (sorted[sorted.len() / 2], sorted[sorted.len() - 1 - sorted.len() / 200])
    }

    /// All corner marks among what is brighter than `threshold`.
    fn marks(&self, threshold: f32) -> Vec<Mark> {
        let parts = self.parts(threshold);
        let filled = |part: &Part| part.pixels as f64 / (part.size[0] * part.size[1]) as f64;
        let even = |part: &Part| {
            let ratio = part.size[0] as f64 / part.size[1] as f64;
            (0.35..2.9).contains(&ratio)
        };
        let (discs, rings): (Vec<&Part>, Vec<&Part>) =
            parts.iter().filter(|part| even(part)).partition(|part| filled(part) > 0.64);
        let rings =
            rings.into_iter().filter(|part| filled(part) > 0.2 && part.size[0].min(part.size[1]) >= 7);
        let mut marks = Vec::new();
        for ring in rings {
            let size = ring.size.map(|side| side as f64);
            let is_its_dot = |disc: &&&Part| {
                let off = [0, 1].map(|axis| (disc.at[axis] - ring.at[axis]).abs() / size[axis]);
                let part = [0, 1].map(|axis| disc.size[axis] as f64 / size[axis]);
                off.iter().all(|&off| off < 0.08) && part.iter().all(|part| (0.15..0.6).contains(part))
            };
            let mut dots = discs.iter().filter(is_its_dot);
            if let (Some(dot), None) = (dots.next(), dots.next()) {
                let at = [0, 1].map(|axis| (dot.at[axis] + ring.at[axis]) / 2.0);
                marks.push(Mark { at, size: size[0].max(size[1]), seen: 1 });
            }
        }
        marks
    }

    /// The connected parts brighter than `threshold`, all but the smallest.
    fn parts(&self, threshold: f32) -> Vec<Part> {
        let mut open: Vec<bool> = self.values.iter().map(|&value| value > threshold).collect();
        let mut parts = Vec::new();
        let mut waiting = Vec::new();
        for first in 0..open.len() {
            if !std::mem::take(&mut open[first]) {
                continue;
            }
            waiting.push(first);
            let (mut pixels, mut sum) = (0, [0.0; 2]);
            let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
            while let Some(at) = waiting.pop() {
                let place = [at % self.width, at / self.width];
                pixels += 1;
                for axis in 0..2 {
                    sum[axis] += place[axis] as f64;
                    low[axis] = low[axis].min(place[axis]);
                    high[axis] = high[axis].max(place[axis]);
                }
                let mut visit = |there: bool, next: usize| {
                    if there && std::mem::take(&mut open[next]) {
                        waiting.push(next);
                    }
                };
                visit(place[0] > 0, at.wrapping_sub(1));
                visit(place[0] + 1 < self.width, at + 1);
                visit(place[1] > 0, at.wrapping_sub(self.width));
                visit(place[1] + 1 < self.height, at + self.width);
            }
            if pixels >= SMALLEST {
                let size = [high[0] - low[0] + 1, high[1] - low[1] + 1];
                parts.push(Part { at: sum.map(|sum| sum / pixels as f64), pixels, size });
            }
        }
        parts
    }
}
