//! Photographs of charts, made up for tests.

use super::{Chart, Perspective};
use crate::picture::{Picture, srgb_encode};

/// A camera before a chart.
pub(crate) struct Camera<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Where the chart's corners lie: upper left, upper right, lower right, lower left.
    pub(crate) corners: [[f64; 2]; 4],
    /// Light of an ink by its coverage, and by the place on the chart.
    pub(crate) glow: &'a dyn Fn(usize, f32, [f64; 2]) -> f64,
    /// Light everywhere.
    pub(crate) ambient: f64,
    /// How much darker the picture's corners are than its middle.
    pub(crate) vignetting: f64,
    /// Standard deviation of the noise.
    pub(crate) noise: f64,
    /// Passes of a blur over three pixels.
    pub(crate) blur: usize,
}

/// A chart in the middle of a landscape picture, seen from the upper left.
pub(crate) const TILTED: [[f64; 2]; 4] = [[150.0, 90.0], [1080.0, 140.0], [1010.0, 830.0], [90.0, 900.0]];

impl Camera<'_> {
    /// Photographs `chart`: sRGB code values of 8 bits.
    pub(crate) fn take(&self, chart: &Chart) -> Picture {
        let (w, h) = (chart.width_mm, chart.height_mm);
        let sheet = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]];
        let back = Perspective::through(self.corners, sheet).unwrap();
        let (sheet, mut picture) = (Sheet::of(chart), Picture::new(self.width, self.height));
        for row in 0..self.height {
            for column in 0..self.width {
                let light = self.light(&sheet, &back, column as f64, row as f64);
                for (channel, light) in light.into_iter().enumerate() {
                    picture.channel_mut(channel)[row * self.width + column] = light as f32;
                }
            }
        }
        for _ in 0..self.blur {
            picture = self.blurred(&picture);
        }
        let mut seed = 1_u64;
        for value in picture.values_mut() {
            let noise: f64 = (0..12).map(|_| random(&mut seed)).sum::<f64>() - 6.0;
            *value =
                (srgb_encode((*value + (noise * self.noise) as f32).clamp(0.0, 1.0)) * 255.0).round() / 255.0;
        }
        picture
    }

    fn light(&self, sheet: &Sheet, back: &Perspective, column: f64, row: f64) -> [f64; 3] {
        const PARTS: [f64; 2] = [-0.25, 0.25];
        let (x, y) = (column / self.width as f64 - 0.5, row / self.height as f64 - 0.5);
        let shade = 1.0 - self.vignetting * 2.0 * (x * x + y * y);
        let mut light = [0.0; 3];
        for (dx, dy) in PARTS.iter().flat_map(|dx| PARTS.iter().map(move |dy| (dx, dy))) {
            let at = back.apply([column + dx, row + dy]);
            let coverages = sheet.at(at);
            for ink in (0..3).filter(|&ink| coverages[ink] > 0.0) {
                light[ink] += (self.glow)(ink, coverages[ink], at) / 4.0;
            }
        }
        light.map(|light| light * shade + self.ambient)
    }

    fn blurred(&self, picture: &Picture) -> Picture {
        let mut blurred = picture.clone();
        for channel in 0..3 {
            let values = picture.channel(channel);
            for row in 1..self.height - 1 {
                for column in 1..self.width - 1 {
                    let near = |y: usize, x: usize| values[(row + y - 1) * self.width + column + x - 1];
                    let sum: f32 =
                        (0..3).flat_map(|y| (0..3).map(move |x| (y, x))).map(|(y, x)| near(y, x)).sum();
                    blurred.channel_mut(channel)[row * self.width + column] = sum / 9.0;
                }
            }
        }
        blurred
    }
}

/// Points of a mm at which a printed chart is kept.
const FINE: f64 = 10.0;

/// A printed chart.
struct Sheet {
    width: usize,
    height: usize,
    coverages: Vec<[f32; 3]>,
}

impl Sheet {
    fn of(chart: &Chart) -> Self {
        let (width, height) = ((chart.width_mm * FINE) as usize, (chart.height_mm * FINE) as usize);
        let mm = |index: usize| (index as f64 + 0.5) / FINE;
        let row = |row: usize| {
            let chart = chart.at_height(mm(row));
            (0..width).map(move |column| chart.coverages_at(mm(column), mm(row)))
        };
        Self { width, height, coverages: (0..height).flat_map(row).collect() }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f32; 3] {
        let (column, row) = ((x * FINE).floor(), (y * FINE).floor());
        let inside = (0.0..self.width as f64).contains(&column) && (0.0..self.height as f64).contains(&row);
        if inside { self.coverages[row as usize * self.width + column as usize] } else { [0.0; 3] }
    }
}

/// The next number in 0..1 (Knuth's linear congruence of 64 bits).
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as f64 / (1_u64 << 31) as f64
}
