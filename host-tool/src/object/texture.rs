//! Pictures that are laid over meshes.

use crate::picture::{Picture, srgb_decode};
use crate::volume::CHANNELS;

/// A picture that is laid over a mesh, with halved copies of itself, so that a pixel of a film takes the mean of all that
/// it covers.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    /// Light; each level half as wide and high as the one before.
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    width: usize,
    height: usize,
    /// Row by row.
    light: Vec<[f32; CHANNELS]>,
}

impl Texture {
    /// Makes a texture of a picture of sRGB code values; one without pixels is none.
    pub(super) fn new(picture: &Picture) -> Option<Self> {
        let (width, height) = (picture.width(), picture.height());
        if width == 0 || height == 0 {
            return None;
        }
        let [red, green, blue] = [0, 1, 2].map(|channel| picture.channel(channel));
        let pixels = red.iter().zip(green).zip(blue);
        let light = pixels.map(|((r, g), b)| [*r, *g, *b].map(srgb_decode)).collect();
        let mut levels = vec![Level { width, height, light }];
        while let Some(last) = levels.last().filter(|last| last.width.max(last.height) > 1) {
            let half = last.halved();
            levels.push(half);
        }
        Some(Self { levels })
    }

    /// The level whose pixels are about as large as the distance between samples: `step` is that distance as a part of
    /// the texture's width and height.
    pub(super) fn level(&self, step: [f32; 2]) -> usize {
        let [largest, ..] = self.levels.as_slice() else { return 0 };
        let pixels = (step[0] * largest.width as f32).max(step[1] * largest.height as f32);
        let level = pixels.max(1.0).log2().round() as usize;
        level.min(self.levels.len() - 1)
    }

    /// The light at a place of a level; beyond the edges the texture repeats.
    pub(super) fn light(&self, level: usize, [across, down]: [f32; 2]) -> [f32; CHANNELS] {
        let Some(level) = self.levels.get(level) else { return [1.0; CHANNELS] };
        let index = |place: f32, count: usize| {
            let whole = (place.rem_euclid(1.0) * count as f32) as usize;
            whole.min(count - 1)
        };
        level.light[index(down, level.height) * level.width + index(across, level.width)]
    }
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let at = |column: usize, row: usize| {
            self.light[row.min(self.height - 1) * self.width + column.min(self.width - 1)]
        };
        let mean = |index: usize| {
            let (column, row) = (index % width * 2, index / width * 2);
            let four = [at(column, row), at(column + 1, row), at(column, row + 1), at(column + 1, row + 1)];
            [0, 1, 2].map(|channel| four.iter().map(|light| light[channel]).sum::<f32>() / 4.0)
        };
        Self { width, height, light: (0..width * height).map(mean).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_levels_are_means_of_the_light_and_edges_repeat() {
        let values: Vec<f32> = [0.0, 1.0, 1.0, 0.0].repeat(3);
        let texture = Texture::new(&Picture::from_values(2, 2, values).unwrap()).unwrap();
        assert_eq!(texture.level([0.1, 0.1]), 0);
        assert_eq!(texture.level([1.0, 1.0]), 1);
        assert_eq!(texture.light(1, [0.3, 0.9]), [0.5; 3]);
        assert_eq!(texture.light(0, [0.25, 0.25]), [0.0; 3]);
        assert_eq!(texture.light(0, [0.75, 0.25]), [1.0; 3]);
        assert_eq!(texture.light(0, [-0.25, 2.25]), [1.0; 3]);
        assert_eq!(texture.light(0, [f32::NAN, 0.0]), [0.0; 3]);
    }
}
