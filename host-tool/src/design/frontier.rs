//! The frontier: what quality costs in brightness and in contrast.
//!
//! Less light leaves the ink more room below its bounds, and a pedestal (a share of white light everywhere)
//! lets the optimiser take light away where pictures disagree. Both are tried on designs in small.

use serde::Serialize;

use super::pedestal::lifted;
use super::request::{DesignError, DesignRequest, Progress};
use super::scale::reduced;
use super::{Design, Method, design_unwatched, product};

/// Side, in pixels, of the designs in small.
const SIDE_PX: usize = 128;
/// Brightness that is wanted, as in the design's settings.
const BRIGHTNESS: [f64; 5] = [0.1, 0.2, 0.4, 0.7, 1.0];
/// What the ink of the paper's Eq. 1 is multiplied by instead.
const EXPOSURES: [f32; 5] = [1.0, 1.5, 2.5, 4.0, 8.0];
/// Pedestals that are tried, as in the design's settings.
const PEDESTALS: [f64; 3] = [0.0, 0.2, 0.6];

/// One design on the way from dim and true to bright and poor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrontierPoint {
    /// The brightness that was wanted; for the paper's Eq. 1, which knows none, the one that was reached.
    pub brightness: f64,
    /// What was added to the patterns' black: see [`lifted`].
    pub pedestal: f64,
    /// Mean PSNR of the views in dB, against the patterns on their pedestal.
    pub psnr_db: f64,
    /// The least view's PSNR in dB.
    pub least_psnr_db: f64,
    /// Mean SSIM of the views, against the patterns on their pedestal.
    pub ssim: f64,
    /// Mean brightness efficiency of the views.
    pub efficiency: f64,
    /// Mean contrast of the views: the 99th percentile of the light over the 1st, at most 1000.
    pub contrast: f64,
}

/// Tries brightness and pedestals; the points come pedestal by pedestal, from dim to bright.
///
/// # Errors
/// As [`design`](super::design).
pub fn frontier(
    request: &DesignRequest,
    report: &mut dyn FnMut(Progress),
) -> Result<Vec<FrontierPoint>, DesignError> {
    request.check()?;
    let small = reduced(request, SIDE_PX);
    let total = PEDESTALS.len() * BRIGHTNESS.len();
    let mut points = Vec::new();
    let mut lighting = None;
    for pedestal in PEDESTALS {
        let mut lifted_request = small.clone();
        for view in &mut lifted_request.views {
            view.pattern = lifted(&view.pattern, pedestal, request.settings.tone);
        }
        for (brightness, exposure) in BRIGHTNESS.into_iter().zip(EXPOSURES) {
            let mut wanted = lifted_request.clone();
            wanted.settings.brightness = brightness;
            let design = match wanted.settings.method {
                Method::LeastSquares => {
                    let (design, found) = design_unwatched(&wanted, lighting.as_slice())?;
                    lighting = found;
                    design
                }
                Method::Product => exposed_product(&wanted, exposure)?,
            };
            let point = point(&wanted, &design, pedestal);
            points.push(point);
            report(Progress::at("drawing the frontier", points.len(), total).reaching(point.psnr_db));
        }
    }
    Ok(points)
}

/// The paper's Eq. 1 knows no brightness: its ink is as bright as the pictures make it. More of it, up to full ink, is
/// brighter and poorer.
fn exposed_product(request: &DesignRequest, exposure: f32) -> Result<Design, DesignError> {
    request.go_on()?;
    let mut volume = product(request, &mut |_| ());
    volume.values_mut().iter_mut().for_each(|ink| *ink = (*ink * exposure).min(1.0));
    volume.quantise(request.settings.ink_depth);
    Ok(Design::of(request, volume))
}

fn point(request: &DesignRequest, design: &Design, pedestal: f64) -> FrontierPoint {
    let count = design.views.len() as f64;
    let mean = |value: fn(&crate::measure::Quality) -> f64| {
        design.views.iter().map(|view| value(&view.quality)).sum::<f64>() / count
    };
    let efficiency = mean(|quality| quality.efficiency);
    let brightness = match request.settings.method {
        Method::LeastSquares => request.settings.brightness,
        Method::Product => efficiency,
    };
    FrontierPoint {
        brightness,
        pedestal,
        psnr_db: design.mean_psnr_db(),
        least_psnr_db: design.least_psnr_db(),
        ssim: design.mean_ssim(),
        efficiency,
        contrast: mean(|quality| quality.contrast),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DesignSettings, Method, OpticsModel, Stop, Tone, ViewRequest};
    use crate::optics::Direction;
    use crate::picture::Picture;
    use crate::projection::ViewerDistance;
    use crate::stack::Stack;

    #[test]
    fn a_pedestal_costs_contrast_and_every_point_is_there() {
        let side = 24;
        let mut pattern = Picture::new(side, side);
        for (index, value) in pattern.values_mut().iter_mut().enumerate() {
            *value = (index % 5) as f32 / 4.0;
        }
        let request = DesignRequest {
            stack: Stack { films: 4, width_px: side, height_px: side, ..Stack::default() },
            distance: ViewerDistance::Parallel,
            views: vec![ViewRequest::new("front", pattern, Direction::default())],
            settings: DesignSettings {
                method: Method::Product,
                optics: OpticsModel::Ideal,
                tone: Tone::Code,
                ..DesignSettings::default()
            },
            stop: Stop::default(),
        };
        let points = frontier(&request, &mut |_| ()).unwrap();
        assert_eq!(points.len(), PEDESTALS.len() * BRIGHTNESS.len());
        let contrast =
            |pedestal: f64| points.iter().find(|point| point.pedestal == pedestal).unwrap().contrast;
        assert!(contrast(0.0) > 10.0 * contrast(0.2), "{points:?}");
        // The product of one view is its pattern: 0.2 to 1.2, then 0.6 to 1.6.
        assert!((contrast(0.2) - 6.0).abs() < 0.1, "{points:?}");
        assert!((contrast(0.6) - 1.6 / 0.6).abs() < 0.05, "{points:?}");
    }
}
