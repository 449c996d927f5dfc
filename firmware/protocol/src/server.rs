//! The controller's side: frames in, requests to the [`Controller`], frames out.
//!
//! - [`Link`]: one wire (USB, UART, a TCP connection). It finds frames, counts what is none, limits the rate.
//! - [`Server`]: one for all links. It knows the upload in progress and what waits for its confirmation, and answers
//!   requests.
//! - [`Controller`]: what the server needs of the board, or of the virtual controller.
//!
//! Pure: bytes and the time go in, bytes come out. Nothing waits.

use core::ops::RangeInclusive;

use crate::{
    FINGERPRINT, Refusal, VERSION,
    firmware::FirmwareState,
    frame::{self, Deframer, Frame, FrameError},
    message::{Chunk, Hello, LogPage, Reply, Request, Response},
    rate::Bucket,
    status::{ClockState, Status},
};
use vitrine_exhibit::{
    inputs as exhibit,
    limits::LONGEST_LEASE,
    settings::Settings,
    units::{Milliseconds, UtcSeconds},
};

mod confirm;
mod upload;

pub use self::confirm::CONFIRM_WITHIN_MS;
use self::confirm::{Confirmations, Waiting};
pub use self::upload::UPLOAD_SILENCE_MS;
use self::upload::{Content, Kind, Uploads};

/// A clock that was set may be set again after this time: each setting wears the flash that keeps its drift.
pub const CLOCK_REST_MS: u64 = 1_000;

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
    /// Reads back what was written, holds it against `crc`, checks that it is a plan, and tells whether it asks for more
    /// than the active one does.
    fn plan_asks_for_more(&mut self, crc: u32) -> Result<bool, Refusal>;
    /// Reads back what was written, holds it against `crc`, checks that it is a plan, and makes it the active one.
    fn commit_plan(&mut self, crc: u32) -> Result<(), Refusal>;
    /// Reads the active plan from `offset` on into `part`; gives the plan's length and the bytes read.
    fn read_plan(&mut self, offset: u32, part: &mut [u8]) -> Result<(u32, usize), Refusal>;
    /// The settings.
    fn settings(&mut self) -> Settings;
    /// Keeps settings that lie within their bounds, and goes by them from now on.
    fn change_settings(&mut self, settings: &Settings) -> Result<(), Refusal>;
    /// Reads the event log from the entry `from` on.
    fn read_log(&mut self, from: u32) -> Result<LogPage, Refusal>;
    /// Reads what the firmware tells as it runs, from where the call before ended, into `part`; gives where to go on and
    /// how many bytes were read. A controller without such a log refuses.
    fn read_live(&mut self, _from: Option<u16>, _part: &mut [u8]) -> Result<(u16, usize), Refusal> {
        Err(Refusal::UnknownRequest)
    }

    /// The firmware that runs, and how far an update is.
    fn firmware(&mut self) -> FirmwareState;
    /// Prepares the place of the new image for `length` bytes.
    fn begin_update(&mut self, length: u32) -> Result<(), Refusal>;
    /// Writes the next bytes of the image and reads them back; the server calls it with each byte once and in order.
    fn append_update(&mut self, bytes: &[u8]) -> Result<(), Refusal>;
    /// Holds what was written against `crc`, verifies that it is a signed image for this board, and has the next start
    /// install it.
    fn commit_update(&mut self, crc: u32) -> Result<(), Refusal>;
    /// Restarts the controller, dark, when its answer has gone out.
    fn restart(&mut self) -> Result<(), Refusal>;
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

/// Where a link's wire ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Beside the exhibit.
    Cable,
    /// Anywhere: its hosts may only ask for less.
    Network,
}

/// One wire to a host.
#[derive(Debug)]
pub struct Link {
    number: u8,
    reach: Reach,
    deframer: Deframer,
    bucket: Bucket,
    acquainted: bool,
    faults: LinkFaults,
}

/// A request that came in whole, to be given to [`Server::answer`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incoming {
    link: u8,
    reach: Reach,
    sequence: u16,
    request: Result<Request, Refusal>,
}

impl Incoming {
    /// What is asked, where it is a request that may be answered.
    pub const fn request(&self) -> Option<&Request> {
        match &self.request {
            Ok(request) => Some(request),
            Err(_) => None,
        }
    }
}

impl Link {
    /// A new wire. Numbers tell the links of one server apart.
    pub const fn new(number: u8, reach: Reach) -> Self {
        Self {
            number,
            reach,
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
        Some(Incoming {
            link: self.number,
            reach: self.reach,
            sequence,
            request: self.admit(request, now_ms),
        })
    }

    /// Says anew where the wire ends.
    pub const fn set_reach(&mut self, reach: Reach) {
        self.reach = reach;
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
        } else if !self.acquainted && !request.as_ref().is_some_and(Request::is_of_an_update) {
            return Err(Refusal::Unacquainted { version: VERSION, fingerprint: FINGERPRINT });
        }
        request.ok_or(Refusal::UnknownRequest)
    }
}

/// Answers the requests of all links.
#[derive(Debug, Default)]
pub struct Server {
    uploads: Uploads,
    confirmations: Confirmations,
    clock_set_at_ms: Option<u64>,
}

impl Server {
    /// No upload in progress.
    pub const fn new() -> Self {
        Self { uploads: Uploads::new(), confirmations: Confirmations::new(), clock_set_at_ms: None }
    }

    /// Answers a request with the frame to send back on its link.
    pub fn answer<C: Controller>(&mut self, incoming: &Incoming, now_ms: u64, controller: &mut C) -> Frame {
        let reply: Reply = match &incoming.request {
            Ok(request) if incoming.reach == Reach::Network && asks_for_more(request) => {
                Err(Refusal::CableOnly)
            }
            Ok(request) => self.respond(incoming, request, now_ms, controller),
            Err(refusal) => Err(*refusal),
        };
        frame::encode(incoming.sequence, &reply).unwrap_or_else(|_| {
            let refusal: Reply = Err(Refusal::AnswerTooLarge);
            frame::encode(incoming.sequence, &refusal).unwrap_or_default()
        })
    }

    /// Takes note that the host on a link has gone: another may go on with its upload at once.
    pub fn link_closed(&mut self, link: u8) {
        self.uploads.link_closed(link);
        self.confirmations.link_closed(link);
    }

    fn respond<C: Controller>(
        &mut self,
        incoming: &Incoming,
        request: &Request,
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        let link = incoming.link;
        match request {
            Request::Hello { .. } => {
                let mut hello = controller.hello();
                hello.version = VERSION;
                hello.fingerprint = FINGERPRINT;
                Ok(Response::Hello(hello))
            }
            Request::Status => Ok(Response::Status(controller.status())),
            Request::Clock => Ok(Response::Clock(controller.clock())),
            Request::SetClock { now } => self.set_clock(*now, now_ms, controller),
            Request::BeginUpload { length, crc } => {
                let content = Content { kind: Kind::Plan, length: *length, crc: *crc };
                self.uploads.begin(link, content, now_ms, controller)
            }
            Request::BeginUpdate { length, crc } => {
                let content = Content { kind: Kind::Firmware, length: *length, crc: *crc };
                self.uploads.begin(link, content, now_ms, controller)
            }
            Request::UploadChunk { offset, bytes } => {
                self.uploads.chunk(link, *offset, bytes, now_ms, controller)
            }
            Request::CommitUpload { crc } => self.commit(incoming, *crc, now_ms, controller),
            Request::ReadPlan { offset } => read_plan(*offset, controller),
            Request::Exhibit(exhibit::Request::NewStack) => {
                Ok(self.confirmations.want(link, Waiting::NewStack, now_ms))
            }
            Request::Exhibit(request) => {
                check_lease(*request)?;
                controller.request(*request)?;
                Ok(Response::Done)
            }
            Request::ReadSettings => Ok(Response::Settings(controller.settings())),
            Request::ChangeSettings(settings) => {
                settings.check().map_err(Refusal::UnfitSettings)?;
                Ok(self.confirmations.want(link, Waiting::Settings(settings.clone()), now_ms))
            }
            Request::Confirm { code } => self.confirm(link, *code, now_ms, controller),
            Request::ReadLog { from } => controller.read_log(*from).map(Response::Log),
            Request::ReadLive { from } => read_live(*from, controller),
            Request::Firmware => Ok(Response::Firmware(controller.firmware())),
            Request::Restart => controller.restart().map(|()| Response::Done),
        }
    }

    fn set_clock<C: Controller>(&mut self, now: UtcSeconds, now_ms: u64, controller: &mut C) -> Reply {
        if !PLAUSIBLE_TIMES.contains(&now) {
            return Err(Refusal::ImplausibleTime);
        }
        let rested_ms = self.clock_set_at_ms.map_or(CLOCK_REST_MS, |at_ms| now_ms.saturating_sub(at_ms));
        if rested_ms < CLOCK_REST_MS {
            let left_ms = u32::try_from(CLOCK_REST_MS - rested_ms).unwrap_or(u32::MAX);
            return Err(Refusal::TooManyRequests { retry: Milliseconds(left_ms) });
        }
        controller.set_clock(now)?;
        self.clock_set_at_ms = Some(now_ms);
        Ok(Response::Clock(controller.clock()))
    }

    /// Makes a plan active, or has an image installed by the next start; a plan that asks for more than the active one waits for its confirmation.
    fn commit<C: Controller>(
        &mut self,
        incoming: &Incoming,
        crc: u32,
        now_ms: u64,
        controller: &mut C,
    ) -> Reply {
        let link = incoming.link;
        if self.uploads.complete(link, crc)? == Some(Kind::Plan)
            && self.uploads.verified(controller.plan_asks_for_more(crc))?
        {
            return match incoming.reach {
                Reach::Network => Err(Refusal::CableOnly),
                Reach::Cable => Ok(self.confirmations.want(link, Waiting::Plan { crc }, now_ms)),
            };
        }
        self.uploads.commit(link, crc, controller)
    }

    /// Carries out what waits for this confirmation. A repeated confirmation, whose first answer was lost, is told the same.
    fn confirm<C: Controller>(&mut self, link: u8, code: u32, now_ms: u64, controller: &mut C) -> Reply {
        if let Some(response) = self.confirmations.done(link, code) {
            return Ok(response);
        }
        let response = match self.confirmations.waiting(link, code, now_ms)? {
            Waiting::NewStack => {
                controller.request(exhibit::Request::NewStack)?;
                Response::Done
            }
            Waiting::Settings(settings) => {
                controller.change_settings(settings)?;
                Response::Settings(settings.clone())
            }
            Waiting::Plan { crc } => {
                let crc = *crc;
                self.uploads.commit(link, crc, controller)?
            }
        };
        self.confirmations.finish(&response);
        Ok(response)
    }
}

/// Whether a request asks for more than the exhibit gives now; a plan is looked at when it is whole.
const fn asks_for_more(request: &Request) -> bool {
    use exhibit::Request::{Dark, Release};
    match request {
        Request::Exhibit(request) => !matches!(request, Dark { .. } | Release),
        Request::SetClock { .. } | Request::ChangeSettings(_) | Request::Confirm { .. } => true,
        Request::BeginUpdate { .. } | Request::Restart => true,
        _ => false,
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
