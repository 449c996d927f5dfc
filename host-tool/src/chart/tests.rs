use super::photograph::{Camera, TILTED};
use super::*;
use crate::picture::Picture;

/// A chart of patches that fill it but for some.
fn chart() -> Chart {
    let patch = |index: usize| Patch {
        x_mm: 20.0 + 10.0 * (index % 9) as f64,
        y_mm: 20.0 + 10.0 * (index / 9) as f64,
        size_mm: 6.0,
        shape: if index.is_multiple_of(2) { Shape::Square } else { Shape::Disc },
        coverages: [[0.8, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.5], [0.0; 3]][index % 4],
    };
    Chart { width_mm: 120.0, height_mm: 100.0, patches: (0..63).map(patch).collect() }
}

fn camera<'a>(corners: [[f64; 2]; 4], glow: &'a dyn Fn(usize, f32, [f64; 2]) -> f64) -> Camera<'a> {
    Camera { width: 1200, height: 960, corners, glow, ambient: 0.01, vignetting: 0.3, noise: 0.01, blur: 1 }
}

fn even(_: usize, coverage: f32, _: [f64; 2]) -> f64 {
    0.7 * f64::from(coverage)
}

#[test]
fn a_chart_is_found_turned_and_from_its_back() {
    let chart = chart();
    let corners = chart.marks();
    let [a, b, c, d] = TILTED;
    for to in [[a, b, c, d], [b, c, d, a], [c, d, a, b], [d, a, b, c], [b, a, d, c], [d, c, b, a]] {
        let light = camera(to, &even).take(&chart).decoded();
        let found = find(&light, &chart).unwrap();
        let sheet = [[0.0, 0.0], [120.0, 0.0], [120.0, 100.0], [0.0, 100.0]];
        let exact = Perspective::through(sheet, to).unwrap();
        for corner in corners {
            let (at, wanted) = (found.perspective.apply(corner), exact.apply(corner));
            let off = (at[0] - wanted[0]).hypot(at[1] - wanted[1]);
            assert!(off < 0.4, "{corner:?} is {off} pixels off");
        }
        for reading in read_patches(&light, &chart, &found) {
            let ink = reading.patch.coverages.iter().position(|&coverage| coverage > 0.0);
            for channel in 0..3 {
                let wanted = if Some(channel) == ink {
                    0.7 * f64::from(reading.patch.coverages[channel])
                } else {
                    0.0
                };
                let read = reading.light[channel];
                assert!(read > 0.65 * wanted && read < wanted + 0.02, "{read} for {wanted}");
            }
        }
    }
}

#[test]
fn pictures_that_show_no_whole_chart_are_told_apart() {
    let chart = chart();
    let find_in = |camera: &Camera<'_>| find(&camera.take(&chart).decoded(), &chart);
    assert_eq!(find(&Picture::new(600, 400).map(|_| 0.2), &chart), Err(ChartError::NotFound));
    let cat =
        Picture::read(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/photos/cat.jpg"))).unwrap();
    assert!(matches!(find(&cat.decoded(), &chart), Err(ChartError::NotFound | ChartError::CutOff { .. })));
    let cut = TILTED.map(|[x, y]| [x + 260.0, y]);
    assert_eq!(find_in(&camera(cut, &even)), Err(ChartError::CutOff { marks: 2 }));
    let dark = |ink: usize, coverage: f32, at: [f64; 2]| 0.005 * even(ink, coverage, at);
    assert!(matches!(
        find_in(&Camera { noise: 0.0, ambient: 0.0, ..camera(TILTED, &dark) }),
        Err(ChartError::TooDark { .. })
    ));
    let small = [[500.0, 400.0], [740.0, 400.0], [740.0, 600.0], [500.0, 600.0]];
    assert!(matches!(
        find_in(&camera(small, &even)),
        Err(ChartError::TooSmall { .. } | ChartError::NotFound)
    ));
    let covered = |ink: usize, coverage: f32, at: [f64; 2]| {
        let dot = (at[0] - 14.0).hypot(at[1] - 6.0) < 3.0;
        if dot { 0.0 } else { even(ink, coverage, at) }
    };
    assert_eq!(find_in(&camera(TILTED, &covered)), Err(ChartError::AnotherChart));
}

#[test]
fn an_uneven_field_is_told_from_the_levels() {
    let field = |x: f64, y: f64| 1.0 + 0.2 * x - 0.1 * y - 0.25 * (x * x + y * y);
    let sample = |index: usize| {
        let (x, y) = ((index % 10) as f64 / 4.5 - 1.0, (index / 10) as f64 / 4.5 - 1.0);
        let group = index * 7 % 12;
        Sample { x, y, group, layers: 0, light: field(x, y) * (0.1 + 0.08 * group as f64) }
    };
    let samples: Vec<Sample> = (0..100).map(sample).collect();
    let fitted = Field::fit(&samples, 12).unwrap();
    let levels = fitted.levels(&samples, 12);
    for (group, level) in levels.iter().enumerate() {
        let relative = level / levels[11] / ((0.1 + 0.08 * group as f64) / 0.98);
        assert!((relative - 1.0).abs() < 0.01, "group {group}: {relative}");
    }
    assert_eq!(Field::fit(&samples[..5], 12), None);
}
