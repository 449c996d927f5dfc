//! The wedge: patches of each ink at known coverages, to measure its curve from.

use crate::chart::{Chart, MARGIN_MM, Patch, Shape};
use crate::volume::CHANNELS;

/// The coverages of each ink: closer where curves bend most.
pub(super) const COVERAGES: [f64; 13] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
/// How often each patch is there: the repeats tell how evenly the chart is lit.
const REPEATS: usize = 3;
/// Patches without ink, which tell what else is bright.
const BARE: usize = 15;
const COLUMNS: usize = 12;
const ROWS: usize = 11;
const PLACES: usize = COLUMNS * ROWS;
const PITCH_MM: f64 = 8.0;
const PATCH_MM: f64 = 6.0;
/// A step that meets every place once, far from the one before: it has no divisor in common with their number.
const STRIDE: usize = 53;

/// The wedge, 120 x 112 mm: each of the three inks at each of [`COVERAGES`], three times, and bare patches between.
pub fn wedge() -> Chart {
    let count = CHANNELS * COVERAGES.len() * REPEATS;
    debug_assert_eq!(count + BARE, PLACES);
    let patch = |index: usize| {
        let place = index * STRIDE % PLACES;
        let mut coverages = [0.0; CHANNELS];
        if index < count {
            coverages[index % CHANNELS] = COVERAGES[index / CHANNELS % COVERAGES.len()] as f32;
        }
        let middle = |position: usize| MARGIN_MM + (position as f64 + 0.5) * PITCH_MM;
        Patch {
            x_mm: middle(place % COLUMNS),
            y_mm: middle(place / COLUMNS),
            size_mm: PATCH_MM,
            shape: Shape::Square,
            coverages,
        }
    };
    Chart {
        width_mm: 2.0 * MARGIN_MM + COLUMNS as f64 * PITCH_MM,
        height_mm: 2.0 * MARGIN_MM + ROWS as f64 * PITCH_MM,
        patches: (0..PLACES).map(patch).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coverage_is_there_in_three_thirds_of_the_wedge() {
        let wedge = wedge();
        assert_eq!((wedge.width_mm, wedge.height_mm), (120.0, 112.0));
        for ink in 0..CHANNELS {
            for coverage in COVERAGES {
                let of_it = |patch: &&Patch| patch.coverages[ink] == coverage as f32;
                let found: Vec<&Patch> = wedge.patches.iter().filter(of_it).collect();
                assert_eq!(found.len(), REPEATS);
                for (a, b) in [(0, 1), (1, 2), (0, 2)] {
                    let apart = (found[a].x_mm - found[b].x_mm).hypot(found[a].y_mm - found[b].y_mm);
                    assert!(apart > 24.0, "ink {ink} at {coverage}: {apart} mm");
                }
            }
        }
        let mut places: Vec<_> = wedge.patches.iter().map(|p| (p.x_mm as i32, p.y_mm as i32)).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), PLACES);
    }
}
