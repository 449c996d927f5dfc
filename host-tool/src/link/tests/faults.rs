//! Ports with nothing, with something else, with another version, and with noise behind them.

use std::{
    collections::VecDeque,
    io::{self, Read, Write},
    net::TcpListener,
    sync::{Arc, Mutex},
    thread,
    time::Duration,
};

use vitrine_protocol::{
    Hello, Link, Reply, Request, Response, VERSION,
    frame::{self, Deframer},
};

use super::{connected, controller, plan_bytes, served};
use crate::{
    controller::{FlashError, FlashFile, Pace, ServeError, VirtualController, serve},
    link::{Address, Client, LinkError, Transport},
};

/// Speaks to a controller in the same program, and does harm to the bytes on the way.
struct Wire {
    link: Link,
    controller: Arc<Mutex<VirtualController>>,
    answers: VecDeque<u8>,
    /// The n-th byte in either direction goes through this.
    harm: Box<dyn FnMut(u8) -> Option<u8> + Send>,
}

impl Wire {
    fn new(harm: impl FnMut(u8) -> Option<u8> + Send + 'static) -> Self {
        let controller = Arc::new(Mutex::new(controller(FlashFile::in_memory())));
        Self {
            link: Link::new(0, vitrine_protocol::Reach::Cable),
            controller,
            answers: VecDeque::new(),
            harm: Box::new(harm),
        }
    }
}

impl Transport for Wire {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut controller = self.controller.lock().expect("no panic");
        for byte in bytes {
            let now_ms = controller.time_ms();
            let Some(byte) = (self.harm)(*byte) else { continue };
            if let Some(incoming) = self.link.push(byte, now_ms) {
                self.answers
                    .extend(controller.answer(&incoming).iter().filter_map(|byte| (self.harm)(*byte)));
            }
        }
        // Time passes, so that the rate of requests is no hindrance.
        controller.advance(10);
        Ok(())
    }

    fn receive(&mut self, bytes: &mut [u8], _patience: Duration) -> io::Result<usize> {
        let count = bytes.len().min(self.answers.len()).min(37);
        for place in &mut bytes[..count] {
            *place = self.answers.pop_front().expect("counted");
        }
        Ok(count)
    }
}

fn address() -> Address {
    Address::Serial("wire".into())
}

#[test]
fn lost_and_damaged_bytes_cost_only_repetitions() {
    let mut count = 0_u32;
    let wire = Wire::new(move |byte| {
        count += 1;
        match count % 911 {
            0 => None,
            400 => Some(byte ^ 0x10),
            _ => Some(byte),
        }
    });
    let mut client = Client::over(address(), Box::new(wire)).expect("greeted");
    for number in 0..3 {
        let plan = plan_bytes(&format!("Plan {number}"));
        client.upload(&plan, &mut |_| {}).expect("uploaded");
        assert_eq!(client.read_plan().expect("read"), plan);
    }
}

#[test]
fn noise_before_the_greeting_does_not_matter() {
    let mut wire = Wire::new(Some);
    wire.send(b"ATZ\r\nAT+GMM\r").expect("sent");
    wire.answers.extend(b"boot 1.2.3\r\nOK\0\0garbage");
    Client::over(address(), Box::new(wire)).expect("greeted");
}

#[test]
fn nothing_there_says_how_to_start_something() {
    let free = TcpListener::bind("127.0.0.1:0").expect("a free port").local_addr().expect("its address");
    let error = Client::open(&Address::Tcp(free.to_string())).expect_err("nothing there");
    assert!(matches!(error, LinkError::Missing { .. }), "{error:?}");
    let help = miette::Diagnostic::help(&error).expect("a remedy").to_string();
    assert!(help.contains(&format!("vitrine controller --listen tcp:{free}")), "{help}");
    let error = Client::open(&Address::Serial("/dev/no-such-port".into())).expect_err("nothing there");
    assert!(matches!(error, LinkError::Missing { .. }), "{error:?}");
    assert!(error.to_string().contains("/dev/no-such-port"));
}

#[test]
fn what_is_no_controller_is_not_taken_for_one() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let place = listener.local_addr().expect("its address").to_string();
    let web_server = thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a connection");
        let mut bytes = [0; 100];
        while stream.read(&mut bytes).is_ok_and(|count| count > 0) {
            if stream.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n\0").is_err() {
                break;
            }
        }
    });
    let error = Client::open(&Address::Tcp(place)).expect_err("no controller");
    assert!(matches!(error, LinkError::NotOurs { .. }), "{error:?}");
    web_server.join().expect("no panic");
}

/// Answers every greeting with a hello of this version and fingerprint.
struct Other {
    version: u16,
    fingerprint: u32,
    deframer: Deframer,
    answers: VecDeque<u8>,
}

impl Transport for Other {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        for byte in bytes {
            if let Some(Ok(body)) = self.deframer.push(*byte)
                && let Some((sequence, Request::Hello { .. })) = frame::decode(body)
            {
                let hello = Hello {
                    version: self.version,
                    fingerprint: self.fingerprint,
                    serial_number: "E660".try_into().expect("short"),
                    firmware: "9.9.9".try_into().expect("short"),
                    name: heapless::String::new(),
                };
                let frame = frame::encode(sequence, &Reply::Ok(Response::Hello(hello))).expect("fits");
                self.answers.extend(frame.iter());
            }
        }
        Ok(())
    }

    fn receive(&mut self, bytes: &mut [u8], _patience: Duration) -> io::Result<usize> {
        let count = bytes.len().min(self.answers.len());
        self.answers.drain(..count).zip(bytes).for_each(|(byte, place)| *place = byte);
        Ok(count)
    }
}

fn greet(version: u16, fingerprint: u32) -> (LinkError, String) {
    let other = Other { version, fingerprint, deframer: Deframer::new(), answers: VecDeque::new() };
    let error = Client::over(address(), Box::new(other)).expect_err("another version");
    let help = miette::Diagnostic::help(&error).expect("a remedy").to_string();
    (error, help)
}

#[test]
fn another_version_says_which_side_to_update() {
    let (error, help) = greet(VERSION + 1, 0);
    assert!(matches!(error, LinkError::OtherVersion { .. }));
    assert!(help.starts_with("update this vitrine"), "{help}");
    let (_, help) = greet(VERSION - 1, 0);
    assert!(help.starts_with("update the controller's firmware (9.9.9)"), "{help}");
    let (error, _) = greet(VERSION, vitrine_protocol::FINGERPRINT ^ 1);
    assert!(matches!(error, LinkError::OtherBuild { .. }));
}

#[test]
fn a_controller_that_goes_away_is_lost_and_found_again() {
    let (served, mut client) = connected();
    let place = served.address().to_string();
    client.status().expect("status");
    let controller = served.stop();
    let error = client.status().expect_err("gone");
    assert!(matches!(error, LinkError::Lost { .. }), "{error:?}");
    assert!(error.is_passing());
    let served = serve(controller, &place, Pace::Manual).expect("the same port");
    let mut again = Client::open(&Address::Tcp(place)).expect("greeted");
    again.status().expect("status");
    drop(served);
}

#[test]
fn a_busy_port_and_a_busy_flash_file_are_named() {
    let (served, _) = served(FlashFile::in_memory());
    let place = served.address().to_string();
    let Err(error) = serve(controller(FlashFile::in_memory()), &place, Pace::Manual) else {
        panic!("the port is taken")
    };
    assert!(matches!(error, ServeError::PortBusy { .. }));
    assert!(error.to_string().contains(&place));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flash.bin");
    let first = FlashFile::open(&path).expect("a new file");
    assert!(matches!(FlashFile::open(&path), Err(FlashError::Busy { .. })));
    drop(first);
    FlashFile::open(&path).expect("free again");
    std::fs::write(&path, b"notes").expect("written");
    assert!(matches!(FlashFile::open(&path), Err(FlashError::Size { length: 5, .. })));
}

#[test]
fn garbage_on_the_wire_is_counted_and_the_next_host_is_served() {
    let (served, address) = served(FlashFile::in_memory());
    let mut vandal = std::net::TcpStream::connect(served.address()).expect("connected");
    let noise: Vec<u8> = (0..100_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    vandal.write_all(&noise).expect("sent");
    let mut client = Client::open(&address).expect("greeted");
    let counted = (0..200).any(|_| {
        thread::sleep(Duration::from_millis(10));
        client.status().expect("status").damaged_frames > 100
    });
    assert!(counted);
}
