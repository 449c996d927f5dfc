//! Updates of a simulated controller's firmware, which the boot loader's own code installs.

use std::{
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::Duration,
};

use vitrine_protocol::{
    Controller, Refusal, Request,
    firmware::{ImageFault, Outcome, Progress},
    message::Chunk,
    plan_file,
};

use super::{plan_bytes, served};
use crate::{
    controller::{FlashFile, Served},
    firmware::{SecretKey, SignedImage, sign},
    link::{Address, Client, Installed, LinkError, Stage, update},
};

fn signed(version: &str) -> SignedImage {
    SignedImage::from_bytes(sign(&[7; 9_000], version, &SecretKey::development())).expect("whole")
}

/// Updates while the controller's time passes quickly; `each` is done before every piece of time.
fn update_quickly(
    served: &Served,
    address: &Address,
    image: &SignedImage,
    each: &(dyn Fn(&Served) + Sync),
) -> (Result<Installed, LinkError>, Vec<Stage>) {
    let done = AtomicBool::new(false);
    let mut stages = Vec::new();
    let outcome = thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                each(served);
                served.controller().advance(100);
                thread::sleep(Duration::from_millis(1));
            }
        });
        let client = Client::open_for_update(address).expect("greeted");
        let outcome = update(client, image, &|| Ok(address.clone()), &mut |progress| {
            if stages.last() != Some(&progress.stage) {
                stages.push(progress.stage);
            }
        });
        done.store(true, Ordering::Relaxed);
        outcome
    });
    (outcome, stages)
}

#[test]
fn new_firmware_is_installed_confirms_itself_and_keeps_plan_and_log() {
    let (served, address) = served(FlashFile::in_memory());
    let plan = plan_bytes("Three photographs");
    let mut client = Client::open(&address).expect("greeted");
    client.upload(&plan, &mut |_| {}).expect("uploaded");
    served.controller().advance(100);
    let before = client.firmware().expect("told");
    assert_eq!(before.version.as_str(), env!("CARGO_PKG_VERSION"));
    assert_eq!(before.progress, Progress::default());
    drop(client);

    let image = signed("9.0.0");
    let (outcome, stages) = update_quickly(&served, &address, &image, &|_| {});
    let Ok(Installed::Confirmed(state)) = outcome else { panic!("{outcome:?}") };
    assert_eq!((state.version.as_str(), state.digest), ("9.0.0", image.header.digest));
    assert_eq!(stages[..2], [Stage::Sending, Stage::Committing]);
    let mut client = Client::open(&address).expect("greeted");
    assert_eq!(client.hello().firmware, "9.0.0");
    assert_eq!(client.read_plan().expect("read"), plan);
    assert_eq!(client.status().expect("status").snapshot.power_cycles, 2);
}

#[test]
fn firmware_that_cannot_confirm_itself_is_gone_back_from() {
    let (served, address) = served(FlashFile::in_memory());
    let lose_supply = |served: &Served| {
        let mut controller = served.controller();
        if controller.firmware().progress == Progress::Wanted {
            controller.surroundings.supply = None;
        }
    };
    let (outcome, _) = update_quickly(&served, &address, &signed("9.0.0"), &lose_supply);
    let Ok(Installed::Not(Outcome::WentBack, state)) = outcome else { panic!("{outcome:?}") };
    assert_eq!(state.version.as_str(), env!("CARGO_PKG_VERSION"));
}

#[test]
fn what_the_board_may_not_run_is_refused_and_nothing_changes() {
    let (served, address) = served(FlashFile::in_memory());
    let mut client = Client::open(&address).expect("greeted");
    let refusal = |client: &mut Client, image: &SignedImage| match client.send_firmware(image, &mut |_| {}) {
        Err(LinkError::Refused { refusal, .. }) => refusal,
        other => panic!("{other:?}"),
    };
    let other_key = SecretKey::generate().expect("random numbers");
    let foreign = SignedImage::from_bytes(sign(&[7; 5_000], "9.0.0", &other_key)).expect("whole");
    assert_eq!(refusal(&mut client, &foreign), Refusal::UnfitImage(ImageFault::OtherKey));
    let mut flipped = signed("9.0.0");
    flipped.bytes[5_000] ^= 1;
    assert_eq!(refusal(&mut client, &flipped), Refusal::UnfitImage(ImageFault::Damaged));
    served.controller().surroundings.supply = None;
    assert_eq!(refusal(&mut client, &signed("9.0.0")), Refusal::NoSupply);
    assert_eq!(client.firmware().expect("told").progress, Progress::default());
}

#[test]
fn a_broken_update_is_continued_and_a_start_in_between_changes_nothing() {
    let (served, address) = served(FlashFile::in_memory());
    let image = signed("9.0.0");
    let begin = Request::BeginUpdate { length: image.bytes.len() as u32, crc: plan_file::crc(&image.bytes) };
    let mut client = Client::open(&address).expect("greeted");
    client.ask(&begin).expect("begun");
    let bytes = Chunk::from_slice(&image.bytes[..256]).expect("a chunk");
    client.ask(&Request::UploadChunk { offset: 0, bytes }).expect("accepted");
    client.restart().expect("restarted");
    served.controller().advance(20);
    let (outcome, _) = update_quickly(&served, &address, &image, &|_| {});
    assert!(matches!(outcome, Ok(Installed::Confirmed(_))), "{outcome:?}");
}
