use vitrine_exhibit::{settings::Settings, units::CentiDegrees};

use crate::{
    map::{FLASH_BYTES, IMAGE_END, SETTINGS},
    mock::{EraseOrder, LastStep, MockFlash},
    settings,
};

fn flash() -> MockFlash {
    MockFlash::new(IMAGE_END, FLASH_BYTES)
}

fn somewhere() -> Settings {
    Settings {
        place: "Hall 3, left case by the door..".try_into().expect("fits"),
        viewer_pitch: CentiDegrees(-3_000),
        ..Settings::default()
    }
}

#[test]
fn empty_flash_has_the_defaults() {
    assert_eq!(settings::read(&mut flash()), Ok(Settings::default()));
}

#[test]
fn settings_are_kept() {
    let mut flash = flash();
    settings::store(&mut flash, &somewhere()).expect("stored");
    assert_eq!(settings::read(&mut flash), Ok(somewhere()));
}

#[test]
fn settings_that_nobody_could_have_made_are_none() {
    let mut flash = flash();
    let unfit = Settings { top_beta_kelvin: 1, ..somewhere() };
    settings::store(&mut flash, &unfit).expect("stored");
    assert_eq!(settings::read(&mut flash), Ok(Settings::default()));
    SETTINGS.store(&mut flash, &[0xff; 40]).expect("stored");
    assert_eq!(settings::read(&mut flash), Ok(Settings::default()));
}

/// At each step of a change, in the hardest order of tearing: the settings before, or the new ones whole.
#[test]
fn a_cut_at_any_step_keeps_the_settings_before_or_the_new_ones() {
    let mut before = flash().tearing(EraseOrder::Shuffled, LastStep::Garbage);
    let old = Settings { top_beta_kelvin: 3_435, ..Settings::default() };
    settings::store(&mut before, &old).expect("stored");
    let mut whole = before.clone();
    settings::store(&mut whole, &somewhere()).expect("stored");
    for cut in 0..whole.steps() - before.steps() {
        let mut torn = before.clone();
        torn.cut_after(cut);
        settings::store(&mut torn, &somewhere()).expect_err("the power went");
        torn.power_on();
        let found = settings::read(&mut torn).expect("readable");
        assert!(found == old || found == somewhere(), "{found:?} after a cut at step {cut}");
    }
}
