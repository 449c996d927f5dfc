//! The paper's product on the bundled photographs, held to figures that other implementations reached.

mod common;

use common::{FOUR, THREE, request};
use vitrine::design::{Design, DesignSettings, Method, OpticsModel, Tone, design};

fn product(views: &[(&str, f64, f64)]) -> Design {
    let settings = DesignSettings {
        method: Method::Product,
        optics: OpticsModel::Ideal,
        tone: Tone::Code,
        ..DesignSettings::default()
    };
    design(&request(views, 512, settings), &mut |_| ()).expect("a design")
}

fn assert_figures(design: &Design, mean_db: f64, least_db: f64, ssim: f64) {
    let found = (design.mean_psnr_db(), design.least_psnr_db(), design.mean_ssim());
    println!("mean {:.3} dB, least {:.3} dB, SSIM {:.4}", found.0, found.1, found.2);
    assert!((found.0 - mean_db).abs() < 0.05, "mean {found:?}");
    assert!((found.1 - least_db).abs() < 0.05, "least {found:?}");
    assert!((found.2 - ssim).abs() < 0.004, "SSIM {found:?}");
}

#[test]
fn three_views_about_the_vertical_axis() {
    assert_figures(&product(&THREE), 11.04, 10.23, 0.524);
}

#[test]
fn four_views_about_both_axes() {
    assert_figures(&product(&FOUR), 11.34, 10.44, 0.526);
}
