//! Predictions and advice are held to the designs that they are about.

mod common;
#[path = "common/pages.rs"]
mod pages;

use common::{FOUR, THREE, photo, request};
use pages::{PAGES, pages};
use vitrine::design::{
    Change, DesignRequest, DesignSettings, OpticsModel, Placement, Tone, advise, design, predict,
};
use vitrine::optics::Direction;
use vitrine::picture::Picture;

fn settings(optics: OpticsModel, tone: Tone) -> DesignSettings {
    DesignSettings { optics, tone, misplacement_um: 0.0, iterations: 40, ..DesignSettings::default() }
}

/// The same grey in all channels, by row and column.
fn drawn(pixels: usize, grey: impl Fn(usize, usize) -> f32) -> Picture {
    let plane: Vec<f32> = (0..pixels * pixels).map(|at| grey(at / pixels, at % pixels)).collect();
    Picture::from_values(pixels, pixels, plane.repeat(3)).expect("a picture")
}

/// Single bright pixels on black.
fn stars(pixels: usize) -> Picture {
    drawn(pixels, |row, column| {
        let hash = (row * pixels + column).wrapping_mul(0x9E37_79B1) % 0x1_0000_0000;
        if hash < 0x80_0000 { 0.4 + 0.6 * (hash as f32 / 8_388_608.0) } else { 0.0 }
    })
}

/// Dark strokes on white, such as text has.
fn strokes(pixels: usize) -> Picture {
    drawn(pixels, |row, column| {
        let (line, letter) = (row / 12, column / 7);
        let ink = (line * 31 + letter * 17) % 5;
        let inside = row % 12 > 2 && column % 7 < 6;
        let stroke = column % 7 == ink || row % 12 == 3 + ink;
        if inside && stroke && letter % 6 != 5 { 0.05 } else { 0.95 }
    })
}

fn board(pixels: usize) -> Picture {
    drawn(pixels, |row, column| ((row / 16 + column / 16) % 2) as f32)
}

/// A value of its own for every pixel.
fn noise(pixels: usize) -> Picture {
    drawn(pixels, |row, column| {
        let hash = (row * pixels + column).wrapping_mul(0x9E37_79B1) % 0x1_0000_0000;
        hash as f32 / 4_294_967_296.0
    })
}

#[test]
fn hard_pictures_are_predicted_as_they_will_be_designed() {
    let pixels = 160;
    let mut misses = Vec::new();
    for (views, optics, tone) in
        [(&THREE[..], OpticsModel::Ideal, Tone::Code), (&FOUR[..], OpticsModel::Stack, Tone::Linear)]
    {
        let mut wanted = request(views, pixels, settings(optics, tone));
        wanted.views[0].pattern = stars(pixels);
        wanted.views[1].pattern = strokes(pixels);
        let boards = wanted.clone();
        wanted.views[2].pattern = board(pixels);
        if let Some(view) = wanted.views.get_mut(3) {
            view.pattern = noise(pixels);
        }
        for wanted in [boards, wanted] {
            let predicted = predict(&wanted, &mut |_| ()).expect("a prediction");
            let designed = design(&wanted, &mut |_| ()).expect("a design");
            for (predicted, designed) in predicted.views.iter().zip(&designed.views) {
                let found = designed.quality;
                println!(
                    "{}: {:.2} dB {:.3} predicted, {:.2} dB {:.3} reached",
                    predicted.id, predicted.psnr_db, predicted.ssim, found.psnr_db, found.ssim
                );
                misses.push((predicted.psnr_db - found.psnr_db).abs());
                assert!((predicted.ssim - found.ssim).abs() < 0.1);
            }
        }
    }
    let mean = misses.iter().sum::<f64>() / misses.len() as f64;
    println!("{mean:.2} dB beside in the mean");
    assert!(mean < 0.6 && misses.iter().all(|miss| *miss < 2.0), "{misses:?}");
}

fn place(request: &mut DesignRequest, placements: &[Placement]) {
    for placement in placements {
        let view = request.views.iter_mut().find(|view| view.id == placement.id).expect("a view");
        view.direction = Direction::new(placement.horizontal_deg, placement.vertical_deg);
        view.lamp = placement.lamp;
    }
}

fn changed(request: &DesignRequest, change: &Change) -> DesignRequest {
    let mut changed = request.clone();
    match change {
        Change::Directions { views } | Change::Angles { views } => place(&mut changed, views),
        Change::Spacer { spacer_mm } => changed.stack.spacer_mm = *spacer_mm,
        Change::Brightness { brightness } => changed.settings.brightness = *brightness,
        Change::LeaveOut { id } => changed.views.retain(|view| view.id != *id),
        Change::Adapt { .. } => {
            changed = vitrine::design::adapt(request, 0.9, &mut |_| ()).expect("pictures").request;
        }
        Change::Exposure { views } => {
            for exposed in views {
                let view = changed.views.iter_mut().find(|view| view.id == exposed.id).expect("a view");
                view.pattern =
                    view.pattern.decoded().map(|light| (light * exposed.factor).min(1.0)).encoded();
            }
        }
    }
    changed
}

/// Mean square of a picture in dB.
fn level_db(picture: &Picture) -> f64 {
    let sum: f64 = picture.values().iter().map(|&value| f64::from(value).powi(2)).sum();
    10.0 * (sum / picture.values().len() as f64).log10()
}

/// Mean PSNR of the views `ids`; of exposed pictures, held against their own light.
fn quality(request: &DesignRequest, ids: &[String], given: &DesignRequest, is_exposed: bool) -> f64 {
    let designed = design(request, &mut |_| ()).expect("a design");
    let views = request.views.iter().zip(&designed.views).filter(|(view, _)| ids.contains(&view.id));
    let qualities = views.map(|(view, designed)| {
        let given = given.views.iter().find(|given| given.id == view.id).expect("a view");
        let light = if is_exposed { level_db(&view.pattern) - level_db(&given.pattern) } else { 0.0 };
        designed.quality.psnr_db + light
    });
    qualities.sum::<f64>() / ids.len() as f64
}

#[test]
fn what_advice_promises_designs_gain() {
    let mut wanted = request(&THREE, 96, settings(OpticsModel::Stack, Tone::Code));
    wanted.views[1].pattern = photo("rocket", 96);
    let advice = advise(&wanted, &mut |_| ()).expect("advice");
    assert!(advice.len() >= 4, "{advice:?}");
    for advice in &advice {
        let changed = changed(&wanted, &advice.change);
        let ids: Vec<String> = changed.views.iter().map(|view| view.id.clone()).collect();
        let is_exposed = matches!(advice.change, Change::Exposure { .. });
        let before = quality(&wanted, &ids, &wanted, false);
        let gained = quality(&changed, &ids, &wanted, is_exposed) - before;
        println!("{}: {:+.2} dB promised, {gained:+.2} dB gained", advice.change, advice.gain_db);
        assert!((gained - advice.gain_db).abs() < 0.3 + 0.3 * advice.gain_db, "{advice:?}: {gained}");
    }
}

#[test]
fn pages_change_directions_and_lamps_for_better_ones() {
    let mut wanted = request(&THREE, 48, settings(OpticsModel::Stack, Tone::Code));
    wanted.views = pages(&PAGES, 48);
    let advice = advise(&wanted, &mut |_| ()).expect("advice");
    let placed = advice.iter().find(|advice| matches!(advice.change, Change::Directions { .. }));
    let placed = changed(&wanted, &placed.expect("better places").change);
    for places in [&wanted, &placed] {
        let mut places: Vec<_> =
            places.views.iter().map(|view| (view.direction.horizontal_deg as i32, view.lamp)).collect();
        places.sort_by_key(|(degrees, lamp)| (*degrees, format!("{lamp:?}")));
        places.dedup();
        assert_eq!(places.len(), 6, "{places:?}");
    }
    let reached = |request| design(request, &mut |_| ()).expect("a design").mean_psnr_db();
    let (before, after) = (reached(&wanted), reached(&placed));
    println!("{before:.2} dB as given, {after:.2} dB as advised");
    assert!(after > before + 0.5);
}
