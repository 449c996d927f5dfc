//! What the image tells as it runs, decoded by the real tool with the very image: over the link, and over a probe.

use std::io::Write;
use std::net::TcpListener;

use vitrine_exhibit::viewer::RadarFrame;
use vitrine_tests::room::radar_bytes;

use crate::bench::{Bench, MILLISECOND, built};

/// Tells that a radar reports, besides the start: reports for two seconds.
fn something_to_tell(bench: &mut Bench) {
    bench.radar(&radar_bytes(&RadarFrame::new()).repeat(1_700));
}

#[test]
fn the_real_tool_decodes_the_images_messages_over_the_link() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let address = bench.listen();
    let image = built("vitrine-pico.elf");
    something_to_tell(&mut bench);
    let told = bench.vitrine(&["log", "--live", &image.to_string_lossy(), "--for", "3", "--to", &address]);
    assert!(told.contains("started") && told.contains("a radar reports"), "{told}");
}

/// The probe is the bench, which reads the ring in memory as one does; its server hands the bytes on as OpenOCD's does.
#[test]
fn the_real_tool_decodes_the_images_messages_over_a_probe() {
    let mut bench = Bench::new();
    bench.power_on();
    bench.run(100 * MILLISECOND);
    let server = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = server.local_addr().expect("its address").to_string();
    server.set_nonblocking(true).expect("a socket");
    let image = built("vitrine-pico.elf");
    something_to_tell(&mut bench);
    let mut probe = None;
    let arguments = ["log", "--live", &image.to_string_lossy(), "--for", "3", "--rtt", &address];
    let (succeeded, told, faults) = bench.vitrine_meanwhile(&arguments, |bench| {
        if let Ok((stream, _)) = server.accept() {
            probe = Some(stream);
        }
        if let Some(stream) = &mut probe {
            let _ = stream.write_all(&bench.rtt());
        }
    });
    assert!(succeeded, "{faults}");
    assert!(told.contains("started") && told.contains("a radar reports"), "{told}");
    assert!(!told.contains("missed"), "{told}");
}
