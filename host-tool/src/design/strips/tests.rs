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
    for index in 0..strips.strips() {
        let rows = strips.rows(index);
        let place = rows.start * stack.width_px..rows.end * stack.width_px;
        let mut above = 0;
        for films in strips.strip(index, &mut |_| ()).unwrap() {
            for (channel, film) in (0..CHANNELS).flat_map(|c| (0..films.films()).map(move |f| (c, f))) {
                volume.film_mut(channel, above + film)[place.clone()]
                    .copy_from_slice(films.film(channel, film));
            }
            above += films.films();
        }
        assert_eq!(above, stack.films);
    }
    volume
}

/// Each view's quality in the films of the whole request: designed whole from the exhibit in small, for its lamps, and
/// by strips.
fn assert_strips_show_as_much(whole: &DesignRequest, strips: &StripDesign, what: &str) {
    let Levels { start, lighting, .. } = levels_of(strips);
    let problem = set_up(whole, &whole.targets(), lighting, None);
    let at_once = solve_each_colour(whole, &problem, start.clone(), None, &mut |_| ());
    let [at_once, strips] = [at_once, by_strips(strips)].map(|volume| Design::of(whole, volume));
    for (one, other) in at_once.views.iter().zip(&strips.views) {
        let lost = one.quality.psnr_db - other.quality.psnr_db;
        assert!(lost < 0.03, "{what}, {}: {lost} of {} dB lost", one.id, one.quality.psnr_db);
    }
}

#[test]
fn the_product_by_strips_is_the_whole_product() {
    for distance in [ViewerDistance::Parallel, ViewerDistance::Millimetres(60.0)] {
        let (whole, request) = requests(whole(Method::Product, distance, 90), 45);
        let whole = design(&whole, &mut |_| ()).unwrap().volume;
        assert!(by_strips(&prepared(request)) == whole, "{distance:?}");
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
