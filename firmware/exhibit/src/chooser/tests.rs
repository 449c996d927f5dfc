use super::*;
use crate::testing::plan;
use crate::units::{CentiDegrees, PerLamp};
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

/// The pair under the shared policy for viewers at these bearings.
fn shared_pair(plan: &Plan, viewers: &[(i16, u16)]) -> Emphasis {
    let (mut chooser, mut tracker) = (Chooser::new(), Tracker::new());
    let mut pair = None;
    for _ in 0..30 {
        see(&mut tracker, viewers);
        pair = chooser.choose(plan, &tracker, PICTURE);
    }
    pair.unwrap()
}

#[test]
fn shared_gives_the_plans_pair_for_the_views_looked_at() {
    let mut plan = plan();
    plan.viewer.policy = Policy::Shared;
    let pair = |top, bottom| PerLamp::new(Level(top), Level(bottom));
    let (left, right) = ((-3_000, 100), (3_000, 100));
    assert_eq!(shared_pair(&plan, &[left, right]), pair(32_767, 32_767), "the mean, for want of better");
    plan.shared = [pair(100, 200), pair(65_000, 10_000), pair(300, 1_000)].into_iter().collect();
    assert_eq!(shared_pair(&plan, &[left, right]), pair(65_000, 10_000));
    assert_eq!(shared_pair(&plan, &[left, (0, 100), right]), pair(21_800, 3_733));
    assert_eq!(shared_pair(&plan, &[(-3_400, 100), (-2_600, 100)]), plan.views[0].emphasis);
}

#[test]
fn shared_minds_the_page_that_is_turned_up() {
    let mut plan = plan();
    plan.viewer.policy = Policy::Shared;
    plan.views[1].horizontal = plan.views[0].horizontal;
    plan.viewer.page = Milliseconds(1_000);
    let pair = |top| PerLamp::new(Level(top), Level(1));
    plan.shared = [pair(1), pair(2), pair(3)].into_iter().collect();
    let (mut chooser, mut tracker) = (Chooser::new(), Tracker::new());
    let mut pairs = std::vec::Vec::new();
    for picture in 0..80 {
        let viewers = [(-3_000, 100), (3_000, 100)];
        see(&mut tracker, &viewers[..if picture < 20 { 1 } else { 2 }]);
        pairs.extend(chooser.choose(&plan, &tracker, PICTURE));
    }
    pairs.dedup();
    assert!(pairs.ends_with(&[pair(2), pair(3), pair(2)]) || pairs.ends_with(&[pair(3), pair(2), pair(3)]));
}

#[test]
fn views_in_one_direction_are_turned_like_pages() {
    let mut plan = plan();
    plan.views[1].horizontal = plan.views[0].horizontal;
    assert_eq!(views_shown(&plan, 250, &[(-3_000, 100)]), [0, 1, 0, 1]);
}

#[test]
fn pages_are_turned_by_the_viewers_step_where_the_plan_says_so() {
    let mut plan = plan();
    plan.views[1].horizontal = plan.views[0].horizontal;
    plan.viewer.paging = Paging::Step;
    let (mut chooser, mut tracker) = (Chooser::new(), Tracker::new());
    let mut shown_at = |bearing: i16| {
        for _ in 0..40 {
            see(&mut tracker, &[(bearing, 100)]);
            chooser.choose(&plan, &tracker, PICTURE);
        }
        chooser.view(&plan)
    };
    assert_eq!(shown_at(-3_000), Some(0));
    assert_eq!(shown_at(-3_000), Some(0), "standing still turns nothing");
    assert_eq!(shown_at(-2_700), Some(0), "swaying neither");
    assert_eq!(shown_at(-2_300), Some(1));
    assert_eq!(shown_at(-2_300), Some(1));
    assert_eq!(shown_at(-3_000), Some(0), "the last page is followed by the first");
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
