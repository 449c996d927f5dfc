use super::calendar::{ClosedDays, Date, MinuteOfDay, ScheduleRule, TimeZone, Weekdays};
use super::*;
use crate::limits;
use crate::testing::plan;
use crate::units::Level;

fn refused(change: impl FnOnce(&mut Plan)) -> PlanError {
    let mut plan = plan();
    change(&mut plan);
    ValidPlan::new(plan).expect_err("this plan must be refused")
}

fn rule() -> ScheduleRule {
    ScheduleRule {
        days: Weekdays::ALL,
        from: MinuteOfDay(540),
        to: MinuteOfDay(1_020),
        first: None,
        last: None,
        level: Level::FULL,
    }
}

fn with_rule(rule: ScheduleRule) -> PlanError {
    refused(|plan| plan.calendar.rules.push(rule).unwrap())
}

#[test]
fn a_slot_holds_the_plan_that_was_put_there_or_nothing() {
    let mut slot = None;
    let fingerprint = ValidPlan::put(&plan(), &mut slot).map(ValidPlan::fingerprint);
    assert_eq!(slot, ValidPlan::new(plan()).ok());
    assert_eq!(fingerprint.ok(), slot.as_ref().map(ValidPlan::fingerprint));
    let unfit = Plan { views: Vec::new(), ..plan() };
    assert_eq!(ValidPlan::put(&unfit, &mut slot).err(), Some(PlanError::NoViews));
    assert_eq!(slot, None, "a plan that was refused takes nobody's place");
}

#[test]
fn the_plan_of_three_photographs_is_valid() {
    assert_eq!(plan().check(), Ok(()));
}

#[test]
fn views_are_checked() {
    assert_eq!(refused(|plan| plan.views.clear()), PlanError::NoViews);
    assert_eq!(refused(|plan| plan.views[1].id = plan.views[0].id.clone()), PlanError::ViewName(1));
    assert_eq!(refused(|plan| plan.views[2].id.clear()), PlanError::ViewName(2));
    assert_eq!(refused(|plan| plan.views[0].horizontal.0 = 8_001), PlanError::ViewAngle(0));
    assert_eq!(refused(|plan| plan.views[0].vertical.0 = i16::MIN), PlanError::ViewAngle(0));
    assert_eq!(refused(|plan| plan.views[1].emphasis = Emphasis::default()), PlanError::ViewDark(1));
    assert_eq!(refused(|plan| plan.volume.films = 0), PlanError::Volume);
}

#[test]
fn pairs_for_two_views_are_found_in_either_order_and_all_or_none_are_there() {
    let pair = |level| Emphasis::new(Level(level), Level(1));
    let mut plan = plan();
    plan.views.push(View { id: "fourth".try_into().unwrap(), ..plan.views[0].clone() }).unwrap();
    assert_eq!(plan.shared_pair(0, 2), Some(Emphasis::new(Level(32_767), Level(32_767))));
    plan.shared = (0..6).map(pair).collect();
    assert_eq!(plan.check(), Ok(()));
    let mut found = Vec::<Emphasis, 6>::new();
    for one in 0..4 {
        assert_eq!(plan.shared_pair(one, one), Some(plan.views[usize::from(one)].emphasis));
        for other in one + 1..4 {
            assert_eq!(plan.shared_pair(one, other), plan.shared_pair(other, one));
            found.extend(plan.shared_pair(other, one));
        }
    }
    assert_eq!(found[..], plan.shared[..]);
    assert_eq!(plan.shared_pair(0, 4), None);
    plan.shared[3] = Emphasis::default();
    assert_eq!(plan.check(), Err(PlanError::Shared));
    plan.shared.truncate(3);
    assert_eq!(plan.check(), Err(PlanError::Shared));
}

#[test]
fn no_plan_raises_a_limit_of_the_firmware() {
    let over = |irradiance: Irradiance| Irradiance(irradiance.0 + 1);
    assert_eq!(refused(|plan| plan.limits.ceiling = over(limits::CEILING)), PlanError::Ceiling);
    assert_eq!(refused(|plan| plan.limits.ceiling.0 = 0), PlanError::Ceiling);
    assert_eq!(refused(|plan| plan.limits.daily_dose.0 += 1), PlanError::DoseLimit);
    assert_eq!(refused(|plan| plan.limits.life_dose.0 += 1), PlanError::DoseLimit);
    assert_eq!(refused(|plan| plan.limits.life_dose.0 = 0), PlanError::DoseLimit);
    assert_eq!(refused(|plan| plan.limits.continuous.0 += 1), PlanError::Continuous);
    assert_eq!(refused(|plan| plan.limits.rest.0 -= 1), PlanError::Rest);
    let above = over(limits::HARDWARE_CEILING);
    assert_eq!(refused(|plan| plan.lamps.top.full_level = above), PlanError::FullLevel);
    assert_eq!(refused(|plan| plan.lamps.bottom.full_level.0 = 0), PlanError::FullLevel);
    assert_eq!(refused(|plan| plan.lamps.bottom.ultraviolet_at_full = above), PlanError::FullLevel);
}

#[test]
fn a_calibration_rises_from_nothing_to_full() {
    let point = |level, duty| CurvePoint { level: Level(level), duty };
    let curve = |points: &[CurvePoint]| {
        let points = points.iter().copied().collect();
        refused(|plan| plan.lamps.top.curve = points)
    };
    assert_eq!(curve(&[point(0, 0), point(100, 50)]), PlanError::Curve);
    assert_eq!(curve(&[point(1, 0), point(65_535, 50)]), PlanError::Curve);
    assert_eq!(curve(&[point(0, 0), point(9, 90), point(8, 91), point(65_535, 99)]), PlanError::Curve);
    assert_eq!(curve(&[point(0, 0), point(9, 90), point(10, 90), point(65_535, 99)]), PlanError::Curve);
}

#[test]
fn viewers_and_presence_are_checked() {
    assert_eq!(refused(|plan| plan.viewer.hysteresis.0 = -1), PlanError::Viewer);
    assert_eq!(refused(|plan| plan.viewer.fade.0 = 299), PlanError::Viewer);
    assert_eq!(refused(|plan| plan.viewer.page.0 = 0), PlanError::Viewer);
    assert_eq!(refused(|plan| plan.viewer.step.0 = 99), PlanError::Viewer);
    assert_eq!(refused(|plan| plan.presence.fade.0 = 0), PlanError::Presence);
    assert_eq!(refused(|plan| plan.presence.idle.0 = u32::MAX), PlanError::Presence);
}

#[test]
fn times_are_checked() {
    let date = |month, day| Date { year: 2026, month, day };
    assert_eq!(with_rule(ScheduleRule { days: Weekdays(0), ..rule() }), PlanError::Rule(0));
    assert_eq!(with_rule(ScheduleRule { days: Weekdays(128), ..rule() }), PlanError::Rule(0));
    assert_eq!(with_rule(ScheduleRule { from: MinuteOfDay(1_440), ..rule() }), PlanError::Rule(0));
    assert_eq!(with_rule(ScheduleRule { to: MinuteOfDay(1_441), ..rule() }), PlanError::Rule(0));
    assert_eq!(with_rule(ScheduleRule { first: Some(date(2, 29)), ..rule() }), PlanError::Rule(0));
    let reversed = ScheduleRule { first: Some(date(6, 2)), last: Some(date(6, 1)), ..rule() };
    assert_eq!(with_rule(reversed), PlanError::Rule(0));
    let closed = ClosedDays { first: date(6, 2), last: date(6, 1) };
    assert_eq!(refused(|plan| plan.calendar.closed.push(closed).unwrap()), PlanError::Closed(0));
    let mut zone = TimeZone::from_posix("CET-1CEST,M3.5.0,M10.5.0/3").unwrap();
    zone.offset_minutes = 1_441;
    assert_eq!(refused(|plan| plan.calendar.time_zone = zone), PlanError::TimeZone);
}

#[test]
fn two_different_plans_are_told_apart() {
    let mut other = plan();
    other.views[0].emphasis.top.0 -= 1;
    let print = |plan| ValidPlan::new(plan).unwrap().fingerprint();
    assert_ne!(print(plan()), print(other));
    assert_eq!(print(plan()), print(plan()));
}

#[test]
fn a_calibration_gives_the_duty_of_each_point_and_never_more_than_asked() {
    let mut lamp = LampCalibration::default();
    for (level, duty) in [(0, 0), (20_000, 30_000), (65_535, 60_000)] {
        lamp.curve.push(CurvePoint { level: Level(level), duty }).unwrap();
    }
    let counts = |level| crate::duty::counts(&lamp, Level(level));
    assert_eq!([counts(0), counts(10_000), counts(20_000), counts(65_535)], [0, 14_305, 28_610, 57_221]);
    for level in 1..=u16::MAX {
        assert!(counts(level) >= counts(level - 1), "{level}");
    }
    let linear = LampCalibration::default();
    for level in 0..=u16::MAX {
        let counts = f64::from(crate::duty::counts(&linear, Level(level)));
        let exact = f64::from(level) * 62_500.0 / 65_535.0;
        assert!(counts <= exact && counts > exact - 1.0, "{level}");
    }
}

#[test]
fn a_bearing_is_looked_at_among_the_views() {
    let mut plan = plan();
    let among = |plan: &Plan, horizontal, vertical| plan.among_views(Bearing::new(horizontal, vertical));
    assert_eq!(among(&plan, 1_000, 3_000), Bearing::new(1_000, 0));
    assert_eq!(among(&plan, -4_500, -1), Bearing::new(-3_000, 0));
    plan.views[1].vertical.0 = 2_000;
    assert_eq!(among(&plan, 4_500, 3_000), Bearing::new(3_000, 2_000));
    assert_eq!(among(&plan, 0, 1_500), Bearing::new(0, 1_500));
    plan.views.clear();
    assert_eq!(among(&plan, 4_500, 3_000), Bearing::new(4_500, 3_000));
}
