use super::*;
use proptest::prelude::*;

/// A picture of 24 x 20 pixels by formula; the same pictures were given to scikit-image 0.26.
fn formula(across: usize, down: usize, channels: usize) -> Picture {
    let (width, height) = (24, 20);
    let mut picture = Picture::new(width, height);
    for channel in 0..3 {
        for j in 0..height {
            for i in 0..width {
                let value = (i * across + j * down + channel * channels + (i * j) % 7 * 11) % 256;
                picture.channel_mut(channel)[j * width + i] = value as f32 / 255.0;
            }
        }
    }
    picture
}

#[test]
fn figures_are_those_of_scikit_image_and_numpy() {
    let (a, b) = (formula(7, 3, 50), formula(7, 4, 45));
    let mut c = a.clone();
    for (value, &other) in c.values_mut().iter_mut().zip(b.values()) {
        *value = (*value * 0.9 + 0.03 * other).clamp(0.0, 1.0);
    }
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-6, "{value} {expected}");
    near(structural_similarity(&a, &b), 0.914_717_085_420_512);
    near(structural_similarity(&a, &c), 0.994_624_588_147_117_2);
    near(psnr_db(&a, &b), 14.855_920_089_796_042);
    near(least_squares_gain(c.values(), a.values()), 1.076_648_597_575_763);
    let [bright, dark] = percentiles(a.values(), [99.5, 1.0]);
    near(bright, 0.996_078_431_372_549);
    near(dark, 0.009_372_549_019_607_846);
}

proptest! {
    #[test]
    fn the_gain_undoes_a_dimming(dimming in 0.05f32..3.0) {
        let pattern = formula(5, 9, 13);
        let dimmed = pattern.map(|value| value * dimming);
        let fitted = fit(&dimmed, &pattern, Tone::Code);
        prop_assert!((fitted.gain * f64::from(dimming) - 1.0).abs() < 1e-4);
        let light = pattern.decoded().map(|value| value * dimming);
        let fitted = fit(&light, &pattern, Tone::Linear);
        prop_assert!((fitted.gain * f64::from(dimming) - 1.0).abs() < 1e-3, "{}", fitted.gain);
        prop_assert!(psnr_db(&fitted.picture, &pattern) > 60.0);
    }
}

#[test]
fn what_shines_through_from_another_view_is_cross_talk() {
    let (own, other) = (formula(7, 3, 50), formula(2, 11, 90));
    let mut mixed = own.clone();
    for (value, &leak) in mixed.values_mut().iter_mut().zip(other.values()) {
        *value += 0.3 * leak;
    }
    let clean = measure(&own, &[&own, &other], 0, Tone::Code, 1.0).0;
    let leaking = measure(&mixed, &[&own, &other], 0, Tone::Code, 1.0).0;
    assert!(clean.cross_talk.abs() < 1e-3, "{clean:?}");
    assert!(leaking.cross_talk > 0.3, "{leaking:?}");
}

#[test]
fn the_brightest_ink_leaves_outliers_aside() {
    let mut volume = Volume::new(1, 100, 100);
    volume.values_mut().fill(0.25);
    volume.values_mut()[..20].fill(1.0);
    assert!((brightest_ink(&volume) - 0.25).abs() < 1e-4);
    volume.values_mut()[..40].fill(1.0);
    assert!((brightest_ink(&volume) - 1.0).abs() < 1e-4);
}
