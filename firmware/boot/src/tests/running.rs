//! A running firmware's side of an update.

use vitrine_exhibit::units::{Milliseconds, Millivolts};
use vitrine_protocol::Refusal;
use vitrine_protocol::firmware::{ImageFault, Outcome, Progress};
use vitrine_storage::mock::MockFlash;

use super::bench::{LAYOUT, PLACE, boot, flash_with, header, image, signed, signing_key, stage_of};
use crate::trial::{Health, Verdict};
use crate::{Updates, VerifyingKey};

const SUPPLY: Option<Millivolts> = Some(Millivolts(24_000));
const HEALTHY: Health = Health { dark: true, supply: SUPPLY, all_checked_in: true };

fn running(flash: &mut MockFlash) -> Updates<VerifyingKey> {
    Updates::load(flash, &LAYOUT, signing_key().verifying_key())
}

fn send(updates: &mut Updates<VerifyingKey>, flash: &mut MockFlash, image: &[u8]) -> Result<(), Refusal> {
    updates.begin(flash, image.len() as u32)?;
    image.chunks(256).try_for_each(|part| updates.append(flash, part))?;
    updates.commit(flash, vitrine_storage::CRC.checksum(image), SUPPLY)
}

#[test]
fn an_update_is_sent_tried_and_confirmed() {
    let key = signing_key().verifying_key();
    let mut flash = flash_with(&image("1.0.0", 3_000));
    let mut updates = running(&mut flash);
    assert_eq!(updates.state("built").version.as_str(), "1.0.0");
    assert_eq!(
        updates.look_after(&mut flash, HEALTHY, Milliseconds(60_000)),
        Verdict::Wait,
        "nothing is on trial"
    );
    send(&mut updates, &mut flash, &image("2.0.0", 5_000)).expect("taken");
    assert_eq!(updates.state("built").progress, Progress::Wanted);

    assert_eq!(boot(&mut flash, &key), ("2.0.0".into(), true));
    let mut updates = running(&mut flash);
    let on_trial = send(&mut updates, &mut flash, &image("3.0.0", 500));
    assert!(matches!(on_trial, Err(Refusal::OnTrial { .. })), "the old image is still needed");
    let lit = Health { dark: false, ..HEALTHY };
    assert_eq!(updates.look_after(&mut flash, lit, Milliseconds(5_000)), Verdict::Wait);
    assert_eq!(stage_of(&mut flash), Progress::OnTrial);
    assert_eq!(updates.look_after(&mut flash, HEALTHY, Milliseconds(6_000)), Verdict::Confirm);
    assert_eq!(stage_of(&mut flash), Progress::Settled(Outcome::Confirmed));
    send(&mut updates, &mut flash, &image("3.0.0", 500)).expect("taken again");
}

#[test]
fn an_image_for_another_board_or_of_another_key_is_refused_with_its_header() {
    let mut flash = flash_with(&image("1.0.0", 3_000));
    let mut updates = running(&mut flash);
    let body = [7; 5_000];
    for fault in [ImageFault::OtherKey, ImageFault::OtherBoard] {
        let mut header = header("2.0.0", &body);
        match fault {
            ImageFault::OtherKey => header.key[3] ^= 1,
            _ => header.board = *b"rp2350\0\0",
        }
        let foreign = signed(header, &body);
        updates.begin(&mut flash, foreign.len() as u32).expect("begun");
        updates.append(&mut flash, &foreign[..200]).expect("no header yet");
        assert_eq!(updates.append(&mut flash, &foreign[200..456]), Err(Refusal::UnfitImage(fault)));
    }
    send(&mut updates, &mut flash, &image("2.0.0", 5_000)).expect("taken");
}

#[test]
fn what_could_not_confirm_itself_or_is_no_image_is_refused() {
    let mut flash = flash_with(&image("1.0.0", 3_000));
    let mut updates = running(&mut flash);
    let new = image("2.0.0", 1_000);
    assert_eq!(updates.append(&mut flash, &new), Err(Refusal::NoUpload));
    assert_eq!(updates.begin(&mut flash, PLACE + 1), Err(Refusal::ImageLength { most: PLACE }));
    updates.begin(&mut flash, new.len() as u32).expect("begun");
    updates.append(&mut flash, &new).expect("written");
    let crc = vitrine_storage::CRC.checksum(&new);
    for supply in [None, Some(Millivolts(12_000))] {
        assert_eq!(updates.commit(&mut flash, crc, supply), Err(Refusal::NoSupply));
    }
    let refused = updates.commit(&mut flash, crc ^ 1, SUPPLY);
    assert_eq!(refused, Err(Refusal::Checksum { expected: crc ^ 1, found: crc }));
    let mut flipped = new.clone();
    flipped[700] ^= 1;
    assert_eq!(send(&mut updates, &mut flash, &flipped), Err(Refusal::UnfitImage(ImageFault::Damaged)));
    assert_eq!(stage_of(&mut flash), Progress::default());
}

#[test]
fn firmware_without_a_boot_loader_takes_no_update() {
    let mut flash = flash_with(&[]);
    let mut updates = running(&mut flash);
    assert_eq!(updates.state("0.1.0").version.as_str(), "0.1.0");
    assert_eq!(updates.begin(&mut flash, 1_000), Err(Refusal::NoBootLoader));
    assert_eq!(flash.steps(), 0);
}
