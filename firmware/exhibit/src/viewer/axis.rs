//! Two sensors' warmth on one azimuth axis, and the bodies in it.

use super::eye::Warmth;
use super::{Bearing, COLUMNS, MAX_SIGHTINGS, ROWS, Sighting, Sightings, ThermalFrame};
use crate::angle;

/// Width of a pixel, and of a row, in hundredths of a degree.
const PIXEL: i32 = 750;
/// Width of a bin of the common azimuth axis.
const BIN: i32 = 250;
/// Half the width of the common azimuth axis.
const HALF_AXIS: i32 = 5_500;
/// Bins of the common azimuth axis.
const BINS: usize = 44;
/// The distance at which viewers are expected, in mm: the parallax of the sensors is that of this distance.
const EXPECTED_MM: i32 = 1_200;
/// A valley parts two bodies where it is not above this many eighths of the lower one's peak.
const VALLEY_EIGHTHS: u32 = 5;
/// A body's peak holds at least this much warmth in a bin, in eighths of a degree.
const LEAST_PEAK: u32 = 8;
/// Eyes are about this far below the top of the head, seen from the expected distance.
const EYES_BELOW_TOP: i32 = 450;
/// A warm thing wholly below this elevation is no viewer: a dog, a bag, a patch of sun on the floor.
const FLOOR: i32 = -1_600;

/// One sensor's warmth, column by column.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    warmth: u16,
    /// Elevation of the upper edge of what is warm.
    top: i16,
    moved: bool,
}

/// One sensor's warmth on its place on the axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    columns: [Column; COLUMNS],
    /// Left edge of the first column.
    left: i32,
    right_mm: i32,
}

/// One bin of the axis.
#[derive(Clone, Copy, Default)]
struct Bin {
    warmth: u32,
    /// The azimuth, as seen from the stack.
    azimuth: i32,
    top: i32,
    moved: bool,
}

impl Strip {
    pub(super) const EMPTY: Self =
        Self { columns: [Column { warmth: 0, top: i16::MIN, moved: false }; COLUMNS], left: 0, right_mm: 0 };

    /// Sums the rows of a sensor's warmth.
    pub(super) fn new(frame: &ThermalFrame, warmth: &Warmth) -> Self {
        let mut strip = Self {
            left: i32::from(frame.yaw.0) - PIXEL * COLUMNS as i32 / 2,
            right_mm: i32::from(frame.right_mm),
            ..Self::EMPTY
        };
        for (index, column) in strip.columns.iter_mut().enumerate() {
            let rows = warmth.above.iter().skip(index).step_by(COLUMNS);
            column.warmth = rows.clone().fold(0_u16, |sum, above| sum.saturating_add(*above));
            column.top =
                upper_edge(rows.copied()).map_or(i16::MIN, |top| (top + i32::from(frame.pitch.0)) as i16);
            let of_column = 0x0101_0101_0101_0101_u64 << index;
            column.moved = warmth.moved & of_column != 0;
        }
        strip
    }

    fn at(&self, azimuth: i32) -> Option<&Column> {
        usize::try_from((azimuth - self.left).div_euclid(PIXEL))
            .ok()
            .and_then(|column| self.columns.get(column))
    }
}

/// The elevation of the upper edge of what is warm in a column: the top row is filled in part, as its warmth says.
fn upper_edge(rows: impl Iterator<Item = u16> + Clone) -> Option<i32> {
    let top = rows.clone().position(|above| above > 0)?;
    let mut below = rows.skip(top);
    let here = i32::from(below.next().unwrap_or(0));
    let next = i32::from(below.next().unwrap_or(0));
    let part = if next > here { PIXEL * here / next } else { PIXEL };
    let bottom_of_row = (ROWS as i32 / 2 - 1 - top as i32) * PIXEL;
    Some(bottom_of_row + part)
}

/// Finds the bodies in both sensors' warmth.
pub(super) fn bodies(strips: &[Strip; 2]) -> Sightings {
    let bins = fuse(strips);
    let mut sightings = Sightings::new();
    let mut from = 0;
    while let Some(rest) = bins.get(from..).filter(|rest| !rest.is_empty()) {
        let length = body_length(rest);
        if let Some(sighting) = rest.get(..length).and_then(sighting)
            && sightings.push(sighting).is_err()
        {
            replace_weakest(&mut sightings, sighting);
        }
        from += length;
    }
    sightings
}

/// Lays both sensors on the axis; where both see, they are averaged.
fn fuse(strips: &[Strip; 2]) -> [Bin; BINS] {
    let mut bins = [Bin::default(); BINS];
    for (bin, index) in bins.iter_mut().zip(0_i32..) {
        let azimuth = index * BIN + BIN / 2 - HALF_AXIS;
        let (mut seen_by, mut warmth, mut seen_from) = (0_u32, 0_u32, 0);
        bin.top = i32::from(i16::MIN);
        for strip in strips {
            let Some(column) = strip.at(azimuth) else { continue };
            seen_by += 1;
            warmth += u32::from(column.warmth);
            seen_from += strip.right_mm;
            bin.top = bin.top.max(i32::from(column.top));
            bin.moved |= column.moved;
        }
        bin.warmth = warmth.checked_div(seen_by).unwrap_or(0);
        bin.azimuth = azimuth + parallax(azimuth, seen_from / seen_by.max(1) as i32);
    }
    bins
}

/// What is added to an azimuth that was seen from beside the stack: to first order `x cos(azimuth) / distance`,
/// within 0.02 degrees of the arc tangent at these distances.
fn parallax(azimuth: i32, right_mm: i32) -> i32 {
    right_mm * angle::cosine(azimuth) / 32_768 * angle::RADIAN / EXPECTED_MM
}

/// Gives how many bins from the first on belong to one body, or to none.
fn body_length(bins: &[Bin]) -> usize {
    let (mut peak, mut valley, mut valley_at) = (0, u32::MAX, 0);
    for (bin, at) in bins.iter().zip(0_usize..) {
        if bin.warmth == 0 {
            return at.max(1);
        }
        if bin.warmth > peak && valley == u32::MAX {
            peak = bin.warmth;
            continue;
        }
        if bin.warmth < valley && bin.warmth < peak {
            (valley, valley_at) = (bin.warmth, at);
        }
        let lower_peak = peak.min(bin.warmth);
        if valley != u32::MAX && lower_peak >= LEAST_PEAK && valley * 8 <= lower_peak * VALLEY_EIGHTHS {
            return valley_at.max(1);
        }
        if valley != u32::MAX && bin.warmth > peak {
            // No real valley lay between: the body only rises further.
            (peak, valley) = (bin.warmth, u32::MAX);
        }
    }
    bins.len()
}

/// Gives where a body stands; none for what is too weak or on the floor.
fn sighting(bins: &[Bin]) -> Option<Sighting> {
    let warmth: u32 = bins.iter().map(|bin| bin.warmth).sum();
    let peak = bins.iter().map(|bin| bin.warmth).max()?;
    if peak < LEAST_PEAK {
        return None;
    }
    let moment: i64 = bins.iter().map(|bin| i64::from(bin.warmth) * i64::from(bin.azimuth)).sum();
    let horizontal = moment / i64::from(warmth.max(1));
    let solid = bins.iter().filter(|bin| bin.warmth * 2 >= peak);
    let top = solid.map(|bin| bin.top).max()?;
    if top <= FLOOR {
        return None;
    }
    Some(Sighting {
        bearing: Bearing::new(horizontal as i16, (top - EYES_BELOW_TOP) as i16),
        strength: warmth.min(u32::from(u16::MAX)) as u16,
        moves: bins.iter().any(|bin| bin.moved && bin.warmth > 0),
    })
}

fn replace_weakest(sightings: &mut Sightings, sighting: Sighting) {
    debug_assert_eq!(sightings.len(), MAX_SIGHTINGS);
    if let Some(weakest) = sightings.iter_mut().min_by_key(|other| other.strength)
        && weakest.strength < sighting.strength
    {
        *weakest = sighting;
    }
}
