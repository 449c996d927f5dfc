//! Hosts on the board's USB port.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use vitrine_exhibit::plan::Plan;
use vitrine_protocol::frame::{self, Deframer};
use vitrine_protocol::message::LogEntry;
use vitrine_protocol::plan_file::{self, MAX_PLAN_BYTES};
use vitrine_protocol::{FINGERPRINT, MAX_CHUNK, Reply, Request, Response, Status, VERSION};

use crate::bench::{Bench, MILLISECOND};

/// A host that speaks the protocol frame by frame, for what the real tool would never do.
pub(crate) struct Host {
    pub(crate) stream: TcpStream,
    deframer: Deframer,
    sequence: u16,
}

impl Host {
    /// Opens the board's USB port and greets.
    pub(crate) fn greet(bench: &mut Bench, address: &str) -> Self {
        Self::try_greet(bench, address).expect("the board greets")
    }

    /// The same; none when the board has no power, or loses it on the way.
    pub(crate) fn try_greet(bench: &mut Bench, address: &str) -> Option<Self> {
        let stream = TcpStream::connect(address.trim_start_matches("tcp:")).expect("the port opens");
        stream.set_nonblocking(true).expect("a socket");
        let mut host = Self { stream, deframer: Deframer::new(), sequence: 0 };
        bench.run(20 * MILLISECOND);
        // Ends what the host before has left unfinished, as the real tool does.
        host.stream.write_all(&[0]).expect("the port takes it");
        let hello = host.try_ask(bench, &Request::Hello { version: VERSION, fingerprint: FINGERPRINT })?;
        assert!(matches!(hello, Ok(Response::Hello(_))), "{hello:?}");
        Some(host)
    }

    /// Sends a request and runs the board until it answers.
    pub(crate) fn ask(&mut self, bench: &mut Bench, request: &Request) -> Reply {
        self.try_ask(bench, request).unwrap_or_else(|| panic!("no answer to {request:?}"))
    }

    /// The same; none when the board has no power, or does not answer within two seconds.
    pub(crate) fn try_ask(&mut self, bench: &mut Bench, request: &Request) -> Option<Reply> {
        self.send(request);
        for _ in 0..2_000 {
            if !bench.run(MILLISECOND) {
                return None;
            }
            if let Some((sequence, reply)) = self.hear()
                && sequence == self.sequence
            {
                return Some(reply);
            }
        }
        None
    }

    /// Sends a request without waiting for its answer.
    pub(crate) fn send(&mut self, request: &Request) {
        self.sequence += 1;
        let sent = frame::encode(self.sequence, request).expect("a small request");
        self.stream.write_all(&sent).expect("the port takes it");
    }

    /// Takes the next answer that has come.
    pub(crate) fn hear(&mut self) -> Option<(u16, Reply)> {
        let mut byte = [0];
        while matches!(self.stream.read(&mut byte), Ok(1)) {
            if let Some(Ok(body)) = self.deframer.push(byte[0]) {
                return frame::decode(body);
            }
        }
        // What the bench has written may still be on its way through the computer.
        std::thread::sleep(Duration::from_micros(200));
        None
    }

    /// Uploads a plan; gives its CRC.
    pub(crate) fn upload(&mut self, bench: &mut Bench, plan: &Plan) -> u32 {
        self.try_upload(bench, plan).expect("the board keeps its power")
    }

    /// The same; none when the power goes on the way.
    pub(crate) fn try_upload(&mut self, bench: &mut Bench, plan: &Plan) -> Option<u32> {
        let mut buffer = [0; MAX_PLAN_BYTES];
        let bytes = plan_file::encode(plan, &mut buffer).expect("it fits");
        let crc = plan_file::crc(bytes);
        let length = bytes.len() as u32;
        self.patiently(bench, &Request::BeginUpload { length, crc })?;
        for (index, chunk) in bytes.chunks(MAX_CHUNK).enumerate() {
            let bytes = chunk.try_into().expect("a chunk");
            self.patiently(bench, &Request::UploadChunk { offset: (index * MAX_CHUNK) as u32, bytes })?;
        }
        let committed = self.patiently(bench, &Request::CommitUpload { crc })?;
        assert_eq!(committed, Response::Committed { crc });
        Some(crc)
    }

    /// What the board tells of itself.
    pub(crate) fn status(&mut self, bench: &mut Bench) -> Status {
        match self.patiently(bench, &Request::Status) {
            Some(Response::Status(status)) => status,
            other => panic!("no status but {other:?}"),
        }
    }

    /// All entries of the log from a number on.
    pub(crate) fn log(&mut self, bench: &mut Bench, mut from: u32) -> Vec<LogEntry> {
        let mut entries = Vec::new();
        loop {
            let Some(Response::Log(page)) = self.patiently(bench, &Request::ReadLog { from }) else {
                panic!("no log")
            };
            let Some(last) = page.entries.last() else { return entries };
            from = last.sequence + 1;
            entries.extend(page.entries);
        }
    }

    /// Asks again as long as the board says when.
    pub(crate) fn patiently(&mut self, bench: &mut Bench, request: &Request) -> Option<Response> {
        for _ in 0..200 {
            match self.try_ask(bench, request)? {
                Ok(response) => return Some(response),
                Err(refusal) => {
                    let retry = refusal.retry().unwrap_or_else(|| panic!("{request:?}: {refusal}"));
                    bench.run(u64::from(retry.0) * MILLISECOND);
                }
            }
        }
        panic!("{request:?} was put off for ever");
    }
}
