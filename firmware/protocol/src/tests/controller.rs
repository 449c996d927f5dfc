//! A controller in memory, that remembers what it was asked.

use std::{vec, vec::Vec};

use vitrine_exhibit::{
    inputs,
    settings::Settings,
    units::{Milliseconds, UtcSeconds},
};

use super::samples;
use crate::{
    Controller, Refusal, Status,
    firmware::{FirmwareState, ImageFault, Progress},
    message::{Hello, LogPage},
    plan_file,
    status::ClockState,
};

#[derive(Default)]
pub(super) struct Memory {
    pub(super) active: Option<Vec<u8>>,
    pub(super) staged: Vec<u8>,
    pub(super) asked: Vec<inputs::Request>,
    pub(super) now: Option<UtcSeconds>,
    pub(super) begun: u32,
    /// The staged plan asks for more than the active one.
    pub(super) asks_for_more: bool,
    pub(super) settings: Settings,
    /// The next write of flash is refused with this.
    pub(super) refusal: Option<Refusal>,
    /// The new firmware image; good where it begins with a zero.
    pub(super) image: Vec<u8>,
    pub(super) progress: Progress,
    pub(super) restarts: u32,
}

pub(super) const MOST: u32 = 4_096;

impl Memory {
    fn may_write(&mut self) -> Result<(), Refusal> {
        self.refusal.take().map_or(Ok(()), Err)
    }
}

impl Controller for Memory {
    fn hello(&mut self) -> Hello {
        samples::hello()
    }
    fn status(&mut self) -> Status {
        samples::status()
    }
    fn clock(&mut self) -> ClockState {
        ClockState { now: self.now, ..ClockState::default() }
    }
    fn set_clock(&mut self, now: UtcSeconds) -> Result<(), Refusal> {
        self.now = Some(now);
        Ok(())
    }
    fn request(&mut self, request: inputs::Request) -> Result<(), Refusal> {
        self.asked.push(request);
        Ok(())
    }
    fn begin_plan(&mut self, length: u32) -> Result<(), Refusal> {
        if length == 0 || length > MOST {
            return Err(Refusal::PlanLength { most: MOST });
        }
        self.may_write()?;
        self.staged.clear();
        self.begun += 1;
        Ok(())
    }
    fn append_plan(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        self.may_write()?;
        self.staged.extend_from_slice(bytes);
        Ok(())
    }
    fn plan_asks_for_more(&mut self, crc: u32) -> Result<bool, Refusal> {
        let found = plan_file::crc(&self.staged);
        if found == crc { Ok(self.asks_for_more) } else { Err(Refusal::Checksum { expected: crc, found }) }
    }
    fn commit_plan(&mut self, crc: u32) -> Result<(), Refusal> {
        self.may_write()?;
        let found = plan_file::crc(&self.staged);
        if found != crc {
            return Err(Refusal::Checksum { expected: crc, found });
        }
        self.active = Some(self.staged.clone());
        Ok(())
    }
    fn read_plan(&mut self, offset: u32, part: &mut [u8]) -> Result<(u32, usize), Refusal> {
        let active = self.active.as_ref().ok_or(Refusal::NoPlan)?;
        let rest = active.get(offset as usize..).unwrap_or_default();
        let read = rest.len().min(part.len());
        part[..read].copy_from_slice(&rest[..read]);
        Ok((active.len() as u32, read))
    }
    fn settings(&mut self) -> Settings {
        self.settings.clone()
    }
    fn change_settings(&mut self, settings: &Settings) -> Result<(), Refusal> {
        self.may_write()?;
        self.settings = settings.clone();
        Ok(())
    }
    fn read_log(&mut self, _from: u32) -> Result<LogPage, Refusal> {
        Ok(samples::largest_log_page())
    }
    fn firmware(&mut self) -> FirmwareState {
        FirmwareState { progress: self.progress, ..samples::firmware() }
    }
    fn begin_update(&mut self, length: u32) -> Result<(), Refusal> {
        if length == 0 || length > MOST {
            return Err(Refusal::ImageLength { most: MOST });
        }
        self.may_write()?;
        self.image.clear();
        Ok(())
    }
    fn append_update(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        self.may_write()?;
        self.image.extend_from_slice(bytes);
        Ok(())
    }
    fn commit_update(&mut self, crc: u32) -> Result<(), Refusal> {
        self.may_write()?;
        let found = plan_file::crc(&self.image);
        if found != crc {
            return Err(Refusal::Checksum { expected: crc, found });
        }
        if self.image[0] != 0 {
            return Err(Refusal::UnfitImage(ImageFault::Signature));
        }
        self.progress = Progress::Wanted;
        Ok(())
    }
    fn restart(&mut self) -> Result<(), Refusal> {
        self.restarts += 1;
        Ok(())
    }
}

pub(super) const LAMPS_IN_MOTION: Refusal = Refusal::LampsInMotion { retry: Milliseconds(100) };

pub(super) fn bytes(length: usize) -> Vec<u8> {
    vec![0; length].iter().enumerate().map(|(i, _)| (i * 7 + i / 256) as u8).collect()
}
