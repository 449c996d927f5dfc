use std::{println, vec, vec::Vec};

use proptest::prelude::*;

use super::cut_stride;
use crate::{
    Error, TwoSlots,
    map::SECTOR_BYTES,
    mock::{EraseOrder, LastStep, MockError, MockFlash},
};

const START: u32 = 0x10_0000;

fn slots(sectors: u32) -> (TwoSlots, MockFlash) {
    let slots = TwoSlots::new(START, sectors * SECTOR_BYTES);
    (slots, MockFlash::new(START, slots.end()))
}

fn body(number: u32, length: usize) -> Vec<u8> {
    (0..length as u32).map(|i| (number.wrapping_mul(31) + i * 7 + i / 256) as u8).collect()
}

fn newest(slots: &TwoSlots, flash: &mut MockFlash) -> Option<Vec<u8>> {
    let record = slots.newest(flash).expect("readable flash")?;
    let mut bytes = vec![0; record.length() as usize];
    assert_eq!(record.read(flash, 0, &mut bytes).expect("readable record"), bytes.len());
    Some(bytes)
}

#[test]
fn erased_flash_holds_no_record() {
    let (slots, mut flash) = slots(1);
    assert_eq!(newest(&slots, &mut flash), None);
}

#[test]
fn flash_full_of_zeros_or_noise_holds_no_record() {
    let (slots, mut flash) = slots(1);
    flash.bytes_mut().fill(0);
    assert_eq!(newest(&slots, &mut flash), None);
    let mut random = crate::mock::Random(1);
    flash.bytes_mut().iter_mut().for_each(|byte| *byte = random.next() as u8);
    assert_eq!(newest(&slots, &mut flash), None);
}

#[test]
fn the_newest_of_many_records_is_read_and_the_slots_wear_alike() {
    let (slots, mut flash) = slots(2);
    for number in 0..50 {
        let bytes = body(number, 100 * number as usize);
        let record = slots.store(&mut flash, &bytes).expect("stored");
        assert_eq!(record.generation(), number + 1);
        assert_eq!(record.crc(), crate::CRC.checksum(&bytes));
        assert_eq!(newest(&slots, &mut flash), Some(bytes));
    }
    assert_eq!([flash.erases()[0], flash.erases()[2]], [25, 25]);
}

#[test]
fn parts_are_read_from_any_offset_and_end_with_the_record() {
    let (slots, mut flash) = slots(1);
    let bytes = body(1, 300);
    let record = slots.store(&mut flash, &bytes).expect("stored");
    let mut part = [0; 256];
    assert_eq!(record.read(&mut flash, 200, &mut part), Ok(100));
    assert_eq!(part[..100], bytes[200..]);
    assert_eq!(record.read(&mut flash, 300, &mut part), Ok(0));
    assert_eq!(record.read(&mut flash, u32::MAX, &mut part), Ok(0));
}

#[test]
fn the_old_record_stays_until_the_new_one_is_finished() {
    let (slots, mut flash) = slots(4);
    let old = body(1, 9_000);
    slots.store(&mut flash, &old).expect("stored");
    let new = body(2, 16_000);
    let mut writer = slots.begin(&mut flash, 16_000).expect("begun");
    for chunk in new.chunks(256) {
        writer.append(&mut flash, chunk).expect("written");
        assert_eq!(newest(&slots, &mut flash).as_ref(), Some(&old));
    }
    let staged = writer.staged(&mut flash).expect("as written");
    assert_eq!(staged.crc(), crate::CRC.checksum(&new));
    assert_eq!(newest(&slots, &mut flash).as_ref(), Some(&old));
    writer.finish(&mut flash).expect("finished");
    assert_eq!(newest(&slots, &mut flash).as_ref(), Some(&new));
}

#[test]
fn a_writer_erases_sector_by_sector_and_says_so_before() {
    let (slots, mut flash) = slots(4);
    let mut writer = slots.begin(&mut flash, 16_000).expect("begun");
    for chunk in body(1, 16_000).chunks(256) {
        let erased: u32 = flash.erases().iter().sum();
        let announced = writer.will_erase(chunk.len() as u32);
        writer.append(&mut flash, chunk).expect("written");
        assert_eq!(flash.erases().iter().sum::<u32>() - erased, u32::from(announced));
    }
    assert_eq!(flash.erases().iter().sum::<u32>(), 4);
}

#[test]
fn too_long_and_incomplete_records_are_refused() {
    let (slots, mut flash) = slots(1);
    let most = slots.capacity();
    assert_eq!(slots.begin(&mut flash, most + 1).err(), Some(Error::TooLong { most }));
    slots.store(&mut flash, &body(1, most as usize)).expect("the longest record fits");
    let mut writer = slots.begin(&mut flash, 10).expect("begun");
    assert_eq!(writer.append(&mut flash, &[0; 11]), Err(Error::TooLong { most: 10 }));
    writer.append(&mut flash, &[1; 9]).expect("written");
    assert_eq!(writer.finish(&mut flash).err(), Some(Error::Incomplete { written: 9 }));
    assert_eq!(newest(&slots, &mut flash), Some(body(1, most as usize)));
}

#[test]
fn a_damaged_newest_record_gives_way_to_the_one_before() {
    let (slots, mut flash) = slots(1);
    slots.store(&mut flash, &body(1, 500)).expect("stored");
    let newer = slots.store(&mut flash, &body(2, 500)).expect("stored");
    let damaged = (newer.address() - START) as usize + 250;
    flash.bytes_mut()[damaged] ^= 1;
    assert_eq!(newest(&slots, &mut flash), Some(body(1, 500)));
}

#[test]
fn flash_that_does_not_hold_what_is_written_is_noticed() {
    let (slots, mut flash) = slots(1);
    let mut writer = slots.begin(&mut flash, 100).expect("begun");
    writer.append(&mut flash, &body(1, 100)).expect("written");
    flash.bytes_mut()[32 + 50] = 0;
    assert_eq!(writer.finish(&mut flash).err(), Some(Error::NotAsWritten));
}

/// Cuts the power at every step of storing each of `records` (every `stride`-th), again while it is stored anew, and
/// expects the old or the new record each time, and the new one after an undisturbed try. Gives the cuts tried.
fn cut_everywhere(sectors: u32, records: &[Vec<u8>], stride: usize) -> u64 {
    let mut cuts = 0;
    for order in EraseOrder::ALL {
        for last_step in LastStep::ALL {
            let (slots, flash) = slots(sectors);
            let mut flash = flash.tearing(order, last_step);
            let mut old = None;
            for (number, new) in records.iter().enumerate() {
                let before = flash.clone();
                slots.store(&mut flash, new).expect("stored");
                let steps = flash.steps() - before.steps();
                for cut in (0..steps).skip(number % stride).step_by(stride) {
                    let mut once = before.clone();
                    store_with_cut(&slots, &mut once, new, cut);
                    expect_old_or_new(&slots, &mut once, old.as_ref(), new);
                    cuts += 1;
                    for second_cut in (cut % 97..steps).step_by(steps as usize / 3 + 1) {
                        let mut twice = once.clone();
                        store_with_cut(&slots, &mut twice, new, second_cut);
                        expect_old_or_new(&slots, &mut twice, old.as_ref(), new);
                        cuts += 1;
                    }
                    slots.store(&mut once, new).expect("stored at last");
                    assert_eq!(newest(&slots, &mut once).as_ref(), Some(new));
                }
                old = Some(new.clone());
            }
        }
    }
    cuts
}

fn store_with_cut(slots: &TwoSlots, flash: &mut MockFlash, record: &[u8], cut: u64) {
    flash.cut_after(cut);
    let outcome = slots.store(flash, record);
    assert!(matches!(outcome, Err(Error::Flash(MockError::PowerLost))), "{outcome:?}");
    flash.power_on();
}

fn expect_old_or_new(slots: &TwoSlots, flash: &mut MockFlash, old: Option<&Vec<u8>>, new: &Vec<u8>) {
    let found = newest(slots, flash);
    assert!(
        found.as_ref() == old || found.as_ref() == Some(new),
        "neither the old nor the new record: {:?}",
        found.map(|bytes| bytes.len())
    );
}

#[test]
fn a_cut_at_any_step_leaves_the_old_or_the_new_record() {
    let records: Vec<_> = (0..6).map(|number| body(number, 180 + 13 * number as usize)).collect();
    let cuts = cut_everywhere(1, &records, cut_stride(1));
    println!("slots of one sector: {cuts} cuts, no failure");
    assert!(cuts > 3_000 / cut_stride(1) as u64);
}

#[test]
fn a_cut_in_a_record_of_several_sectors_leaves_the_old_or_the_new_record() {
    let records: Vec<_> = (0..3).map(|number| body(number, 9_000 + 150 * number as usize)).collect();
    let cuts = cut_everywhere(4, &records, cut_stride(61));
    println!("slots of four sectors: {cuts} cuts, no failure");
    assert!(cuts > 100);
}

proptest! {
    #[test]
    fn any_history_of_cuts_leaves_a_record_that_was_stored(
        history in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..200), prop::option::of(0_u64..300)), 1..20),
        order in prop::sample::select(EraseOrder::ALL.to_vec()),
        last_step in prop::sample::select(LastStep::ALL.to_vec()),
    ) {
        let (slots, flash) = slots(1);
        let mut flash = flash.tearing(order, last_step);
        let mut known: Option<Vec<u8>> = None;
        for (bytes, cut) in history {
            if let Some(cut) = cut {
                flash.cut_after(cut);
            }
            let stored = slots.store(&mut flash, &bytes).is_ok();
            flash.power_on();
            let found = newest(&slots, &mut flash);
            if stored {
                prop_assert_eq!(found.as_ref(), Some(&bytes));
            } else {
                prop_assert!(found == known || found.as_ref() == Some(&bytes));
            }
            known = found;
        }
    }
}
