//! What asks for more, and waits until its host has said so twice.

use crate::{Refusal, message::Response};
use vitrine_exhibit::settings::Settings;

/// How long a request waits for its confirmation.
pub const CONFIRM_WITHIN_MS: u64 = 60_000;

/// What is carried out once it is confirmed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Waiting {
    /// A fresh stack is declared.
    NewStack,
    /// The settings change.
    Settings(Settings),
    /// The uploaded plan becomes the active one.
    Plan {
        /// Its CRC.
        crc: u32,
    },
}

#[derive(Clone, Debug)]
struct Wanted {
    link: u8,
    code: u32,
    until_ms: u64,
    waiting: Waiting,
    /// It has been carried out, with this answer.
    done: Option<Response>,
}

/// The last request that wanted a confirmation, of all links.
#[derive(Clone, Debug, Default)]
pub(super) struct Confirmations {
    wanted: Option<Wanted>,
    count: u32,
}

impl Confirmations {
    pub(super) const fn new() -> Self {
        Self { wanted: None, count: 0 }
    }

    /// Lets a request wait; one that waited until now is forgotten. Gives the answer with its code.
    pub(super) fn want(&mut self, link: u8, waiting: Waiting, now_ms: u64) -> Response {
        if let Some(wanted) = &mut self.wanted
            && wanted.link == link
            && wanted.waiting == waiting
            && wanted.done.is_none()
        {
            // The same request again, whose answer was lost.
            wanted.until_ms = now_ms.saturating_add(CONFIRM_WITHIN_MS);
            return Response::Confirm { code: wanted.code };
        }
        self.count = self.count.wrapping_add(1);
        // Different each time, so that no frame recorded earlier confirms anything; not a secret.
        let code = self.count.wrapping_mul(0x9e37_79b9) ^ now_ms as u32;
        let until_ms = now_ms.saturating_add(CONFIRM_WITHIN_MS);
        self.wanted = Some(Wanted { link, code, until_ms, waiting, done: None });
        Response::Confirm { code }
    }

    /// What waits for this confirmation.
    pub(super) fn waiting(&self, link: u8, code: u32, now_ms: u64) -> Result<&Waiting, Refusal> {
        let wanted = self.of(link, code).filter(|wanted| now_ms <= wanted.until_ms);
        wanted.map(|wanted| &wanted.waiting).ok_or(Refusal::NothingToConfirm)
    }

    /// What was answered when this confirmation came first.
    pub(super) fn done(&self, link: u8, code: u32) -> Option<Response> {
        self.of(link, code)?.done.clone()
    }

    /// Takes note of the answer to the confirmed request.
    pub(super) fn finish(&mut self, response: &Response) {
        if let Some(wanted) = &mut self.wanted {
            wanted.done = Some(response.clone());
        }
    }

    /// Forgets what a host that has gone asked for.
    pub(super) fn link_closed(&mut self, link: u8) {
        if let Some(wanted) = &self.wanted
            && wanted.link == link
        {
            self.wanted = None;
        }
    }

    fn of(&self, link: u8, code: u32) -> Option<&Wanted> {
        self.wanted.as_ref().filter(|wanted| wanted.link == link && wanted.code == code)
    }
}
