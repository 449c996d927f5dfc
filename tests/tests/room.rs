//! How well viewers are found in the simulated room: bearing, delay, and how long a wrong view may be held.

use vitrine_tests::bench::Bench;
use vitrine_tests::room::{Body, Waypoint};

fn run_until(bench: &mut Bench, time_s: f64) {
    while bench.time_s() < time_s {
        bench.step().expect("what must always hold");
    }
}

fn walker(path: &[(f64, f64, f64)]) -> Body {
    let path = path.iter().map(|(time, angle, distance)| Waypoint(*time, *angle, *distance)).collect();
    Body { path, ..Body::standing(0.0, 1.0) }
}

/// The mean error of the horizontal bearing over three seconds, and that of the vertical, in degrees.
fn bearing_errors(angle: f64, distance: f64, height_m: f64) -> (f64, f64) {
    let mut bench = Bench::new();
    let path = vec![Waypoint(5.0, angle, distance), Waypoint(100.0, angle, distance)];
    bench.room.bodies = vec![Body { height_m, path, ..Body::standing(angle, distance) }];
    run_until(&mut bench, 8.0);
    let (mut horizontal, mut vertical) = (0.0, 0.0);
    for _ in 0..300 {
        bench.step().expect("what must always hold");
        let bearing = bench.snapshot().bearing.unwrap_or_else(|| panic!("lost at {angle} deg, {distance} m"));
        let body = &bench.room.bodies[0];
        let time_s = bench.time_s();
        let of = |angle: Option<f64>| angle.expect("it stands there");
        horizontal += f64::from(bearing.horizontal.0) / 100.0 - of(body.horizontal_deg(time_s));
        vertical += f64::from(bearing.vertical.0) / 100.0 - of(body.vertical_deg(time_s));
    }
    (horizontal / 300.0, vertical / 300.0)
}

#[test]
fn bearings_are_within_two_degrees_out_to_45_from_0_7_to_3_m() {
    let mut worst = (0.0_f64, 0, 0.0);
    for distance in [0.7, 1.0, 1.5, 2.0, 2.5, 3.0] {
        for angle in (-45..=45).step_by(5) {
            let (error, _) = bearing_errors(f64::from(angle), distance, 1.7);
            if error.abs() > worst.0.abs() {
                worst = (error, angle, distance);
            }
        }
    }
    println!("worst bias {:.2} deg at {} deg, {} m", worst.0, worst.1, worst.2);
    assert!(worst.0.abs() <= 2.0, "{worst:?}");
}

#[test]
fn eyes_are_found_within_six_degrees_from_1_2_to_2_m() {
    let mut worst = 0.0_f64;
    for distance in [1.2, 1.5, 2.0] {
        for height in [1.4, 1.55, 1.7, 1.85] {
            for angle in [-30.0, -12.0, 0.0, 25.0] {
                worst = worst.max(bearing_errors(angle, distance, height).1.abs());
            }
        }
    }
    println!("worst vertical bias {worst:.2} deg");
    assert!(worst <= 6.0, "{worst}");
}

/// From the moment the viewer's bearing has crossed to another view's side by the hysteresis, to a change of levels.
#[test]
fn levels_follow_a_viewer_who_moved_within_0_9_s() {
    let mut worst = 0.0_f64;
    for start in 0..20 {
        let moves = 10.0 + f64::from(start) * 0.037;
        let mut bench = Bench::new();
        bench.room.bodies =
            vec![walker(&[(5.0, 0.0, 1.5), (moves, 0.0, 1.5), (moves + 0.3, 30.0, 1.5), (99.0, 30.0, 1.5)])];
        run_until(&mut bench, moves);
        let before = bench.command.levels();
        while bench.command.levels() == before {
            bench.step().expect("what must always hold");
            assert!(bench.time_s() < moves + 5.0, "the levels never follow");
        }
        // The viewer is clearly nearer to the other view from 17 degrees on, after this part of the stride.
        worst = worst.max(bench.time_s() - moves - 0.3 * 17.0 / 30.0);
    }
    println!("slowest answer {worst:.2} s");
    assert!(worst <= 0.9, "{worst}");
}

/// Somebody walks to and fro at many paces; a view that is clearly not the nearest is never kept for long.
#[test]
fn a_wrong_view_is_never_held_longer_than_one_and_a_half_seconds() {
    let mut worst = 0.0_f64;
    for pace_s in [2.0, 3.0, 4.0, 6.0, 9.0] {
        let legs = (0..12).map(|leg| {
            let side = if leg % 2 == 0 { -38.0 } else { 38.0 };
            (5.0 + f64::from(leg) * pace_s, side, 1.3)
        });
        let mut bench = Bench::new();
        bench.room.bodies = vec![walker(&legs.collect::<Vec<_>>())];
        run_until(&mut bench, 7.0);
        let mut wrong_for = 0.0;
        while bench.time_s() < 5.0 + 11.0 * pace_s - 0.1 {
            bench.step().expect("what must always hold");
            wrong_for = if is_wrong(&bench) { wrong_for + 0.01 } else { 0.0 };
            worst = worst.max(wrong_for);
        }
    }
    println!("longest wrong view {worst:.2} s");
    assert!(worst <= 1.5, "{worst}");
}

/// Another view is nearer to where the viewer really stands, by more than the hysteresis and 2 degrees.
fn is_wrong(bench: &Bench) -> bool {
    let Some(at) = bench.room.bodies[0].horizontal_deg(bench.time_s()) else { return false };
    let plan = bench.plan.as_ref().expect("there is a plan");
    let away = |view: &vitrine_exhibit::plan::View| (f64::from(view.horizontal.0) / 100.0 - at).abs();
    let Some(shown) = bench.snapshot().view.and_then(|view| plan.views.get(usize::from(view))) else {
        return true;
    };
    let nearest = plan.views.iter().map(away).fold(f64::MAX, f64::min);
    away(shown) - nearest > 6.0
}

/// What came of a day's visits.
#[derive(Debug, Default)]
struct Day {
    visited_s: f64,
    wrong_s: f64,
    longest_wrong_s: f64,
    /// Seconds with a bearing, and the sum of its errors in degrees over them.
    seen_s: f64,
    error_deg_s: f64,
    worst_mean_deg: f64,
}

/// A number from 0 to 1 of the day's script; the same on every day.
fn number(script: &mut u64) -> f64 {
    *script = script.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*script >> 40) as f64 / (1_u64 << 24) as f64
}

/// Somebody of any height walks in from the side, looks from one or two places, and leaves; gives when they have left.
fn visit(script: &mut u64, from_s: f64) -> (Body, f64) {
    let mut between = |least: f64, most: f64| least + number(script) * (most - least);
    let side = if between(0.0, 1.0) < 0.5 { -55.0 } else { 55.0 };
    let mut path = vec![Waypoint(from_s, side, 3.0)];
    let mut time_s = from_s;
    for _ in 0..1 + (between(0.0, 2.0) as usize) {
        let (angle, distance) = (between(-45.0, 45.0), between(0.7, 3.0));
        time_s += between(2.0, 5.0);
        path.push(Waypoint(time_s, angle, distance));
        time_s += between(4.0, 15.0);
        path.push(Waypoint(time_s, angle, distance));
    }
    time_s += between(2.5, 4.0);
    path.push(Waypoint(time_s, -side, 3.0));
    let height_m = between(1.1, 1.95);
    (Body { height_m, path, ..Body::standing(0.0, 1.0) }, time_s)
}

/// A hundred visits of one person each, without the hours between them: how far off bearings are, how much of the visits'
/// time a wrong view is shown, and how long at most.
#[test]
fn in_a_day_of_a_hundred_visits_no_wrong_view_stays() {
    let (mut script, mut day, mut bench) = (2_026_u64, Day::default(), Bench::new());
    run_until(&mut bench, 5.0);
    for _ in 0..100 {
        let (body, until_s) = visit(&mut script, bench.time_s());
        bench.room.bodies = vec![body];
        follow_visit(&mut bench, until_s, &mut day);
        bench.room.bodies.clear();
        let pause_s = 2.0 + 6.0 * number(&mut script);
        let until_s = bench.time_s() + pause_s;
        run_until(&mut bench, until_s);
    }
    let (wrong, bias) = (day.wrong_s / day.visited_s, day.error_deg_s / day.seen_s);
    println!(
        "{:.0} s of visits, a wrong view for {:.2} % of them, {:.2} s at most",
        day.visited_s,
        100.0 * wrong,
        day.longest_wrong_s
    );
    println!("bias {bias:.2} deg in all, {:.2} deg in the worst place", day.worst_mean_deg);
    assert!(day.longest_wrong_s <= 1.5 && wrong <= 0.1, "{day:?}");
    assert!(bias.abs() <= 0.5 && day.worst_mean_deg.abs() <= 2.0, "{day:?}");
}

/// Follows a visit: a view is wrong where another is clearly nearer, a bearing while its viewer stands within 45 degrees.
fn follow_visit(bench: &mut Bench, until_s: f64, day: &mut Day) {
    let (mut wrong_s, mut stood) = (0.0, Vec::new());
    while bench.time_s() < until_s - 0.02 {
        bench.step().expect("what must always hold");
        let time_s = bench.time_s();
        let body = &bench.room.bodies[0];
        let Some(at) = body.horizontal_deg(time_s).filter(|at| at.abs() <= 45.0) else { continue };
        day.visited_s += 0.01;
        wrong_s = if is_wrong(bench) { wrong_s + 0.01 } else { 0.0 };
        day.wrong_s += if wrong_s > 0.0 { 0.01 } else { 0.0 };
        day.longest_wrong_s = day.longest_wrong_s.max(wrong_s);
        let stands = body
            .path
            .windows(2)
            .any(|leg| leg[0].1 == leg[1].1 && leg[0].0 + 1.0 < time_s && time_s < leg[1].0);
        let bearing = bench.snapshot().bearing.map(|bearing| f64::from(bearing.horizontal.0) / 100.0);
        match bearing.filter(|_| stands) {
            Some(bearing) => stood.push(bearing - at),
            None => count_place(&mut stood, day),
        }
    }
    count_place(&mut stood, day);
}

/// Counts the bearing's errors at one place.
fn count_place(errors: &mut Vec<f64>, day: &mut Day) {
    let sum: f64 = errors.iter().sum();
    let mean = sum / errors.len().max(1) as f64;
    if mean.abs() > day.worst_mean_deg.abs() {
        day.worst_mean_deg = mean;
    }
    day.seen_s += errors.len() as f64 * 0.01;
    day.error_deg_s += sum * 0.01;
    errors.clear();
}

/// Somebody walks up to a place far away and stands there without moving at all for a minute and a half.
#[test]
fn who_stands_dead_still_far_away_is_not_lost() {
    for (angle, distance) in [(-40.0, 3.0), (-20.0, 3.0), (0.0, 3.0), (12.0, 2.5), (25.0, 3.0), (40.0, 2.0)] {
        let mut bench = Bench::new();
        let from = if angle > 0.0 { angle - 25.0 } else { angle + 25.0 };
        let path = [(5.0, from, 2.0), (8.0, angle, distance), (200.0, angle, distance)];
        bench.room.bodies = vec![Body { sway: 0.0, ..walker(&path) }];
        run_until(&mut bench, 9.0);
        while bench.time_s() < 100.0 {
            bench.step().expect("what must always hold");
            let now = bench.snapshot();
            assert_eq!(
                now.viewers,
                1,
                "lost at {angle} degrees, {distance} m, after {:.1} s",
                bench.time_s()
            );
            let bearing = now.bearing.map(|bearing| f64::from(bearing.horizontal.0) / 100.0);
            assert!(bearing.is_some_and(|bearing| (bearing - angle).abs() < 4.0), "{bearing:?} at {angle}");
        }
    }
}
