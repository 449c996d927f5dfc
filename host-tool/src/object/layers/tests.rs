//! Which point goes where.

use std::collections::BTreeMap;

use super::*;
use crate::config::CentreSetting;
use crate::object::shape::Box3;
use proptest::prelude::*;

/// 4 films of 8 x 6 pixels of 0.25 mm, 0.5 mm apart: 2 x 1.5 x 2 mm in numbers that are exact.
fn stack() -> Stack {
    Stack {
        films: 4,
        width_px: 8,
        height_px: 6,
        width_mm: 2.0,
        film_mm: 0.25,
        spacer_mm: 0.25,
        ..Stack::default()
    }
}

fn in_mm() -> ObjectSettings {
    ObjectSettings { unit_mm: Some(1.0), centre: CentreSetting::Origin, ..ObjectSettings::default() }
}

fn layers(settings: &ObjectSettings, points: &[Point]) -> Layers {
    let placement = Placement::new(settings, &Box3::EMPTY, &stack());
    let layers = Layers::new(&stack(), placement, settings);
    points.par_chunks(7).for_each(|points| layers.points(points));
    layers
}

fn point(position: Vector) -> Point {
    Point { position, colour: [10, 20, 30] }
}

#[test]
fn a_point_goes_to_the_film_of_the_papers_rule() {
    for (z, film) in [
        (-1.0, Some(3)),
        (-0.501, Some(3)),
        (-0.5, Some(2)),
        (0.0, Some(1)),
        (0.499, Some(1)),
        (0.5, Some(0)),
        (0.999, Some(0)),
        (1.0, None),
        (-1.001, None),
    ] {
        let layers = layers(&in_mm(), &[point([0.0, 0.0, z])]);
        let points: Vec<u64> = (0..4).map(|index| u64::from(Some(index) == film)).collect();
        assert_eq!(layers.points_of_films(), points, "z = {z}");
        assert_eq!(layers.tally().outside, u64::from(film.is_none()), "z = {z}");
    }
}

#[test]
fn x_is_to_the_right_and_y_up() {
    // 0.25 mm right of the left edge and below the upper one: column 1, row 0 holds its lower edge.
    let layers = layers(&in_mm(), &[point([-0.75, 0.5, 0.75])]);
    let taken: Vec<usize> =
        layers.occupied().iter().enumerate().filter(|(_, taken)| **taken).map(|(at, _)| at).collect();
    assert_eq!(taken, [1]);
    let volume = layers.volume(Tone::Code);
    assert_eq!(volume.film_rgb8(0)[3..6], [10, 20, 30]);
    let light = layers.volume(Tone::Linear).film(2, 0)[1];
    assert!((light - srgb_decode(30.0 / 255.0)).abs() < 1e-6);
}

#[test]
fn a_point_has_the_diameter_that_is_asked_for() {
    let settings = ObjectSettings { point_mm: 0.6, ..in_mm() };
    // In the middle of a pixel: its four neighbours' middles are 0.25 mm away, the corners' 0.35 mm.
    let layers = layers(&settings, &[point([0.125, 0.125, 0.25])]);
    assert_eq!(layers.voxels_of_films().iter().sum::<u64>(), 5);
    assert_eq!(layers.tally().on_films, 1);
}

#[test]
fn dithering_spreads_a_plane_over_the_two_films_beside_it() {
    let settings = ObjectSettings { depth_dither: true, ..in_mm() };
    let plane = |z: f64| {
        let place = |at: usize| point([(at % 8) as f64 * 0.25 - 0.9, (at / 8) as f64 * 0.25 - 0.6, z]);
        layers(&settings, &(0..48).map(place).collect::<Vec<_>>()).points_of_films()
    };
    // Films lie at 0.75, 0.25, -0.25, -0.75 mm.
    assert_eq!(plane(0.25), [0, 48, 0, 0]);
    let [upper, lower] = [plane(0.375)[0], plane(0.375)[1]];
    assert_eq!(upper + lower, 48);
    assert!((10..=14).contains(&upper), "{upper}");
    assert_eq!(plane(0.9), [48, 0, 0, 0]);
    assert_eq!(plane(-0.9), [0, 0, 0, 48]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Against a map filled point by point; points come in any order, on any number of threads.
    #[test]
    fn the_nearest_point_of_a_voxel_stays(
        drawn in proptest::collection::vec(
            (proptest::array::uniform3(-1.3f64..1.3), any::<[u8; 3]>(), 0u8..20), 0..200),
    ) {
        let points: Vec<Point> = drawn
            .iter()
            .map(|(position, colour, kind)| match kind {
                0 => Point { position: [position[0], f64::NAN, 0.0], colour: *colour },
                1 => Point { position: [f64::INFINITY, 0.0, 0.0], colour: *colour },
                _ => Point { position: *position, colour: *colour },
            })
            .collect();
        let mut wanted: BTreeMap<[i64; 3], (i64, [u8; 3])> = BTreeMap::new();
        let mut tally = Tally::default();
        for point in &points {
            let [x, y, z] = point.position;
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                tally.not_finite += 1;
                continue;
            }
            let at = [(z + 1.0) / 0.5, (y + 0.75) / 0.25, (x + 1.0) / 0.25];
            let cell = at.map(|value| value.floor() as i64);
            if !(0..4).contains(&cell[0]) || !(0..6).contains(&cell[1]) || !(0..8).contains(&cell[2]) {
                tally.outside += 1;
                continue;
            }
            tally.on_films += 1;
            let key = ((at[0].fract() * 254.0) as i64, point.colour);
            let kept = wanted.entry(cell).or_insert(key);
            *kept = (*kept).max(key);
        }
        let laid = layers(&in_mm(), &points);
        prop_assert_eq!(laid.tally(), tally);
        prop_assert_eq!(laid.voxels_of_films().iter().sum::<u64>(), wanted.len() as u64);
        let volume = laid.volume(Tone::Code);
        for ([layer, up, column], (_, colour)) in wanted {
            let pixel = ((5 - up) * 8 + column) as usize;
            prop_assert_eq!(&volume.film_rgb8(3 - layer as usize)[3 * pixel..][..3], &colour);
        }
        let backwards: Vec<Point> = points.iter().rev().copied().collect();
        prop_assert_eq!(layers(&in_mm(), &backwards).volume(Tone::Code), volume);
    }
}
