//! A flash that loses its power: for tests here and in other crates.
//!
//! Every programmed byte and every erased slice of [`SLICE_BYTES`] costs one step. When the steps allowed run out,
//! the power is gone in the middle of that step, and every call fails until [`MockFlash::power_on`].

use std::{vec, vec::Vec};

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

use crate::map::SECTOR_BYTES;

/// What of a sector is erased at once when an erase is torn.
pub const SLICE_BYTES: usize = 64;

/// The order in which the slices of a sector get erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EraseOrder {
    /// From the lowest address up.
    Rising,
    /// From the highest address down.
    Falling,
    /// In an order that differs from erase to erase.
    Shuffled,
}

impl EraseOrder {
    /// All orders.
    pub const ALL: [Self; 3] = [Self::Rising, Self::Falling, Self::Shuffled];
}

/// What the step leaves behind in which the power is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LastStep {
    /// Nothing: it had not begun.
    Nothing,
    /// Some of the bits that it was to change.
    Garbage,
}

impl LastStep {
    /// Both ways.
    pub const ALL: [Self; 2] = [Self::Nothing, Self::Garbage];
}

/// Why the mock refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MockError {
    /// The power is gone.
    PowerLost,
    /// Not within the flash, or not on a sector's edge.
    OutOfBounds,
    /// A byte is programmed that has not been erased since it was last programmed.
    NotErased,
}

impl NorFlashError for MockError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::PowerLost | Self::NotErased => NorFlashErrorKind::Other,
        }
    }
}

/// Flash in memory that begins at any address and counts its wear.
#[derive(Clone, Debug)]
pub struct MockFlash {
    base: usize,
    bytes: Vec<u8>,
    steps: u64,
    power_lost_at: Option<u64>,
    erases: Vec<u32>,
    order: EraseOrder,
    last_step: LastStep,
}

impl MockFlash {
    /// Erased flash from the address `start` to `end`.
    pub fn new(start: u32, end: u32) -> Self {
        let bytes = (end - start) as usize;
        Self {
            base: start as usize,
            bytes: vec![0xff; bytes],
            steps: 0,
            power_lost_at: None,
            erases: vec![0; bytes / SECTOR_BYTES as usize],
            order: EraseOrder::Rising,
            last_step: LastStep::Nothing,
        }
    }

    /// Sets how erases and the last step tear.
    pub fn tearing(mut self, order: EraseOrder, last_step: LastStep) -> Self {
        self.order = order;
        self.last_step = last_step;
        self
    }

    /// Steps done since the beginning.
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Lets the power go after so many more steps.
    pub const fn cut_after(&mut self, steps: u64) {
        self.power_lost_at = Some(self.steps + steps);
    }

    /// The power is back; nothing will cut it.
    pub const fn power_on(&mut self) {
        self.power_lost_at = None;
    }

    /// How often each sector was erased.
    pub fn erases(&self) -> &[u32] {
        &self.erases
    }

    /// All bytes, to damage them.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    fn has_power(&self) -> Result<(), MockError> {
        if self.power_lost_at.is_some_and(|at| self.steps >= at) { Err(MockError::PowerLost) } else { Ok(()) }
    }

    fn step(&mut self) -> Result<(), MockError> {
        self.has_power()?;
        self.steps += 1;
        Ok(())
    }

    fn range(&self, offset: u32, length: usize) -> Result<core::ops::Range<usize>, MockError> {
        let start = (offset as usize).checked_sub(self.base).ok_or(MockError::OutOfBounds)?;
        let end = start + length;
        if end > self.bytes.len() { Err(MockError::OutOfBounds) } else { Ok(start..end) }
    }

    fn slices_of_erase(&self, sector_start: usize) -> Vec<usize> {
        let mut slices: Vec<usize> =
            (sector_start..sector_start + SECTOR_BYTES as usize).step_by(SLICE_BYTES).collect();
        match self.order {
            EraseOrder::Rising => {}
            EraseOrder::Falling => slices.reverse(),
            EraseOrder::Shuffled => {
                let mut random = Random(self.steps);
                for i in (1..slices.len()).rev() {
                    slices.swap(i, random.below(i as u64 + 1) as usize);
                }
            }
        }
        slices
    }

    fn erase_sector(&mut self, start: usize) -> Result<(), MockError> {
        for slice in self.slices_of_erase(start) {
            let outcome = self.step();
            let bytes = &mut self.bytes[slice..slice + SLICE_BYTES];
            if let Err(error) = outcome {
                if self.last_step == LastStep::Garbage {
                    let mut random = Random(self.steps ^ slice as u64);
                    bytes.iter_mut().for_each(|byte| *byte |= random.next() as u8);
                }
                return Err(error);
            }
            bytes.fill(0xff);
        }
        self.erases[start / SECTOR_BYTES as usize] += 1;
        Ok(())
    }
}

impl ErrorType for MockFlash {
    type Error = MockError;
}

impl ReadNorFlash for MockFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MockError> {
        self.has_power()?;
        let range = self.range(offset, bytes.len())?;
        bytes.copy_from_slice(&self.bytes[range]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.base + self.bytes.len()
    }
}

impl NorFlash for MockFlash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), MockError> {
        if !from.is_multiple_of(SECTOR_BYTES) || !to.is_multiple_of(SECTOR_BYTES) || to < from {
            return Err(MockError::OutOfBounds);
        }
        let range = self.range(from, (to - from) as usize)?;
        for sector in range.step_by(SECTOR_BYTES as usize) {
            self.erase_sector(sector)?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), MockError> {
        let range = self.range(offset, bytes.len())?;
        for (place, value) in range.zip(bytes) {
            if self.bytes[place] != 0xff {
                return Err(MockError::NotErased);
            }
            if let Err(error) = self.step() {
                if self.last_step == LastStep::Garbage {
                    self.bytes[place] &= value | Random(self.steps).next() as u8;
                }
                return Err(error);
            }
            self.bytes[place] &= value;
        }
        Ok(())
    }
}

/// Numbers that look random and are the same in every run (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next number.
    #[allow(clippy::should_implement_trait, reason = "an endless source is no iterator to loop over")]
    pub const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `bound`.
    pub const fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }
}
