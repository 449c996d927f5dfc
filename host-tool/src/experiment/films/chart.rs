//! The printed circles.

use super::MOST_FILMS;
use crate::chart::{Chart, MARGIN_MM, Patch, Shape};
use crate::volume::CHANNELS;

const COLUMNS: usize = MOST_FILMS + 1;
const PITCH_MM: f64 = 6.0;
const CIRCLE_MM: f64 = 4.2;
/// Room between the bands, for the strips' edges.
const GAP_MM: f64 = 3.0;
/// Rows of a band: one for each ink, and one without ink.
const BAND_ROWS: usize = CHANNELS + 1;
const BANDS: usize = 3;
/// The band that the strips lie over.
pub(super) const COVERED: usize = 1;
const BAND_MM: f64 = BAND_ROWS as f64 * PITCH_MM;

/// The chart, 180 x 102 mm: three bands of circles, a row for each ink and one left bare; patches go by band, row and
/// column. The strips lie over the middle band.
pub fn chart() -> Chart {
    let patch = |index: usize| {
        let (column, row, band) =
            (index % COLUMNS, index / COLUMNS % BAND_ROWS, index / (COLUMNS * BAND_ROWS));
        let mut coverages = [0.0; CHANNELS];
        if row < CHANNELS {
            coverages[row] = 1.0;
        }
        Patch {
            x_mm: MARGIN_MM + (column as f64 + 0.5) * PITCH_MM,
            y_mm: band_top_mm(band) + (row as f64 + 0.5) * PITCH_MM,
            size_mm: CIRCLE_MM,
            shape: Shape::Disc,
            coverages,
        }
    };
    Chart {
        width_mm: 2.0 * MARGIN_MM + COLUMNS as f64 * PITCH_MM,
        height_mm: band_top_mm(BANDS - 1) + BAND_MM + MARGIN_MM,
        patches: (0..COLUMNS * BAND_ROWS * BANDS).map(patch).collect(),
    }
}

fn band_top_mm(band: usize) -> f64 {
    MARGIN_MM + band as f64 * (BAND_MM + GAP_MM)
}

/// Where strip `number`, 1 to 25, lies: left edge, upper edge, width and height in mm.
pub fn strip_mm(number: usize) -> [f64; 4] {
    let left = MARGIN_MM + number as f64 * PITCH_MM;
    let right = MARGIN_MM + COLUMNS as f64 * PITCH_MM + 2.0;
    [left, band_top_mm(COVERED) - GAP_MM / 2.0, right - left, BAND_MM + GAP_MM]
}

/// The column, and so the number of strips over a place of the middle band.
pub(super) fn column_of(patch: &Patch) -> usize {
    ((patch.x_mm - MARGIN_MM) / PITCH_MM) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn column_n_lies_behind_n_strips_and_nothing_else_behind_any() {
        let chart = chart();
        assert_eq!((chart.width_mm, chart.height_mm), (180.0, 102.0));
        for (index, patch) in chart.patches.iter().enumerate() {
            let half = patch.size_mm / 2.0;
            let over = |number: &usize| {
                let [left, top, width, height] = strip_mm(*number);
                let across = patch.x_mm - half > left && patch.x_mm + half < left + width;
                across && patch.y_mm - half > top && patch.y_mm + half < top + height
            };
            let strips = (1..=MOST_FILMS).filter(over).count();
            let covered = index / (COLUMNS * BAND_ROWS) == COVERED;
            assert_eq!(strips, if covered { column_of(patch) } else { 0 });
        }
    }
}
