//! An object's ink in the levels that a printer knows.
//!
//! A point stays where it is, and of its ink the nearest level is printed. What that leaves over goes to the object's
//! nearest points that have yet to choose, on its own film and on the next ones behind (error diffusion, Floyd and
//! Steinberg 1976, over points instead of a grid), so that wherever one looks from, a neighbourhood glows as it should.
//! Ink that is a level already, none and full among them, stays what it is and hands on what it was given.

use rayon::prelude::*;

use crate::volume::{CHANNELS, Volume};

/// How far an error goes, in pixels; a film counts as so many.
const REACH_PX: isize = 8;
const FILM_PX: f32 = 1.5;
/// Films behind that an error goes to.
const FILMS_BEHIND: isize = 2;
/// How many points share an error.
const SHARING: usize = 3;
/// How near to a level ink is that level: less than a step of 16 bits.
const IS_LEVEL: f32 = 1e-5;

/// A place from another: films behind, rows below, columns in the direction of the walk, and the distance.
#[derive(Clone, Copy)]
struct Step {
    film: isize,
    row: isize,
    column: isize,
    distance_px: f32,
}

/// Brings the ink of `volume` at `voxels` (film, row, column) to `levels` even levels from none to full, 2 or more.
pub(super) fn lay(volume: &mut Volume, voxels: &[bool], levels: u16) {
    let size = [volume.films(), volume.height(), volume.width()];
    let steps = steps();
    let top = f32::from(levels.max(2) - 1);
    let len = voxels.len();
    let channels = volume.values_mut().par_chunks_mut(len.max(1)).take(CHANNELS);
    channels.for_each(|ink| lay_channel(ink, voxels, size, &steps, top));
}

/// All places that are walked to later than one, the nearest first.
fn steps() -> Vec<Step> {
    let mut steps = Vec::new();
    for film in 0..=FILMS_BEHIND {
        for row in -REACH_PX..=REACH_PX {
            for column in -REACH_PX..=REACH_PX {
                let squares = (row * row + column * column) as f32 + (film as f32 * FILM_PX).powi(2);
                if (film, row, column) > (0, 0, 0) && squares <= (REACH_PX * REACH_PX) as f32 {
                    steps.push(Step { film, row, column, distance_px: squares.sqrt() });
                }
            }
        }
    }
    steps.sort_by(|one, other| one.distance_px.total_cmp(&other.distance_px));
    steps
}

fn lay_channel(ink: &mut [f32], voxels: &[bool], size: [usize; 3], steps: &[Step], top: f32) {
    let [films, height, width] = size;
    let mut due = vec![0.0_f32; ink.len()];
    for film in 0..films {
        for row in 0..height {
            // There and back.
            let ahead = if row % 2 == 0 { 1 } else { -1 };
            for step in 0..width {
                let column = if ahead > 0 { step } else { width - 1 - step };
                let at = (film * height + row) * width + column;
                if !voxels[at] {
                    continue;
                }
                let level = |value: f32| (value * top).round().clamp(0.0, top) / top;
                let own = level(ink[at]);
                let left = if (ink[at] - own).abs() < IS_LEVEL {
                    ink[at] = own;
                    due[at]
                } else {
                    let wanted = ink[at] + due[at];
                    ink[at] = level(wanted);
                    wanted - ink[at]
                };
                if left != 0.0 {
                    hand_on(
                        left,
                        &mut due,
                        voxels,
                        size,
                        steps,
                        [film as isize, row as isize, column as isize],
                        ahead,
                    );
                }
            }
        }
    }
}

/// Shares what is `left` among the nearest points behind `at` (film, row, column).
fn hand_on(
    left: f32,
    due: &mut [f32],
    voxels: &[bool],
    [films, height, width]: [usize; 3],
    steps: &[Step],
    [film, row, column]: [isize; 3],
    ahead: isize,
) {
    let place = |step: &Step| {
        let inside = |value: isize, count: usize| usize::try_from(value).ok().filter(|value| *value < count);
        let film = inside(film + step.film, films)?;
        let row = inside(row + step.row, height)?;
        let column = inside(column + ahead * step.column, width)?;
        let at = (film * height + row) * width + column;
        voxels[at].then_some((at, 1.0 / step.distance_px))
    };
    let mut nearest = [(0, 0.0); SHARING];
    for (own, found) in nearest.iter_mut().zip(steps.iter().filter_map(place)) {
        *own = found;
    }
    let sum: f32 = nearest.iter().map(|(_, weight)| weight).sum();
    if sum > 0.0 {
        nearest.iter().for_each(|(at, weight)| due[*at] += left * weight / sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Direction, ideal_weights};
    use crate::projection::{ViewerDistance, project};
    use crate::stack::Stack;

    const SIDE: usize = 48;
    const FILMS: usize = 8;

    /// Points of a linear congruence, one in `part` voxels, with the ink of `ink` (film, row, column).
    fn cloud(part: u32, ink: impl Fn(usize, usize, usize) -> [f32; 3]) -> (Volume, Vec<bool>) {
        let mut state = 7_u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16).is_multiple_of(part)
        };
        let voxels: Vec<bool> = (0..FILMS * SIDE * SIDE).map(|_| draw()).collect();
        let mut volume = Volume::new(FILMS, SIDE, SIDE);
        for (at, _) in voxels.iter().enumerate().filter(|(_, taken)| **taken) {
            let own = ink(at / SIDE / SIDE, at / SIDE % SIDE, at % SIDE);
            (0..CHANNELS).for_each(|channel| volume.channel_mut(channel)[at] = own[channel]);
        }
        (volume, voxels)
    }

    #[test]
    fn points_are_levels_and_glow_as_much_together() {
        for (levels, part) in [(2, 60), (2, 3), (4, 20), (16, 1)] {
            let (volume, voxels) = cloud(part, |_, _, _| [0.31, 1.0, 0.0]);
            let mut laid = volume.clone();
            lay(&mut laid, &voxels, levels);
            let top = f32::from(levels - 1);
            for (value, taken) in laid.values().iter().zip(voxels.iter().cycle()) {
                assert!(*taken || *value == 0.0);
                assert!((value * top - (value * top).round()).abs() < 1e-6, "{levels}: {value}");
            }
            // What is full or none stays so.
            assert_eq!(laid.channel(1), volume.channel(1));
            assert_eq!(laid.channel(2), volume.channel(2));
            let sum = |volume: &Volume| volume.channel(0).iter().map(|ink| f64::from(*ink)).sum::<f64>();
            let ratio = sum(&laid) / sum(&volume);
            assert!((ratio - 1.0).abs() < 0.04, "{levels} levels, one in {part}: {ratio}");
        }
    }

    #[test]
    fn views_show_shades_that_rounding_loses() {
        let shade = |film: usize, row: usize, column: usize| {
            let at = (row + column) as f32 / (2 * SIDE) as f32;
            [0.1 + 0.8 * at, 0.4 * (1.0 - at), 0.05 * film as f32]
        };
        let (volume, voxels) = cloud(2, shade);
        let stack =
            Stack { films: FILMS, width_px: SIDE, height_px: SIDE, width_mm: 10.0, ..Stack::default() };
        let shown = |volume: &Volume, degrees: f64| {
            let direction = Direction::new(degrees, 0.0);
            let view = project(volume, &stack, direction, ViewerDistance::Parallel, &ideal_weights(&stack));
            // Squares of 8 pixels, as eyes see them.
            let mut squares = vec![0.0_f64; CHANNELS * 36];
            for channel in 0..CHANNELS {
                for (at, value) in view.channel(channel).iter().enumerate() {
                    squares[channel * 36 + at / SIDE / 8 * 6 + at % SIDE / 8] += f64::from(*value) / 64.0;
                }
            }
            squares
        };
        let mut laid = volume.clone();
        lay(&mut laid, &voxels, 2);
        let mut rounded = volume.clone();
        rounded.values_mut().iter_mut().for_each(|value| *value = value.round());
        for degrees in [-25.0, 0.0, 25.0] {
            let wanted = shown(&volume, degrees);
            let error = |volume: &Volume| -> f64 {
                shown(volume, degrees).iter().zip(&wanted).map(|(one, other)| (one - other).powi(2)).sum()
            };
            let (laid, rounded) = (error(&laid), error(&rounded));
            assert!(laid < 0.02 * rounded, "{degrees}: {laid} against {rounded}");
        }
    }
}
