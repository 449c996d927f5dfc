//! A host's side of the protocol: one question, one answer.

use std::{
    fmt, thread,
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use vitrine_exhibit::{
    inputs,
    settings::Settings,
    units::{Milliseconds, UtcSeconds},
};
use vitrine_protocol::{
    Deframer, FINGERPRINT, Hello, Refusal, Request, Response, Status, VERSION,
    frame::{self, Frame},
    message::{LogEntry, LogPage, Reply},
    status::ClockState,
};

use super::{Address, LinkError, Transport, transport};
use crate::plain::make_plain;

/// How long one try of a request waits for its answer: an erase of flash takes up to 0.4 s.
const PATIENCE: Duration = Duration::from_millis(1_500);
/// How long the first greeting waits.
const GREETING_PATIENCE: Duration = Duration::from_millis(700);
/// How often a request is sent before the controller counts as silent.
const TRIES: u32 = 4;
/// How long a request is repeated that the controller puts off.
const PUT_OFF_AT_MOST: Duration = Duration::from_secs(20);
/// The same where it waits for lamps that fade: a fade takes a minute at most.
const FADES_AT_MOST: Duration = Duration::from_secs(75);

fn patience_with(refusal: &Refusal) -> Duration {
    if matches!(refusal, Refusal::LampsInMotion { .. }) { FADES_AT_MOST } else { PUT_OFF_AT_MOST }
}

/// A connection to a controller that has greeted in this program's version.
pub struct Client {
    address: Address,
    transport: Box<dyn Transport>,
    deframer: Deframer,
    unread: Vec<u8>,
    sequence: u16,
    hello: Hello,
    confirms: bool,
}

impl fmt::Debug for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client").field("address", &self.address).field("hello", &self.hello).finish()
    }
}

impl Client {
    /// Opens the port and greets.
    ///
    /// # Errors
    /// Where the port cannot be opened, or what is there is no controller or one of another version.
    pub fn open(address: &Address) -> Result<Self, LinkError> {
        Self::over(address.clone(), transport::open(address)?)
    }

    /// Opens the port and greets a controller of whatever version: enough for an update of its firmware, and for nothing else.
    ///
    /// # Errors
    /// Where the port cannot be opened, or what is there is no controller.
    pub fn open_for_update(address: &Address) -> Result<Self, LinkError> {
        let mut client = Self::unacquainted(address.clone(), transport::open(address)?);
        client.hello = client.greet()?;
        Ok(client)
    }

    /// Greets over an open transport. `address` is for messages.
    ///
    /// # Errors
    /// Where what is there is no controller or one of another version.
    pub fn over(address: Address, transport: Box<dyn Transport>) -> Result<Self, LinkError> {
        let mut client = Self::unacquainted(address, transport);
        client.hello = client.greet()?;
        let (address, hello) = (client.address.clone(), client.hello.clone());
        if hello.version != VERSION {
            return Err(LinkError::OtherVersion { address, hello: Box::new(hello) });
        }
        if hello.fingerprint != FINGERPRINT {
            return Err(LinkError::OtherBuild { address, hello: Box::new(hello) });
        }
        Ok(client)
    }

    fn unacquainted(address: Address, transport: Box<dyn Transport>) -> Self {
        Self {
            address,
            transport,
            deframer: Deframer::new(),
            unread: Vec::new(),
            sequence: first_sequence(),
            hello: Hello {
                version: 0,
                fingerprint: 0,
                serial_number: heapless::String::new(),
                firmware: heapless::String::new(),
                name: heapless::String::new(),
            },
            confirms: false,
        }
    }

    /// Confirms from now on whatever asks for more than the exhibit gives: a person has said so.
    pub const fn confirm_more(&mut self) {
        self.confirms = true;
    }

    /// Where the controller is.
    pub const fn address(&self) -> &Address {
        &self.address
    }

    /// How the controller greeted.
    pub const fn hello(&self) -> &Hello {
        &self.hello
    }

    /// How is the exhibit?
    ///
    /// # Errors
    /// Those of the link.
    pub fn status(&mut self) -> Result<Status, LinkError> {
        match self.ask(&Request::Status)? {
            Response::Status(status) => Ok(status),
            _ => Err(self.wrong_answer()),
        }
    }

    /// What time is it there?
    ///
    /// # Errors
    /// Those of the link.
    pub fn clock(&mut self) -> Result<ClockState, LinkError> {
        match self.ask(&Request::Clock)? {
            Response::Clock(clock) => Ok(clock),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Sets the controller's clock.
    ///
    /// # Errors
    /// Those of the link, and the controller's refusal.
    pub fn set_clock(&mut self, now: UtcSeconds) -> Result<ClockState, LinkError> {
        match self.ask(&Request::SetClock { now })? {
            Response::Clock(clock) => Ok(clock),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Shows one view, from 0, whoever stands where, until the lease ends.
    ///
    /// # Errors
    /// Those of the link, and the controller's refusal.
    pub fn hold(&mut self, view: u8, lease: Milliseconds) -> Result<(), LinkError> {
        self.tell(inputs::Request::Hold { view, lease })
    }

    /// Keeps both lamps off until the lease ends.
    ///
    /// # Errors
    /// Those of the link, and the controller's refusal.
    pub fn dark(&mut self, lease: Milliseconds) -> Result<(), LinkError> {
        self.tell(inputs::Request::Dark { lease })
    }

    /// Lights the exhibit outside the schedule's hours until the lease ends.
    ///
    /// # Errors
    /// Those of the link, and the controller's refusal.
    pub fn open_outside_hours(&mut self, lease: Milliseconds) -> Result<(), LinkError> {
        self.tell(inputs::Request::Open { lease })
    }

    /// Ends what a host asked for.
    ///
    /// # Errors
    /// Those of the link.
    pub fn release(&mut self) -> Result<(), LinkError> {
        self.tell(inputs::Request::Release)
    }

    /// Re-arms after a latched fault or an opened interlock.
    ///
    /// # Errors
    /// Those of the link, and the controller's refusal where the cause is still there.
    pub fn rearm(&mut self) -> Result<(), LinkError> {
        self.tell(inputs::Request::Rearm)
    }

    /// Declares that a fresh stack stands in the exhibit; wants [`Client::confirm_more`].
    ///
    /// # Errors
    /// Those of the link, and [`LinkError::Unconfirmed`].
    pub fn new_stack(&mut self) -> Result<(), LinkError> {
        let request = Request::Exhibit(inputs::Request::NewStack);
        let help = "replace the films first, then say `vitrine new-stack --yes`";
        match self.ask_for_more(&request, "begin the life of a fresh stack", help)? {
            Response::Done => Ok(()),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Reads the settings of the board and its place.
    ///
    /// # Errors
    /// Those of the link.
    pub fn settings(&mut self) -> Result<Settings, LinkError> {
        match self.ask(&Request::ReadSettings)? {
            Response::Settings(settings) => Ok(settings),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Changes all settings; wants [`Client::confirm_more`]. Gives them as they are kept now.
    ///
    /// # Errors
    /// Those of the link, the controller's refusal, and [`LinkError::Unconfirmed`].
    pub fn change_settings(&mut self, settings: &Settings) -> Result<Settings, LinkError> {
        let request = Request::ChangeSettings(settings.clone());
        let help =
            "say it once more with --yes: settings correct what the sensors say that keep the lamps cool";
        match self.ask_for_more(&request, "change its settings", help)? {
            Response::Settings(settings) => Ok(settings),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Reads a piece of the event log, from this entry on.
    ///
    /// # Errors
    /// Those of the link.
    pub fn log_page(&mut self, from: u32) -> Result<LogPage, LinkError> {
        match self.ask(&Request::ReadLog { from })? {
            Response::Log(page) => Ok(page),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Reads the event log from this entry on to its end, oldest first.
    ///
    /// # Errors
    /// Those of the link.
    pub fn log(&mut self, from: u32) -> Result<Vec<LogEntry>, LinkError> {
        let mut entries = Vec::new();
        let mut next = from;
        loop {
            let page = self.log_page(next)?;
            let Some(last) = page.entries.last() else { return Ok(entries) };
            next = last.sequence.saturating_add(1);
            entries.extend_from_slice(&page.entries);
            if next >= page.next {
                return Ok(entries);
            }
        }
    }

    /// Reads what the firmware tells as it runs, in defmt's encoding, from where the call before ended; gives where to go
    /// on.
    ///
    /// # Errors
    /// Those of the link, and the refusal of a controller without such a log.
    pub fn live(&mut self, from: Option<u16>) -> Result<(u16, Vec<u8>), LinkError> {
        match self.ask(&Request::ReadLive { from })? {
            Response::Live { next, bytes } => Ok((next, bytes.to_vec())),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Asks, waits, asks again; waits where the controller puts the request off.
    pub(super) fn ask(&mut self, request: &Request) -> Result<Response, LinkError> {
        let begun = Instant::now();
        loop {
            match self.exchange(request, PATIENCE)? {
                Ok(response) => return Ok(response),
                Err(refusal) => match refusal.retry() {
                    Some(wait) if begun.elapsed() < patience_with(&refusal) => {
                        thread::sleep(Duration::from_millis(wait.0.clamp(1, 2_000).into()));
                    }
                    _ => return Err(LinkError::Refused { address: self.address.clone(), refusal }),
                },
            }
        }
    }

    /// Asks for something that the controller may want to hear twice, and confirms it where a person has.
    pub(super) fn ask_for_more(
        &mut self,
        request: &Request,
        what: &'static str,
        help: &'static str,
    ) -> Result<Response, LinkError> {
        match self.ask(request)? {
            Response::Confirm { code } if self.confirms => self.ask(&Request::Confirm { code }),
            Response::Confirm { .. } => {
                Err(LinkError::Unconfirmed { address: self.address.clone(), what, help })
            }
            response => Ok(response),
        }
    }

    pub(super) fn wrong_answer(&self) -> LinkError {
        LinkError::WrongAnswer { address: self.address.clone() }
    }

    fn tell(&mut self, request: inputs::Request) -> Result<(), LinkError> {
        match self.ask(&Request::Exhibit(request))? {
            Response::Done => Ok(()),
            _ => Err(self.wrong_answer()),
        }
    }

    fn greet(&mut self) -> Result<Hello, LinkError> {
        let request = Request::Hello { version: VERSION, fingerprint: FINGERPRINT };
        let address = self.address.clone();
        match self.exchange(&request, GREETING_PATIENCE) {
            Ok(Ok(Response::Hello(hello))) => Ok(hello),
            Ok(Err(refusal @ Refusal::TooManyRequests { .. })) => {
                Err(LinkError::Refused { address, refusal })
            }
            Ok(_) | Err(LinkError::Silent { .. } | LinkError::WrongAnswer { .. }) => {
                Err(LinkError::NotOurs { address })
            }
            Err(error) => Err(error),
        }
    }

    /// Sends a request until its answer comes, with the same sequence number each time.
    fn exchange(&mut self, request: &Request, patience: Duration) -> Result<Reply, LinkError> {
        self.sequence = self.sequence.wrapping_add(1);
        let frame = frame::encode(self.sequence, request).map_err(|_| self.wrong_answer())?;
        for attempt in 0..TRIES {
            self.send(&frame, attempt > 0 || matches!(request, Request::Hello { .. }))?;
            if let Some(reply) = self.await_reply(patience)? {
                return Ok(reply);
            }
        }
        let seconds = (patience * TRIES).as_secs_f64();
        Err(LinkError::Silent { address: self.address.clone(), seconds })
    }

    /// Sends a frame; a 0x00 before it ends what was left unfinished.
    fn send(&mut self, frame: &Frame, on_a_fresh_start: bool) -> Result<(), LinkError> {
        let mut bytes = Vec::with_capacity(frame.len() + 1);
        if on_a_fresh_start {
            bytes.push(0);
        }
        bytes.extend_from_slice(frame);
        self.transport
            .send(&bytes)
            .map_err(|source| LinkError::Lost { address: self.address.clone(), source })
    }

    /// Waits for the answer to the last request; other answers and noise are passed over.
    fn await_reply(&mut self, patience: Duration) -> Result<Option<Reply>, LinkError> {
        let deadline = Instant::now() + patience;
        loop {
            if let Some(reply) = self.next_reply() {
                return reply.ok_or_else(|| self.wrong_answer()).map(Some);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            let mut bytes = [0; 512];
            let count = self
                .transport
                .receive(&mut bytes, left)
                .map_err(|source| LinkError::Lost { address: self.address.clone(), source })?;
            self.unread.extend_from_slice(&bytes[..count]);
        }
    }

    /// The next answer with the current sequence number among the bytes received; `Some(None)` if it is unreadable.
    fn next_reply(&mut self) -> Option<Option<Reply>> {
        let mut unread = std::mem::take(&mut self.unread).into_iter();
        while let Some(byte) = unread.next() {
            let Some(Ok(body)) = self.deframer.push(byte) else { continue };
            if frame::decode_sequence(body) != Some(self.sequence) {
                continue;
            }
            let reply = frame::decode::<Reply>(body).map(|(_, reply)| reply.map(plainly));
            self.unread = unread.collect();
            return Some(reply);
        }
        None
    }
}

/// An answer whose names can be told: whoever answers may call itself what a terminal obeys.
fn plainly(mut response: Response) -> Response {
    match &mut response {
        Response::Hello(hello) => {
            make_plain(&mut hello.serial_number);
            make_plain(&mut hello.firmware);
            make_plain(&mut hello.name);
        }
        Response::Status(Status { plan: Some(plan), .. }) => {
            make_plain(&mut plan.name);
            make_plain(&mut plan.view_id);
        }
        Response::Settings(settings) => make_plain(&mut settings.place),
        Response::Firmware(firmware) => make_plain(&mut firmware.version),
        _ => {}
    }
    response
}

/// A first sequence number that the last program on this port hardly used.
fn first_sequence() -> u16 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    (now.subsec_nanos() >> 4) as u16
}
