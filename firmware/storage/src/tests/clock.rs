use vitrine_exhibit::{clock::ClockRecord, units::UtcSeconds};

use crate::{
    clock,
    map::{FLASH_BYTES, IMAGE_END},
    mock::{EraseOrder, LastStep, MockFlash},
};

fn record(number: i64) -> ClockRecord {
    ClockRecord {
        set_at: Some(UtcSeconds(1_777_629_600 + number * 86_400)),
        drift_ppb: 20_000 + number as i32,
        last_error_s: Some(52),
    }
}

#[test]
fn flash_without_a_record_knows_nothing() {
    let mut flash = MockFlash::new(IMAGE_END, FLASH_BYTES);
    assert_eq!(clock::read(&mut flash), Ok(ClockRecord::default()));
}

#[test]
fn the_longest_record_fits() {
    let mut flash = MockFlash::new(IMAGE_END, FLASH_BYTES);
    let longest =
        ClockRecord { set_at: Some(UtcSeconds(i64::MIN)), drift_ppb: i32::MIN, last_error_s: Some(i32::MIN) };
    clock::store(&mut flash, &longest).expect("fits");
    assert_eq!(clock::read(&mut flash), Ok(longest));
}

/// At each step of a setting, however the erase and the last step tear: the record of before, or the new one whole.
#[test]
fn a_cut_at_any_step_keeps_the_drift_of_before_or_the_new_one() {
    let mut cuts = 0;
    for order in EraseOrder::ALL {
        for last_step in LastStep::ALL {
            let mut flash = MockFlash::new(IMAGE_END, FLASH_BYTES).tearing(order, last_step);
            let mut old = ClockRecord::default();
            for new in (0..4).map(record) {
                let before = flash.clone();
                clock::store(&mut flash, &new).expect("stored");
                for cut in 0..flash.steps() - before.steps() {
                    let mut torn = before.clone();
                    torn.cut_after(cut);
                    clock::store(&mut torn, &new).expect_err("the power went");
                    torn.power_on();
                    let found = clock::read(&mut torn).expect("readable");
                    assert!(found == old || found == new, "{found:?} after a cut at step {cut}");
                    cuts += 1;
                }
                old = new;
            }
        }
    }
    assert!(cuts > 1_000, "{cuts}");
}
