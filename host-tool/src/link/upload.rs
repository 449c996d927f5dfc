//! Sending a plan, and reading it back.

use vitrine_exhibit::plan::Plan;
use vitrine_protocol::{
    MAX_CHUNK, Refusal, Request, Response,
    message::Chunk,
    plan_file::{self, MAX_PLAN_BYTES},
};

use super::{Client, LinkError};
use crate::plain::make_plain;

/// What is being done with a plan or with firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// It is sent.
    Sending,
    /// The controller verifies it and makes it the active one.
    Committing,
    /// The active plan is read back and compared.
    ReadingBack,
    /// The boot loader installs the new firmware.
    Installing,
    /// The new firmware runs and is to confirm itself.
    OnTrial,
}

/// How far an upload has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// Bytes done in this stage.
    pub done: usize,
    /// Bytes in all.
    pub total: usize,
}

impl Client {
    /// Sends a plan (`plan.bin`), has it verified and made active, reads it back and compares. The old plan stays
    /// active until the controller has verified the new one. An upload that broke off is continued. A plan that asks for
    /// more than the active one wants [`Client::confirm_more`].
    ///
    /// # Errors
    /// Those of the link, the controller's refusal, and a difference in what is read back.
    pub fn upload(&mut self, plan: &[u8], progress: &mut dyn FnMut(Progress)) -> Result<(), LinkError> {
        let total = plan.len();
        if total == 0 || total > MAX_PLAN_BYTES {
            return Err(LinkError::PlanLength { length: total, most: MAX_PLAN_BYTES });
        }
        let crc = plan_file::crc(plan);
        self.send_and_commit(&Request::BeginUpload { length: total as u32, crc }, plan, crc, progress)?;
        let read = self.read_plan_with(&mut |done| {
            progress(Progress { stage: Stage::ReadingBack, done, total });
        })?;
        match first_difference(plan, &read) {
            None => Ok(()),
            Some(offset) => Err(LinkError::ReadBack { address: self.address().clone(), offset }),
        }
    }

    /// Reads the active plan.
    ///
    /// # Errors
    /// Those of the link, and [`Refusal::NoPlan`].
    pub fn read_plan(&mut self) -> Result<Vec<u8>, LinkError> {
        self.read_plan_with(&mut |_| {})
    }

    /// The active plan with names that can be told; none if there is none, or this version cannot read it.
    ///
    /// # Errors
    /// Those of the link.
    pub fn active_plan(&mut self) -> Result<Option<Plan>, LinkError> {
        let bytes = match self.read_plan() {
            Err(LinkError::Refused { refusal: Refusal::NoPlan, .. }) => return Ok(None),
            read => read?,
        };
        let Ok(mut plan) = plan_file::decode(&bytes) else { return Ok(None) };
        make_plain(&mut plan.name);
        plan.views.iter_mut().for_each(|view| make_plain(&mut view.id));
        Ok(Some(plan))
    }

    /// Sends what `begin` announces and has it committed; once more where another host has left damaged parts of it.
    pub(super) fn send_and_commit(
        &mut self,
        begin: &Request,
        bytes: &[u8],
        crc: u32,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(), LinkError> {
        match self.send_once(begin, bytes, crc, progress) {
            Err(LinkError::Refused { refusal: Refusal::Checksum { .. }, .. }) => {
                self.send_once(begin, bytes, crc, progress)
            }
            outcome => outcome,
        }
    }

    fn send_once(
        &mut self,
        begin: &Request,
        content: &[u8],
        crc: u32,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(), LinkError> {
        let total = content.len();
        let mut sent = self.upload_step(begin)?;
        while sent < total {
            progress(Progress { stage: Stage::Sending, done: sent, total });
            let part = &content[sent..total.min(sent + MAX_CHUNK)];
            let bytes = Chunk::from_slice(part).map_err(|_| self.wrong_answer())?;
            let received = self.upload_step(&Request::UploadChunk { offset: sent as u32, bytes })?;
            if received <= sent || received > total {
                return Err(self.wrong_answer());
            }
            sent = received;
        }
        progress(Progress { stage: Stage::Committing, done: total, total });
        let help =
            "if the higher limits or the other calibration are meant, say `vitrine upload --allow-more`";
        match self.ask_for_more(&Request::CommitUpload { crc }, "take a plan that asks for more", help)? {
            Response::Committed { crc: active } if active == crc => Ok(()),
            _ => Err(self.wrong_answer()),
        }
    }

    fn upload_step(&mut self, request: &Request) -> Result<usize, LinkError> {
        match self.ask(request)? {
            Response::Upload { received } => Ok(received as usize),
            _ => Err(self.wrong_answer()),
        }
    }

    fn read_plan_with(&mut self, progress: &mut dyn FnMut(usize)) -> Result<Vec<u8>, LinkError> {
        let mut plan = Vec::new();
        loop {
            progress(plan.len());
            let wanted = plan.len() as u32;
            match self.ask(&Request::ReadPlan { offset: wanted })? {
                Response::PlanPart { length, offset, bytes } if offset == wanted => {
                    if bytes.is_empty() || plan.len() >= length as usize {
                        return Ok(plan);
                    }
                    plan.extend_from_slice(&bytes);
                    if plan.len() >= length as usize {
                        progress(plan.len());
                        return Ok(plan);
                    }
                }
                _ => return Err(self.wrong_answer()),
            }
        }
    }
}

fn first_difference(sent: &[u8], read: &[u8]) -> Option<usize> {
    let shared = sent.len().min(read.len());
    sent.iter()
        .zip(read)
        .position(|(sent, read)| sent != read)
        .or_else(|| (sent.len() != read.len()).then_some(shared))
}
