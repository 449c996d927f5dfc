//! What an object shows in its views, and pictures around it.

use crate::config::Exhibit;
use crate::design::{FixedInk, Tone};
use crate::measure::percentiles;
use crate::optics::{Direction, ideal_weights};
use crate::picture::Picture;
use crate::projection::{ViewerDistance, project};
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

use super::levels;
use super::slice::Sliced;

/// The percentile of an object's lit pixels that is white where the object is shown alone.
const WHITE_PERCENT: f64 = 99.0;

/// An object's ink, and what it shows.
pub struct Shown {
    stack: Stack,
    tone: Tone,
    /// What white is for pictures around the object: the light of full ink on so many films.
    white_films: f32,
    volume: Volume,
    /// The same in the printer's levels, where it knows few.
    printed: Option<Volume>,
    /// Whether each voxel (film, row, column) belongs to the object.
    voxels: Vec<bool>,
}

impl Shown {
    /// The object in the stack of `exhibit`.
    pub fn new(exhibit: &Exhibit, sliced: &Sliced) -> Self {
        let stack = exhibit.film_stack();
        let (volume, voxels) = (sliced.layers.volume(exhibit.tone()), sliced.layers.occupied());
        let white_films = (exhibit.design.brightness * stack.films as f64) as f32;
        let printed = exhibit.print.levels.map(|levels| {
            let mut printed = volume.clone();
            levels::lay(&mut printed, &voxels, levels);
            printed
        });
        Self { tone: exhibit.tone(), white_films, volume, printed, voxels, stack }
    }

    /// The ink alone, as it is printed.
    pub fn into_volume(self) -> Volume {
        self.printed.unwrap_or(self.volume)
    }

    /// The ink as it is printed, to be held while pictures are designed around it.
    pub fn into_fixed(self) -> Option<FixedInk> {
        FixedInk::new(self.printed.unwrap_or(self.volume), &self.voxels)
    }

    /// What the object alone shows without absorption, as sRGB code values; the 99th percentile of what is lit is
    /// white.
    pub fn alone(&self, direction: Direction, distance: ViewerDistance) -> Picture {
        let light = self.light(&self.volume, direction, distance);
        let lit: Vec<f32> = light.values().iter().copied().filter(|value| *value > 0.0).collect();
        let white = if lit.is_empty() { 1.0 } else { percentiles(&lit, [WHITE_PERCENT])[0] as f32 };
        self.encoded(&light.map(|value| (value / white).min(1.0)))
    }

    /// The pattern (code values) with the object before it, in the values in which films add up:
    ///
    /// ```text
    /// T' = (1 - c) T + min(1, L / (b N))
    /// ```
    ///
    /// L is the object's light without absorption in films of full ink, b the brightness wanted of N films, and c how
    /// much of the pixel the object covers: its voxels seen as full ink, at most 1.
    pub fn before(&self, pattern: &Picture, direction: Direction, distance: ViewerDistance) -> Picture {
        let light = self.light(&self.volume, direction, distance);
        let cover = self.light(&self.full(), direction, distance);
        let mut shown = match self.tone {
            Tone::Linear => pattern.decoded(),
            Tone::Code => pattern.clone(),
        };
        for channel in 0..CHANNELS {
            let pixels =
                shown.channel_mut(channel).iter_mut().zip(light.channel(channel)).zip(cover.channel(0));
            for ((value, light), cover) in pixels {
                let behind = (1.0 - cover.min(1.0)) * *value;
                *value = (behind + (light / self.white_films).min(1.0)).min(1.0);
            }
        }
        self.encoded(&shown)
    }

    /// The object's voxels as full ink of the first colour.
    fn full(&self) -> Volume {
        let mut full = Volume::new(self.stack.films, self.stack.height_px, self.stack.width_px);
        let voxels = full.channel_mut(0).iter_mut().zip(&self.voxels);
        voxels.for_each(|(value, taken)| *value = f32::from(u8::from(*taken)));
        full
    }

    fn light(&self, volume: &Volume, direction: Direction, distance: ViewerDistance) -> Picture {
        project(volume, &self.stack, direction, distance, &ideal_weights(&self.stack))
    }

    fn encoded(&self, light: &Picture) -> Picture {
        match self.tone {
            Tone::Linear => light.encoded(),
            Tone::Code => light.clone(),
        }
    }
}
