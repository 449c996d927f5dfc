//! The films as PNG files: ink as it is, 8 or 16 bits a channel, film 1 on top.

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType};
use rayon::prelude::*;
use thiserror::Error;

use super::read::OpenError;
use crate::volume::{InkDepth, Volume};

/// Why a film cannot be read.
#[derive(Debug, Error)]
pub enum FilmError {
    /// The file cannot be read.
    #[error("{0}")]
    Unreadable(#[from] std::io::Error),
    /// It is no whole PNG.
    #[error("it is no whole PNG file: {0}")]
    Damaged(#[from] png::DecodingError),
    /// It is of another kind than films are.
    #[error("it is not {0}")]
    Kind(String),
}

/// The name of film `index` (from 0) within a build.
pub fn film_name(index: usize) -> String {
    format!("films/film-{:02}.png", index + 1)
}

/// All films of `volume` as PNG files, film 0 first.
///
/// # Errors
/// Fails when a film cannot be encoded, which no volume of a valid stack causes.
pub(super) fn encode(volume: &Volume, depth: InkDepth) -> Result<Vec<Vec<u8>>, png::EncodingError> {
    (0..volume.films()).into_par_iter().map(|film| encode_film(volume, film, depth)).collect()
}

fn encode_film(volume: &Volume, film: usize, depth: InkDepth) -> Result<Vec<u8>, png::EncodingError> {
    let (bits, samples) = match depth {
        InkDepth::Eight => (BitDepth::Eight, volume.film_rgb8(film)),
        // PNG has the high byte first.
        InkDepth::Sixteen => {
            (BitDepth::Sixteen, volume.film_rgb16(film).into_iter().flat_map(u16::to_be_bytes).collect())
        }
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, volume.width() as u32, volume.height() as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(bits);
    // Films are nearly noise: a slow search for repetition would find little.
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&samples)?;
    writer.finish()?;
    bytes.shrink_to_fit();
    Ok(bytes)
}

/// Puts the film read from `bytes` into `volume`.
///
/// # Errors
/// Fails when `bytes` are no RGB picture of the volume's size.
pub(super) fn decode(volume: &mut Volume, film: usize, bytes: &[u8]) -> Result<(), FilmError> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info()?;
    let info = reader.info();
    let (width, height) = (volume.width(), volume.height());
    if (info.width as usize, info.height as usize) != (width, height) {
        return Err(FilmError::other_size((width, height), info));
    }
    let size = reader.output_buffer_size().ok_or_else(|| FilmError::Kind("small enough".to_owned()))?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples)?;
    samples.truncate(frame.buffer_size());
    let stored = match (frame.color_type, frame.bit_depth) {
        (ColorType::Rgb, BitDepth::Eight) => volume.set_film_rgb8(film, &samples),
        (ColorType::Rgb, BitDepth::Sixteen) => {
            let wide: Vec<u16> = samples.as_chunks().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
            volume.set_film_rgb16(film, &wide)
        }
        (color, bits) => return Err(FilmError::other_kind(color, bits)),
    };
    stored.map_err(|error| FilmError::Kind(format!("of the right size: {error}")))
}

/// A film that is read row by row, so that even a large one takes little memory.
pub struct FilmRows {
    reader: png::Reader<BufReader<File>>,
    path: PathBuf,
    wide: bool,
}

impl FilmRows {
    /// Opens the film at `path`.
    ///
    /// # Errors
    /// Fails when it is no RGB picture of `width` x `height` pixels.
    pub(crate) fn open(path: &Path, width: usize, height: usize) -> Result<Self, FilmError> {
        let reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        let info = reader.info();
        if (info.width as usize, info.height as usize) != (width, height) {
            return Err(FilmError::other_size((width, height), info));
        }
        let wide = match (info.color_type, info.bit_depth, info.interlaced) {
            (ColorType::Rgb, BitDepth::Eight, false) => false,
            (ColorType::Rgb, BitDepth::Sixteen, false) => true,
            (color, bits, _) => return Err(FilmError::other_kind(color, bits)),
        };
        Ok(Self { reader, path: path.to_owned(), wide })
    }

    /// The next row from the top: interleaved red, green and blue, 65,535 for full ink.
    ///
    /// # Errors
    /// Fails where the file is damaged, and after the last row.
    pub fn next_row(&mut self) -> Result<Vec<u16>, OpenError> {
        let bad = |source| OpenError::BadFilm { path: self.path.clone(), source };
        let row = self.reader.next_row().map_err(|error| bad(error.into()))?;
        let row = row.ok_or_else(|| bad(FilmError::Kind("as high as the stack's films".to_owned())))?;
        Ok(match self.wide {
            true => row.data().as_chunks().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect(),
            // 255 becomes 65,535.
            false => row.data().iter().map(|&value| u16::from(value) * 257).collect(),
        })
    }
}

impl FilmError {
    fn other_size((width, height): (usize, usize), info: &png::Info<'_>) -> Self {
        Self::Kind(format!("{width} x {height} pixels, but {} x {}", info.width, info.height))
    }

    fn other_kind(color: ColorType, bits: BitDepth) -> Self {
        Self::Kind(format!("8- or 16-bit RGB row by row, but {color:?} of {} bits", bits as u8))
    }
}

/// Reads the film at `path` into `volume` and gives its bytes' BLAKE3.
pub(super) fn read_film(volume: &mut Volume, film: usize, path: &Path) -> Result<blake3::Hash, FilmError> {
    let bytes = std::fs::read(path)?;
    decode(volume, film, &bytes)?;
    Ok(blake3::hash(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn films_come_back_as_they_were(values in proptest::collection::vec(0.0_f32..=1.0, 3 * 2 * 4 * 5), wide: bool) {
            let depth = if wide { InkDepth::Sixteen } else { InkDepth::Eight };
            let mut volume = Volume::new(2, 4, 5);
            volume.values_mut().copy_from_slice(&values);
            volume.quantise(depth);
            let mut back = Volume::new(2, 4, 5);
            for (film, bytes) in encode(&volume, depth).unwrap().iter().enumerate() {
                decode(&mut back, film, bytes).unwrap();
            }
            prop_assert_eq!(back, volume);
        }
    }

    #[test]
    fn films_of_another_size_and_broken_films_are_refused() {
        let bytes = encode(&Volume::new(1, 4, 5), InkDepth::Eight).unwrap().remove(0);
        assert!(matches!(decode(&mut Volume::new(1, 5, 4), 0, &bytes), Err(FilmError::Kind(_))));
        let half = &bytes[..bytes.len() / 2];
        assert!(matches!(decode(&mut Volume::new(1, 4, 5), 0, half), Err(FilmError::Damaged(_))));
    }
}
