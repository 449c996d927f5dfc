//! As much of HTTP/1.1 as one page needs: a request on each connection, small in all its parts, and a stream of events.
//!
//! The frameworks for this bring an asynchronous runtime, and the small synchronous servers have been dormant for years;
//! the parser of requests is `httparse`, which the frameworks use too.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::Commands;
use super::gate::Gate;
use super::hub::Hub;
use super::page::answer;

/// The most bytes of a request's head and of its body.
const MOST_HEAD: usize = 16 << 10;
const MOST_BODY: usize = 1 << 10;
const MOST_HEADERS: usize = 64;
/// How long a request may take to arrive, and a piece of an answer to leave.
const PATIENCE: Duration = Duration::from_secs(10);
/// The most connections at once.
const MOST_CONNECTIONS: usize = 64;
/// How often somebody who listens is told that nothing is new, so that a broken connection shows.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// A request.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) method: String,
    pub(super) path: String,
    headers: Vec<(String, String)>,
    pub(super) body: Vec<u8>,
}

/// An answer.
pub(super) enum Answer {
    /// A whole one.
    Whole {
        /// The status with its words, such as `200 OK`.
        status: &'static str,
        /// The kind of the body.
        kind: &'static str,
        body: Arc<[u8]>,
    },
    /// All news from now on.
    Events,
}

impl Answer {
    /// An answer in plain words.
    pub(super) fn words(status: &'static str, words: &str) -> Self {
        Self::Whole {
            status,
            kind: "text/plain; charset=utf-8",
            body: format!("{words}\n").into_bytes().into(),
        }
    }
}

impl Request {
    /// Reads a request; none where it is none, or too large.
    pub(super) fn read(stream: &mut impl Read) -> io::Result<Self> {
        let ends = Instant::now() + PATIENCE;
        let mut bytes = Vec::new();
        let mut piece = [0; 1024];
        loop {
            if let Some((mut request, start, length)) = Self::parse(&bytes)? {
                if let Some(body) = bytes.get(start..start + length) {
                    request.body = body.to_vec();
                    return Ok(request);
                }
            } else if bytes.len() > MOST_HEAD {
                return Err(bad("the request is too large"));
            }
            let count = if Instant::now() < ends { stream.read(&mut piece)? } else { 0 };
            if count == 0 {
                return Err(bad("the request ends too early"));
            }
            bytes.extend_from_slice(&piece[..count]);
        }
    }

    /// The value of a header; none where it is not there, or more than once.
    pub(super) fn header(&self, name: &str) -> Option<&str> {
        let mut values = self.headers.iter().filter(|(own, _)| own.eq_ignore_ascii_case(name));
        let (_, value) = values.next()?;
        values.next().is_none().then_some(value)
    }

    /// The request's head, where its body starts, and the body's length; none while the head is not whole.
    fn parse(bytes: &[u8]) -> io::Result<Option<(Self, usize, usize)>> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut head = httparse::Request::new(&mut headers);
        let parsed = head.parse(bytes).map_err(|error| bad(&error.to_string()))?;
        let (httparse::Status::Complete(start), Some(method), Some(path)) = (parsed, head.method, head.path)
        else {
            return Ok(None);
        };
        let text = |value: &[u8]| String::from_utf8(value.to_vec()).map_err(|_| bad("a header is no text"));
        let headers: Vec<(String, String)> = head
            .headers
            .iter()
            .map(|header| Ok((header.name.to_owned(), text(header.value)?)))
            .collect::<io::Result<_>>()?;
        let request = Self { method: method.to_owned(), path: path.to_owned(), headers, body: Vec::new() };
        if request.headers.iter().any(|(name, _)| name.eq_ignore_ascii_case("transfer-encoding")) {
            return Err(bad("bodies come whole here"));
        }
        let length = request.header("content-length").map_or(Ok(0), str::parse::<usize>);
        match length {
            Ok(length) if length <= MOST_BODY => Ok(Some((request, start, length))),
            _ => Err(bad("the body is too large")),
        }
    }
}

fn bad(words: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, words.to_owned())
}

/// Answers whoever connects, for ever.
pub(super) fn serve(listener: &TcpListener, gate: &Arc<Gate>, hub: &Arc<Hub>, commands: &Commands) {
    let open = Arc::new(AtomicUsize::new(0));
    loop {
        let Ok((mut stream, _)) = listener.accept() else {
            // Out of files, mostly: others have to end first.
            thread::sleep(Duration::from_millis(100));
            continue;
        };
        let patient = stream.set_read_timeout(Some(PATIENCE)).and(stream.set_write_timeout(Some(PATIENCE)));
        if patient.is_err() {
            continue;
        }
        let place = Place::take(&open);
        if open.load(Ordering::Relaxed) > MOST_CONNECTIONS {
            let _gone =
                write(&mut stream, &Answer::words("503 Service Unavailable", "too many look at once"));
            continue;
        }
        let (gate, hub, commands) = (Arc::clone(gate), Arc::clone(hub), commands.clone());
        thread::spawn(move || {
            let _whoever_goes_away_needs_no_answer = attend(&mut stream, &gate, &hub, &commands);
            drop(place);
        });
    }
}

/// One of the connections, until it is dropped.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn take(open: &Arc<AtomicUsize>) -> Self {
        open.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(open))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn attend(stream: &mut TcpStream, gate: &Gate, hub: &Hub, commands: &Commands) -> io::Result<()> {
    let answer = match Request::read(stream) {
        Ok(request) => answer(&request, gate, hub, commands),
        Err(error) if error.kind() == ErrorKind::InvalidData => {
            Answer::words("400 Bad Request", &error.to_string())
        }
        Err(error) => return Err(error),
    };
    write(stream, &answer)?;
    match answer {
        Answer::Whole { .. } => Ok(()),
        Answer::Events => tell_news(stream, hub),
    }
}

fn write(stream: &mut impl Write, answer: &Answer) -> io::Result<()> {
    const COMMON: &str = "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
        Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n\
        Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
        img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\nConnection: close\r\n";
    match answer {
        Answer::Whole { status, kind, body } => {
            let length = body.len();
            let head = format!(
                "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{COMMON}\r\n"
            );
            stream.write_all(&[head.as_bytes(), body].concat())
        }
        Answer::Events => {
            let head = format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{COMMON}\r\n");
            stream.write_all(head.as_bytes())
        }
    }
}

fn tell_news(stream: &mut impl Write, hub: &Hub) -> io::Result<()> {
    let mut version = 0;
    loop {
        match hub.newer(version, HEARTBEAT) {
            Some(heard) => {
                version = heard.version;
                stream.write_all(format!("data: {}\n\n", heard.page).as_bytes())?;
            }
            None => stream.write_all(b": nothing new\n\n")?,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Gives its bytes in pieces, as a network does.
    struct Pieces<'a>(&'a [u8], usize);

    impl Read for Pieces<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(self.0.len()).min(buffer.len());
            buffer[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    #[test]
    fn a_request_comes_in_pieces() {
        let text = b"POST /ask HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\n{}\n";
        for size in 1..text.len() {
            let request = Request::read(&mut Pieces(text, size)).unwrap();
            assert_eq!((request.method.as_str(), request.path.as_str()), ("POST", "/ask"));
            assert_eq!((request.header("HOST"), request.body.as_slice()), (Some("a"), b"{}\n".as_slice()));
        }
    }

    #[test]
    fn what_is_too_large_or_cut_short_or_said_twice_is_refused() {
        let long = format!("GET /{} HTTP/1.1\r\n\r\n", "a".repeat(2 * MOST_HEAD));
        let wrong = [
            long.as_str(),
            "GET / HTTP/1.1\r\nHost: a\r\n",
            "POST / HTTP/1.1\r\nContent-Length: 4\r\n\r\nabc",
            "POST / HTTP/1.1\r\nContent-Length: 99999999\r\n\r\nabc",
            "POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\nabc",
            "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
            "\0\0\0",
        ];
        for text in wrong {
            assert_eq!(
                Request::read(&mut text.as_bytes()).unwrap_err().kind(),
                ErrorKind::InvalidData,
                "{text:.60}"
            );
        }
        let twice = Request::read(&mut "GET / HTTP/1.1\r\nHost: a\r\nhost: b\r\n\r\n".as_bytes()).unwrap();
        assert_eq!(twice.header("host"), None);
    }

    proptest! {
        #[test]
        fn no_bytes_bring_it_down(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let _ = Request::read(&mut bytes.as_slice());
        }
    }
}
