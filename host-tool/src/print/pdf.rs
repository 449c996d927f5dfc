//! Sheets as PDF files: films as pictures of their dots, of one bit where a halftone fills or leaves them, else of 16
//! bits; marks as outlines.
//!
//! The three inks are a DeviceN colour space under the names in exhibit.toml, 1 for full ink, so that a raster image
//! processor puts each into its channel; what shows no inks shows them as paint on paper. Pictures lie on the printer's
//! dots. Files are written as they grow: nothing larger than a part of a film is held in memory.

use std::io::{self, Write};

use kurbo::PathEl;
use pdf_writer::types::{OutputIntentSubtype, Predictor};
use pdf_writer::{Chunk, Content, Filter, Name, Rect, Ref, TextStr};
use rayon::prelude::*;

use super::dots::INCH_MM;
use super::drawing::Drawing;
use super::job::{PrintJob, Sheet};
use super::rows::{Batch, Content as FilmRow, SheetRows};
use super::strips::{RowCoder, RowForm, Strip, Strips};
use super::write::PrintError;
use crate::deflate::{Deflater, Piece, Stream};
use crate::volume::CHANNELS;

/// PDF's unit, the point, in an inch.
const INCH_POINTS: f64 = 72.0;
/// Bytes of dots in the pictures that are at work at once: films with more become several pictures, one below the other.
const PICTURE_BYTES: usize = 1 << 27;

/// Points of a length in mm.
pub(super) fn points(mm: f64) -> f64 {
    mm / INCH_MM * INCH_POINTS
}

/// A PDF file that grows object by object.
pub(super) struct PdfFile<W> {
    out: W,
    at: u64,
    /// Where each object begins, the first being object 1.
    places: Vec<u64>,
}

impl<W: Write> PdfFile<W> {
    pub(super) fn begin(out: W) -> io::Result<Self> {
        let mut file = Self { out, at: 0, places: Vec::new() };
        // Four bytes beyond ASCII tell programs that the file is binary.
        file.put(b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n")?;
        Ok(file)
    }

    /// A number for an object that is still to be written.
    pub(super) fn reserve(&mut self) -> Ref {
        self.places.push(0);
        Ref::new(self.places.len() as i32)
    }

    /// Writes the object `id`, and nothing else, as `build` puts it into a chunk.
    pub(super) fn object(&mut self, id: Ref, build: impl FnOnce(&mut Chunk)) -> io::Result<()> {
        let mut chunk = Chunk::new();
        build(&mut chunk);
        if let Some(place) = self.places.get_mut(id.get() as usize - 1) {
            *place = self.at;
        }
        self.put(chunk.as_bytes())
    }

    /// Writes a compressed stream of drawing operators as a new object.
    pub(super) fn content(&mut self, content: Content) -> io::Result<Ref> {
        let operators = content.finish();
        let mut stream = Stream::new();
        stream.push(&Deflater::new().piece(operators.as_slice()));
        let (id, bytes) = (self.reserve(), stream.finish());
        self.object(id, |chunk| {
            chunk.stream(id, &bytes).filter(Filter::FlateDecode);
        })?;
        Ok(id)
    }

    /// Writes the ICC profile of the inks.
    fn profile(&mut self, profile: &[u8]) -> io::Result<Ref> {
        let mut stream = Stream::new();
        stream.push(&Deflater::new().piece(profile));
        let (id, bytes) = (self.reserve(), stream.finish());
        self.object(id, |chunk| {
            chunk.icc_profile(id, &bytes).n(CHANNELS as i32).filter(Filter::FlateDecode);
        })?;
        Ok(id)
    }

    /// Writes the pages' root, the catalogue with the inks' `profile`, the title and the table of objects.
    pub(super) fn end(
        mut self,
        tree: Ref,
        pages: &[Ref],
        title: &str,
        profile: Option<&[u8]>,
    ) -> io::Result<W> {
        let profile = profile.map(|profile| self.profile(profile)).transpose()?;
        let (catalog, information) = (self.reserve(), self.reserve());
        self.object(tree, |chunk| {
            chunk.pages(tree).kids(pages.iter().copied()).count(pages.len() as i32);
        })?;
        self.object(catalog, |chunk| {
            let mut catalog = chunk.indirect(catalog).start::<pdf_writer::writers::Catalog<'_>>();
            catalog.pages(tree);
            if let Some(profile) = profile {
                let mut intents = catalog.output_intents();
                let mut intent = intents.push();
                intent.subtype(OutputIntentSubtype::PDFX).dest_output_profile(profile);
                intent.output_condition_identifier(TextStr("Custom"));
                intent.info(TextStr("Fluorescent inks under ultraviolet light"));
            }
        })?;
        self.object(information, |chunk| {
            let mut dictionary = chunk.indirect(information).dict();
            dictionary.pair(Name(b"Title"), TextStr(title));
            dictionary.pair(Name(b"Producer"), TextStr(concat!("vitrine ", env!("CARGO_PKG_VERSION"))));
        })?;
        let table = self.at;
        let count = self.places.len() + 1;
        let mut end = format!("xref\n0 {count}\n0000000000 65535 f \n");
        for place in &self.places {
            end.push_str(&format!("{place:010} 00000 n \n"));
        }
        end.push_str(&format!(
            "trailer\n<< /Size {count} /Root {} 0 R /Info {} 0 R >>\nstartxref\n{table}\n%%EOF\n",
            catalog.get(),
            information.get()
        ));
        self.put(end.as_bytes())?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.out.write_all(bytes)
    }
}

/// A sheet whose rows are still coming.
pub(super) struct PdfSheet<'a, W> {
    file: PdfFile<W>,
    job: &'a PrintJob,
    index: usize,
    sheet: &'a Sheet,
    space: Ref,
    /// Bits of a sample.
    bits: u8,
    films: Vec<FilmStrips>,
    pictures: Vec<PlacedPicture>,
}

/// A film's dots that are not in the file yet.
struct FilmStrips {
    strips: Strips,
    /// The sheet's row of dots where the next picture begins.
    next_row: usize,
}

/// A picture in the file, in the sheet's dots.
struct PlacedPicture {
    id: Ref,
    left: usize,
    top: usize,
    rows: usize,
}

impl<'a, W: Write> PdfSheet<'a, W> {
    /// Begins with the sheet of this index, whose dots have levels up to `top_level` where there is a halftone.
    pub(super) fn begin(
        out: W,
        (job, index, sheet): (&'a PrintJob, usize, &'a Sheet),
        top_level: Option<u8>,
    ) -> Result<Self, PrintError> {
        let mut file = PdfFile::begin(out)?;
        let space = ink_space(&mut file, &job.request.inks)?;
        let (bits, form) = row_form(job.across.dots(), top_level);
        let films = sheet.films.iter().map(|place| {
            let beside = sheet.films.iter().filter(|other| other.y_dots == place.y_dots).count();
            let most_rows = (PICTURE_BYTES / beside / form.bytes).max(1);
            FilmStrips { strips: Strips::new(form, most_rows), next_row: place.y_dots }
        });
        let films = films.collect();
        Ok(Self { file, job, index, sheet, space, bits, films, pictures: Vec::new() })
    }

    /// Goes on with rows of the sheet.
    pub(super) fn rows(&mut self, rows: &SheetRows<'_>, batch: &Batch) -> Result<(), PrintError> {
        let compress = |coder: &mut RowCoder, row: &(FilmRow, usize)| film_piece(coder, rows, &row.0);
        let whole = self.films.par_iter_mut().enumerate().map(|(index, film)| {
            let mut whole = Vec::new();
            film.strips.push(
                &batch.film(index),
                |row| row.1,
                compress,
                |strip| {
                    whole.push(strip);
                    Ok(())
                },
            )?;
            Ok(whole)
        });
        for (index, whole) in whole.collect::<Result<Vec<_>, PrintError>>()?.into_iter().enumerate() {
            whole.iter().try_for_each(|strip| self.picture(index, strip))?;
        }
        Ok(())
    }

    /// Puts dots of the film of this index on the sheet into the file.
    fn picture(&mut self, index: usize, strip: &Strip) -> Result<(), PrintError> {
        let id = picture(&mut self.file, (self.job.across.dots(), self.bits), strip, self.space)?;
        let top = self.films[index].next_row;
        self.pictures.push(PlacedPicture { id, left: self.sheet.films[index].x_dots, top, rows: strip.rows });
        self.films[index].next_row += strip.rows;
        Ok(())
    }

    /// Ends the file.
    pub(super) fn end(mut self) -> Result<W, PrintError> {
        for index in 0..self.films.len() {
            let rest = self.films[index].strips.rest();
            rest.iter().try_for_each(|strip| self.picture(index, strip))?;
        }
        let (job, sheet, index) = (self.job, self.sheet, self.index);
        let contents = self.drawn()?;
        let mut file = self.file;
        let (page, tree) = (file.reserve(), file.reserve());
        let (width_mm, height_mm) = sheet.size_mm(job.request.resolution);
        file.object(page, |chunk| {
            let mut page = chunk.page(page);
            page.parent(tree).contents(contents);
            page.media_box(Rect::new(0.0, 0.0, points(width_mm) as f32, points(height_mm) as f32));
            let mut resources = page.resources();
            resources.color_spaces().pair(Name(b"Inks"), self.space);
            let mut names = resources.x_objects();
            for (number, picture) in self.pictures.iter().enumerate() {
                names.pair(Name(picture_name(number).as_bytes()), picture.id);
            }
        })?;
        let title = format!("{}, sheet {} of {}", job.request.exhibit, index + 1, job.sheets.len());
        let profile = job.request.profiles.as_ref().map(|profiles| profiles.inks.as_slice());
        Ok(file.end(tree, &[page], &title, profile)?)
    }

    /// Puts the pictures in their places and draws what is around them.
    fn drawn(&mut self) -> io::Result<Ref> {
        let resolution = self.job.request.resolution;
        let height = self.sheet.height as f64 / resolution.dpi_y * INCH_POINTS;
        let mut content = Content::new();
        for (number, picture) in self.pictures.iter().enumerate() {
            let across = |dots: usize| (dots as f64 / resolution.dpi_x * INCH_POINTS) as f32;
            let down = |dots: usize| dots as f64 / resolution.dpi_y * INCH_POINTS;
            content.save_state();
            let bottom = (height - down(picture.top + picture.rows)) as f32;
            let (width, rows) = (across(self.job.across.dots()), down(picture.rows) as f32);
            content.transform([width, 0.0, 0.0, rows, across(picture.left), bottom]);
            content.x_object(Name(picture_name(number).as_bytes()));
            content.restore_state();
        }
        content.set_fill_color_space(pdf_writer::types::ColorSpaceOperand::Named(Name(b"Inks")));
        draw(&mut content, &self.sheet.drawing, height);
        self.file.content(content)
    }
}

fn picture_name(number: usize) -> String {
    format!("F{number}")
}

/// The colour space of the three inks. On a screen each takes away the light of the two other colours, as paint does.
fn ink_space<W: Write>(file: &mut PdfFile<W>, names: &[String; 3]) -> io::Result<Ref> {
    // The paint's look: red = (1 - g)(1 - b), green = (1 - r)(1 - b), blue = (1 - r)(1 - g).
    const LOOK: &[u8] = b"{ 1 exch sub 3 1 roll 1 exch sub 3 1 roll 1 exch sub 3 1 roll \
        2 index 2 index mul 4 1 roll dup 4 -1 roll mul 3 1 roll mul 3 1 roll exch }";
    let (space, look) = (file.reserve(), file.reserve());
    file.object(look, |chunk| {
        let mut function = chunk.post_script_function(look, LOOK);
        function.domain([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]).range([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
    })?;
    file.object(space, |chunk| {
        let mut inks = chunk.color_space(space).device_n(names.iter().map(|name| Name(name.as_bytes())));
        inks.alternate_color_space().device_rgb();
        inks.tint_ref(look);
    })?;
    Ok(space)
}

/// Bits of a sample, and rows of `width` dots before compression.
pub(super) fn row_form(width: usize, top_level: Option<u8>) -> (u8, RowForm) {
    let samples = width * CHANNELS;
    match top_level {
        Some(1) => (1, RowForm { samples: 0, bytes: samples.div_ceil(8), put: |_, _| () }),
        _ => (16, RowForm { samples, bytes: 1 + 2 * samples, put: differences }),
    }
}

fn picture<W: Write>(
    file: &mut PdfFile<W>,
    (width, bits): (usize, u8),
    strip: &Strip,
    space: Ref,
) -> io::Result<Ref> {
    let id = file.reserve();
    file.object(id, |chunk| {
        let mut picture = chunk.image_xobject(id, &strip.bytes);
        picture.width(width as i32).height(strip.rows as i32).bits_per_component(bits.into());
        picture.pair(Name(b"ColorSpace"), space);
        picture.filter(Filter::FlateDecode);
        if bits > 1 {
            let mut how = picture.decode_parms();
            how.predictor(Predictor::PngSub).colors(CHANNELS as i32).bits_per_component(bits.into());
            how.columns(width as i32);
        }
    })?;
    Ok(id)
}

/// Compresses what a film shows in a row.
pub(super) fn film_piece(coder: &mut RowCoder, rows: &SheetRows<'_>, content: &FilmRow) -> Piece {
    match content {
        FilmRow::Full(dots) => {
            single_bits(dots.fours(), &mut coder.bytes);
            coder.deflater.piece(&coder.bytes)
        }
        _ => coder.painted(|dots| rows.paint_film(content, dots)),
    }
}

/// A bit for each sample, the first one highest: 1 for ink. `fours` are the kinds of four dots each, the first lowest.
fn single_bits(fours: &[u8], bytes: &mut [u8]) {
    // The twelve bits of four dots.
    const BITS: [u16; 256] = {
        const OF_KIND: [u16; 4] = [0b000, 0b100, 0b010, 0b001];
        let mut bits = [0; 256];
        let mut four = 0;
        while four < bits.len() {
            let mut dot = 0;
            while dot < 4 {
                bits[four] = bits[four] << 3 | OF_KIND[four >> (2 * dot) & 3];
                dot += 1;
            }
            four += 1;
        }
        bits
    };
    for (bytes, eight) in bytes.chunks_mut(3).zip(fours.chunks(2)) {
        let four = |at: usize| eight.get(at).map_or(0, |four| u32::from(BITS[usize::from(*four)]));
        let [_, three @ ..] = (four(0) << 12 | four(1)).to_be_bytes();
        bytes.iter_mut().zip(three).for_each(|(byte, bits)| *byte = bits);
    }
}

/// The row's bytes less those of the dot to the left, as PNG's filter 1 has them, high bytes first.
fn differences(dots: &[u16], bytes: &mut [u8]) {
    const SUB: u8 = 1;
    let Some((filter, bytes)) = bytes.split_first_mut() else { return };
    *filter = SUB;
    let (pairs, _) = bytes.as_chunks_mut::<2>();
    let (first, rest) = pairs.split_at_mut(CHANNELS);
    for (pair, ink) in first.iter_mut().zip(dots) {
        *pair = ink.to_be_bytes();
    }
    for ((pair, left), here) in rest.iter_mut().zip(dots).zip(&dots[CHANNELS..]) {
        let ([high, low], [left_high, left_low]) = (here.to_be_bytes(), left.to_be_bytes());
        *pair = [high.wrapping_sub(left_high), low.wrapping_sub(left_low)];
    }
}

/// Bytes of what is drawn on a sheet.
pub(super) fn drawn_bytes(sheet: &Sheet) -> usize {
    let mut content = Content::new();
    draw(&mut content, &sheet.drawing, 0.0);
    Deflater::new().piece(content.finish().as_slice()).compressed_len()
}

/// Fills all shapes on a page of this height, each with its ink in the colour space that is set.
pub(super) fn draw(content: &mut Content, drawing: &Drawing, page_height: f64) {
    let x = |mm: f64| points(mm) as f32;
    let y = |mm: f64| (page_height - points(mm)) as f32;
    let mut last = None;
    for shape in &drawing.shapes {
        if last != Some(shape.ink) {
            content.set_fill_color(shape.ink.map(|ink| f32::from(ink) / f32::from(u16::MAX)));
            last = Some(shape.ink);
        }
        let mut at = kurbo::Point::ZERO;
        for element in shape.path.elements() {
            match *element {
                PathEl::MoveTo(to) => {
                    content.move_to(x(to.x), y(to.y));
                }
                PathEl::LineTo(to) => {
                    content.line_to(x(to.x), y(to.y));
                }
                PathEl::QuadTo(middle, to) => {
                    let (first, second) = (at.lerp(middle, 2.0 / 3.0), to.lerp(middle, 2.0 / 3.0));
                    content.cubic_to(x(first.x), y(first.y), x(second.x), y(second.y), x(to.x), y(to.y));
                }
                PathEl::CurveTo(first, second, to) => {
                    content.cubic_to(x(first.x), y(first.y), x(second.x), y(second.y), x(to.x), y(to.y));
                }
                PathEl::ClosePath => {
                    content.close_path();
                }
            }
            at = element.end_point().unwrap_or(at);
        }
        content.fill_nonzero();
    }
}
