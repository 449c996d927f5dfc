//! Hosts that come and go, flood, stop reading, or leave half a frame: the control loop never waits for them, and
//! the next host is served.

use std::{
    io::Write,
    net::TcpStream,
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::{Duration, Instant},
};

use vitrine_protocol::{FINGERPRINT, Request, VERSION, frame};

use super::{controller, plan_bytes, served};
use crate::{
    controller::{FlashFile, Pace, serve},
    link::{Address, Client},
};

#[test]
fn a_host_that_floods_and_never_reads_holds_up_nobody() {
    let served =
        serve(controller(FlashFile::in_memory()), "127.0.0.1:0", Pace::RealTime).expect("a free port");
    let place = served.address();
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| flood(TcpStream::connect(place).expect("connected"), &stop));
        }
        let mut client = Client::open(&Address::Tcp(place.to_string())).expect("greeted");
        let begun = (Instant::now(), served.controller().time_ms());
        for number in 0..5 {
            let plan = plan_bytes(&format!("Plan {number}"));
            client.upload(&plan, &mut |_| {}).expect("uploaded");
            assert_eq!(client.read_plan().expect("read"), plan);
        }
        while begun.0.elapsed() < Duration::from_millis(500) {
            client.status().expect("status");
        }
        let passed = served.controller().time_ms() - begun.1;
        assert!(passed > 0, "the control loop stands still");
        stop.store(true, Ordering::Relaxed);
    });
}

/// Sends requests as fast as the connection takes them, and reads no answer.
fn flood(mut stream: TcpStream, stop: &AtomicBool) {
    stream.set_write_timeout(Some(Duration::from_millis(50))).expect("set");
    let hello =
        frame::encode(1, &Request::Hello { version: VERSION, fingerprint: FINGERPRINT }).expect("fits");
    let status = frame::encode(2, &Request::Status).expect("fits");
    let _ = stream.write_all(&hello);
    while !stop.load(Ordering::Relaxed) {
        // The server hangs up on a host that does not take its answers.
        if stream.write_all(&status.repeat(100)).is_err() {
            thread::sleep(Duration::from_millis(5));
        }
    }
}

#[test]
fn hosts_that_come_and_go_in_mid_frame_leave_no_trace() {
    let (_served, address) = served(FlashFile::in_memory());
    let Address::Tcp(place) = &address else { panic!("{address}") };
    let plan = plan_bytes("Stays");
    Client::open(&address).expect("greeted").upload(&plan, &mut |_| {}).expect("uploaded");
    let hello =
        frame::encode(1, &Request::Hello { version: VERSION, fingerprint: FINGERPRINT }).expect("fits");
    let begin = frame::encode(2, &Request::BeginUpload { length: 100, crc: 1 }).expect("fits");
    for cut in 0..begin.len() {
        let mut stream = TcpStream::connect(place).expect("connected");
        stream.write_all(&hello).expect("sent");
        stream.write_all(&begin[..cut]).expect("sent");
    }
    let mut client = Client::open(&address).expect("greeted");
    assert_eq!(client.read_plan().expect("read"), plan);
    let other = plan_bytes("Other");
    client.upload(&other, &mut |_| {}).expect("uploaded");
    assert_eq!(client.read_plan().expect("read"), other);
}
