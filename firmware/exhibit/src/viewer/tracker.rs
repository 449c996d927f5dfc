//! Follows viewers from frame to frame.

use heapless::Vec;

use super::{Bearing, Sightings};
use crate::units::{CentiDegrees, Milliseconds};

/// The most viewers followed at once.
pub const MAX_TRACKS: usize = 6;
/// A sighting belongs to a track within this many hundredths of a degree.
const GATE: u32 = 1_200;
/// A track that has not been seen for this long is dropped.
const DROP_AFTER: Milliseconds = Milliseconds(1_000);

/// One viewer as followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Track {
    /// Where the viewer stands, filtered.
    pub bearing: Bearing,
    /// How long the viewer has been there.
    pub age: Milliseconds,
    /// How long ago the viewer was last seen.
    pub unseen: Milliseconds,
    /// How strong the signal is.
    pub strength: u16,
    seen: bool,
}

/// The viewers followed.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    tracks: Vec<Track, MAX_TRACKS>,
}

impl Tracker {
    /// A tracker that follows nobody.
    pub const fn new() -> Self {
        Self { tracks: Vec::new() }
    }

    /// Lets time pass, and takes everybody seen in a new picture.
    pub fn update(&mut self, sightings: Option<&Sightings>, elapsed: Milliseconds) {
        for track in &mut self.tracks {
            track.age = track.age.plus(elapsed);
            track.unseen = track.unseen.plus(elapsed);
            track.seen = false;
        }
        for sighting in sightings.into_iter().flatten() {
            let near = |track: &&mut Track| !track.seen && track.bearing.distance(sighting.bearing) <= GATE;
            let nearest = self
                .tracks
                .iter_mut()
                .filter(near)
                .min_by_key(|track| track.bearing.distance(sighting.bearing));
            if let Some(track) = nearest {
                track.bearing = follow(track.bearing, sighting.bearing);
                track.strength = sighting.strength;
                track.unseen = Milliseconds(0);
                track.seen = true;
            } else {
                let track = Track {
                    bearing: sighting.bearing,
                    age: Milliseconds(0),
                    unseen: Milliseconds(0),
                    strength: sighting.strength,
                    seen: true,
                };
                // A crowd beyond the tracker's room stays unseen.
                let _ = self.tracks.push(track);
            }
        }
        self.tracks.retain(|track| track.unseen < DROP_AFTER);
    }

    /// Forgets everybody.
    pub fn clear(&mut self) {
        self.tracks.clear();
    }

    /// The viewers followed.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// The viewer who has been there longest.
    pub fn longest(&self) -> Option<&Track> {
        self.tracks.iter().max_by_key(|track| track.age)
    }
}

/// Moves a filtered bearing half-way to a new one.
fn follow(filtered: Bearing, new: Bearing) -> Bearing {
    let half = |a: CentiDegrees, b: CentiDegrees| ((i32::from(a.0) + i32::from(b.0)) / 2) as i16;
    Bearing::new(half(filtered.horizontal, new.horizontal), half(filtered.vertical, new.vertical))
}
