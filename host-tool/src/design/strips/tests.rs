use proptest::prelude::*;

use super::*;
use crate::design::joint::solve_each_colour;
use crate::design::optimise::set_up;
use crate::design::request::ViewRequest;
use crate::design::scale::{averaged, reduced};
use crate::design::{DesignSettings, OpticsModel, design};
use crate::optics::Direction;
use crate::projection::ViewerDistance;

/// A whole picture of which rows are given.
struct Whole(Picture);

impl PictureRows for Whole {
    fn rows(&self, (width, height): (usize, usize), rows: Range<usize>) -> Picture {
        averaged(&self.0, width, height).rows(rows)
    }

    fn held_bytes(&self) -> usize {
        0
    }
}

fn pattern(stack: &Stack, seed: usize) -> Picture {
    let mut picture = Picture::new(stack.width_px, stack.height_px);
    let width = stack.width_px;
    for channel in 0..CHANNELS {
        for (index, value) in picture.channel_mut(channel).iter_mut().enumerate() {
            let (x, y) = ((index % width) as f32, (index / width) as f32);
            let wave = ((x * 0.13 + channel as f32) * (1.0 + seed as f32 * 0.4)).sin() * (y * 0.21).cos();
            *value = 0.5 + 0.5 * wave;
        }
    }
    picture
}

/// The whole request, and the same by strips of 25 rows, `small_px` rows being those of the exhibit in small.
fn requests(whole: DesignRequest, small_px: usize) -> (DesignRequest, StripRequest) {
    let patterns =
        whole.views.iter().map(|view| Box::new(Whole(view.pattern.clone())) as Box<dyn PictureRows>);
    let request = StripRequest {
        small: reduced(&whole, small_px),
        stack: whole.stack.clone(),
        patterns: patterns.collect(),
        masks: whole.views.iter().map(|_| None).collect(),
        rows: 25,
    };
    (whole, request)
}

/// Films without errors, of 40 columns and so many rows.
fn whole(method: Method, distance: ViewerDistance, height_px: usize) -> DesignRequest {
    let stack = Stack { films: 6, width_px: 40, height_px, width_mm: 4.0, ..Stack::default() };
    let directions = [Direction::new(20.0, 0.0), Direction::new(-20.0, 6.0), Direction::new(0.0, -9.0)];
    let views = directions.iter().enumerate();
    let views =
        views.map(|(at, direction)| ViewRequest::new(format!("view-{at}"), pattern(&stack, at), *direction));
    let views = views.collect();
    let settings =
        DesignSettings { method, optics: OpticsModel::Ideal, tone: Tone::Code, ..Default::default() };
    DesignRequest { stack, distance, views, settings, stop: Default::default() }
}

fn prepared(request: StripRequest) -> StripDesign {
    StripDesign::prepare(request, &mut |_| ()).unwrap().0
}

fn levels_of(strips: &StripDesign) -> &Levels {
    let Way::LeastSquares(levels) = &strips.way else { panic!("another method") };
    levels
}

fn by_strips(strips: &StripDesign) -> Volume {
    let stack = &strips.request.stack;
    let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
    let mut ends = vec![0; stack.films];
    for index in 0..strips.strips() {
        let films = strips.strip(index, &mut |_| ()).unwrap().flatten();
        for (film, (rows, end)) in films.zip(&mut ends).enumerate() {
            let place = *end..*end + rows.height() * stack.width_px;
            for channel in 0..CHANNELS {
                volume.film_mut(channel, film)[place.clone()].copy_from_slice(rows.channel(channel));
            }
            *end = place.end;
        }
    }
    assert_eq!(ends, vec![stack.film_len(); stack.films]);
    volume
}

/// The whole request, designed at once from the exhibit in small, for its lamps, and by strips.
fn both(whole: &DesignRequest, strips: &StripDesign) -> [Design; 2] {
    let Levels { start, lighting, .. } = levels_of(strips);
    let problem = set_up(whole, &whole.targets(), lighting, None);
    let at_once = solve_each_colour(whole, &problem, start.clone(), None, &mut |_| ());
    [at_once, by_strips(strips)].map(|volume| Design::of(whole, volume))
}

/// Looks at each view of both.
fn assert_strips_show_as_much(whole: &DesignRequest, strips: &StripDesign, what: &str) {
    let [at_once, strips] = both(whole, strips);
    for (one, other) in at_once.views.iter().zip(&strips.views) {
        let lost = one.quality.psnr_db - other.quality.psnr_db;
        assert!(lost < 0.03, "{what}, {}: {lost} of {} dB lost", one.id, one.quality.psnr_db);
    }
}

#[test]
fn the_product_by_strips_is_the_whole_product() {
    // Where strips lean, what films lose by rounding is carried along them: that may be a step elsewhere.
    const STEP: f32 = 1.0001 / 255.0;
    let viewers = [
        (ViewerDistance::Parallel, 0.0),
        (ViewerDistance::Millimetres(60.0), STEP),
        (ViewerDistance::Millimetres(15.0), STEP),
    ];
    for (distance, most) in viewers {
        let (whole, request) = requests(whole(Method::Product, distance, 90), 45);
        let whole = design(&whole, &mut |_| ()).unwrap().volume;
        let strips = by_strips(&prepared(request));
        let apart = strips.values().iter().zip(whole.values()).map(|(one, other)| (one - other).abs());
        assert!(apart.fold(0.0, f32::max) <= most, "{distance:?}");
    }
}

#[test]
fn least_squares_by_strips_shows_what_the_whole_design_shows() {
    for distance in [ViewerDistance::Parallel, ViewerDistance::Millimetres(60.0)] {
        let whole = whole(Method::LeastSquares, distance, 90);
        let (whole, request) = requests(whole, 45);
        assert_strips_show_as_much(&whole, &prepared(request), &format!("{distance:?}"));
    }
}

#[test]
fn strips_far_finer_than_the_exhibit_in_small_come_by_coarser_ones() {
    let (whole, request) = requests(whole(Method::LeastSquares, ViewerDistance::Parallel, 180), 45);
    let strips = prepared(request);
    assert_eq!(levels_of(&strips).heights_px(), [90, 180]);
    assert_strips_show_as_much(&whole, &strips, "two levels");
}

#[test]
fn films_that_lie_astray_by_pixels_are_solved_with_coarser_ones() {
    let mut whole = whole(Method::LeastSquares, ViewerDistance::Parallel, 90);
    whole.stack.width_mm = 1.2;
    whole.settings = DesignSettings::default();
    let (whole, request) = requests(whole, 45);
    let strips = prepared(request);
    assert_eq!(levels_of(&strips).heights_px(), [45], "an error of 68 µm is one of 2.3 pixels of 30 µm");
    assert_strips_show_as_much(&whole, &strips, "half as fine");
}

#[test]
fn more_memory_holds_more_rows_and_too_little_none() {
    for method in [Method::Product, Method::LeastSquares] {
        let whole = whole(method, ViewerDistance::Millimetres(60.0), 9000);
        let small = reduced(&whole, 45);
        let rows = |mib| rows_within(&whole.stack, &small, mib);
        assert_eq!(rows(0.01), None);
        assert!(rows(20.0) < rows(30.0) && rows(20.0).is_some(), "{:?} {:?}", rows(20.0), rows(30.0));
        assert_eq!(rows(1e6), Some(9000));
    }
}

/// Errors of each row of a view, mean squares of codes.
fn row_errors(shown: &Picture, pattern: &Picture) -> Vec<f64> {
    let width = shown.width();
    let row = |row: usize| {
        let place = row * width..(row + 1) * width;
        let errors = (0..CHANNELS).flat_map(|channel| {
            let pixels =
                shown.channel(channel)[place.clone()].iter().zip(&pattern.channel(channel)[place.clone()]);
            pixels.map(|(shown, wanted)| f64::from(shown - wanted).powi(2)).collect::<Vec<_>>()
        });
        errors.sum::<f64>() / (CHANNELS * width) as f64
    };
    (0..shown.height()).map(row).collect()
}

#[test]
fn leaning_strips_show_a_near_viewer_as_much_without_a_seam() {
    let mut whole = whole(Method::LeastSquares, ViewerDistance::Millimetres(20.0), 180);
    whole.views[1].distance = Some(ViewerDistance::Millimetres(24.0));
    let (whole, request) = requests(whole, 90);
    let strips = prepared(request);
    let leaning = strips.tiles.tile(0).leaning(&whole.stack);
    assert!(leaning.first_row(0) - leaning.first_row(5) > 10, "the first strip leans by more than 10 rows");
    let [at_once, by_strips] = both(&whole, &strips);
    for ((one, other), view) in at_once.views.iter().zip(&by_strips.views).zip(&whole.views) {
        let lost = one.quality.psnr_db - other.quality.psnr_db;
        assert!(lost < 0.03, "{}: {lost} of {} dB lost", view.id, one.quality.psnr_db);
        let rows = [one, other].map(|design| row_errors(&design.shown, &view.pattern));
        for (row, (one, other)) in rows[0].iter().zip(&rows[1]).enumerate() {
            let lost = 10.0 * (other / one).log10();
            assert!(lost < 0.3, "row {row} of {}: {lost} dB lost", view.id);
        }
    }
}

proptest! {
    #[test]
    fn every_row_of_every_film_belongs_to_one_strip(
        height_px in 2usize..3000,
        films in 1usize..30,
        rows in 1usize..400,
        pixel_um in 10.0f64..300.0,
        spacer_mm in 0.0f64..8.0,
        views in proptest::collection::vec((-60.0f64..60.0, -60.0f64..60.0, proptest::option::of(1.01f64..100.0)), 1..4),
    ) {
        let stack = Stack { films, width_px: 2, height_px, width_mm: pixel_um * 2e-3, spacer_mm, ..Stack::default() };
        let views = views.into_iter().map(|(horizontal_deg, vertical_deg, depths)| ViewRequest {
            distance: depths.map(|depths| ViewerDistance::Millimetres(depths * (stack.depth_mm() + 1.0))),
            ..ViewRequest::new("view", Picture::new(2, height_px), Direction::new(horizontal_deg, vertical_deg))
        });
        let views = views.collect();
        let small = DesignRequest {
            stack: stack.clone(),
            distance: ViewerDistance::Parallel,
            views,
            settings: DesignSettings::default(),
            stop: Default::default(),
        };
        let tiles = Tiles::new(&stack, &small, rows);
        let mut ends = vec![0; films];
        for index in 0..tiles.count() {
            let tile = tiles.tile(index);
            for (rows, end) in tile.films.iter().zip(&mut ends) {
                prop_assert!(rows.start == *end && rows.end >= rows.start);
                *end = rows.end;
            }
        }
        prop_assert_eq!(ends, vec![height_px; films]);
    }
}

#[test]
fn signs_of_a0_for_viewers_at_any_distance_are_designed_within_two_gibibytes() {
    const STRIPS_MIB: f64 = 0.75 * 2048.0 - 100.0;
    let stack =
        Stack { width_px: 23_839, height_px: 33_704, width_mm: 841.0, spacer_mm: 5.0, ..Stack::default() };
    for method in [Method::LeastSquares, Method::Product] {
        for distance in [None, Some(3000.0), Some(1500.0), Some(800.0)] {
            let small = Stack { width_px: 362, height_px: 512, ..stack.clone() };
            let distance = distance.map_or(ViewerDistance::Parallel, ViewerDistance::Millimetres);
            let views = [-20.0, 0.0, 20.0].map(|degrees| {
                ViewRequest::new("view", Picture::new(362, 512), Direction::new(degrees, 0.0))
            });
            let settings = DesignSettings { method, ..DesignSettings::default() };
            let mut small = DesignRequest {
                stack: small,
                distance,
                views: views.into(),
                settings,
                stop: Default::default(),
            };
            let rows = rows_within(&stack, &small, STRIPS_MIB);
            assert!(rows.is_some_and(|rows| rows > 60), "{method:?} {distance:?}: {rows:?}");
            small.views[0].direction.vertical_deg = 40.0;
            assert_eq!(
                rows_within(&stack, &small, STRIPS_MIB),
                None,
                "rays that climb 0.84 mm apart for each mm"
            );
        }
    }
}
