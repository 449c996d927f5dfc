use super::*;
use crate::testing::plan;
use crate::units::CentiDegrees;
use crate::viewer::{Sighting, Sightings};

const PICTURE: Milliseconds = Milliseconds(100);

/// Viewers at horizontal bearings, with their signals.
fn see(tracker: &mut Tracker, viewers: &[(i16, u16)]) {
    let sightings: Sightings = viewers
        .iter()
        .map(|(horizontal, strength)| Sighting {
            bearing: Bearing::new(*horizontal, 0),
            strength: *strength,
            moves: true,
        })
        .collect();
    tracker.update(Some(&sightings), PICTURE);
}

/// Runs for some pictures and gives the views shown, without repetitions.
fn views_shown(plan: &Plan, pictures: u32, viewers: &[(i16, u16)]) -> std::vec::Vec<u8> {
    let (mut chooser, mut tracker) = (Chooser::new(), Tracker::new());
    let mut shown = std::vec::Vec::new();
    for _ in 0..pictures {
        see(&mut tracker, viewers);
        chooser.choose(plan, &tracker, PICTURE);
        shown.extend(chooser.view(plan));
    }
    shown.dedup();
    shown
}

#[test]
fn the_first_comer_decides_even_when_somebody_nearer_comes() {
    let plan = plan();
    let (mut chooser, mut tracker) = (Chooser::new(), Tracker::new());
    for _ in 0..20 {
        see(&mut tracker, &[(-3_000, 100)]);
        chooser.choose(&plan, &tracker, PICTURE);
    }
    for _ in 0..50 {
        see(&mut tracker, &[(-3_000, 100), (3_000, 300)]);
        chooser.choose(&plan, &tracker, PICTURE);
    }
    assert_eq!(chooser.view(&plan), Some(0));
}

#[test]
fn the_nearest_decides_where_the_plan_says_so() {
    let mut plan = plan();
    plan.viewer.policy = Policy::Nearest;
    assert_eq!(views_shown(&plan, 50, &[(-3_000, 100), (3_000, 300)]), [2]);
    assert_eq!(views_shown(&plan, 50, &[(-3_000, 300), (3_000, 100)]), [0]);
}

#[test]
fn alternating_shows_each_viewer_their_view_in_turn() {
    let mut plan = plan();
    plan.viewer.policy = Policy::Alternating;
    let shown = views_shown(&plan, 300, &[(-3_000, 100), (3_000, 100)]);
    assert!(shown.len() >= 3 && shown.windows(2).all(|pair| pair[0] != pair[1]), "{shown:?}");
    assert!(shown.contains(&0) && shown.contains(&2));
}

#[test]
fn shared_gives_the_mean_of_the_views_looked_at() {
    let mut plan = plan();
    plan.viewer.policy = Policy::Shared;
    let (mut chooser, mut tracker) = (Chooser::new(), Tracker::new());
    let mut pair = None;
    for _ in 0..30 {
        see(&mut tracker, &[(-3_000, 100), (3_000, 100)]);
        pair = chooser.choose(&plan, &tracker, PICTURE);
    }
    assert_eq!(pair, Some(PerLamp::new(Level(32_767), Level(32_767))));
}

#[test]
fn views_in_one_direction_are_turned_like_pages() {
    let mut plan = plan();
    plan.views[1].horizontal = plan.views[0].horizontal;
    assert_eq!(views_shown(&plan, 250, &[(-3_000, 100)]), [0, 1, 0, 1]);
}

#[test]
fn between_views_the_pair_moves_without_a_jump() {
    let plan = plan();
    let mut last = smooth(&plan, Bearing::new(-4_500, 0));
    for horizontal in -4_500..=4_500 {
        let pair = smooth(&plan, Bearing::new(horizontal, 0));
        let step = |a: Level, b: Level| a.0.abs_diff(b.0);
        assert!(step(pair.top, last.top) < 60 && step(pair.bottom, last.bottom) < 60, "{horizontal}");
        last = pair;
    }
    for view in &plan.views {
        assert_eq!(smooth(&plan, view.bearing()), view.emphasis);
    }
    assert_eq!(plan.views[0].horizontal, CentiDegrees(-3_000));
}
