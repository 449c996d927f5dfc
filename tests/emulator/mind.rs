//! What the exhibit's mind costs on the processor: the instructions of its step, counted one by one in the emulator.

use vitrine_exhibit::plan::calendar::{ClosedDays, Date, MinuteOfDay, ScheduleRule, Weekdays};
use vitrine_exhibit::plan::{Between, MAX_VIEWS, Plan, Policy, View};
use vitrine_exhibit::units::{CentiDegrees, Level, PerLamp};
use vitrine_tests::room::Room;
use vitrine_tests::scenario::Scenario;

use crate::bench::{Bench, MILLISECOND};
use crate::exhibit::plan;
use crate::hosts::Host;
use crate::room::{battery_clock, show};

/// 5 % of what the processor does in a step's time.
const BUDGET: u64 = 60_000;

/// The sensors make ten frames a second.
const FRAME: u64 = 100 * MILLISECOND;

/// Rooms in which there is much to see, and how long they are watched, in seconds.
const ROOMS: [(&str, f64, f64); 7] = [
    ("crowd", 5.0, 16.0),
    ("two-visitors-shared", 5.0, 12.0),
    ("two-visitors-side-by-side", 5.0, 10.0),
    ("dog-and-owner", 5.0, 11.0),
    ("viewer-walks", 5.0, 12.0),
    ("radiator-beside-a-viewer", 5.0, 9.0),
    ("far-passer-by", 5.0, 12.0),
];

/// As many views, rules and closed days as a plan holds, with the policies that reckon most.
pub(crate) fn largest_plan(policy: Policy, between: Between) -> Plan {
    let mut plan = plan();
    plan.viewer.policy = policy;
    plan.viewer.between = between;
    plan.views = (0..MAX_VIEWS as i16)
        .map(|index| View {
            id: format!("view-{index}").as_str().try_into().expect("a short name"),
            horizontal: CentiDegrees((index % 8 - 4) * 1_100 + 500),
            vertical: CentiDegrees(index / 8 * 1_500),
            emphasis: PerLamp::new(Level(4_000 * index.unsigned_abs() + 1), Level(60_000)),
        })
        .collect();
    plan.calendar.time_zone =
        vitrine_exhibit::plan::calendar::TimeZone::from_posix("CET-1CEST,M3.5.0,M10.5.0/3").expect("a zone");
    let date = |day| Date { year: 2030, month: 1 + day / 28, day: 1 + day % 28 };
    for index in 0..32_u8 {
        let rule = ScheduleRule {
            days: Weekdays::ALL,
            from: MinuteOfDay(u16::from(index)),
            to: MinuteOfDay(1_440),
            // The first decides, so that all the others are asked before.
            first: (index > 0).then(|| date(index)),
            last: None,
            level: Level::FULL,
        };
        plan.calendar.rules.push(rule).expect("room for all");
    }
    for index in 0..64_u8 {
        plan.calendar
            .closed
            .push(ClosedDays { first: date(index), last: date(index) })
            .expect("room for all");
    }
    plan
}

#[test]
fn the_worst_step_stays_within_its_instructions() {
    let policies = [
        (Policy::Shared, Between::Nearest),
        (Policy::Nearest, Between::Smooth),
        (Policy::Alternating, Between::Smooth),
    ];
    let (mut worst, mut worst_room, mut sum, mut steps) = (0, "", 0, 0);
    for (index, (name, from_s, to_s)) in ROOMS.into_iter().enumerate() {
        let (policy, between) = policies[index % policies.len()];
        let mut bench = Bench::with_image("vitrine-pico-bench.elf");
        battery_clock(&mut bench);
        bench.power_on();
        bench.run(100 * MILLISECOND);
        let address = bench.listen();
        Host::greet(&mut bench, &address).upload(&mut bench, &largest_plan(policy, between));
        let mut room = Room::new(1);
        room.bodies = Scenario::read(name).expect("a scenario").bodies().to_vec();
        // The background is learnt before anybody comes, as in the scenario.
        let mut time_s = 0.0;
        while time_s < to_s {
            show(&mut bench, &mut room, time_s);
            bench.run(FRAME);
            if time_s < from_s {
                bench.step_instructions();
            }
            time_s += 0.1;
        }
        let counts = bench.step_instructions();
        assert!(counts.len() > 350, "{} steps in {name}", counts.len());
        let longest = counts.iter().copied().max().expect("steps");
        println!("{name}: {longest} instructions at worst of {} steps", counts.len());
        if longest > worst {
            (worst, worst_room) = (longest, name);
        }
        sum += counts.iter().sum::<u64>();
        steps += counts.len() as u64;
    }
    println!("worst step: {worst} instructions ({worst_room}), {} on average, budget {BUDGET}", sum / steps);
    assert!(worst <= BUDGET, "{worst} instructions in {worst_room}");
}
