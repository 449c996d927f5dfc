//! Films that are written strip by strip, and survive Ctrl-C and a loss of power.
//!
//! They grow in a folder beside the build's place. After each strip its bytes are brought to the disk, and then a line
//! of the journal says how long each film is. Whoever goes on cuts the films to the last whole line and designs the next
//! strip: the files come out byte for byte as if nothing had happened.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::films::{FilmRows, film_name};
use super::read::OpenError;
use crate::deflate::{Deflater, Piece, Stream};
use crate::volume::{CHANNELS, InkDepth, Volume};

/// The films of a design by strips while they grow.
#[derive(Debug)]
pub struct GrowingFilms {
    folder: PathBuf,
    journal: File,
    depth: InkDepth,
    width: usize,
    height: usize,
    /// Of each film: its bytes so far and the checksum of what they hold.
    ends: Vec<End>,
    strips: usize,
}

/// Films that have grown to their end.
#[derive(Clone, Debug)]
pub struct GrownFilms {
    /// BLAKE3 of the volume.
    pub volume: [u8; 32],
    /// BLAKE3 of the files in hexadecimal digits, by their names within the build.
    pub files: Vec<(String, String)>,
}

/// How far a film is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct End {
    bytes: u64,
    /// Adler-32 of the uncompressed rows.
    adler: u32,
}

/// A line of the journal.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Line {
    /// The first: what is designed.
    Design(String),
    /// A strip that is on the disk.
    Strip(Vec<End>),
}

/// The journal's name in the folder.
pub(super) const JOURNAL: &str = "strips.jsonl";
/// What a PNG file begins with.
const SIGNATURE: [u8; 8] = [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a];

/// The folder in which the build at `place` grows.
pub fn growing_place(place: &Path) -> PathBuf {
    let mut name = place.file_name().unwrap_or_default().to_owned();
    name.push(".unfinished");
    place.with_file_name(name)
}

impl GrowingFilms {
    /// Goes on with the films in `folder`, or begins anew where there are none of the design named by `fingerprint`.
    ///
    /// # Errors
    /// When the folder cannot be read or written.
    pub fn open(
        folder: &Path,
        fingerprint: &str,
        (films, width, height): (usize, usize, usize),
        depth: InkDepth,
    ) -> io::Result<Self> {
        fs::create_dir_all(folder.join("films"))?;
        let path = folder.join(JOURNAL);
        let text = fs::read_to_string(&path).unwrap_or_default();
        let (strips, last, whole_bytes) = journal_lines(&text, fingerprint, films);
        let mut journal = OpenOptions::new().create(true).truncate(false).write(true).open(path)?;
        journal.set_len(whole_bytes)?;
        journal.seek(SeekFrom::End(0))?;
        let begun = last.is_some();
        let ends = last.unwrap_or_default();
        let mut growing = Self { folder: folder.to_owned(), journal, depth, width, height, ends, strips };
        if begun {
            for (film, end) in growing.ends.iter().enumerate() {
                OpenOptions::new().write(true).open(growing.film(film))?.set_len(end.bytes)?;
            }
        } else {
            growing.begin(fingerprint, films)?;
        }
        Ok(growing)
    }

    /// How many strips are on the disk.
    pub fn strips(&self) -> usize {
        self.strips
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes the next strip: its films from the top one down, some at once, each a volume of the rows that follow those
    /// of the last strip.
    ///
    /// # Errors
    /// When it cannot be written; then the films can still be gone on with.
    pub fn push(&mut self, strip: impl IntoIterator<Item = Vec<Volume>>) -> io::Result<()> {
        let mut grown = Vec::with_capacity(self.ends.len());
        for films in strip {
            let first = grown.len();
            let ends = self.ends.get(first..).unwrap_or_default();
            let ends = ends.par_iter().zip(&films).enumerate();
            let ends = ends.map(|(index, (end, rows))| self.grow(first + index, *end, rows));
            grown.extend(ends.collect::<io::Result<Vec<_>>>()?);
        }
        self.ends = grown;
        self.strips += 1;
        self.log(&Line::Strip(self.ends.clone()))
    }

    /// Adds `rows` to film `film`, which ends at `end`.
    fn grow(&self, film: usize, end: End, rows: &Volume) -> io::Result<End> {
        let piece = compressed(rows, self.depth);
        let mut stream = match self.strips {
            0 => Stream::new(),
            _ => Stream::following(end.adler),
        };
        stream.push(&piece);
        let adler = stream.adler();
        let bytes = chunk(*b"IDAT", stream.so_far());
        append(&self.film(film), &bytes)?;
        Ok(End { bytes: end.bytes + bytes.len() as u64, adler })
    }

    /// Ends all films and gives the BLAKE3 of the volume, read from the files, and of each file. The journal stays: until
    /// it is taken away, the films can be gone on with and ended again.
    ///
    /// # Errors
    /// When a film cannot be written, or read again.
    pub fn finish(self) -> Result<GrownFilms, OpenError> {
        let bad = |film: usize| {
            let path = self.film(film);
            move |error: io::Error| OpenError::BadFilm { path, source: error.into() }
        };
        self.ends.par_iter().enumerate().try_for_each(|(film, end)| {
            let mut bytes = chunk(*b"IDAT", &Stream::following(end.adler).finish());
            bytes.extend(chunk(*b"IEND", &[]));
            append(&self.film(film), &bytes).map_err(bad(film))
        })?;
        let mut volume = blake3::Hasher::new();
        for film in 0..self.ends.len() {
            let path = self.film(film);
            let mut rows = FilmRows::open(&path, self.width, self.height)
                .map_err(|source| OpenError::BadFilm { path, source })?;
            for _ in 0..self.height {
                let row = rows.next_row()?;
                let bytes: Vec<u8> = match self.depth {
                    InkDepth::Eight => row.into_iter().map(|value| (value / 257) as u8).collect(),
                    InkDepth::Sixteen => row.into_iter().flat_map(u16::to_le_bytes).collect(),
                };
                volume.update(&bytes);
            }
        }
        let files = (0..self.ends.len()).into_par_iter().map(|film| {
            let hash = hash_of(&self.film(film)).map_err(bad(film))?;
            Ok((film_name(film), hash))
        });
        let files = files.collect::<Result<_, OpenError>>()?;
        Ok(GrownFilms { volume: *volume.finalize().as_bytes(), files })
    }

    fn film(&self, film: usize) -> PathBuf {
        self.folder.join(film_name(film))
    }

    /// Begins all films.
    fn begin(&mut self, fingerprint: &str, films: usize) -> io::Result<()> {
        let bits = match self.depth {
            InkDepth::Eight => 8,
            InkDepth::Sixteen => 16,
        };
        const RGB: u8 = 2;
        let mut header = Vec::new();
        header.extend((self.width as u32).to_be_bytes());
        header.extend((self.height as u32).to_be_bytes());
        header.extend([bits, RGB, 0, 0, 0]);
        let bytes = [&SIGNATURE[..], &chunk(*b"IHDR", &header)].concat();
        for film in 0..films {
            let mut file = File::create(self.film(film))?;
            file.write_all(&bytes)?;
            file.sync_all()?;
        }
        self.ends = vec![End { bytes: bytes.len() as u64, adler: 1 }; films];
        self.log(&Line::Design(fingerprint.to_owned()))?;
        self.log(&Line::Strip(self.ends.clone()))
    }

    fn log(&mut self, line: &Line) -> io::Result<()> {
        let mut text = serde_json::to_string(line)?;
        text.push('\n');
        self.journal.write_all(text.as_bytes())?;
        self.journal.sync_all()
    }
}

/// Reads the journal as far as its lines are whole: how many strips are done, how far the films are, and how many bytes
/// of the journal say so; nothing where it is another design's.
fn journal_lines(text: &str, fingerprint: &str, films: usize) -> (usize, Option<Vec<End>>, u64) {
    let mut lines = text.split_inclusive('\n');
    let read = |line: &str| -> Option<Line> {
        line.ends_with('\n').then(|| serde_json::from_str(line).ok()).flatten()
    };
    let Some(first) = lines.next() else { return (0, None, 0) };
    if read(first) != Some(Line::Design(fingerprint.to_owned())) {
        return (0, None, 0);
    }
    let (mut count, mut last, mut bytes) = (0, None, first.len() as u64);
    for line in lines {
        match read(line) {
            Some(Line::Strip(ends)) if ends.len() == films => last = Some(ends),
            _ => break,
        }
        count += 1;
        bytes += line.len() as u64;
    }
    // The first of these lines is that of the films' beginnings.
    match last {
        Some(ends) => (count - 1, Some(ends), bytes),
        None => (0, None, 0),
    }
}

/// Bytes that these rows of some films add to their files.
pub fn strip_bytes(films: &[Volume], depth: InkDepth) -> usize {
    let added = |rows: &Volume| chunk(*b"IDAT", &[]).len() + compressed(rows, depth).compressed_len();
    films.par_iter().map(added).sum()
}

fn compressed(rows: &Volume, depth: InkDepth) -> Piece {
    Deflater::new().piece(&filtered(rows, depth))
}

/// The rows of one film as PNG has them before compression, each less the pixel to its left (filter 1).
fn filtered(film: &Volume, depth: InkDepth) -> Vec<u8> {
    const SUB: u8 = 1;
    let samples: Vec<u8> = match depth {
        InkDepth::Eight => film.film_rgb8(0),
        InkDepth::Sixteen => film.film_rgb16(0).into_iter().flat_map(u16::to_be_bytes).collect(),
    };
    let pixel = if depth == InkDepth::Eight { CHANNELS } else { 2 * CHANNELS };
    let mut rows = Vec::with_capacity(samples.len() + film.height());
    for row in samples.chunks_exact(pixel * film.width()) {
        rows.push(SUB);
        rows.extend_from_slice(&row[..pixel]);
        rows.extend(row[pixel..].iter().zip(row).map(|(here, left)| here.wrapping_sub(*left)));
    }
    rows
}

/// A chunk of a PNG file.
fn chunk(kind: [u8; 4], bytes: &[u8]) -> Vec<u8> {
    let mut sum = crc32fast::Hasher::new();
    sum.update(&kind);
    sum.update(bytes);
    let length = (bytes.len() as u32).to_be_bytes();
    [&length[..], &kind, bytes, &sum.finalize().to_be_bytes()].concat()
}

/// Adds bytes to a file, through to the disk.
fn append(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut out = BufWriter::new(OpenOptions::new().append(true).open(path)?);
    out.write_all(bytes)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
}

fn hash_of(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut file = File::open(path)?;
    let mut bytes = vec![0; 1 << 20];
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(hasher.finalize().to_hex().to_string()),
            read => hasher.update(&bytes[..read]),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILMS: usize = 3;
    const WIDTH: usize = 7;
    const HEIGHT: usize = 10;
    const STRIP: usize = 4;

    fn whole() -> Volume {
        let mut volume = Volume::new(FILMS, HEIGHT, WIDTH);
        for (index, value) in volume.values_mut().iter_mut().enumerate() {
            *value = (index * 37 % 256) as f32 / 255.0;
        }
        volume
    }

    /// A strip's films: each ends at rows of its own, and one begins with a strip that has none of it.
    fn strip(volume: &Volume, index: usize) -> Vec<Volume> {
        let films = (0..FILMS).map(|film| {
            let edge = |strip: usize| {
                if strip == 0 { 0 } else { (strip * STRIP + film).saturating_sub(STRIP).min(HEIGHT) }
            };
            let rows = edge(index)..if index == 2 { HEIGHT } else { edge(index + 1) };
            let mut strip = Volume::new(1, rows.len(), WIDTH);
            for channel in 0..CHANNELS {
                let source = &volume.film(channel, film)[rows.start * WIDTH..rows.end * WIDTH];
                strip.channel_mut(channel).copy_from_slice(source);
            }
            strip
        });
        films.collect()
    }

    fn open(folder: &Path, depth: InkDepth) -> GrowingFilms {
        GrowingFilms::open(folder, "one", (FILMS, WIDTH, HEIGHT), depth).unwrap()
    }

    fn grown(folder: &Path, depth: InkDepth) -> ([u8; 32], Vec<Vec<u8>>) {
        let mut films = open(folder, depth);
        for index in films.strips()..3 {
            films.push([strip(&whole(), index)]).unwrap();
        }
        let GrownFilms { volume, files } = films.finish().unwrap();
        let bytes: Vec<Vec<u8>> =
            files.iter().map(|(name, _)| fs::read(folder.join(name)).unwrap()).collect();
        for ((_, hash), bytes) in files.iter().zip(&bytes) {
            assert_eq!(*hash, blake3::hash(bytes).to_hex().to_string());
        }
        (volume, bytes)
    }

    #[test]
    fn strips_become_the_films_of_the_whole_volume() {
        for depth in [InkDepth::Eight, InkDepth::Sixteen] {
            let folder = tempfile::tempdir().unwrap();
            let (hash, films) = grown(folder.path(), depth);
            assert_eq!(hash, whole().blake3(depth));
            for (film, bytes) in films.iter().enumerate() {
                let decoded = image::load_from_memory(bytes).unwrap().to_rgb8().into_raw();
                assert_eq!(decoded, whole().film_rgb8(film));
            }
        }
    }

    #[test]
    fn films_go_on_byte_for_byte_wherever_the_power_was_lost() {
        let folder = tempfile::tempdir().unwrap();
        let wanted = grown(folder.path(), InkDepth::Eight);
        for done in 0..=3 {
            for torn in [false, true] {
                let folder = tempfile::tempdir().unwrap();
                let mut films = open(folder.path(), InkDepth::Eight);
                for index in 0..done {
                    films.push([strip(&whole(), index)]).unwrap();
                }
                drop(films);
                if torn {
                    // A strip that had come to some films, and half a line of the journal.
                    append(&folder.path().join(film_name(0)), b"half a strip").unwrap();
                    append(&folder.path().join(JOURNAL), b"{\"Strip\":[{\"bytes\":1").unwrap();
                }
                assert_eq!(open(folder.path(), InkDepth::Eight).strips(), done);
                assert_eq!(grown(folder.path(), InkDepth::Eight), wanted, "after {done} strips");
            }
        }
    }

    #[test]
    fn another_design_begins_anew() {
        let folder = tempfile::tempdir().unwrap();
        open(folder.path(), InkDepth::Eight).push([strip(&whole(), 0)]).unwrap();
        let other =
            GrowingFilms::open(folder.path(), "two", (FILMS, WIDTH, HEIGHT), InkDepth::Eight).unwrap();
        assert_eq!(other.strips(), 0);
    }
}
