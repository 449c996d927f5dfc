//! Updates while the power stays.

use vitrine_protocol::firmware::{ImageFault, Outcome, Progress};
use vitrine_storage::Error;

use super::bench::{
    LAYOUT, PLACE, Remembering, boot, erased, flash_with, held, image, put, signing_key, stage, stage_of,
};
use crate::{Staging, Start, start, store_progress};

fn runs(version: &str, on_trial: bool) -> (std::string::String, bool) {
    (version.into(), on_trial)
}

#[test]
fn a_confirmed_update_stays() {
    let (old, new, key) = (image("1.0.0", 5_000), image("2.0.0", 3_000), signing_key().verifying_key());
    let mut flash = flash_with(&old);
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", false));
    stage(&mut flash, &key, &new).expect("staged");
    assert_eq!(stage_of(&mut flash), Progress::Wanted);
    assert_eq!(boot(&mut flash, &key), runs("2.0.0", true));
    assert_eq!(stage_of(&mut flash), Progress::OnTrial);
    assert_eq!(held(&mut flash, LAYOUT.old, old.len()), old);
    store_progress(&mut flash, &LAYOUT, Progress::Settled(Outcome::Confirmed)).expect("stored");
    for _ in 0..3 {
        assert_eq!(boot(&mut flash, &key), runs("2.0.0", false));
    }
    assert_eq!(stage_of(&mut flash), Progress::Settled(Outcome::Confirmed));
}

#[test]
fn an_update_that_does_not_confirm_is_gone_back_from() {
    let (old, new, key) = (image("1.0.0", 5_000), image("2.0.0", 6_000), signing_key().verifying_key());
    let mut flash = flash_with(&old);
    stage(&mut flash, &key, &new).expect("staged");
    assert_eq!(boot(&mut flash, &key), runs("2.0.0", true));
    for _ in 0..2 {
        assert_eq!(boot(&mut flash, &key), runs("1.0.0", false));
        assert_eq!(stage_of(&mut flash), Progress::Settled(Outcome::WentBack));
    }
}

#[test]
fn a_start_without_an_update_writes_nothing() {
    let key = signing_key().verifying_key();
    let mut flash = flash_with(&image("1.0.0", 5_000));
    boot(&mut flash, &key);
    assert_eq!(flash.steps(), 0);
}

#[test]
fn a_damaged_image_is_replaced_by_the_old_one_or_else_by_the_new_one() {
    let (old, new, key) = (image("1.0.0", 5_000), image("2.0.0", 3_000), signing_key().verifying_key());
    let mut flash = flash_with(&old);
    stage(&mut flash, &key, &new).expect("staged");
    boot(&mut flash, &key);
    store_progress(&mut flash, &LAYOUT, Progress::Settled(Outcome::Confirmed)).expect("stored");
    let mut damaged = new.clone();
    damaged[1_000] ^= 0x10;
    put(&mut flash, LAYOUT.active, &damaged);
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", false));
    assert_eq!(stage_of(&mut flash), Progress::Settled(Outcome::Restored));

    put(&mut flash, LAYOUT.active, &damaged);
    put(&mut flash, LAYOUT.old, &damaged);
    assert_eq!(boot(&mut flash, &key), runs("2.0.0", false));
    put(&mut flash, LAYOUT.active, &damaged);
    put(&mut flash, LAYOUT.new, &erased(16));
    assert_eq!(start(&mut flash, &LAYOUT, &key), Ok(Start::Nothing));
    assert_eq!(held(&mut flash, LAYOUT.active, damaged.len()), damaged, "nothing is touched in vain");
}

#[test]
fn an_image_that_was_damaged_after_it_was_staged_is_not_installed() {
    let (old, new, key) = (image("1.0.0", 5_000), image("2.0.0", 3_000), signing_key().verifying_key());
    let mut flash = flash_with(&old);
    stage(&mut flash, &key, &new).expect("staged");
    let mut damaged = new.clone();
    damaged[2_000] ^= 1;
    put(&mut flash, LAYOUT.new, &damaged);
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", false));
    assert_eq!(stage_of(&mut flash), Progress::Settled(Outcome::Refused));
}

#[test]
fn the_first_image_has_nothing_to_go_back_to_and_keeps_running() {
    let key = signing_key().verifying_key();
    let mut flash = flash_with(&[]);
    assert_eq!(start(&mut flash, &LAYOUT, &key), Ok(Start::Nothing));
    stage(&mut flash, &key, &image("1.0.0", 3_000)).expect("staged");
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", true));
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", false));
    assert_eq!(stage_of(&mut flash), Progress::Settled(Outcome::NothingToGoBackTo));
}

/// Whatever is stored as progress, what runs is whole.
#[test]
fn a_made_up_progress_starts_no_mixture() {
    let (old, new, key) = (image("1.0.0", 5_000), image("2.0.0", 6_000), Remembering::new());
    for progress in [
        Progress::Wanted,
        Progress::Installing,
        Progress::OnTrial,
        Progress::GoingBack,
        Progress::Settled(Outcome::Confirmed),
    ] {
        for (in_new, in_old) in
            [(&new[..], &[][..]), (&new[..300], &old[..]), (&[][..], &new[..]), (&[], &[])]
        {
            let mut flash = flash_with(&old);
            put(&mut flash, LAYOUT.new, in_new);
            put(&mut flash, LAYOUT.old, in_old);
            store_progress(&mut flash, &LAYOUT, progress).expect("stored");
            for _ in 0..3 {
                boot(&mut flash, &key);
            }
        }
    }
}

#[test]
fn what_is_not_whole_signed_or_announced_is_refused_before_anything_changes() {
    let (old, new, key) = (image("1.0.0", 5_000), image("2.0.0", 3_000), Remembering::new());
    let mut flash = flash_with(&old);
    for length in [0, 256, PLACE + 1] {
        let refused = Staging::begin(&mut flash, &LAYOUT, length).err();
        assert_eq!(refused, Some(Error::TooLong { most: PLACE }));
    }
    let mut staging = Staging::begin(&mut flash, &LAYOUT, new.len() as u32).expect("begun");
    staging.append(&mut flash, &new[..1_000]).expect("written");
    assert_eq!(staging.finish(&mut flash, &key), Err(Error::Incomplete { written: 1_000 }));
    assert_eq!(staging.append(&mut flash, &[0; 3_000]), Err(Error::TooLong { most: new.len() as u32 }));

    let sent = |flash: &mut _, bytes: &[u8]| {
        let mut staging = Staging::begin(flash, &LAYOUT, bytes.len() as u32).expect("begun");
        bytes.chunks(200).for_each(|part| staging.append(flash, part).expect("written"));
        assert_eq!(staging.crc(), vitrine_storage::CRC.checksum(bytes));
        staging.finish(flash, &key).expect("readable").err()
    };
    let mut flipped = new.clone();
    flipped[1_500] ^= 1;
    assert_eq!(sent(&mut flash, &flipped), Some(ImageFault::Damaged));
    let longer = [&new[..], &[0; 10]].concat();
    assert_eq!(sent(&mut flash, &longer), Some(ImageFault::Length));
    assert_eq!(sent(&mut flash, &[7; 500]), Some(ImageFault::NoImage));
    assert_eq!(stage_of(&mut flash), Progress::default());
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", false));
}

#[test]
fn another_image_may_be_sent_before_the_first_is_installed() {
    let (old, key) = (image("1.0.0", 5_000), Remembering::new());
    let mut flash = flash_with(&old);
    stage(&mut flash, &key, &image("2.0.0", 3_000)).expect("staged");
    let mut staging = Staging::begin(&mut flash, &LAYOUT, 3_256).expect("begun");
    staging.append(&mut flash, &image("3.0.0", 3_000)[..500]).expect("written");
    assert_eq!(boot(&mut flash, &key), runs("1.0.0", false), "half of it is no update");
    stage(&mut flash, &key, &image("3.0.0", 3_000)).expect("staged");
    assert_eq!(boot(&mut flash, &key), runs("3.0.0", true));
}

#[test]
fn a_staging_says_before_it_erases() {
    let new = image("2.0.0", 6_000);
    let mut flash = flash_with(&image("1.0.0", 500));
    let mut staging = Staging::begin(&mut flash, &LAYOUT, new.len() as u32).expect("begun");
    for part in new.chunks(100) {
        let before: u32 = flash.erases().iter().sum();
        let announced = staging.will_erase(part.len() as u32);
        staging.append(&mut flash, part).expect("written");
        assert_eq!(flash.erases().iter().sum::<u32>() - before, u32::from(announced));
    }
    assert_eq!(staging.written() as usize, new.len());
    assert_eq!(flash.erases().iter().sum::<u32>(), 2);
}
