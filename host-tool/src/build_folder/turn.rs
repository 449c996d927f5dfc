//! An animation of what a viewer sees of a build from one direction after another.

use super::look::{LookRequest, look};
use crate::config::{Exhibit, ToneSetting};
use crate::volume::Volume;

/// What an animation shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// From where each frame looks, at least one.
    pub frames: Vec<LookRequest>,
    /// Frames a second.
    pub fps: u16,
    /// What the light is multiplied by; `None` brings the 99.5th percentile of the brightest frame to 1.
    pub gain: Option<f64>,
}

/// An animation.
#[derive(Clone, Debug)]
pub struct Turned {
    /// The file: an animated PNG of 8-bit sRGB, played over and over.
    pub png: Vec<u8>,
    /// What the light was multiplied by.
    pub gain: f64,
}

/// Shows the `volume` of `exhibit` frame by frame.
///
/// # Errors
/// Fails when the animation cannot be encoded.
pub fn turn(exhibit: &Exhibit, volume: &Volume, wanted: &Turn) -> Result<Turned, png::EncodingError> {
    let own = |frame: &LookRequest| look(exhibit, volume, &LookRequest { gain: None, ..*frame }).gain;
    let gain = wanted.gain.unwrap_or_else(|| wanted.frames.iter().map(own).fold(f64::INFINITY, f64::min));
    let gain = if gain.is_finite() { gain } else { 1.0 };
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, volume.width() as u32, volume.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_animated(wanted.frames.len() as u32, 0)?;
    encoder.set_frame_delay(1, wanted.fps)?;
    let mut writer = encoder.write_header()?;
    for frame in &wanted.frames {
        let seen = look(exhibit, volume, &LookRequest { gain: Some(gain), ..*frame }).picture;
        let picture = if exhibit.design.tone == ToneSetting::Linear { seen.encoded() } else { seen };
        writer.write_image_data(&picture.rgb8())?;
    }
    writer.finish()?;
    Ok(Turned { png, gain })
}
