use vitrine_exhibit::{
    events::Event,
    units::{Lamp, Level, UtcSeconds},
    viewer::Bearing,
};

use super::{Clock, FlashFile, Noise, Viewer, VirtualController, Walk, thermal_frames};
use crate::link::tests::plan_bytes;
use vitrine_protocol::{Controller, plan_file};

fn with_plan() -> VirtualController {
    let mut controller = VirtualController::new(FlashFile::in_memory(), Clock::Computer).expect("readable");
    load_plan(&mut controller);
    controller
}

fn load_plan(controller: &mut VirtualController) {
    let plan = plan_bytes("Three photographs");
    controller.begin_plan(plan.len() as u32).expect("begun");
    controller.append_plan(&plan).expect("written");
    controller.commit_plan(plan_file::crc(&plan)).expect("committed");
}

#[test]
fn an_empty_room_looks_alike_to_both_sensors() {
    let [left, right] = thermal_frames(None, &mut Noise::none());
    assert_eq!(left.pixels, right.pixels);
    assert!(left.pixels.iter().all(|pixel| *pixel == 88));
}

#[test]
fn a_viewer_is_warm_where_the_viewer_is() {
    let [left, right] = thermal_frames(Some(Viewer::at(Bearing::new(2_500, 800))), &mut Noise::none());
    assert!(left.pixels.iter().all(|pixel| *pixel == 88), "beyond the left sensor's edge");
    let warmest = (0..64).max_by_key(|pixel| right.pixels[*pixel]).expect("pixels");
    assert!((3..=4).contains(&(warmest % 8)), "in the middle of the right sensor: {:?}", right.pixels);
    assert!(right.pixels[8 * 2..8 * 3].iter().all(|pixel| *pixel == 88), "nothing above the head");
}

#[test]
fn noise_is_that_of_the_sensor() {
    let mut noise = Noise::new();
    let frames: Vec<_> = (0..100).map(|_| thermal_frames(None, &mut noise)).collect();
    let deviations =
        frames.iter().flatten().flat_map(|frame| frame.pixels).map(|pixel| f64::from(pixel - 88));
    let variance = deviations.map(|deviation| deviation * deviation).sum::<f64>() / (100.0 * 2.0 * 64.0);
    // That of the noise and that of rounding to quarters.
    assert!((variance - (0.64 * 0.64 + 1.0 / 12.0)).abs() < 0.03, "{variance}");
}

#[test]
fn the_lamps_follow_a_visitor_and_go_dark_when_nobody_is_left() {
    let mut controller = with_plan();
    controller.set_walk(Walk::back_and_forth());
    let mut shown = Vec::new();
    for _ in 0..600 {
        controller.advance(100);
        let view = controller.snapshot().view;
        if controller.lamps().bottom != Level::OFF && view.is_some() && shown.last() != Some(&view) {
            shown.push(view);
        }
    }
    assert_eq!(shown, [Some(0), Some(1), Some(2), Some(1), Some(0)]);
    controller.set_viewer(None);
    controller.advance(20 * 60_000);
    assert_eq!(controller.lamps(), vitrine_exhibit::units::PerLamp::default());
}

#[test]
fn a_walk_is_straight_between_its_stations_and_repeats() {
    let at = |horizontal| Some(Viewer::at(Bearing::new(horizontal, 0)));
    let walk = Walk::new(vec![(0, None), (1_000, at(-1_000)), (3_000, at(1_000)), (4_000, None)], true);
    assert_eq!(walk.at(500), None);
    assert_eq!(walk.at(1_000), at(-1_000));
    assert_eq!(walk.at(2_500), at(500));
    assert_eq!(walk.at(3_500), at(1_000));
    assert_eq!(walk.at(4_500), None);
    assert_eq!(walk.at(6_500), at(500));
    assert_eq!(Walk::nobody().at(5), None);
}

#[test]
fn time_passes_alike_in_small_and_in_large_pieces() {
    let (mut small, mut large) = (with_plan(), with_plan());
    for controller in [&mut small, &mut large] {
        controller.set_walk(Walk::back_and_forth());
    }
    (0..3_000).for_each(|_| small.advance(7));
    large.advance(21_000);
    assert_eq!(small.time_ms(), large.time_ms());
    assert_eq!(small.snapshot().levels, large.snapshot().levels);
}

#[test]
fn boards_warm_up_under_the_lamps() {
    let mut controller = with_plan();
    let cold = controller.surroundings.boards().bottom;
    controller
        .set_walk(Walk::new(vec![(0, None), (5_000, Some(Viewer::at(Bearing::new(3_000, 500))))], false));
    controller.advance(120_000);
    let warm = controller.surroundings.boards();
    let celsius = |reading: Option<vitrine_exhibit::inputs::TemperatureReading>| {
        reading.and_then(vitrine_exhibit::inputs::TemperatureReading::celsius).expect("a temperature")
    };
    assert!(celsius(warm.bottom).0 > celsius(cold).0 + 500);
    assert!(celsius(warm.bottom) > celsius(warm.top));
}

#[test]
fn the_log_keeps_the_dose_of_each_day() {
    // 2026-11-22T20:37:42Z, and a plan without a time zone.
    let evening = UtcSeconds(1_795_379_862);
    let mut controller =
        VirtualController::new(FlashFile::in_memory(), Clock::Simulated(evening)).expect("readable");
    load_plan(&mut controller);
    controller.set_walk(Walk::back_and_forth());
    controller.advance(4 * 3_600_000);
    let mut entries = Vec::new();
    let mut next = 0;
    loop {
        let page = controller.read_log(next).expect("log");
        let Some(last) = page.entries.last() else { break };
        next = last.sequence + 1;
        entries.extend(page.entries.iter().map(|entry| entry.event));
    }
    let doses: Vec<_> = entries
        .iter()
        .filter_map(|event| match event {
            Event::DayDose { lamp, day, joules_m2, .. } => Some((*lamp, *day, *joules_m2)),
            _ => None,
        })
        .collect();
    let [(Lamp::Top, 20_779, top), (Lamp::Bottom, 20_779, bottom)] = doses[..] else { panic!("{doses:?}") };
    let life = controller.snapshot().life_dose.map(|dose| dose.0 / 1_000_000);
    assert!(u64::from(top) > life.top / 2 && u64::from(top) < life.top, "{top} of {life:?}");
    assert!(u64::from(bottom) > life.bottom / 2 && u64::from(bottom) < life.bottom, "{bottom} of {life:?}");
}

/// A battery clock that gains 52 s in a month is set twice, a month apart, with the power off between: from then on
/// what it shows is corrected, also after a start.
#[test]
fn the_battery_clocks_drift_is_learnt_kept_and_corrected() {
    let set_at = 1_795_379_862;
    let month = 30 * 86_400;
    let start =
        |flash, shows| VirtualController::new(flash, Clock::Simulated(UtcSeconds(shows))).expect("readable");
    let mut controller = start(FlashFile::in_memory(), set_at - 3_600);
    controller.set_clock(UtcSeconds(set_at)).expect("set");
    assert_eq!(controller.clock().record.last_error_s, Some(-3_600));

    let mut controller = start(controller.power_off(), set_at + month + 52);
    assert_eq!(
        controller.clock().now,
        Some(UtcSeconds(set_at + month + 52)),
        "nothing is known of its drift yet"
    );
    controller.set_clock(UtcSeconds(set_at + month)).expect("set");
    let record = controller.clock().record;
    assert_eq!((record.last_error_s, record.drift_ppb / 1_000), (Some(52), 20));

    let mut controller = start(controller.power_off(), set_at + 2 * month + 52);
    assert_eq!(controller.clock().record, record);
    assert_eq!(controller.clock().now, Some(UtcSeconds(set_at + 2 * month)));
    controller.advance(1_500);
    assert_eq!(controller.snapshot().now, Some(UtcSeconds(set_at + 2 * month + 1)));
}
