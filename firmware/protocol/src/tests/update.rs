//! Updates of the firmware, as the server sees them.

use vitrine_exhibit::units::Milliseconds;

use super::controller::{LAMPS_IN_MOTION, MOST, bytes};
use super::samples;
use super::server::{Bench, committed, received};
use crate::{
    FINGERPRINT, Refusal, Request, VERSION,
    firmware::{ImageFault, Progress},
    message::{Reply, Response},
    plan_file,
    server::Reach,
};

fn begin(bench: &mut Bench, link: usize, image: &[u8]) -> Reply {
    bench.ask(link, &Request::BeginUpdate { length: image.len() as u32, crc: plan_file::crc(image) })
}

fn send(bench: &mut Bench, image: &[u8]) -> Reply {
    assert_eq!(begin(bench, 0, image), received(0));
    for start in (0..image.len()).step_by(256) {
        bench.chunk(0, image, start..image.len().min(start + 256)).expect("accepted");
    }
    bench.commit(0, image)
}

#[test]
fn an_image_is_sent_committed_and_started() {
    let mut bench = Bench::new(1);
    let image = bytes(1_000);
    assert_eq!(send(&mut bench, &image), committed(&image));
    assert_eq!(bench.memory.image, image);
    let Ok(Response::Firmware(state)) = bench.ask(0, &Request::Firmware) else { panic!("no state") };
    assert_eq!((state.version, state.progress), (samples::firmware().version, Progress::Wanted));
    assert_eq!(bench.ask(0, &Request::Restart), Ok(Response::Done));
    assert_eq!(bench.memory.restarts, 1);
    assert_eq!(bench.memory.active, None, "an image is no plan");
}

#[test]
fn an_image_that_is_not_signed_or_too_long_is_refused() {
    let mut bench = Bench::new(1);
    let mut image = bytes(600);
    image[0] = 1;
    assert_eq!(send(&mut bench, &image), Err(Refusal::UnfitImage(ImageFault::Signature)));
    assert_eq!(bench.commit(0, &image), Err(Refusal::NoUpload), "it has to begin anew");
    let begin = Request::BeginUpdate { length: MOST + 1, crc: 0 };
    assert_eq!(bench.ask(0, &begin), Err(Refusal::ImageLength { most: MOST }));
}

/// A host of another release has nothing but the frozen messages, and needs no more to bring firmware of its own release.
#[test]
fn a_host_of_another_version_can_update_and_nothing_else() {
    let mut bench = Bench::new(1);
    let image = bytes(600);
    bench.links[0].reset();
    bench.ask(0, &Request::Hello { version: VERSION + 1, fingerprint: FINGERPRINT ^ 1 }).expect("greeted");
    let stranger = Err(Refusal::Unacquainted { version: VERSION, fingerprint: FINGERPRINT });
    assert_eq!(bench.ask(0, &Request::Status), stranger);
    assert_eq!(bench.begin(0, &image), stranger);
    assert_eq!(send(&mut bench, &image), committed(&image));
    assert_eq!(bench.ask(0, &Request::Restart), Ok(Response::Done));
}

#[test]
fn a_plan_and_an_image_of_the_same_bytes_are_two_uploads() {
    let mut bench = Bench::new(1);
    let both = bytes(600);
    bench.begin(0, &both).expect("begun");
    bench.chunk(0, &both, 0..256).expect("accepted");
    assert_eq!(begin(&mut bench, 0, &both), received(0));
    assert_eq!(begin(&mut bench, 0, &both), received(0), "the same again goes on");
    assert_eq!(bench.begin(0, &both), received(0));
}

#[test]
fn a_broken_update_goes_on_where_it_was_and_waits_for_steady_lamps() {
    let mut bench = Bench::new(2);
    let image = bytes(600);
    bench.memory.refusal = Some(LAMPS_IN_MOTION);
    assert_eq!(begin(&mut bench, 0, &image), Err(LAMPS_IN_MOTION));
    assert_eq!(begin(&mut bench, 0, &image), received(0));
    bench.memory.refusal = Some(LAMPS_IN_MOTION);
    assert_eq!(bench.chunk(0, &image, 0..256), Err(LAMPS_IN_MOTION));
    assert_eq!(bench.chunk(0, &image, 0..256), received(256));
    assert!(matches!(begin(&mut bench, 1, &image), Err(Refusal::OtherUpload { .. })));
    assert_eq!(begin(&mut bench, 0, &image), received(256));
    bench.chunk(0, &image, 256..512).expect("accepted");
    bench.chunk(0, &image, 512..600).expect("accepted");
    bench.memory.refusal = Some(Refusal::OnTrial { retry: Milliseconds(500) });
    assert!(bench.commit(0, &image).is_err_and(|refusal| refusal.retry().is_some()));
    assert_eq!(bench.commit(0, &image), committed(&image));
}

#[test]
fn over_a_network_no_firmware_is_taken() {
    let mut bench = Bench::reaching(1, Reach::Network);
    let image = bytes(600);
    assert_eq!(begin(&mut bench, 0, &image), Err(Refusal::CableOnly));
    assert_eq!(bench.ask(0, &Request::Restart), Err(Refusal::CableOnly));
    assert!(matches!(bench.ask(0, &Request::Firmware), Ok(Response::Firmware(_))));
}
