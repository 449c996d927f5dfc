//! A chart to be printed: one film whose values are coverages.

use std::io::{self, BufWriter};

use png::{BitDepth, ColorType};
use tempfile::NamedTempFile;

use crate::build_folder::{FilmRows, OpenError};
use crate::chart::Chart;
use crate::stack::Stack;

/// Pixels of a chart, in mm: the edges of its patches lie between them.
const PIXEL_MM: f64 = 0.1;

/// A chart as a film to print, kept in a temporary file.
#[derive(Debug)]
pub struct ChartFilm {
    file: NamedTempFile,
    stack: Stack,
    hash: blake3::Hash,
}

impl ChartFilm {
    /// Draws `chart`.
    ///
    /// # Errors
    /// When the temporary file cannot be written.
    pub fn new(chart: &Chart) -> io::Result<Self> {
        let pixels = |mm: f64| (mm / PIXEL_MM).round() as usize;
        let stack = Stack {
            films: 1,
            width_px: pixels(chart.width_mm),
            height_px: pixels(chart.height_mm),
            width_mm: chart.width_mm,
            ..Stack::default()
        };
        let mut file = NamedTempFile::new()?;
        let mut hasher = blake3::Hasher::new();
        let out = BufWriter::new(&mut file);
        let mut encoder = png::Encoder::new(out, stack.width_px as u32, stack.height_px as u32);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Sixteen);
        let mut writer = encoder.write_header()?;
        let mut stream = writer.stream_writer()?;
        for row in 0..stack.height_px {
            let y_mm = (row as f64 + 0.5) * PIXEL_MM;
            let crossed = chart.at_height(y_mm);
            let samples = (0..stack.width_px).flat_map(|column| {
                let coverages = crossed.coverages_at((column as f64 + 0.5) * PIXEL_MM, y_mm);
                coverages.map(|coverage| (coverage * f32::from(u16::MAX)).round() as u16)
            });
            let bytes: Vec<u8> = samples.flat_map(u16::to_be_bytes).collect();
            hasher.update(&bytes);
            io::Write::write_all(&mut stream, &bytes)?;
        }
        stream.finish()?;
        writer.finish()?;
        Ok(Self { file, stack, hash: hasher.finalize() })
    }

    /// The stack of this one film.
    pub fn stack(&self) -> &Stack {
        &self.stack
    }

    /// BLAKE3 of its values in hexadecimal digits.
    pub fn blake3(&self) -> String {
        self.hash.to_hex().to_string()
    }

    /// Opens its rows.
    ///
    /// # Errors
    /// When the temporary file has gone.
    pub fn rows(&self) -> Result<FilmRows, OpenError> {
        let path = self.file.path();
        FilmRows::open(path, self.stack.width_px, self.stack.height_px)
            .map_err(|source| OpenError::BadFilm { path: path.to_owned(), source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_is_drawn_with_its_coverages() {
        let chart = crate::ink::wedge();
        let film = ChartFilm::new(&chart).unwrap();
        assert_eq!((film.stack().width_px, film.stack().height_px), (1200, 1120));
        let mut rows = film.rows().unwrap();
        for row in 0..1120 {
            let samples = rows.next_row().unwrap();
            let y_mm = (f64::from(row) + 0.5) * PIXEL_MM;
            for patch in
                chart.patches.iter().filter(|patch| (patch.y_mm - y_mm).abs() < PIXEL_MM / 2.0 + 1e-9)
            {
                let at = 3 * (patch.x_mm / PIXEL_MM) as usize;
                let wanted = patch.coverages.map(|coverage| (coverage * 65_535.0).round() as u16);
                assert_eq!(samples[at..at + 3], wanted);
            }
        }
        assert!(rows.next_row().is_err());
    }
}
