//! A photograph with what was found in it.

use super::{Chart, Found, RING_MM};
use crate::picture::{Picture, srgb_encode};

/// What lines are drawn in: yellow, which no ink glows.
const LINE: [f32; 3] = [1.0, 0.9, 0.0];

/// Draws the corner marks, the dot that tells the upright and the outlines of all patches over a photograph, of which
/// this is the `light`: sRGB code values.
pub fn overlay(light: &Picture, chart: &Chart, found: &Found) -> Picture {
    let mut picture = light.map(|light| srgb_encode(light) * 0.8);
    let upright = chart.upright();
    for centre in chart.marks().into_iter().chain([upright]) {
        let radius = if centre == upright { RING_MM.start } else { RING_MM.end + 0.6 };
        let around = |turn: f64| {
            let (sine, cosine) = (std::f64::consts::TAU * turn).sin_cos();
            [centre[0] + radius * cosine, centre[1] + radius * sine]
        };
        draw(&mut picture, found, around);
    }
    for patch in &chart.patches {
        let half = 0.5 * patch.size_mm;
        let around = |turn: f64| {
            let (side, along) = ((turn * 4.0) as usize, (turn * 4.0).fract() * 2.0 - 1.0);
            let (x, y) = [(along, -1.0), (1.0, along), (-along, 1.0), (-1.0, -along)][side.min(3)];
            [patch.x_mm + half * x, patch.y_mm + half * y]
        };
        draw(&mut picture, found, around);
    }
    picture
}

/// Draws a closed line: `around` gives its points for 0..1.
fn draw(picture: &mut Picture, found: &Found, around: impl Fn(f64) -> [f64; 2]) {
    let steps = (found.pixels_per_mm * 60.0).ceil() as usize;
    for step in 0..steps {
        let [x, y] = found.perspective.apply(around(step as f64 / steps as f64));
        let (width, height) = (picture.width(), picture.height());
        if !(0.0..width as f64 - 0.5).contains(&x) || !(0.0..height as f64 - 0.5).contains(&y) {
            continue;
        }
        let at = y.round() as usize * width + x.round() as usize;
        for (channel, value) in LINE.into_iter().enumerate() {
            picture.channel_mut(channel)[at] = value;
        }
    }
}
