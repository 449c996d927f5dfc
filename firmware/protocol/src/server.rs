//! The controller's side: frames in, requests to the [`Controller`], frames out.
//!
//! - [`Link`]: one wire (USB, UART, a TCP connection). It finds frames, counts what is none, limits the rate.
//! - [`Server`]: one for all links. It knows the upload in progress and answers requests.
//! - [`Controller`]: what the server needs of the board, or of the virtual controller.
//!
//! Pure: bytes and the time go in, bytes come out. Nothing waits.

use core::ops::RangeInclusive;

use crate::{
    FINGERPRINT, Refusal, VERSION,
    frame::{self, Deframer, Frame, FrameError},
    message::{Chunk, Hello, LogPage, Reply, Request, Response},
    rate::Bucket,
    status::{ClockState, Status},
};
use vitrine_exhibit::{
    inputs as exhibit,
    limits::LONGEST_LEASE,
    units::{Milliseconds, UtcSeconds},
};

/// After this silence another host may take over an upload.
pub const UPLOAD_SILENCE_MS: u64 = 10_000;

/// The times to which a clock may be set: from 2024 to the end of 2099.
pub const PLAUSIBLE_TIMES: RangeInclusive<UtcSeconds> = UtcSeconds(1_704_067_200)..=UtcSeconds(4_102_444_799);

/// What the server needs of a controller. All calls return at once, or within one erase of flash.
pub trait Controller {
    /// Serial number, firmware version and plan name. The server fills in version and fingerprint.
    fn hello(&mut self) -> Hello;
    /// The state of the exhibit.
    fn status(&mut self) -> Status;
    /// The clock.
    fn clock(&mut self) -> ClockState;
    /// Sets the clock.
    fn set_clock(&mut self, now: UtcSeconds) -> Result<(), Refusal>;
    /// Hands a host's request to the exhibit's next step, or refuses it.
    fn request(&mut self, request: exhibit::Request) -> Result<(), Refusal>;

    /// Prepares the inactive slot for a plan of `length` bytes.
    fn begin_plan(&mut self, length: u32) -> Result<(), Refusal>;
    /// Writes the next bytes of the plan; the server calls it with each byte once and in order.
    fn append_plan(&mut self, bytes: &[u8]) -> Result<(), Refusal>;
    /// Reads back what was written, holds it against `crc`, checks that it is a plan, and makes it the active one.
    fn commit_plan(&mut self, crc: u32) -> Result<(), Refusal>;
    /// Reads the active plan from `offset` on into `part`; gives the plan's length and the bytes read.
    fn read_plan(&mut self, offset: u32, part: &mut [u8]) -> Result<(u32, usize), Refusal>;
    /// Reads the event log from the entry `from` on.
    fn read_log(&mut self, from: u32) -> Result<LogPage, Refusal>;
    /// Reads what the firmware tells as it runs, from where the call before ended, into `part`; gives where to go on and
    /// how many bytes were read. A controller without such a log refuses.
    fn read_live(&mut self, _from: Option<u16>, _part: &mut [u8]) -> Result<(u16, usize), Refusal> {
        Err(Refusal::UnknownRequest)
    }
}

/// What went wrong on a link since it began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkFaults {
    /// Frames longer than any message.
    pub too_long: u32,
    /// Frames whose stuffing or CRC is broken.
    pub damaged: u32,
    /// Requests over the rate.
    pub too_many: u32,
}

/// One wire to a host.
#[derive(Debug)]
pub struct Link {
    number: u8,
    deframer: Deframer,
    bucket: Bucket,
    acquainted: bool,
    faults: LinkFaults,
}

/// A request that came in whole, to be given to [`Server::answer`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incoming {
    link: u8,
    sequence: u16,
    request: Result<Request, Refusal>,
}

impl Link {
    /// A new wire. Numbers tell the links of one server apart.
    pub const fn new(number: u8) -> Self {
        Self {
            number,
            deframer: Deframer::new(),
            bucket: Bucket::new(),
            acquainted: false,
            faults: LinkFaults { too_long: 0, damaged: 0, too_many: 0 },
        }
    }

    /// Takes the next byte; gives a request when it ends one. What is no frame is counted and not answered.
    pub fn push(&mut self, byte: u8, now_ms: u64) -> Option<Incoming> {
        let decoded = match self.deframer.push(byte)? {
            Ok(body) => frame::decode::<Request>(body)
                .map(|(sequence, request)| (sequence, Some(request)))
                .or_else(|| Some((frame::decode_sequence(body)?, None))),
            Err(FrameError::TooLong) => {
                self.faults.too_long = self.faults.too_long.saturating_add(1);
                None
            }
            Err(FrameError::Stuffing | FrameError::Checksum) => {
                self.faults.damaged = self.faults.damaged.saturating_add(1);
                None
            }
        };
        let (sequence, request) = decoded?;
        Some(Incoming { link: self.number, sequence, request: self.admit(request, now_ms) })
    }

    /// Forgets a host that has gone: the next one has to greet.
    pub fn reset(&mut self) {
        self.deframer.reset();
        self.acquainted = false;
    }

    /// What went wrong so far.
    pub const fn faults(&self) -> LinkFaults {
        self.faults
    }

    fn admit(&mut self, request: Option<Request>, now_ms: u64) -> Result<Request, Refusal> {
        if let Err(retry_ms) = self.bucket.take(now_ms) {
            self.faults.too_many = self.faults.too_many.saturating_add(1);
            return Err(Refusal::TooManyRequests { retry: Milliseconds(retry_ms) });
        }
        if let Some(Request::Hello { version, fingerprint }) = request {
            self.acquainted = version == VERSION && fingerprint == FINGERPRINT;
        } else if !self.acquainted {
            return Err(Refusal::Unacquainted { version: VERSION, fingerprint: FINGERPRINT });
        }
        request.ok_or(Refusal::UnknownRequest)
    }
}

/// An upload in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Upload {
    link: u8,
    length: u32,
    crc: u32,
    received: u32,
    heard_at_ms: u64,
    abandoned: bool,
}

/// Answers the requests of all links.
#[derive(Debug, Default)]
pub struct Server {
    upload: Option<Upload>,
    committed: Option<u32>,
}

impl Server {
    /// No upload in progress.
    pub const fn new() -> Self {
        Self { upload: None, committed: None }
    }

    /// Answers a request with the frame to send back on its link.
    pub fn answer<C: Controller>(&mut self, incoming: &Incoming, now_ms: u64, controller: &mut C) -> Frame {
        let reply: Reply = match &incoming.request {
            Ok(request) => self.respond(incoming.link, request, now_ms, controller),
            Err(refusal) => Err(*refusal),
        };
        frame::encode(incoming.sequence, &reply).unwrap_or_else(|_| {
            let refusal: Reply = Err(Refusal::AnswerTooLarge);
            frame::encode(incoming.sequence, &refusal).unwrap_or_default()
        })
    }

    /// Takes note that the host on a link has gone: another may go on with its upload at once.
    pub const fn link_closed(&mut self, link: u8) {
        if let Some(upload) = &mut self.upload
            && upload.link == link
        {
            upload.abandoned = true;
        }
    }

    fn respond<C: Controller>(
        &mut self,
        link: u8,
        request: &Request,
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        match request {
            Request::Hello { .. } => {
                let mut hello = controller.hello();
                hello.version = VERSION;
                hello.fingerprint = FINGERPRINT;
                Ok(Response::Hello(hello))
            }
            Request::Status => Ok(Response::Status(controller.status())),
            Request::Clock => Ok(Response::Clock(controller.clock())),
            Request::SetClock { now } => {
                if !PLAUSIBLE_TIMES.contains(now) {
                    return Err(Refusal::ImplausibleTime);
                }
                controller.set_clock(*now)?;
                Ok(Response::Clock(controller.clock()))
            }
            Request::BeginUpload { length, crc } => self.begin(link, *length, *crc, now_ms, controller),
            Request::UploadChunk { offset, bytes } => self.chunk(link, *offset, bytes, now_ms, controller),
            Request::CommitUpload { crc } => self.commit(link, *crc, controller),
            Request::ReadPlan { offset } => read_plan(*offset, controller),
            Request::Exhibit(request) => {
                check_lease(*request)?;
                controller.request(*request)?;
                Ok(Response::Done)
            }
            Request::ReadLog { from } => controller.read_log(*from).map(Response::Log),
            Request::ReadLive { from } => read_live(*from, controller),
        }
    }

    fn begin<C: Controller>(
        &mut self,
        link: u8,
        length: u32,
        crc: u32,
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        if let Some(upload) = &mut self.upload {
            let silence_ms = now_ms.saturating_sub(upload.heard_at_ms);
            if upload.link != link && !upload.abandoned && silence_ms < UPLOAD_SILENCE_MS {
                let left_ms = u32::try_from(UPLOAD_SILENCE_MS - silence_ms).unwrap_or(u32::MAX);
                return Err(Refusal::OtherUpload { retry: Milliseconds(left_ms) });
            }
            if upload.length == length && upload.crc == crc {
                upload.link = link;
                upload.heard_at_ms = now_ms;
                upload.abandoned = false;
                return Ok(Response::Upload { received: upload.received });
            }
        }
        self.upload = None;
        self.committed = None;
        controller.begin_plan(length)?;
        self.upload = Some(Upload { link, length, crc, received: 0, heard_at_ms: now_ms, abandoned: false });
        Ok(Response::Upload { received: 0 })
    }

    fn chunk<C: Controller>(
        &mut self,
        link: u8,
        offset: u32,
        bytes: &[u8],
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        let upload = self.upload.as_mut().filter(|upload| upload.link == link).ok_or(Refusal::NoUpload)?;
        upload.heard_at_ms = now_ms;
        let known = upload.received.checked_sub(offset).ok_or(Refusal::Gap { expected: upload.received })?;
        let end = u32::try_from(bytes.len())
            .ok()
            .and_then(|length| offset.checked_add(length))
            .filter(|end| *end <= upload.length)
            .ok_or(Refusal::PastEnd { length: upload.length })?;
        let fresh = usize::try_from(known).ok().and_then(|known| bytes.get(known..)).unwrap_or_default();
        if !fresh.is_empty() {
            match controller.append_plan(fresh) {
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

    fn commit<C: Controller>(&mut self, link: u8, crc: u32, controller: &mut C) -> Reply {
        if self.committed == Some(crc) {
            return Ok(Response::Committed { crc });
        }
        let upload = self.upload.filter(|upload| upload.link == link).ok_or(Refusal::NoUpload)?;
        if upload.received < upload.length {
            return Err(Refusal::Incomplete { received: upload.received, length: upload.length });
        }
        if upload.crc != crc {
            return Err(Refusal::Checksum { expected: upload.crc, found: crc });
        }
        match controller.commit_plan(crc) {
            Err(refusal) if refusal.retry().is_some() => return Err(refusal),
            outcome => {
                self.upload = None;
                outcome?;
            }
        }
        self.committed = Some(crc);
        Ok(Response::Committed { crc })
    }
}

fn read_plan<C: Controller>(offset: u32, controller: &mut C) -> Reply {
    let mut bytes = Chunk::new();
    let _always_fits = bytes.resize_default(bytes.capacity());
    let (length, read) = controller.read_plan(offset, &mut bytes)?;
    bytes.truncate(read);
    Ok(Response::PlanPart { length, offset, bytes })
}

fn read_live<C: Controller>(from: Option<u16>, controller: &mut C) -> Reply {
    let mut bytes = Chunk::new();
    let _always_fits = bytes.resize_default(bytes.capacity());
    let (next, read) = controller.read_live(from, &mut bytes)?;
    bytes.truncate(read);
    Ok(Response::Live { next, bytes })
}

fn check_lease(request: exhibit::Request) -> Result<(), Refusal> {
    use exhibit::Request::{Dark, Hold, NewStack, Open, Rearm, Release};
    match request {
        Hold { lease, .. } | Dark { lease } | Open { lease } => {
            if lease.0 == 0 || lease > LONGEST_LEASE {
                return Err(Refusal::Lease { most: LONGEST_LEASE });
            }
            Ok(())
        }
        Release | Rearm | NewStack => Ok(()),
    }
}
