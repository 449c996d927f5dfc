//! Sheets as 16-bit RGB TIFF files.
//!
//! A sample is 65,535 less the ink: white where there is none, so that the sheet looks like paper in every viewer, and a
//! printer whose channels for cyan, magenta and yellow carry the three inks lays them as they are without any colour
//! management. Strips are compressed by Deflate (technical note on compression 8), with horizontal differencing (TIFF 6.0,
//! section 14) but for halftones whose dots are full or empty, which repeat without it. Files that may grow beyond 2 GiB, where many readers of plain TIFF end, are BigTIFF.

use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::sync::{Mutex, PoisonError};

use tiff::encoder::{DirectoryEncoder, Rational, TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard};
use tiff::tags::Tag;

use super::job::{PrintJob, Sheet};
use super::raster::Span;
use super::rows::{Batch, Content, DotRows, Part, SheetRows, draw};
use super::strips::{RowCoder, RowForm, Strip, Strips};
use super::write::{PrintError, TiffForm};
use crate::deflate::Piece;
use crate::volume::CHANNELS;

/// Bytes of dots in a strip, about.
const STRIP_BYTES: usize = 1 << 22;

/// Files that may become larger than this are BigTIFF.
const CLASSIC_BYTES: u64 = 1 << 31;

/// Takes rows of a sheet.
pub(super) type TakeRows<'a> = &'a mut dyn FnMut(&Batch) -> Result<(), PrintError>;

/// Writes `sheet`, the one of this index; `each` gives all of its `rows`.
pub(super) fn write<W: Write + Seek>(
    out: W,
    place: (&PrintJob, usize, &Sheet),
    form: TiffForm,
    rows: &SheetRows<'_>,
    halftoned: bool,
    each: impl FnOnce(TakeRows<'_>) -> Result<(), PrintError>,
) -> Result<(), PrintError> {
    let (job, _, sheet) = place;
    // A pixel's dots take at most six bytes and the reference that repeats them; a halftone's are all different.
    let film_rows = sheet.films.len() as u64 * job.down.dots() as u64;
    let (pixels, dots) = (job.across.pixels() as u64, job.across.dots() as u64);
    let most = film_rows * if halftoned { dots * 6 } else { pixels * 9 };
    if form == TiffForm::Big || most > CLASSIC_BYTES {
        let encoder = TiffEncoder::new_generic(out).map_err(PrintError::Tiff)?;
        write_kind::<W, TiffKindBig>(encoder, place, rows, each)
    } else {
        let encoder = TiffEncoder::new_generic(out).map_err(PrintError::Tiff)?;
        write_kind::<W, TiffKindStandard>(encoder, place, rows, each)
    }
}

fn write_kind<W: Write + Seek, K: TiffKind>(
    mut encoder: TiffEncoder<W, K>,
    (job, index, sheet): (&PrintJob, usize, &Sheet),
    rows: &SheetRows<'_>,
    each: impl FnOnce(TakeRows<'_>) -> Result<(), PrintError>,
) -> Result<(), PrintError> {
    let mut directory = encoder.image_directory().map_err(PrintError::Tiff)?;
    let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
    let mut take = |strip: Strip| {
        lengths.push(strip.bytes.len() as u64);
        offsets.push(directory.write_data(strip.bytes.as_slice()).map_err(PrintError::Tiff)?);
        Ok(())
    };
    let tiff_rows = TiffRows::new(rows, sheet.width);
    let mut strips = Strips::new(tiff_rows.form, rows_per_strip(sheet));
    each(&mut |batch| {
        let compress = |coder: &mut RowCoder, row: &DotRows| tiff_rows.piece(coder, row);
        strips.push(&rows.distinct(batch), |row| row.repeat, compress, &mut take)
    })?;
    strips.rest().map_or(Ok(()), &mut take)?;
    let predictor = tiff_rows.predictor;
    describe(&mut directory, (job, index, sheet), predictor, &offsets, &lengths).map_err(PrintError::Tiff)
}

/// How a TIFF has the rows of a sheet.
pub(super) struct TiffRows<'a> {
    rows: &'a SheetRows<'a>,
    pub(super) form: RowForm,
    predictor: u16,
    /// What lies around films is the same in many rows.
    around: Mutex<BTreeMap<(usize, Vec<Span>), Piece>>,
}

/// Parts of rows that are kept.
const MOST_KEPT: usize = 1024;

impl<'a> TiffRows<'a> {
    /// Rows of `width` dots.
    pub(super) fn new(rows: &'a SheetRows<'a>, width: usize) -> Self {
        const NONE: u16 = 1;
        const DIFFERENCES: u16 = 2;
        let samples = width * CHANNELS;
        let form = |put: fn(&[u16], &mut [u8])| RowForm { samples, bytes: 2 * samples, put };
        let (predictor, form) = match rows.is_full_or_empty() {
            true => (NONE, form(plain)),
            false => (DIFFERENCES, form(differences)),
        };
        Self { rows, form, predictor, around: Mutex::default() }
    }

    /// Compresses a row.
    fn piece(&self, coder: &mut RowCoder, row: &DotRows) -> Piece {
        let Some(parts) = self.rows.parts(row) else {
            return coder.painted(|dots| self.rows.paint(row, dots));
        };
        let mut piece = Piece::empty();
        for part in parts {
            match part {
                Part::Film(dots) => piece.push(&coder.dot_deflater.piece(dots)),
                Part::Around { width: 0, .. } => {}
                Part::Around { width, spans } => piece.push(&self.around(coder, width, spans)),
            }
        }
        piece
    }

    /// Compresses what a film shows in a row.
    pub(super) fn film_piece(&self, coder: &mut RowCoder, content: &Content) -> Piece {
        match content {
            Content::Full(dots) => coder.dot_deflater.piece(dots),
            _ => coder.painted(|dots| self.rows.paint_film(content, dots)),
        }
    }

    fn around(&self, coder: &mut RowCoder, width: usize, spans: Vec<Span>) -> Piece {
        let kept = || self.around.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (width, spans);
        if let Some(piece) = kept().get(&key) {
            return piece.clone();
        }
        let mut dots = vec![0; width * CHANNELS];
        draw(&key.1, &mut dots);
        let mut bytes = vec![0; 2 * dots.len()];
        plain(&dots, &mut bytes);
        let piece = coder.deflater.piece(&bytes);
        let mut kept = kept();
        if kept.len() == MOST_KEPT {
            kept.clear();
        }
        kept.insert(key, piece.clone());
        piece
    }
}

/// White less ink.
fn plain(dots: &[u16], bytes: &mut [u8]) {
    let (pairs, _) = bytes.as_chunks_mut::<2>();
    pairs.iter_mut().zip(dots).for_each(|(pair, ink)| *pair = (u16::MAX - ink).to_ne_bytes());
}

/// The differences of each white-less-ink sample to the one of the dot to its left, as TIFF's predictor 2 has them.
fn differences(dots: &[u16], bytes: &mut [u8]) {
    let put = |pair: &mut [u8; 2], value: u16| *pair = value.to_ne_bytes();
    let (pairs, _) = bytes.as_chunks_mut::<2>();
    let (first, rest) = pairs.split_at_mut(CHANNELS);
    for (pair, ink) in first.iter_mut().zip(dots) {
        put(pair, u16::MAX - ink);
    }
    for ((pair, left), here) in rest.iter_mut().zip(dots).zip(&dots[CHANNELS..]) {
        put(pair, left.wrapping_sub(*here));
    }
}

fn rows_per_strip(sheet: &Sheet) -> usize {
    (STRIP_BYTES / (sheet.width * CHANNELS * 2)).max(1).min(sheet.height)
}

fn describe<W: Write + Seek, K: TiffKind>(
    directory: &mut DirectoryEncoder<'_, W, K>,
    (job, index, sheet): (&PrintJob, usize, &Sheet),
    predictor: u16,
    offsets: &[u64],
    lengths: &[u64],
) -> tiff::TiffResult<()> {
    const DEFLATE: u16 = 8;
    const RGB: u16 = 2;
    const INTERLEAVED: u16 = 1;
    const INCHES: u16 = 2;
    let request = &job.request;
    directory.write_tag(Tag::ImageWidth, sheet.width as u32)?;
    directory.write_tag(Tag::ImageLength, sheet.height as u32)?;
    directory.write_tag(Tag::BitsPerSample, [16u16; CHANNELS].as_slice())?;
    directory.write_tag(Tag::Compression, DEFLATE)?;
    directory.write_tag(Tag::PhotometricInterpretation, RGB)?;
    let description = format!(
        "{}, sheet {} of {}, volume {}; ink = 65535 - sample, channels {}",
        request.exhibit,
        index + 1,
        job.sheets.len(),
        request.volume_blake3,
        request.inks.join(", "),
    );
    directory.write_tag(Tag::ImageDescription, ascii(&description).as_str())?;
    directory.write_tag(Tag::StripOffsets, K::convert_slice(&places::<K>(offsets)?))?;
    directory.write_tag(Tag::SamplesPerPixel, CHANNELS as u16)?;
    directory.write_tag(Tag::RowsPerStrip, rows_per_strip(sheet) as u32)?;
    directory.write_tag(Tag::StripByteCounts, K::convert_slice(&places::<K>(lengths)?))?;
    directory.write_tag(Tag::XResolution, rational(request.resolution.dpi_x))?;
    directory.write_tag(Tag::YResolution, rational(request.resolution.dpi_y))?;
    directory.write_tag(Tag::PlanarConfiguration, INTERLEAVED)?;
    directory.write_tag(Tag::ResolutionUnit, INCHES)?;
    directory.write_tag(Tag::Software, concat!("vitrine ", env!("CARGO_PKG_VERSION")))?;
    directory.write_tag(Tag::Predictor, predictor)?;
    if let Some(profiles) = &request.profiles {
        directory.write_tag(Tag::IccProfile, profiles.samples.as_slice())?;
    }
    Ok(())
}

/// As wide as this kind of file has them.
fn places<K: TiffKind>(values: &[u64]) -> tiff::TiffResult<Vec<K::OffsetType>> {
    values.iter().map(|&value| K::convert_offset(value)).collect()
}

/// To a thousandth of a dot per inch.
fn rational(dpi: f64) -> Rational {
    Rational { n: (dpi * 1000.0).round() as u32, d: 1000 }
}

/// TIFF's texts are ASCII.
fn ascii(text: &str) -> String {
    text.chars().map(|letter| if letter.is_ascii() && letter != '\0' { letter } else { '?' }).collect()
}
