//! Ink that stands in the stack whatever the views want: an object with pictures around it.

use std::sync::Arc;

use super::scale::averaged_plane;
use crate::emission::Emission;
use crate::volume::{CHANNELS, Volume};

/// A voxel of a small design stands for several of the full one; it is held where this part of them is.
const HELD_PART: f32 = 0.5;

/// Ink that a design leaves as it is.
#[derive(Clone, Debug)]
pub struct FixedInk {
    /// The ink of all films.
    volume: Volume,
    /// Whether each voxel (film, row, column) is held to it, of all colours.
    voxels: Arc<[bool]>,
}

impl FixedInk {
    /// Holds `voxels` (film, row, column) to the ink of `volume`; `None` where their number is not the volume's.
    pub fn new(volume: Volume, voxels: &[bool]) -> Option<Self> {
        let count = volume.films() * volume.height() * volume.width();
        (voxels.len() == count).then(|| Self { volume, voxels: voxels.into() })
    }

    /// The same as the glow of its ink.
    pub(super) fn glowing(&self, emission: &Emission) -> Self {
        Self { volume: emission.glow_of(&self.volume).into_owned(), voxels: self.voxels() }
    }

    /// Whether each voxel (film, row, column) is held.
    pub(super) fn voxels(&self) -> Arc<[bool]> {
        Arc::clone(&self.voxels)
    }

    /// Puts the ink where it belongs.
    pub(super) fn put_into(&self, volume: &mut Volume) {
        (0..CHANNELS).for_each(|channel| self.put_into_channel(channel, volume.channel_mut(channel)));
    }

    /// Puts the ink of one channel where it belongs in its films (film, row, column).
    pub(super) fn put_into_channel(&self, channel: usize, films: &mut [f32]) {
        let voxels = films.iter_mut().zip(self.volume.channel(channel));
        for ((value, fixed), _) in voxels.zip(self.voxels.iter()).filter(|(_, held)| **held) {
            *value = *fixed;
        }
    }

    /// The same for films of `width` x `height` pixels: ink is averaged over the voxels that are held.
    pub(super) fn reduced(&self, width: usize, height: usize) -> Self {
        if (width, height) == (self.volume.width(), self.volume.height()) {
            return self.clone();
        }
        let (films, from) = (self.volume.films(), self.volume.width());
        let size = from * self.volume.height();
        let mut volume = Volume::new(films, height, width);
        let mut voxels = Vec::with_capacity(films * width * height);
        for film in 0..films {
            let held: Vec<f32> = self.voxels[film * size..(film + 1) * size]
                .iter()
                .map(|held| f32::from(u8::from(*held)))
                .collect();
            let parts = averaged_plane(&held, from, width, height);
            for channel in 0..CHANNELS {
                let ink = self.volume.film(channel, film).iter().zip(&held).map(|(ink, held)| ink * held);
                let means = averaged_plane(&ink.collect::<Vec<_>>(), from, width, height);
                let values = volume.film_mut(channel, film).iter_mut().zip(means).zip(&parts);
                values.for_each(|((value, mean), part)| *value = mean / part.max(f32::MIN_POSITIVE));
            }
            voxels.extend(parts.iter().map(|part| *part >= HELD_PART));
        }
        Self { volume, voxels: voxels.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_design_holds_what_is_mostly_held() {
        let mut ink = Volume::new(1, 4, 4);
        let mut held = vec![false; 16];
        for at in [0, 1, 4, 10] {
            held[at] = true;
            ink.channel_mut(1)[at] = 0.8;
        }
        let fixed = FixedInk::new(ink, &held).unwrap();
        let small = fixed.reduced(2, 2);
        assert_eq!(*small.voxels(), [true, false, false, false]);
        let mut volume = Volume::new(1, 2, 2);
        small.put_into(&mut volume);
        assert!((volume.channel(1)[0] - 0.8).abs() < 1e-6);
        assert_eq!(&volume.channel(1)[1..], [0.0; 3]);
        assert!(FixedInk::new(Volume::new(1, 4, 4), &[true]).is_none());
    }
}
