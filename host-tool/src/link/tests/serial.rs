//! The same over a pair of pseudo-terminals, as over a cable.

use std::{
    io::{Read, Write},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use serialport::{SerialPort, TTYPort};
use vitrine_protocol::Link;

use super::{controller, plan_bytes};
use crate::{
    controller::FlashFile,
    link::{Address, Client, LinkError},
};

#[test]
fn a_plan_travels_over_a_serial_port_which_is_locked_meanwhile() {
    let (mut board, host) = TTYPort::pair().expect("a pair of ports");
    let port = host.name().expect("a path");
    drop(host);
    board.set_timeout(Duration::from_millis(20)).expect("set");
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = stop.clone();
    let thread = thread::spawn(move || {
        let mut controller = controller(FlashFile::in_memory());
        let mut link = Link::new(0, vitrine_protocol::Reach::Cable);
        let mut bytes = [0; 64];
        while !stopped.load(Ordering::Relaxed) {
            controller.advance(10);
            let Ok(count) = board.read(&mut bytes) else { continue };
            for byte in &bytes[..count] {
                let now_ms = controller.time_ms();
                if let Some(incoming) = link.push(*byte, now_ms) {
                    board.write_all(&controller.answer(&incoming)).expect("sent");
                }
            }
        }
    });
    let address = Address::Serial(port);
    let mut client = Client::open(&address).expect("greeted");
    let plan = plan_bytes("Over a cable");
    client.upload(&plan, &mut |_| {}).expect("uploaded");
    assert_eq!(client.read_plan().expect("read"), plan);
    let error = Client::open(&address).expect_err("locked");
    assert!(matches!(error, LinkError::Busy { .. }), "{error:?}");
    drop(client);
    Client::open(&address).expect("free again");
    stop.store(true, Ordering::Relaxed);
    thread.join().expect("no panic");
}
