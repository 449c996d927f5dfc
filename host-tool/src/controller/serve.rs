//! Serves a simulated controller over TCP, to several hosts at once.

use std::{
    io::{self, Read, Write},
    net::{SocketAddr, TcpListener, TcpStream},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU8, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use miette::Diagnostic;
use thiserror::Error;
use vitrine_protocol::{Link, Reach};

use super::VirtualController;
use crate::link::Announcement;

/// The port on which `vitrine controller` listens if it is not told another.
pub const DEFAULT_PORT: u16 = 7470;

/// How often a thread looks whether it is to end.
const LOOK_UP: Duration = Duration::from_millis(50);
const STEP: Duration = Duration::from_millis(10);
/// After a pause of the computer no more than this is caught up.
const MOST_CAUGHT_UP_MS: u32 = 1_000;

/// Whether the controller's time passes by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As the computer's time does.
    RealTime,
    /// Only when [`VirtualController::advance`] is called.
    Manual,
}

/// Why a controller cannot be served.
#[derive(Debug, Error, Diagnostic)]
pub enum ServeError {
    /// Another program listens there.
    #[error("tcp:{place} is taken by another program")]
    #[diagnostic(
        code(vitrine::controller::port_busy),
        help(
            "another simulated controller may run there; stop it, or listen on another port with --listen tcp:PORT"
        )
    )]
    PortBusy {
        /// `HOST:PORT`.
        place: String,
    },
    /// The port cannot be opened for another reason.
    #[error("tcp:{place} cannot be listened on")]
    #[diagnostic(
        code(vitrine::controller::listen),
        help("listen on an address of this computer and a port above 1023, as in tcp:127.0.0.1:7470")
    )]
    Listen {
        /// `HOST:PORT`.
        place: String,
        /// What the operating system says.
        source: io::Error,
    },
}

/// A controller that is being served; it stops when this is dropped.
pub struct Served {
    controller: Arc<Mutex<VirtualController>>,
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    announcement: Option<Announcement>,
}

fn listen(place: &str) -> Result<(TcpListener, SocketAddr), ServeError> {
    let failed = |source: io::Error| match source.kind() {
        io::ErrorKind::AddrInUse => ServeError::PortBusy { place: place.to_owned() },
        _ => ServeError::Listen { place: place.to_owned(), source },
    };
    let listener = TcpListener::bind(place).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    Ok((listener, address))
}

/// Looks whether a controller could be served at `HOST:PORT`, without doing it.
///
/// # Errors
/// Those of [`serve`].
pub fn try_place(place: &str) -> Result<(), ServeError> {
    listen(place).map(drop)
}

/// Listens at `HOST:PORT` (port 0: any free one) and serves the controller from threads of its own.
///
/// # Errors
/// Where the port is taken or cannot be opened.
pub fn serve(controller: VirtualController, place: &str, pace: Pace) -> Result<Served, ServeError> {
    let (listener, address) = listen(place)?;
    let controller = Arc::new(Mutex::new(controller));
    let stop = Arc::new(AtomicBool::new(false));
    let mut threads = Vec::new();
    {
        let (controller, stop) = (controller.clone(), stop.clone());
        threads.push(thread::spawn(move || accept(&listener, &controller, &stop)));
    }
    if pace == Pace::RealTime {
        let (controller, stop) = (controller.clone(), stop.clone());
        threads.push(thread::spawn(move || keep_pace(&controller, &stop)));
    }
    Ok(Served { controller, address, stop, threads, announcement: None })
}

impl Served {
    /// Where it listens.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Lets `vitrine devices` find it, as long as it is served.
    ///
    /// # Errors
    /// Where the announcement cannot be written.
    pub fn announce(&mut self) -> io::Result<()> {
        self.announcement = Some(Announcement::new(&self.address.to_string())?);
        Ok(())
    }

    /// The controller, to look at or to change; its hosts wait meanwhile.
    pub fn controller(&self) -> MutexGuard<'_, VirtualController> {
        lock(&self.controller)
    }

    /// Ends all connections, frees the port, and gives the controller back.
    pub fn stop(mut self) -> VirtualController {
        self.end();
        let controller = self.controller.clone();
        drop(self);
        let mut controller = controller;
        loop {
            match Arc::try_unwrap(controller) {
                Ok(mutex) => return mutex.into_inner().unwrap_or_else(PoisonError::into_inner),
                Err(shared) => {
                    controller = shared;
                    thread::sleep(LOOK_UP);
                }
            }
        }
    }

    fn end(&mut self) {
        self.announcement = None;
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _panicked = thread.join();
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.end();
    }
}

fn lock(controller: &Mutex<VirtualController>) -> MutexGuard<'_, VirtualController> {
    controller.lock().unwrap_or_else(PoisonError::into_inner)
}

fn accept(listener: &TcpListener, controller: &Arc<Mutex<VirtualController>>, stop: &Arc<AtomicBool>) {
    let numbers = AtomicU8::new(0);
    let mut hosts: Vec<JoinHandle<()>> = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        hosts.retain(|host| !host.is_finished());
        let Ok((stream, peer)) = listener.accept() else {
            thread::sleep(STEP);
            continue;
        };
        let (controller, stop) = (controller.clone(), stop.clone());
        let number = numbers.fetch_add(1, Ordering::Relaxed);
        hosts.push(thread::spawn(move || {
            let _gone = talk(stream, Link::new(number, reach(peer)), &controller, &stop);
            lock(&controller).link_closed(number);
        }));
    }
    for host in hosts {
        let _panicked = host.join();
    }
}

/// A program on this computer stands for one beside the exhibit; any other comes over a network.
const fn reach(peer: SocketAddr) -> Reach {
    if peer.ip().to_canonical().is_loopback() { Reach::Cable } else { Reach::Network }
}

/// Serves one host until it goes or the server ends.
fn talk(
    mut stream: TcpStream,
    mut link: Link,
    controller: &Mutex<VirtualController>,
    stop: &AtomicBool,
) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(LOOK_UP))?;
    stream.set_write_timeout(Some(Duration::from_secs(2)))?;
    let begun = Instant::now();
    let mut damaged = 0;
    let mut bytes = [0; 1_024];
    while !stop.load(Ordering::Relaxed) {
        let count = match stream.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                continue;
            }
            Err(error) => return Err(error),
        };
        // The rate of requests is one of real time, also where the controller's own time stands still.
        let now_ms = u64::try_from(begun.elapsed().as_millis()).unwrap_or(u64::MAX);
        for byte in &bytes[..count] {
            if let Some(incoming) = link.push(*byte, now_ms) {
                let answer = lock(controller).answer(&incoming);
                stream.write_all(&answer)?;
            }
        }
        let faults = link.faults();
        let now_damaged = faults.damaged.saturating_add(faults.too_long);
        if now_damaged != damaged {
            lock(controller).count_damaged_frames(now_damaged - damaged);
            damaged = now_damaged;
        }
    }
    Ok(())
}

fn keep_pace(controller: &Mutex<VirtualController>, stop: &AtomicBool) {
    let mut last = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(STEP);
        let passed = u32::try_from(last.elapsed().as_millis()).unwrap_or(u32::MAX);
        last += Duration::from_millis(passed.into());
        lock(controller).advance(passed.min(MOST_CAUGHT_UP_MS));
    }
}
