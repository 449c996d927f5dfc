//! What a viewer of a build sees from any direction, under any lamp pair.

use crate::config::{Exhibit, ToneSetting, distance};
use crate::emission::Emission;
use crate::measure::percentiles;
use crate::optics::{Direction, LampPair, film_weights, ideal_weights};
use crate::picture::Picture;
use crate::projection::{ViewerDistance, project};
use crate::volume::Volume;

use super::write::encode_rgb8;

/// The percentile of the light that the gain brings to 1 where no gain is given.
const WHITE_PERCENT: f64 = 99.5;

/// From where and under which light to look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookRequest {
    /// The viewer's direction.
    pub direction: Direction,
    /// The viewer's distance from the middle of the stack.
    pub distance: ViewerDistance,
    /// The lamps' levels.
    pub lamps: LampPair,
    /// Whether nothing absorbs, blurs or saturates.
    pub ideal: bool,
    /// What the light is multiplied by; `None` brings its 99.5th percentile to 1.
    pub gain: Option<f64>,
}

/// What is seen.
#[derive(Clone, Debug)]
pub struct Look {
    /// The projection divided by the sum of the films' weights, times the gain, cut to 0..=1.
    pub picture: Picture,
    /// The gain.
    pub gain: f64,
    /// The sum of the films' weights.
    pub weight_sum: f64,
}

impl LookRequest {
    /// Looks along `direction` with everything else as the exhibit has it, both lamps full; from the distance of the
    /// first view in that direction, where there is one.
    pub fn new(exhibit: &Exhibit, direction: Direction) -> Self {
        let mut views = exhibit.views.iter();
        let view = views.find(|view| {
            [view.horizontal_deg, view.vertical_deg] == [direction.horizontal_deg, direction.vertical_deg]
        });
        Self {
            direction,
            distance: view.map_or(exhibit.viewer_distance(), |view| distance(view.distance_mm)),
            lamps: LampPair::FULL,
            ideal: false,
            gain: None,
        }
    }
}

/// Looks at the `volume` of `exhibit`.
pub fn look(exhibit: &Exhibit, volume: &Volume, request: &LookRequest) -> Look {
    let stack = exhibit.film_stack();
    let (weights, emission) = match request.ideal {
        true => (ideal_weights(&stack), Emission::default()),
        false => (film_weights(&stack, request.direction, request.lamps), Emission::of(&stack)),
    };
    let weight_sum: f64 = weights.iter().sum();
    let projection = project(&emission.light(volume), &stack, request.direction, request.distance, &weights);
    let light = projection.map(|value| if weight_sum > 0.0 { value / weight_sum as f32 } else { 0.0 });
    let gain = request.gain.unwrap_or_else(|| {
        let [white] = percentiles(light.values(), [WHITE_PERCENT]);
        if white > 0.0 { 1.0 / white } else { 1.0 }
    });
    let picture =
        exhibit.as_seen(light.map(|value| (value * gain as f32).clamp(0.0, 1.0)), request.direction);
    Look { picture, gain, weight_sum }
}

/// The picture as a PNG of its values as they are. Where they are light, the header says so with a gamma of 1, so
/// that viewers show them right; `encode` writes them as sRGB code values instead.
///
/// # Errors
/// Fails when the picture cannot be encoded.
pub fn look_png(look: &Look, tone: ToneSetting, encode: bool) -> Result<Vec<u8>, png::EncodingError> {
    let as_srgb = |png: &mut png::Encoder<'_, &mut Vec<u8>>| {
        png.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    };
    match (tone, encode) {
        (ToneSetting::Linear, false) => encode_rgb8(&look.picture, |png| {
            png.set_source_gamma(png::ScaledFloat::new(1.0));
        }),
        (ToneSetting::Linear, true) => encode_rgb8(&look.picture.encoded(), as_srgb),
        (ToneSetting::Code, _) => encode_rgb8(&look.picture, as_srgb),
    }
}
