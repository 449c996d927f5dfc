//! From coverages to a printer's dots.
//!
//! No dot carries two inks. In blue noise one threshold m in 0..1 of a mask decides for all inks of a dot: with the
//! coverages a, ink 0 has the dot where m < a_0, ink 1 where a_0 <= m < a_0 + a_1, and so on. In error diffusion the
//! ink that is most in arrears has it. Over an area both lay as much of each ink as its coverage says.
//!
//! Films lie above each other, and what is dotted alike on all of them would stand out, and swim as the viewer moves.
//! So each film has the mask at another place, flipped otherwise, and has its inks take their turns in another order.

use std::sync::Arc;

use super::mask::{Mask, SIDE};
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

/// How far a dot's threshold of error diffusion may lie from the middle, to either side: it breaks up the rows of dots
/// ("worms") that plain error diffusion makes.
const UNREST: f32 = 0.3;

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
        Screen {
            screens: self.clone(),
            placement: Placement {
                right: place(0.754_877_666_246_692_8),
                down: place(0.569_840_290_998_053_3),
                turned: film % 2 == 1,
                upside_down: film / 2 % 2 == 1,
            },
            order: ORDERS[film % ORDERS.len()],
            carried: match self.halftone {
                Halftone::BlueNoise => Vec::new(),
                Halftone::ErrorDiffusion => vec![[0.0; CHANNELS]; width],
            },
        }
    }
}

/// Where a film has the mask.
#[derive(Clone, Copy, Debug)]
struct Placement {
    right: usize,
    down: usize,
    turned: bool,
    upside_down: bool,
}

impl Placement {
    /// The thresholds of the film's row `row`, from the first column on, over and over.
    fn thresholds(self, mask: &Mask, row: usize) -> [f32; SIDE] {
        let row = (row + self.down) % SIDE;
        let line = mask.row(if self.upside_down { SIDE - 1 - row } else { row });
        std::array::from_fn(|column| {
            let column = (column + self.right) % SIDE;
            line[if self.turned { SIDE - 1 - column } else { column }]
        })
    }
}

/// One film's screen, which lays out its rows from the top down.
#[derive(Clone, Debug)]
pub struct Screen {
    screens: Screens,
    placement: Placement,
    order: [usize; CHANNELS],
    /// Of each dot, the errors for the row at hand; empty for blue noise.
    carried: Vec<[f32; CHANNELS]>,
}

impl Screen {
    /// Lays out row `row` from its `coverages`, whose sum at a dot is at most 1, into `levels`, 0 to the top: red,
    /// green and blue rows of the screen's width. Error diffusion wants rows in their order, blue noise any.
    pub fn row(&mut self, row: usize, coverages: [&[f32]; CHANNELS], levels: [&mut [u8]; CHANNELS]) {
        let thresholds = self.placement.thresholds(&self.screens.mask, row);
        match self.screens.halftone {
            Halftone::BlueNoise => self.by_mask(&thresholds, coverages, levels),
            Halftone::ErrorDiffusion => self.by_error(row, &thresholds, coverages, levels),
        }
    }

    fn by_mask(
        &self,
        thresholds: &[f32; SIDE],
        coverages: [&[f32]; CHANNELS],
        levels: [&mut [u8]; CHANNELS],
    ) {
        let top = self.screens.top;
        let [first, second, third] = self.order;
        let mut levels = levels.map(|levels| levels.chunks_mut(SIDE));
        let [a, b, c] = [first, second, third].map(|ink| coverages[ink].chunks(SIDE));
        for ((a, b), c) in a.zip(b).zip(c) {
            let [red, green, blue] = &mut levels;
            let (Some(red), Some(green), Some(blue)) = (red.next(), green.next(), blue.next()) else {
                return;
            };
            let mut places = [Some(red), Some(green), Some(blue)];
            let mut take = |ink: usize| places[ink].take().unwrap_or_default();
            let [x, y, z] = [take(first), take(second), take(third)];
            let dots = thresholds.iter().zip(a.iter().zip(b).zip(c)).zip(x.iter_mut().zip(y).zip(z));
            if top == 1 {
                for ((&threshold, ((&a, &b), &c)), ((x, y), z)) in dots {
                    *x = u8::from(threshold < a);
                    *y = u8::from(threshold >= a && threshold < a + b);
                    *z = u8::from(threshold >= a + b && threshold < a + b + c);
                }
            } else {
                for ((&threshold, ((&a, &b), &c)), ((x, y), z)) in dots {
                    [*x, *y, *z] = shared_dot(threshold, [a, b, c], top);
                }
            }
        }
    }

    /// An error's parts go to the next dot and to three of the next row, which gathers each where this row's own is read
    /// last: `carried` holds one value for each dot.
    fn by_error(
        &mut self,
        row: usize,
        thresholds: &[f32; SIDE],
        coverages: [&[f32]; CHANNELS],
        levels: [&mut [u8]; CHANNELS],
    ) {
        let top = f32::from(self.screens.top);
        let width = coverages[0].len();
        let coverages = self.order.map(|ink| &coverages[ink][..width]);
        let mut levels = levels.map(Some);
        let levels = self.order.map(|ink| &mut levels[ink].take().unwrap_or_default()[..width]);
        let carried = &mut self.carried[..width];
        let backward = !row.is_multiple_of(2);
        // What the next dot gets, and what the dots below the last and below the next have so far.
        let [mut ahead, mut below_last, mut below_next] = [[0.0_f32; CHANNELS]; 3];
        let mut last = None;
        for step in 0..width {
            let column = if backward { width - 1 - step } else { step };
            let due = [0, 1, 2].map(|ink| coverages[ink][column] + carried[column][ink] + ahead[ink]);
            let second_leads = due[1] > due[0];
            let third_leads = due[2] > if second_leads { due[1] } else { due[0] };
            let leads = [!second_leads && !third_leads, second_leads && !third_leads, third_leads];
            let unrest = (thresholds[column % SIDE] - 0.5) * 2.0 * UNREST;
            let level = ((due[0] + due[1] + due[2]) * top + 0.5 + unrest).floor().clamp(0.0, top);
            let error = [0, 1, 2].map(|ink| due[ink] - if leads[ink] { level / top } else { 0.0 });
            for ink in 0..CHANNELS {
                levels[ink][column] = if leads[ink] { level as u8 } else { 0 };
            }
            let shared = |part: f32| error.map(|error| part / 16.0 * error);
            let plus =
                |one: [f32; CHANNELS], other: [f32; CHANNELS]| [0, 1, 2].map(|ink| one[ink] + other[ink]);
            if let Some(last) = last.replace(column) {
                carried[last] = plus(below_last, shared(3.0));
            }
            (below_last, below_next, ahead) = (plus(below_next, shared(5.0)), shared(1.0), shared(7.0));
        }
        if let Some(last) = last {
            carried[last] = below_last;
        }
    }
}

/// The levels of a dot that inks share: all dots of a spot are filled to the sum of its coverages, up to a level, and
/// each ink has its part of them.
fn shared_dot(threshold: f32, coverages: [f32; CHANNELS], top: u8) -> [u8; CHANNELS] {
    let amount: f32 = coverages.iter().sum();
    let mut levels = [0; CHANNELS];
    // Where a threshold lies within an ink's band decides between the two levels next to the amount.
    let mut begin = 0.0;
    for (level, coverage) in levels.iter_mut().zip(coverages) {
        let share = coverage / amount;
        if threshold >= begin && threshold < begin + share {
            let within = (threshold - begin) / share;
            *level = (amount * f32::from(top) + within).floor().min(f32::from(top)) as u8;
        }
        begin += share;
    }
    levels
}

#[cfg(test)]
mod tests;
