//! Error diffusion in whole numbers.

use super::SIDE;
use crate::print::{Dot, Run};
use crate::volume::CHANNELS;

/// Units of a full dot: those of a sample.
const FULL: i32 = u16::MAX as i32;

/// How far a dot's threshold may lie from the middle, to either side, in tenths of a level: it breaks up the rows of
/// dots ("worms") that plain error diffusion makes.
const UNREST_TENTHS: i32 = 3;

/// An error is given away in so many parts: 7 go ahead, and 3, 5 and 1 to the three dots below.
const PARTS_LOG2: u32 = 4;

/// What one film's rows have left over.
#[derive(Clone, Debug)]
pub(super) struct Diffusion {
    order: [usize; CHANNELS],
    top: u8,
    /// Of each dot, between two that are none, what the row above has left to it: in parts of a unit, by the inks'
    /// turns.
    carried: Vec<[i32; CHANNELS]>,
}

impl Diffusion {
    pub(super) fn new(order: [usize; CHANNELS], top: u8, width: usize) -> Self {
        Self { order, top, carried: vec![[0; CHANNELS]; width + 2] }
    }

    /// Lays out row `row`: odd ones from right to left.
    pub(super) fn row(&mut self, row: usize, thresholds: &[u16; 2 * SIDE], runs: &[Run], dots: &mut [Dot]) {
        let unrest = std::array::from_fn(|column| unrest(thresholds[column]));
        match (self.top, row.is_multiple_of(2)) {
            (1, true) => self.walk::<true, false>(&unrest, runs, dots),
            (1, false) => self.walk::<true, true>(&unrest, runs, dots),
            (_, true) => self.walk::<false, false>(&unrest, runs, dots),
            (_, false) => self.walk::<false, true>(&unrest, runs, dots),
        }
    }

    /// An error's parts go to the next dot and to three of the next row, which gathers each where this row's own is read
    /// last: `carried` holds one value for each dot.
    fn walk<const BINARY: bool, const BACKWARD: bool>(
        &mut self,
        unrest: &[i32; SIDE],
        runs: &[Run],
        dots: &mut [Dot],
    ) {
        let [first, second, third] = self.order.map(|ink| ink as i32);
        let top = i32::from(self.top);
        // What the next dot gets, and what the dots below the last and below the next have so far.
        let [mut ahead, mut below_last, mut below_next] = [[0_i32; CHANNELS]; 3];
        for at in 0..runs.len() {
            let at = if BACKWARD { runs.len() - 1 - at } else { at };
            let start = if at == 0 { 0 } else { runs[at - 1].end };
            let pixel = start..runs[at].end;
            // The half rounds.
            let amounts =
                self.order.map(|ink| i32::from(runs[at].amounts[ink]) << PARTS_LOG2 | 1 << (PARTS_LOG2 - 1));
            let pixel_dots = &mut dots[pixel.clone()];
            let carried = &mut self.carried[pixel.start..pixel.end + 2];
            for step in 0..pixel_dots.len() {
                let step = if BACKWARD { pixel_dots.len() - 1 - step } else { step };
                let above = carried[step + 1];
                let due: [i32; CHANNELS] =
                    std::array::from_fn(|ink| (amounts[ink] + above[ink] + ahead[ink]) >> PARTS_LOG2);
                // All ones where an ink has the dot: branches would be guessed wrongly as often as not.
                let third_leads = below(due[0].max(due[1]), due[2]);
                let second_leads = below(due[0], due[1]) & !third_leads;
                let leads = [!(second_leads | third_leads), second_leads, third_leads];
                let wanted = due[0] + due[1] + due[2];
                let moved = unrest[(pixel.start + step) % SIDE];
                let (level, given) = if BINARY {
                    let full = below(FULL / 2, wanted + moved);
                    (full & 1, full & FULL)
                } else {
                    let level = level(wanted, moved, top);
                    (level, level * FULL / top)
                };
                let ink = leads[1] & second | leads[2] & third | leads[0] & first;
                pixel_dots[step] = Dot::new(ink as usize, level as u8);
                let error: [i32; CHANNELS] = std::array::from_fn(|ink| due[ink] - (leads[ink] & given));
                let behind = if BACKWARD { step + 2 } else { step };
                carried[behind] = std::array::from_fn(|ink| below_last[ink] + 3 * error[ink]);
                below_last = std::array::from_fn(|ink| below_next[ink] + 5 * error[ink]);
                below_next = error;
                ahead = error.map(|error| 7 * error);
            }
        }
        let last = if BACKWARD { 1 } else { self.carried.len() - 2 };
        self.carried[last] = below_last;
    }
}

/// All ones where `value` lies below `other`, else 0.
#[inline(always)]
fn below(value: i32, other: i32) -> i32 {
    (value - other) >> 31
}

/// The level up to `top` that is nearest to `wanted` units, but for what the threshold adds.
fn level(wanted: i32, moved: i32, top: i32) -> i32 {
    // Some full dots may be in arrears, which times the top is beyond 32 bits.
    let parts = i64::from(wanted) * i64::from(top) + i64::from(FULL / 2 + moved);
    (parts / i64::from(FULL)).clamp(0, top.into()) as i32
}

/// What a dot's threshold of the mask adds to what it is due, in units.
fn unrest(threshold: u16) -> i32 {
    let middle = FULL / 2;
    (i32::from(threshold) - middle) * 2 * UNREST_TENTHS / 10
}
