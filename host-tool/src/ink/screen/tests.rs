use std::sync::LazyLock;

use super::*;
use crate::ink::{Dots, Inks, Separator, YIELDS};
use proptest::prelude::*;

const BOTH: [Halftone; 2] = [Halftone::BlueNoise, Halftone::ErrorDiffusion];

/// Screens of square dots. The mask takes long to make, and is the same for all.
fn square(halftone: Halftone, levels: u16) -> Screens {
    static MASK: LazyLock<Arc<Mask>> = LazyLock::new(|| Screens::new(Halftone::BlueNoise, 2, 1.0).mask);
    Screens { halftone, mask: MASK.clone(), top: (levels - 1) as u8 }
}

/// The only pixel of a row of `width` dots.
fn pixel(width: usize, coverages: [f32; 3]) -> [Run; 1] {
    [Run { end: width, amounts: coverages.map(|coverage| (coverage * 65_535.0).round() as u16) }]
}

/// Lays an area of equal coverages out: levels of each ink, row by row.
fn area(screens: &Screens, film: usize, width: usize, rows: usize, coverages: [f32; 3]) -> [Vec<u8>; 3] {
    let mut screen = screens.film(film, width);
    let mut planes = [0, 1, 2].map(|_| vec![0; width * rows]);
    let mut dots = vec![Dot::NONE; width];
    for row in 0..rows {
        screen.row(row, &pixel(width, coverages), &mut dots);
        for (column, dot) in dots.iter().enumerate() {
            let (ink, level) = dot.ink();
            planes[ink][row * width + column] = level;
        }
    }
    planes
}

fn mean(plane: &[u8], top: u8) -> f64 {
    plane.iter().map(|&level| f64::from(level)).sum::<f64>() / f64::from(top) / plane.len() as f64
}

/// Coverages whose sum is at most 1.
fn coverages() -> impl Strategy<Value = [f32; 3]> {
    ([0.0_f32..=1.0, 0.0..=1.0, 0.0..=1.0], 0.0_f32..=1.0).prop_map(|(parts, sum)| {
        let all: f32 = parts.iter().sum::<f32>().max(1e-6);
        parts.map(|part| part / all * sum)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn no_dot_carries_two_inks_and_the_mean_is_the_coverage(
        coverages in coverages(),
        levels in prop_oneof![Just(2_u16), Just(3), Just(4), Just(16), Just(256)],
        film in 0_usize..40,
    ) {
        for halftone in BOTH {
            let screens = square(halftone, levels);
            let planes = area(&screens, film, 64, 64, coverages);
            for ((red, green), blue) in planes[0].iter().zip(&planes[1]).zip(&planes[2]) {
                prop_assert!([red, green, blue].into_iter().filter(|&&level| level > 0).count() <= 1);
                prop_assert!(*red.max(green).max(blue) <= screens.top());
            }
            // A mask is 4096 thresholds; error diffusion still holds the last row's errors.
            let tolerance = if halftone == Halftone::BlueNoise { 1.5 / 4096.0 } else { 0.03 };
            for (plane, coverage) in planes.iter().zip(coverages) {
                let mean = mean(plane, screens.top());
                prop_assert!((mean - f64::from(coverage)).abs() < tolerance, "{halftone:?} {mean} {coverage}");
            }
        }
    }

    #[test]
    fn white_stays_white_in_dots(value in 0.0_f32..=1.0, levels in prop_oneof![Just(2_u16), Just(4)]) {
        let dots = if levels == 2 { Dots::Binary } else { Dots::Levels(levels) };
        let (coverages, _) = Separator::new(&Inks { dots, ..Inks::default() }).spot([value; 3]);
        let screens = square(Halftone::BlueNoise, levels);
        let planes = area(&screens, 3, 64, 64, coverages);
        let light = [0, 1, 2].map(|ink| mean(&planes[ink], screens.top()) * YIELDS[ink]);
        for pair in [(light[0], light[1]), (light[1], light[2])] {
            prop_assert!((pair.0 - pair.1).abs() < 2.0 / 4096.0, "{light:?}");
        }
    }
}

/// Variance of what the films' dots add up to where film k is moved by k times `drift` dots, as a viewer at an angle
/// sees them, over means of 2 x 2 dots.
fn unrest(films: &[Vec<u8>], side: usize, drift: usize) -> f64 {
    let mut sum = vec![0.0; side * side];
    for (film, dots) in films.iter().enumerate() {
        for (at, sum) in sum.iter_mut().enumerate() {
            let column = (at % side + film * drift) % side;
            *sum += f64::from(dots[at / side * side + column]);
        }
    }
    let block = |at: usize| {
        let (row, column) = (at / (side / 2) * 2, at % (side / 2) * 2);
        [0, 1, side, side + 1].iter().map(|offset| sum[row * side + column + offset]).sum::<f64>() / 4.0
    };
    let blocks: Vec<f64> = (0..side * side / 4).map(block).collect();
    let mean = blocks.iter().sum::<f64>() / blocks.len() as f64;
    blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / blocks.len() as f64
}

#[test]
fn films_do_not_swim_against_each_other() {
    const SIDE: usize = 128;
    const FILMS: usize = 12;
    for halftone in BOTH {
        for coverage in [0.1, 0.35] {
            let screens = square(halftone, 2);
            let dots =
                |film| area(&screens, film, SIDE, SIDE, [0.0, coverage, 0.0]).into_iter().nth(1).unwrap();
            let own: Vec<Vec<u8>> = (0..FILMS).map(dots).collect();
            let same = vec![dots(0); FILMS];
            let own: Vec<f64> = (0..4).map(|drift| unrest(&own, SIDE, drift)).collect();
            let same: Vec<f64> = (0..4).map(|drift| unrest(&same, SIDE, drift)).collect();
            // Alike, the films' variances add up in step: FILMS times as much.
            assert!(own[0] < 2.0 / FILMS as f64 * same[0], "{halftone:?}: {} against {}", own[0], same[0]);
            let swing = |unrest: &[f64]| {
                unrest.iter().copied().fold(0.0, f64::max) / unrest.iter().copied().fold(f64::MAX, f64::min)
            };
            assert!(swing(&own) < 2.0 && swing(&same) > 4.0, "{halftone:?}: {own:?} against {same:?}");
        }
    }
}

#[test]
fn rows_of_blue_noise_are_the_same_in_any_order() {
    let screens = Screens::new(Halftone::BlueNoise, 2, 4.0);
    let whole = area(&screens, 5, 100, 70, [0.2, 0.3, 0.1]);
    let mut dots = [Dot::NONE; 100];
    screens.film(5, 100).row(69, &pixel(100, [0.2, 0.3, 0.1]), &mut dots);
    for (column, dot) in dots.iter().enumerate() {
        let (ink, level) = dot.ink();
        let own = [0, 1, 2].map(|plane| if plane == ink { level } else { 0 });
        assert_eq!([0, 1, 2].map(|plane: usize| whole[plane][69 * 100 + column]), own);
    }
}

#[test]
fn pixels_of_a_row_are_laid_out_each_by_its_own_amounts() {
    let runs = [[0.5, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 0.9], [0.0, 1.0, 0.0]];
    let ends = [90, 100, 260, 261];
    let runs: Vec<Run> = runs.iter().zip(ends).map(|(&coverages, end)| pixel(end, coverages)[0]).collect();
    for halftone in BOTH {
        let mut screen = square(halftone, 2).film(2, 261);
        let mut sums = [0_usize; 4];
        for row in 0..64 {
            let mut dots = [Dot::new(0, 1); 261];
            screen.row(row, &runs, &mut dots);
            for (column, (ink, level)) in dots.map(Dot::ink).into_iter().enumerate() {
                let pixel = ends.iter().position(|&end| column < end).unwrap();
                assert!(level == 0 || halftone == Halftone::ErrorDiffusion || [0, 3, 2, 1][pixel] == ink);
                sums[pixel] += usize::from(level);
            }
        }
        for (sum, wanted) in sums.into_iter().zip([0.5 * 90.0, 0.0, 0.9 * 160.0, 1.0]) {
            let mean = sum as f64 / 64.0;
            assert!((mean - wanted).abs() < 1.0, "{halftone:?}: {mean} dots a row for {wanted}");
        }
    }
}

#[test]
fn nothing_and_everything_are_laid_out_whole() {
    for halftone in BOTH {
        for levels in [2, 4] {
            let screens = square(halftone, levels);
            assert!(area(&screens, 1, 70, 10, [0.0; 3]).iter().flatten().all(|&level| level == 0));
            assert!(
                area(&screens, 1, 70, 10, [0.0, 1.0, 0.0])[1].iter().all(|&level| level == screens.top())
            );
        }
    }
}
