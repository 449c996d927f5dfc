//! A plan or a firmware image on its way: begin, chunks in order, commit.

use super::Controller;
use crate::{
    Refusal,
    message::{Reply, Response},
};
use vitrine_exhibit::units::Milliseconds;

/// After this silence another host may take over an upload.
pub const UPLOAD_SILENCE_MS: u64 = 10_000;

/// What is being uploaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Content {
    pub(super) kind: Kind,
    pub(super) length: u32,
    pub(super) crc: u32,
}

/// Where it goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Plan,
    Firmware,
}

impl Kind {
    fn begin<C: Controller>(self, length: u32, controller: &mut C) -> Result<(), Refusal> {
        match self {
            Self::Plan => controller.begin_plan(length),
            Self::Firmware => controller.begin_update(length),
        }
    }

    fn append<C: Controller>(self, bytes: &[u8], controller: &mut C) -> Result<(), Refusal> {
        match self {
            Self::Plan => controller.append_plan(bytes),
            Self::Firmware => controller.append_update(bytes),
        }
    }

    fn commit<C: Controller>(self, crc: u32, controller: &mut C) -> Result<(), Refusal> {
        match self {
            Self::Plan => controller.commit_plan(crc),
            Self::Firmware => controller.commit_update(crc),
        }
    }
}

/// An upload in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Upload {
    link: u8,
    content: Content,
    received: u32,
    heard_at_ms: u64,
    abandoned: bool,
}

/// The upload in progress, and the last that was committed.
#[derive(Debug, Default)]
pub(super) struct Uploads {
    upload: Option<Upload>,
    committed: Option<u32>,
}

impl Uploads {
    pub(super) const fn new() -> Self {
        Self { upload: None, committed: None }
    }

    pub(super) const fn link_closed(&mut self, link: u8) {
        if let Some(upload) = &mut self.upload
            && upload.link == link
        {
            upload.abandoned = true;
        }
    }

    pub(super) fn begin<C: Controller>(
        &mut self,
        link: u8,
        content: Content,
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        if let Some(upload) = &mut self.upload {
            let silence_ms = now_ms.saturating_sub(upload.heard_at_ms);
            if upload.link != link && !upload.abandoned && silence_ms < UPLOAD_SILENCE_MS {
                let left_ms = u32::try_from(UPLOAD_SILENCE_MS - silence_ms).unwrap_or(u32::MAX);
                return Err(Refusal::OtherUpload { retry: Milliseconds(left_ms) });
            }
            if upload.content == content {
                upload.link = link;
                upload.heard_at_ms = now_ms;
                upload.abandoned = false;
                return Ok(Response::Upload { received: upload.received });
            }
        }
        self.upload = None;
        self.committed = None;
        content.kind.begin(content.length, controller)?;
        self.upload = Some(Upload { link, content, received: 0, heard_at_ms: now_ms, abandoned: false });
        Ok(Response::Upload { received: 0 })
    }

    pub(super) fn chunk<C: Controller>(
        &mut self,
        link: u8,
        offset: u32,
        bytes: &[u8],
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        let upload = self.upload.as_mut().filter(|upload| upload.link == link).ok_or(Refusal::NoUpload)?;
        upload.heard_at_ms = now_ms;
        let length = upload.content.length;
        let known = upload.received.checked_sub(offset).ok_or(Refusal::Gap { expected: upload.received })?;
        let end = u32::try_from(bytes.len())
            .ok()
            .and_then(|count| offset.checked_add(count))
            .filter(|end| *end <= length)
            .ok_or(Refusal::PastEnd { length })?;
        let fresh = usize::try_from(known).ok().and_then(|known| bytes.get(known..)).unwrap_or_default();
        if !fresh.is_empty() {
            match upload.content.kind.append(fresh, controller) {
                Ok(()) => upload.received = end,
                Err(refusal) if refusal.retry().is_some() => return Err(refusal),
                Err(refusal) => {
                    self.upload = None;
                    return Err(refusal);
                }
            }
        }
        Ok(Response::Upload { received: self.upload.map_or(0, |upload| upload.received) })
    }

    /// Tells whether all of an upload has come that is to be committed with this CRC, and what it is; none where it is
    /// committed already.
    pub(super) fn complete(&self, link: u8, crc: u32) -> Result<Option<Kind>, Refusal> {
        if self.committed == Some(crc) {
            return Ok(None);
        }
        let upload = self.upload.filter(|upload| upload.link == link).ok_or(Refusal::NoUpload)?;
        let Content { kind, length, crc: announced } = upload.content;
        if upload.received < length {
            return Err(Refusal::Incomplete { received: upload.received, length });
        }
        if announced != crc {
            return Err(Refusal::Checksum { expected: announced, found: crc });
        }
        Ok(Some(kind))
    }

    /// Gives up an upload that its controller has refused for good.
    pub(super) fn verified<T>(&mut self, outcome: Result<T, Refusal>) -> Result<T, Refusal> {
        if outcome.as_ref().is_err_and(|refusal| refusal.retry().is_none()) {
            self.upload = None;
        }
        outcome
    }

    /// Makes a complete upload the active plan, or has the next start install it.
    pub(super) fn commit<C: Controller>(&mut self, link: u8, crc: u32, controller: &mut C) -> Reply {
        if let Some(kind) = self.complete(link, crc)? {
            let outcome = kind.commit(crc, controller);
            self.verified(outcome)?;
            self.upload = None;
            self.committed = Some(crc);
        }
        Ok(Response::Committed { crc })
    }
}
