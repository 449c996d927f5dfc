//! From coverages to a printer's dots.
//!
//! No dot carries two inks. In blue noise one threshold m in 0..1 of a mask decides for all inks of a dot: with the
//! coverages a, ink 0 has the dot where m < a_0, ink 1 where a_0 <= m < a_0 + a_1, and so on. In error diffusion the
//! ink that is most in arrears has it. Over an area both lay as much of each ink as its coverage says.
//!
//! Films lie above each other, and what is dotted alike on all of them would stand out, and swim as the viewer moves.
//! So each film has the mask at another place, flipped otherwise, and has its inks take their turns in another order.

mod diffusion;

use std::sync::Arc;

use self::diffusion::Diffusion;
use super::mask::{Mask, SIDE};
use crate::print::{Dot, Run};
use crate::volume::CHANNELS;

/// How dots are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Halftone {
    /// Thresholds of a mask of blue noise: any part of a film can be laid out by itself.
    #[default]
    BlueNoise,
    /// Each dot's error goes to its neighbours (Floyd and Steinberg 1976), row by row.
    ErrorDiffusion,
}

/// The orders in which inks take their turns.
const ORDERS: [[usize; CHANNELS]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// The screens of all films of a print.
#[derive(Clone, Debug)]
pub struct Screens {
    halftone: Halftone,
    mask: Arc<Mask>,
    /// The highest level of a dot.
    top: u8,
}

impl Screens {
    /// Prepares screens for dots of `levels` levels, 2..=256, that lie `elongation` times as close along a row as
    /// along a column (`dpi_x / dpi_y`); other values count as the nearest that are possible.
    pub fn new(halftone: Halftone, levels: u16, elongation: f64) -> Self {
        let top = (levels.clamp(2, 256) - 1) as u8;
        Self { halftone, mask: Arc::new(Mask::new(elongation.clamp(1.0 / 16.0, 16.0))), top }
    }

    /// The highest level of a dot, which is full ink.
    pub fn top(&self) -> u8 {
        self.top
    }

    /// The screen of film `film`, counted from 0, for rows of `width` dots.
    pub fn film(&self, film: usize, width: usize) -> Screen {
        // The additive sequence of the plastic number spreads few points well in two dimensions (Roberts 2018).
        let place = |step: f64| ((film as f64 * step).fract() * SIDE as f64) as usize;
        let order = ORDERS[film % ORDERS.len()];
        Screen {
            placement: Placement {
                mask: self.mask.clone(),
                right: place(0.754_877_666_246_692_8),
                down: place(0.569_840_290_998_053_3),
                turned: film % 2 == 1,
                upside_down: film / 2 % 2 == 1,
            },
            order,
            top: self.top,
            diffusion: match self.halftone {
                Halftone::BlueNoise => None,
                Halftone::ErrorDiffusion => Some(Diffusion::new(order, self.top, width)),
            },
        }
    }
}

/// Where a film has the mask.
#[derive(Clone, Debug)]
struct Placement {
    mask: Arc<Mask>,
    right: usize,
    down: usize,
    turned: bool,
    upside_down: bool,
}

impl Placement {
    /// The thresholds of the film's row `row`, from the first column on, over and over: twice here, so that as many
    /// follow each of the first.
    fn thresholds(&self, row: usize) -> [u16; 2 * SIDE] {
        let row = (row + self.down) % SIDE;
        let line = self.mask.row(if self.upside_down { SIDE - 1 - row } else { row });
        std::array::from_fn(|column| {
            let column = (column + self.right) % SIDE;
            line[if self.turned { SIDE - 1 - column } else { column }]
        })
    }
}

/// One film's screen, which lays out its rows from the top down.
#[derive(Clone, Debug)]
pub struct Screen {
    placement: Placement,
    order: [usize; CHANNELS],
    top: u8,
    /// None for blue noise.
    diffusion: Option<Diffusion>,
}

impl Screen {
    /// Lays out row `row` of `dots` from its pixels, the `runs` from left to right: as many dots as the screen is wide.
    /// Error diffusion wants rows in their order, blue noise any.
    pub fn row(&mut self, row: usize, runs: &[Run], dots: &mut [Dot]) {
        let thresholds = self.placement.thresholds(row);
        match &mut self.diffusion {
            Some(diffusion) => diffusion.row(row, &thresholds, runs, dots),
            None if self.top == 1 => by_mask(&thresholds, runs, dots, |run| self.full_dots(run)),
            None => by_mask(&thresholds, runs, dots, |run| self.shared_dots(run)),
        }
    }

    /// Dots that are full or empty: each ink has its band of thresholds.
    fn full_dots(&self, run: &Run) -> Steps<CHANNELS> {
        let mut end = 0_u16;
        let steps = self.order.map(|ink| {
            end = end.saturating_add(run.amounts[ink]);
            (end, Dot::new(ink, 1))
        });
        Steps(steps)
    }

    /// Dots that inks share: all of a pixel are filled to the sum of its amounts, up to a level, and each ink has its
    /// part of them. Where a threshold lies within an ink's band decides between the two levels next to the sum.
    fn shared_dots(&self, run: &Run) -> Steps<{ 2 * CHANNELS }> {
        let sum: f64 = run.amounts.iter().copied().map(f64::from).sum();
        let full = f64::from(u16::MAX);
        let amount = (sum / full).min(1.0) * f64::from(self.top);
        let (lower, more) = (amount.floor(), amount.fract());
        let (low, high) = (lower as u8, (lower as u8).saturating_add(1).min(self.top));
        let mut steps = [(0, Dot::NONE); 2 * CHANNELS];
        let mut begin = 0.0;
        for (pair, ink) in steps.as_chunks_mut::<2>().0.iter_mut().zip(self.order) {
            let share = if sum > 0.0 { f64::from(run.amounts[ink]) / sum * (full + 1.0) } else { 0.0 };
            let bound = |part: f64| (begin + share * part).round().min(full) as u16;
            *pair = [(bound(1.0 - more), Dot::new(ink, low)), (bound(1.0), Dot::new(ink, high))];
            begin += share;
        }
        Steps(steps)
    }
}

/// What a pixel's dots are by their thresholds: the first entry whose bound lies above, none where there is no such.
struct Steps<const COUNT: usize>([(u16, Dot); COUNT]);

impl<const COUNT: usize> Steps<COUNT> {
    fn dot(&self, threshold: u16) -> Dot {
        let choose = |dot, &(bound, below): &(u16, Dot)| if threshold < bound { below } else { dot };
        self.0.iter().rev().fold(Dot::NONE, choose)
    }
}

fn by_mask<const COUNT: usize>(
    thresholds: &[u16; 2 * SIDE],
    runs: &[Run],
    dots: &mut [Dot],
    steps: impl Fn(&Run) -> Steps<COUNT>,
) {
    let mut start = 0;
    for run in runs {
        let pixel = &mut dots[start..run.end];
        if run.amounts == [0; CHANNELS] {
            pixel.fill(Dot::NONE);
        } else {
            let steps = steps(run);
            for (part, dots) in pixel.chunks_mut(SIDE).enumerate() {
                let own = &thresholds[(start + part * SIDE) % SIDE..];
                dots.iter_mut().zip(own).for_each(|(dot, &threshold)| *dot = steps.dot(threshold));
            }
        }
        start = run.end;
    }
}

#[cfg(test)]
mod tests;
