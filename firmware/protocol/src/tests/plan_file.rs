use heapless::Vec;
use vitrine_exhibit::plan::{
    CurvePoint, Emphasis, LampCalibration, MAX_CURVE, MAX_SHARED, MAX_VIEWS, Plan, View,
    calendar::{ClosedDays, Date, MAX_CLOSED, MAX_RULES, MinuteOfDay, ScheduleRule, Weekdays},
};
use vitrine_exhibit::testing;
use vitrine_exhibit::units::{CentiDegrees, Irradiance, Level, PerLamp};

use super::samples::text;
use crate::plan_file::{self, MAX_PLAN_BYTES, PlanFileError};

pub(super) fn small() -> Plan {
    Plan {
        name: text("Small"),
        views: [testing::view("front", 0, u16::MAX, 1)].into_iter().collect(),
        neutral: Emphasis::new(Level::FULL, Level::FULL),
        ..testing::plan()
    }
}

fn filled<T: Clone, const N: usize>(value: T) -> Vec<T, N> {
    core::iter::repeat_n(value, N).collect()
}

#[test]
fn a_plan_survives_its_bytes() {
    let mut buffer = [0; MAX_PLAN_BYTES];
    let bytes = plan_file::encode(&small(), &mut buffer).expect("fits");
    assert_eq!(plan_file::decode(bytes), Ok(small()));
}

#[test]
fn damage_and_another_layout_are_told_apart() {
    let mut buffer = [0; MAX_PLAN_BYTES];
    let bytes = plan_file::encode(&small(), &mut buffer).expect("fits");
    for place in 0..bytes.len() {
        bytes[place] ^= 4;
        assert_eq!(plan_file::decode(bytes), Err(PlanFileError::Checksum));
        bytes[place] ^= 4;
    }
    assert_eq!(plan_file::decode(&[]), Err(PlanFileError::Checksum));
    let short = &mut bytes[..20];
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(&short[..16]).to_le_bytes();
    short[16..].copy_from_slice(&checksum);
    assert_eq!(plan_file::decode(short), Err(PlanFileError::Layout));
}

#[test]
fn plans_are_named_apart() {
    let plans = ["Small", "Snail"].map(|name| {
        let mut buffer = [0; MAX_PLAN_BYTES];
        let plan = Plan { name: text(name), ..small() };
        plan_file::crc(plan_file::encode(&plan, &mut buffer).expect("fits"))
    });
    assert_ne!(plans[0], plans[1]);
}

#[test]
fn the_largest_plan_fits() {
    let date = Date { year: 2199, month: 12, day: 31 };
    let point = CurvePoint { level: Level::FULL, duty: u16::MAX };
    let lamp = LampCalibration {
        full_level: Irradiance(u32::MAX),
        curve: filled::<_, MAX_CURVE>(point),
        ..LampCalibration::default()
    };
    let view = View {
        id: text("123456789012345678901234"),
        horizontal: CentiDegrees(i16::MIN),
        vertical: CentiDegrees(i16::MIN),
        emphasis: Emphasis::new(Level::FULL, Level::FULL),
    };
    let mut plan = small();
    plan.name = text("123456789012345678901234123456789012345678901234");
    plan.views = filled::<_, MAX_VIEWS>(view);
    plan.shared = filled::<_, MAX_SHARED>(Emphasis::new(Level::FULL, Level::FULL));
    plan.lamps = PerLamp::new(lamp.clone(), lamp);
    plan.calendar.rules = filled::<_, MAX_RULES>(ScheduleRule {
        days: Weekdays::ALL,
        from: MinuteOfDay(1_440),
        to: MinuteOfDay(1_440),
        first: Some(date),
        last: Some(date),
        level: Level::FULL,
    });
    plan.calendar.closed = filled::<_, MAX_CLOSED>(ClosedDays { first: date, last: date });
    let mut buffer = [0; MAX_PLAN_BYTES];
    let bytes = plan_file::encode(&plan, &mut buffer).expect("fits");
    assert_eq!(plan_file::decode(bytes), Ok(plan));
}
