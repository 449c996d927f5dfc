//! Follows viewers from picture to picture.

use heapless::Vec;

use super::{Bearing, Sighting, Sightings};
use crate::units::Milliseconds;

/// The most viewers followed at once.
pub const MAX_TRACKS: usize = 6;
/// A sighting belongs to a track within this many hundredths of a degree.
const GATE: u32 = 1_200;
/// A track that has not been seen for this long is dropped.
const DROP_AFTER: Milliseconds = Milliseconds(1_000);
/// A track counts once it has been seen this often: noise and passers-by do not.
const CONFIRMED: u8 = 3;
/// What has not moved at all for this long is a radiator or a patch of sun, not a viewer ...
const STILL: Milliseconds = Milliseconds(60_000);
/// ... unless it walked here: a viewer who looks at a picture may stand dead still for a while, and from afar the small
/// movements of those who stand are not seen.
const STILL_AFTER_WALKING: Milliseconds = Milliseconds(300_000);
/// What has come so far from where it was first seen has walked, in hundredths of a degree.
const WALKED: u32 = 600;
/// The least part of the strongest signal that is still near the display, as a divisor.
const NEAR: u16 = 4;
/// Fractional bits of a track's filter.
const FRACTION: u32 = 8;
/// The alpha-beta filter's gains as parts of 16: position, and velocity for each picture.
const ALPHA: i32 = 13;
const BETA: i32 = 3;

/// One viewer as followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Track {
    /// How long the viewer has been there.
    pub age: Milliseconds,
    /// How long ago the viewer was last seen.
    pub unseen: Milliseconds,
    /// How strong the signal is.
    pub strength: u16,
    /// Tells this viewer from others; numbers come again after 256 viewers.
    pub number: u8,
    horizontal: i32,
    vertical: i32,
    /// Change of the horizontal bearing from picture to picture.
    velocity: i32,
    still_for: Milliseconds,
    /// Where it was first seen.
    came_from: i16,
    walked: bool,
    sightings: u8,
    taken: bool,
}

impl Track {
    fn new(sighting: &Sighting, number: u8) -> Self {
        Self {
            age: Milliseconds(0),
            unseen: Milliseconds(0),
            strength: sighting.strength,
            number,
            horizontal: i32::from(sighting.bearing.horizontal.0) << FRACTION,
            vertical: i32::from(sighting.bearing.vertical.0) << FRACTION,
            velocity: 0,
            still_for: Milliseconds(0),
            came_from: sighting.bearing.horizontal.0,
            walked: false,
            sightings: 1,
            taken: true,
        }
    }

    /// Where the viewer stands, filtered.
    pub const fn bearing(&self) -> Bearing {
        Bearing::new((self.horizontal >> FRACTION) as i16, (self.vertical >> FRACTION) as i16)
    }

    /// Tells whether this is a viewer, and not noise, a passer-by or a thing.
    pub fn counts(&self) -> bool {
        let patience = if self.walked { STILL_AFTER_WALKING } else { STILL };
        self.sightings >= CONFIRMED && self.still_for < patience
    }

    fn pass(&mut self, elapsed: Milliseconds) {
        self.age = self.age.plus(elapsed);
        self.unseen = self.unseen.plus(elapsed);
        self.still_for = self.still_for.plus(elapsed);
    }

    fn predict(&mut self) {
        self.taken = false;
        self.horizontal = within_sight(self.horizontal + self.velocity);
        // Nobody coasts far: an unseen viewer slows down.
        self.velocity -= self.velocity / 4 * i32::from(self.unseen.0 > 200);
    }

    /// How far a sighting lies from where the track expects it. Heights vary more than bearings: they count less.
    fn distance(&self, sighting: &Sighting) -> u32 {
        let expected = self.bearing();
        let apart = |a: i16, b: i16| (i32::from(a) - i32::from(b)).unsigned_abs();
        apart(expected.horizontal.0, sighting.bearing.horizontal.0)
            + apart(expected.vertical.0, sighting.bearing.vertical.0) / 4
    }

    fn follow(&mut self, sighting: &Sighting) {
        let measured = i32::from(sighting.bearing.horizontal.0) << FRACTION;
        let error = measured - self.horizontal;
        self.horizontal = within_sight(self.horizontal + error * ALPHA / 16);
        self.velocity = (self.velocity + error * BETA / 16).clamp(-600 << FRACTION, 600 << FRACTION);
        let measured = i32::from(sighting.bearing.vertical.0) << FRACTION;
        self.vertical += (measured - self.vertical) / 4;
        self.strength = ((u32::from(self.strength) * 3 + u32::from(sighting.strength)) / 4) as u16;
        self.unseen = Milliseconds(0);
        self.sightings = self.sightings.saturating_add(1);
        self.taken = true;
        let way = i32::from(self.bearing().horizontal.0) - i32::from(self.came_from);
        self.walked |= way.unsigned_abs() >= WALKED;
        if sighting.moves {
            self.still_for = Milliseconds(0);
        }
    }
}

const fn within_sight(horizontal: i32) -> i32 {
    let edge = 9_000 << FRACTION;
    if horizontal > edge {
        edge
    } else if horizontal < -edge {
        -edge
    } else {
        horizontal
    }
}

/// The viewers followed.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    tracks: Vec<Track, MAX_TRACKS>,
    next_number: u8,
}

impl Tracker {
    /// A tracker that follows nobody.
    pub const fn new() -> Self {
        Self { tracks: Vec::new(), next_number: 0 }
    }

    /// Lets time pass, and takes everybody seen in a new picture.
    pub fn update(&mut self, sightings: Option<&Sightings>, elapsed: Milliseconds) {
        for track in &mut self.tracks {
            track.pass(elapsed);
        }
        if let Some(sightings) = sightings {
            self.associate(sightings);
        }
        self.tracks.retain(|track| track.unseen < DROP_AFTER);
    }

    /// Forgets everybody.
    pub fn clear(&mut self) {
        self.tracks.clear();
    }

    /// The viewers who are near the display.
    pub fn viewers(&self) -> impl Iterator<Item = &Track> {
        let strongest = self.tracks.iter().filter(|track| track.counts()).map(|track| track.strength).max();
        let least = strongest.unwrap_or(0) / NEAR;
        self.tracks.iter().filter(move |track| track.counts() && track.strength >= least)
    }

    /// The viewer who has been there longest.
    pub fn longest(&self) -> Option<&Track> {
        self.viewers().max_by_key(|track| track.age)
    }

    /// The viewer with the strongest signal.
    pub fn nearest(&self) -> Option<&Track> {
        self.viewers().max_by_key(|track| track.strength)
    }

    /// Gives each sighting to the nearest track: the closest pair of all first, then the closest of the rest.
    fn associate(&mut self, sightings: &Sightings) {
        for track in &mut self.tracks {
            track.predict();
        }
        let mut left: Vec<Option<Sighting>, { super::MAX_SIGHTINGS }> =
            sightings.iter().map(|sighting| Some(*sighting)).collect();
        while let Some((track, sighting)) = self.closest_pair(&left) {
            let (track, sighting) =
                (self.tracks.get_mut(track), left.get_mut(sighting).and_then(Option::take));
            let (Some(track), Some(sighting)) = (track, sighting) else { break };
            track.follow(&sighting);
        }
        for sighting in left.iter().flatten() {
            let track = Track::new(sighting, self.next_number);
            // A crowd beyond the tracker's room stays unseen.
            if self.tracks.push(track).is_ok() {
                self.next_number = self.next_number.wrapping_add(1);
            }
        }
    }

    /// The places of the free track and the sighting that are closest together.
    fn closest_pair(&self, left: &[Option<Sighting>]) -> Option<(usize, usize)> {
        let free = self.tracks.iter().enumerate().filter(|(_, track)| !track.taken);
        let pairs = free.flat_map(|(at, track)| {
            let sightings = left.iter().enumerate();
            sightings.filter_map(move |(of, sighting)| Some((track.distance(sighting.as_ref()?), at, of)))
        });
        pairs.filter(|(distance, ..)| *distance <= GATE).min().map(|(_, track, sighting)| (track, sighting))
    }
}
