use super::*;
use proptest::prelude::*;

fn inks(quench: [f64; 3], limit: f64, gamut: Gamut, dots: Dots) -> Inks {
    Inks { curves: quench.map(Curve::quenching), limit, gamut, dots, ..Inks::default() }
}

/// What a spot's coverages glow, ink by ink, in the units of the yields.
fn glow(inks: &Inks, coverages: [f32; 3]) -> [f64; 3] {
    let amount: f32 = coverages.iter().sum();
    [0, 1, 2].map(|ink| {
        let curve = &inks.curves[ink];
        let light = match inks.dots {
            Dots::Levels(_) if amount > 0.0 => coverages[ink] / amount * curve.light(amount),
            _ => curve.light(coverages[ink]),
        };
        inks.yields[ink] * f64::from(light)
    })
}

fn any_inks() -> impl Strategy<Value = Inks> {
    let dots = prop_oneof![Just(Dots::Continuous), Just(Dots::Binary), Just(Dots::Levels(4))];
    let gamut = prop_oneof![Just(Gamut::Clip), Just(Gamut::Compress), Just(Gamut::Fit)];
    let curves = prop_oneof![Just([0.0; 3]), [0.0..3.0, 0.0..3.0, 0.0..3.0]];
    (curves, 0.2..1.0, gamut, dots).prop_map(|(quench, limit, gamut, dots)| inks(quench, limit, gamut, dots))
}

proptest! {
    #[test]
    fn the_limit_is_kept(inks in any_inks(), film: [f32; 3]) {
        let (coverages, _) = Separator::new(&inks).spot(film);
        prop_assert!(coverages.iter().all(|coverage| (0.0..=1.0).contains(coverage)), "{coverages:?}");
        prop_assert!(f64::from(coverages.iter().sum::<f32>()) <= inks.limit * (1.0 + 1e-6), "{coverages:?}");
    }

    #[test]
    fn spots_glow_in_the_films_proportion(inks in any_inks(), film in [0.0_f32..=1.0, 0.0..=1.0, 0.0..=1.0]) {
        let (coverages, _) = Separator::new(&inks).spot(film);
        let glow = glow(&inks, coverages);
        let (light, value) = (glow.iter().sum::<f64>(), film.iter().map(|&v| f64::from(v)).sum::<f64>());
        for (glow, value_of) in glow.iter().zip(film) {
            let wanted = f64::from(value_of) * light / value.max(1e-9);
            prop_assert!((glow - wanted).abs() < 2e-4, "{glow:?} for {film:?}");
        }
    }

    #[test]
    fn what_the_limit_allows_is_not_dimmed(quench in 0.0..2.0, dots in prop_oneof![Just(Dots::Binary), Just(Dots::Levels(8))], value in 0.0_f32..=1.0, ink in 0_usize..3) {
        let inks = inks([quench; 3], 1.0, Gamut::Clip, dots);
        let mut film = [0.0; 3];
        film[ink] = value;
        let (coverages, dimmed) = Separator::new(&inks).spot(film);
        prop_assert!(!dimmed);
        prop_assert!((glow(&inks, coverages)[ink] - YIELDS[0] * f64::from(value)).abs() < 2e-4);
    }

    #[test]
    fn more_light_is_never_printed_darker(inks in any_inks(), film in [0.0_f32..=1.0, 0.0..=1.0, 0.0..=1.0], part in 0.0_f32..1.0) {
        let separator = Separator::new(&inks);
        let sum = |film| glow(&inks, separator.spot(film).0).iter().sum::<f64>();
        prop_assert!(sum(film.map(|v| v * part)) <= sum(film) + 2e-4);
    }
}

#[test]
fn white_takes_most_of_the_weakest_ink() {
    let (coverages, dimmed) = Separator::new(&Inks::default()).spot([0.2; 3]);
    assert!(!dimmed);
    for (coverage, expected) in coverages.iter().zip([0.2, 0.2 * 0.43 / 0.85, 0.2 * 0.43 / 0.89]) {
        assert!((coverage - expected).abs() < 1e-6, "{coverages:?}");
    }
    let (coverages, dimmed) = Separator::new(&Inks::default()).spot([1.0; 3]);
    assert!(dimmed && (coverages.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    // 1 / (1/0.43 + 1/0.85 + 1/0.89) of full light is the brightest white side by side.
    assert!((coverages[0] * 0.43 - 0.216_2).abs() < 1e-4, "{coverages:?}");
}

#[test]
fn fitted_values_are_all_dimmed_alike_and_compressed_ones_differ_to_the_end() {
    let fit = Separator::new(&inks([0.0; 3], 1.0, Gamut::Fit, Dots::Binary));
    let (white, _) = fit.spot([1.0; 3]);
    let (grey, _) = fit.spot([0.5; 3]);
    assert!((white.iter().sum::<f32>() - 1.0).abs() < 1e-5);
    assert!(white.iter().zip(grey).all(|(white, grey)| (white - 2.0 * grey).abs() < 1e-6));
    let compress = Separator::new(&inks([0.0; 3], 1.0, Gamut::Compress, Dots::Binary));
    let sums: Vec<f32> = (1..=10).map(|v| compress.spot([v as f32 / 10.0; 3]).0.iter().sum()).collect();
    assert!(sums.windows(2).all(|pair| pair[1] > pair[0] + 1e-4), "{sums:?}");
    let plain = Separator::new(&Inks::default());
    assert_eq!(plain.spot([0.3; 3]).0, compress.spot([0.3; 3]).0);
}

#[test]
fn rows_are_separated_spot_by_spot() {
    let separator = Separator::new(&Inks::default());
    let film = [[0.1, 0.9, -1.0], [0.2, 0.9, 0.0], [0.3, 0.9, f32::NAN]];
    let mut planes = [[0.5; 3]; 3];
    let [red, green, blue] = &mut planes;
    let dimmed = separator.separate([&film[0], &film[1], &film[2]], [red, green, blue]);
    assert_eq!(dimmed, 1);
    let (first, _) = separator.spot([0.1, 0.2, 0.3]);
    assert_eq!([planes[0][0], planes[1][0], planes[2][0]], first);
}
