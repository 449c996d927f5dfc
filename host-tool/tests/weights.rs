//! What a view counts, how it is lit and what its films do with ink: masks, lamps of its own, whites, distances, emission.

mod common;

use common::{FOUR, THREE, request};
use vitrine::design::{Design, DesignRequest, DesignSettings, HandErrors, OpticsModel, Tone, design};
use vitrine::optics::LampPair;
use vitrine::projection::ViewerDistance;
use vitrine::stack::Stack;
use vitrine_exhibit::units::Lamp;

const PIXELS: usize = 64;

fn designed(request: &DesignRequest) -> Design {
    design(request, &mut |_| ()).unwrap()
}

/// Mean square error of a view in the left or the right half of its picture.
fn error_of_half(request: &DesignRequest, design: &Design, view: usize, right: bool) -> f64 {
    let (shown, pattern) = (&design.views[view].shown, &request.views[view].pattern);
    let pixels = shown.values().iter().zip(pattern.values()).enumerate();
    let half = pixels.filter(|(index, _)| (index % PIXELS >= PIXELS / 2) == right);
    let squares: Vec<f64> = half.map(|(_, (a, b))| f64::from(a - b).powi(2)).collect();
    squares.iter().sum::<f64>() / squares.len() as f64
}

#[test]
fn errors_move_to_where_the_mask_is_dark() {
    let settings =
        DesignSettings { optics: OpticsModel::Ideal, tone: Tone::Code, ..DesignSettings::default() };
    let plain = request(&THREE, PIXELS, settings);
    let mut masked = plain.clone();
    let mask = |right: bool| {
        (0..PIXELS * PIXELS)
            .map(|index| f32::from(u8::from((index % PIXELS >= PIXELS / 2) == right)))
            .collect()
    };
    for view in &mut masked.views {
        view.mask = Some(mask(true));
    }
    let (before, after) = (designed(&plain), designed(&masked));
    let sum = |design: &Design, right| -> f64 {
        (0..3).map(|view| error_of_half(&plain, design, view, right)).sum()
    };
    assert!(sum(&after, true) < 0.8 * sum(&before, true), "{} {}", sum(&after, true), sum(&before, true));
    assert!(sum(&after, false) > sum(&before, false));
    masked.views[0].mask = Some(vec![1.0; 7]);
    assert!(masked.check().unwrap_err().to_string().contains("mask of view astronaut"));
}

#[test]
fn a_view_with_a_distance_of_its_own_is_seen_from_there() {
    let settings = DesignSettings { tone: Tone::Code, ..DesignSettings::default() };
    let mut near = request(&THREE[..1], PIXELS, settings);
    near.views[0].distance = Some(ViewerDistance::Millimetres(150.0));
    let design = designed(&near);
    let mut far = near.clone();
    far.views[0].distance = None;
    let seen_from_afar = Design::of(&far, design.volume.clone());
    let [own, other] = [&design, &seen_from_afar].map(|design| design.views[0].under_own_lamps.psnr_db);
    assert!(own > other + 3.0, "{own} {other}");
    near.views[0].distance = Some(ViewerDistance::Millimetres(5.0));
    assert!(near.check().unwrap_err().to_string().contains("distance_mm of view astronaut"));
}

/// Two pages in each of two directions.
fn pages() -> DesignRequest {
    let views = FOUR.map(|(name, horizontal_deg, _)| (name, 1.25 * horizontal_deg, 0.0));
    let settings = DesignSettings { tone: Tone::Code, ..DesignSettings::default() };
    let settings = settings.expecting(HandErrors::misplaced(0.0));
    let mut pages = request(&views, PIXELS, settings);
    for (index, view) in pages.views.iter_mut().enumerate() {
        view.lamp = Some(if index < 2 { Lamp::Top } else { Lamp::Bottom });
    }
    pages
}

#[test]
fn two_pictures_in_one_direction_are_told_apart_by_their_lamps() {
    let design = designed(&pages());
    for (index, view) in design.views.iter().enumerate() {
        let other = if index < 2 { view.emphasis.bottom } else { view.emphasis.top };
        assert_eq!(other, 0.0, "{:?}", view.emphasis);
        assert!(view.quality.psnr_db > 16.0, "{}: {} dB", view.id, view.quality.psnr_db);
    }
    let under_full: f64 = design.views.iter().map(|view| view.under_full_lamps.psnr_db).sum::<f64>() / 4.0;
    assert!(design.mean_psnr_db() > under_full + 2.0, "{} {under_full}", design.mean_psnr_db());
}

#[test]
fn no_view_looks_brighter_than_another_by_more_than_the_ratio() {
    let mut request = pages();
    let design = designed(&request);
    let whites = |design: &Design| design.views.iter().map(|view| view.white).collect::<Vec<_>>();
    let ratio = |whites: &[f64]| {
        whites.iter().copied().fold(0.0, f64::max) / whites.iter().copied().fold(f64::INFINITY, f64::min)
    };
    request.settings.white_ratio = 1000.0;
    let free = Design::of(&request, design.volume.clone());
    assert!(free.views.iter().all(|view| view.emphasis.top.max(view.emphasis.bottom) == 1.0));
    assert!(ratio(&whites(&free)) > 2.1, "{:?}", whites(&free));
    for wanted in [1.0, 1.3, 2.0] {
        request.settings.white_ratio = wanted;
        let kept = Design::of(&request, design.volume.clone());
        assert!((ratio(&whites(&kept)) - wanted).abs() < 0.01, "{wanted}: {:?}", whites(&kept));
        for (kept, free) in kept.views.iter().zip(&free.views) {
            assert!((kept.quality.psnr_db - free.quality.psnr_db).abs() < 0.01);
            // Light is in proportion to the level, and so is the white.
            let level = kept.emphasis.top.max(kept.emphasis.bottom);
            assert!((kept.white / free.white - level).abs() < 0.01);
        }
    }
}

#[test]
fn the_pair_for_two_views_serves_them_better_than_the_mean_of_their_own() {
    let request = pages();
    let design = designed(&request);
    assert_eq!(design.shared.len(), 6);
    let quality = |views: [usize; 2], pair: LampPair| {
        let mut held = request.clone();
        for view in &mut held.views {
            view.lamp = None;
        }
        let built = vitrine::design::as_built(&held, &design.volume, &[pair; 4], 1, 0);
        views.iter().map(|&view| built.views[view].mean_psnr_db).sum::<f64>()
    };
    for shared in &design.shared {
        let views = [shared.first, shared.second];
        let [one, other] = views.map(|view| design.views[view].emphasis);
        let mean = LampPair::new(one.top + other.top, one.bottom + other.bottom).normalised();
        let gained = quality(views, shared.pair) - quality(views, mean);
        assert!(gained > -0.02, "{views:?}: {gained} dB, {:?} against {mean:?}", shared.pair);
    }
}

/// What a design that knows its films gains over one that takes them for plain ones, in dB.
fn gain_of_knowing(change: impl Fn(&mut Stack)) -> f64 {
    let plain = request(&THREE, PIXELS, DesignSettings { tone: Tone::Code, ..DesignSettings::default() });
    let mut real = plain.clone();
    change(&mut real.stack);
    let knowing = designed(&real);
    let ignorant = Design::of(&real, designed(&plain).volume);
    println!("{:.2} against {:.2} dB", knowing.mean_psnr_db(), ignorant.mean_psnr_db());
    assert!(knowing.volume.values().iter().all(|ink| (0.0..=1.0).contains(ink)));
    knowing.mean_psnr_db() - ignorant.mean_psnr_db()
}

#[test]
fn knowing_that_full_ink_saturates_pays() {
    assert!(gain_of_knowing(|stack| stack.ink_absorbance = 2.0) > 1.0);
}

#[test]
fn knowing_that_red_ink_is_faint_pays() {
    assert!(gain_of_knowing(|stack| stack.ink_yields = [0.43, 0.85, 0.89]) > 1.0);
}

#[test]
fn knowing_that_light_spreads_pays() {
    // A pixel and a half of these films.
    assert!(gain_of_knowing(|stack| stack.blur_um = 820.0) > 0.5);
}
