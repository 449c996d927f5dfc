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
/// Nobody is nearer or farther than this, in mm, where the parallax is concerned.
const NEAREST_MM: i32 = 600;
const FARTHEST_MM: i32 = 3_000;
/// A body's width in mm: what its apparent width tells of its distance.
const SHOULDERS_MM: i32 = 420;
/// More warmth than anybody has in a column, in eighths of a degree: means stay within 32 bits.
const MOST_WARMTH: u16 = 4_095;
/// Rows, from the top, in which somebody at the display shows no more than the head.
const HEAD_ROWS: usize = 2;
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
    /// The part of it in the rows of heads.
    head: u16,
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
    head: u32,
    azimuth: i32,
    /// Where the sensors stand that see it, to the right of the stack.
    right_mm: i32,
    seen_by: u8,
    /// Nothing is seen beyond it.
    is_edge: bool,
    top: i32,
    moved: bool,
}

impl Strip {
    pub(super) const EMPTY: Self = Self {
        columns: [Column { warmth: 0, head: 0, top: i16::MIN, moved: false }; COLUMNS],
        left: 0,
        right_mm: 0,
    };

    /// Sums the rows of a sensor's warmth.
    pub(super) fn new(frame: &ThermalFrame, warmth: &Warmth) -> Self {
        let mut strip = Self {
            left: i32::from(frame.yaw.0) - PIXEL * COLUMNS as i32 / 2,
            right_mm: i32::from(frame.right_mm),
            ..Self::EMPTY
        };
        for (index, column) in strip.columns.iter_mut().enumerate() {
            let rows = warmth.above.iter().skip(index).step_by(COLUMNS);
            let sum = |sum: u16, above: &u16| sum.saturating_add(*above).min(MOST_WARMTH);
            column.warmth = rows.clone().fold(0, sum);
            column.head = rows.clone().take(HEAD_ROWS).fold(0, sum);
            column.top =
                upper_edge(rows.copied()).map_or(i16::MIN, |top| (top + i32::from(frame.pitch.0)) as i16);
            column.moved = warmth.moved >> index & 1 == 1;
        }
        strip
    }
}

/// The elevation of the upper edge of what is warm in a column: the top row is filled in part, as its warmth says.
fn upper_edge(rows: impl Iterator<Item = u16> + Clone) -> Option<i32> {
    let top = rows.clone().position(|above| above > 0)?;
    let mut below = rows.skip(top);
    let here = i32::from(below.next().unwrap_or(0));
    let next = i32::from(below.next().unwrap_or(0));
    let part = match next {
        // A thing as flat as a row may lie anywhere in it.
        0 => PIXEL / 2,
        next if next > here => PIXEL * here / next,
        _ => PIXEL,
    };
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
        bin.azimuth = index * BIN + BIN / 2 - HALF_AXIS;
        bin.is_edge = index == 0 || index == BINS as i32 - 1;
        bin.top = i32::from(i16::MIN);
    }
    for strip in strips {
        add(strip, &mut bins);
    }
    for bin in bins.iter_mut().filter(|bin| bin.seen_by > 1) {
        bin.warmth /= 2;
        bin.head /= 2;
        bin.right_mm /= 2;
    }
    bins
}

/// Adds a sensor to the bins that it sees.
fn add(strip: &Strip, bins: &mut [Bin; BINS]) {
    let mut columns = strip.columns.iter();
    let mut column = columns.next();
    let mut right_edge = strip.left + PIXEL;
    for bin in bins.iter_mut().skip_while(|bin| bin.azimuth < strip.left) {
        if bin.azimuth >= right_edge {
            column = columns.next();
            right_edge += PIXEL;
        }
        let Some(column) = column else { break };
        bin.seen_by += 1;
        bin.warmth += u32::from(column.warmth);
        bin.head += u32::from(column.head);
        bin.right_mm += strip.right_mm;
        bin.top = bin.top.max(i32::from(column.top));
        bin.moved |= column.moved;
    }
}

/// What is added to an azimuth that was seen from beside the stack: to first order `x cos(azimuth) / distance`,
/// within 0.02 degrees of the arc tangent at these distances.
fn parallax(azimuth: i32, right_mm: i32, distance_mm: i32) -> i32 {
    right_mm * angle::cosine(azimuth) / 32_768 * angle::RADIAN / distance_mm
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
    let solid = || bins.iter().filter(|bin| bin.warmth * 2 >= peak);
    let width = solid().count() as i32 * BIN;
    let at_edge = solid().any(|bin| bin.is_edge);
    // Of a body that is cut off by the edge of sight the head still tells the middle.
    let azimuth = match mean(bins, |bin| bin.head, |bin| bin.azimuth) {
        Some(head) if at_edge => head,
        _ => mean(bins, |bin| bin.warmth, |bin| bin.azimuth)?,
    };
    let distance_mm = (SHOULDERS_MM * angle::RADIAN / width).clamp(NEAREST_MM, FARTHEST_MM);
    let right_mm = mean(bins, |bin| bin.warmth, |bin| bin.right_mm)?;
    let horizontal = azimuth + parallax(azimuth, right_mm, distance_mm);
    let top = solid().map(|bin| bin.top).max()?;
    if top <= FLOOR {
        return None;
    }
    Some(Sighting {
        bearing: Bearing::new(horizontal as i16, (top - EYES_BELOW_TOP) as i16),
        strength: warmth.min(u32::from(u16::MAX)) as u16,
        moves: bins.iter().any(|bin| bin.moved && bin.warmth > 0),
    })
}

/// The mean of a value over bins by their weight; none where nothing has weight.
fn mean(bins: &[Bin], weight: fn(&Bin) -> u32, value: fn(&Bin) -> i32) -> Option<i32> {
    let total = bins.iter().map(weight).sum::<u32>() as i32;
    let moment: i32 = bins.iter().map(|bin| weight(bin) as i32 * value(bin)).sum();
    moment.checked_div(total)
}

fn replace_weakest(sightings: &mut Sightings, sighting: Sighting) {
    debug_assert_eq!(sightings.len(), MAX_SIGHTINGS);
    if let Some(weakest) = sightings.iter_mut().min_by_key(|other| other.strength)
        && weakest.strength < sighting.strength
    {
        *weakest = sighting;
    }
}
