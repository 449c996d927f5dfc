//! The assembly sheet: how films become a stack, on A4, with a picture of each.

use pdf_writer::{Content, Filter, Name, Rect, Ref};
use rayon::prelude::*;

use super::drawing::{ALL, Align, Drawing, Style};
use super::job::PrintJob;
use super::pdf::{PdfFile, draw, points};
use super::rows::OpenFilm;
use super::write::PrintError;
use crate::deflate::{Deflater, Stream};
use crate::volume::CHANNELS;

const WIDTH_MM: f64 = 210.0;
const HEIGHT_MM: f64 = 297.0;
const MARGIN_MM: f64 = 15.0;
const HAIRLINE_MM: f64 = 0.15;
/// The longer side of a film's picture, in pixels.
const PICTURE_PX: usize = 160;
/// Pictures beside each other, and what each has for itself.
const COLUMNS: usize = 6;
const CELL_MM: f64 = 30.0;
const CAPTION_MM: f64 = 6.5;
/// Where the pictures begin on the first page and on the others.
const FIRST_TOP_MM: f64 = 128.0;
const NEXT_TOP_MM: f64 = 30.0;

/// The assembly sheet of all films, which all are printed, as a PDF file.
///
/// # Errors
/// Fails when a film cannot be read.
pub(super) fn sheet(job: &PrintJob, open: OpenFilm<'_>) -> Result<Vec<u8>, PrintError> {
    let films = job.request.stack.films;
    let mut file = PdfFile::begin(Vec::new())?;
    let pictures =
        (0..films).into_par_iter().map(|film| Picture::of(job, film, open)).collect::<Result<Vec<_>, _>>()?;
    let brightest =
        pictures.iter().flat_map(|picture| &picture.ink).fold(0.0, |most: f32, ink| most.max(*ink));
    let references =
        pictures.iter().map(|picture| picture.put(&mut file, brightest)).collect::<Result<Vec<_>, _>>()?;
    let tree = file.reserve();
    let mut pages = Vec::new();
    let mut shown = 0;
    while shown < films || pages.is_empty() {
        let mut drawing = Drawing::new(HAIRLINE_MM);
        let top = if pages.is_empty() { FIRST_TOP_MM } else { NEXT_TOP_MM };
        match pages.is_empty() {
            true => instructions(&mut drawing, job),
            false => {
                let title = format!("{}: films from {}", job.request.exhibit, shown + 1);
                drawing.text(MARGIN_MM, 22.0, &title, Style::bold(5.0).within(WIDTH_MM - 2.0 * MARGIN_MM));
            }
        }
        let rows = ((HEIGHT_MM - MARGIN_MM - top) / (CELL_MM + CAPTION_MM)).floor() as usize;
        let last = (shown + rows * COLUMNS).min(films);
        let mut content = Content::new();
        for (film, picture) in pictures.iter().enumerate().take(last).skip(shown) {
            let (row, column) = ((film - shown) / COLUMNS, (film - shown) % COLUMNS);
            let (x, y) = (MARGIN_MM + column as f64 * CELL_MM, top + row as f64 * (CELL_MM + CAPTION_MM));
            cell(&mut content, &mut drawing, job, film, picture, (x, y));
        }
        content.set_fill_color_space(pdf_writer::types::ColorSpaceOperand::DeviceRgb);
        // Marks are black here, and ink of all channels there.
        let page_height = points(HEIGHT_MM);
        for shape in &mut drawing.shapes {
            shape.ink = shape.ink.map(|ink| u16::MAX - ink);
        }
        draw(&mut content, &drawing, page_height);
        pages.push(page(&mut file, tree, content, &references[shown..last], shown)?);
        shown = last;
    }
    Ok(file.end(tree, &pages, &format!("{}: assembly", job.request.exhibit), None)?)
}

fn page(
    file: &mut PdfFile<Vec<u8>>,
    tree: Ref,
    content: Content,
    pictures: &[Ref],
    first: usize,
) -> std::io::Result<Ref> {
    let contents = file.content(content)?;
    let page = file.reserve();
    file.object(page, |chunk| {
        let mut page = chunk.page(page);
        page.parent(tree).contents(contents);
        page.media_box(Rect::new(0.0, 0.0, points(WIDTH_MM) as f32, points(HEIGHT_MM) as f32));
        let mut resources = page.resources();
        let mut names = resources.x_objects();
        for (index, picture) in pictures.iter().enumerate() {
            names.pair(Name(format!("F{}", first + index).as_bytes()), *picture);
        }
    })?;
    Ok(page)
}

/// What a technician has to know, and the stack from the side.
fn instructions(drawing: &mut Drawing, job: &PrintJob) {
    let request = &job.request;
    let stack = &request.stack;
    let width = WIDTH_MM - 2.0 * MARGIN_MM;
    drawing.text(MARGIN_MM, 24.0, &request.exhibit, Style::bold(8.0).within(width));
    let films = stack.films;
    let line = format!("Assembly of {films} films, volume {}", request.short_hash());
    drawing.text(MARGIN_MM, 31.0, &line, Style::plain(4.2));
    let (gaps, film_mm, spacer_mm) = (films - 1, stack.film_mm, stack.spacer_mm);
    let height_mm = films as f64 * film_mm + gaps as f64 * spacer_mm;
    let spacers = match spacer_mm > 0.0 {
        true => format!("Lay a spacer of {spacer_mm} mm between every two films: {gaps} spacers."),
        false => "Lay the films directly upon each other, without spacers.".to_owned(),
    };
    let side = match request.mirrored {
        true => "Printed mirrored, on the back: from the front, text reads right through the film.",
        false => "Printed on the front: from there, text reads right.",
    };
    let steps = [
        "Measure both rulers of every sheet: 100 mm have to be 100 mm.".to_owned(),
        side.to_owned(),
        "Cut each film at its corner crosses; punch the four rings for the pins.".to_owned(),
        format!("Begin at the bottom with film {films:02}; film 01 ends on top, towards the viewer."),
        spacers,
        "Every film lies with FRONT towards the viewer and the arrow UP.".to_owned(),
        "The bars at the upper edge then step evenly: a gap or a jump is a wrong film.".to_owned(),
        format!(
            "Finished, the stack is {height_mm:.2} mm high: {films} x {film_mm} mm and {gaps} x {spacer_mm} mm."
        ),
    ];
    let text_width = 120.0;
    for (index, step) in steps.iter().enumerate() {
        let y = 42.0 + index as f64 * 9.0;
        drawing.text(MARGIN_MM, y, &(index + 1).to_string(), Style::bold(4.2));
        drawing.text(MARGIN_MM + 6.0, y, step, Style::plain(3.4).within(text_width));
    }
    from_the_side(drawing, job, height_mm);
    let heading = format!(
        "The films as they glow, brightened; film 01 lies on top ({:.1} x {:.1} mm each)",
        stack.width_mm,
        stack.height_mm()
    );
    drawing.text(MARGIN_MM, FIRST_TOP_MM - 6.0, &heading, Style::bold(4.2));
}

/// The stack from the side: its uppermost and lowest films, the spacers between them, and its height.
fn from_the_side(drawing: &mut Drawing, job: &PrintJob, height_mm: f64) {
    const TOP_MM: f64 = 48.0;
    const LEFT_MM: f64 = 155.0;
    const LENGTH_MM: f64 = 26.0;
    /// Films drawn at either end of a stack that has more than twice as many.
    const ENDS: usize = 4;
    const STEP_MM: f64 = 5.6;
    let films = job.request.stack.films;
    let shown: Vec<Option<usize>> = match films > 2 * ENDS {
        true => (0..ENDS).map(Some).chain([None]).chain((films - ENDS..films).map(Some)).collect(),
        false => (0..films).map(Some).collect(),
    };
    drawing.text(LEFT_MM, TOP_MM - 6.5, "Viewer", Style::bold(3.6));
    drawing.arrow_up(LEFT_MM + 18.0, TOP_MM - 9.5, 5.0);
    for (place, film) in shown.iter().enumerate() {
        let y = TOP_MM + place as f64 * STEP_MM;
        match film {
            Some(film) => {
                drawing.rectangle(LEFT_MM, y, LENGTH_MM, 1.3, ALL);
                let name = format!("{:02}", film + 1);
                drawing.text(LEFT_MM - 1.5, y + 1.6, &name, Style::bold(3.2).aligned(Align::Right));
                if film + 1 < films && job.request.stack.spacer_mm > 0.0 {
                    for left in [0.0, LENGTH_MM - 4.0] {
                        drawing.frame(LEFT_MM + left, y + 1.3, 4.0, STEP_MM - 1.3);
                    }
                }
            }
            None => {
                for dot in 0..3 {
                    let y = y + 0.6 + f64::from(dot) * 1.6;
                    drawing.rectangle(LEFT_MM + LENGTH_MM / 2.0 - 0.4, y, 0.8, 0.8, ALL);
                }
            }
        }
    }
    let bottom = TOP_MM + (shown.len() - 1) as f64 * STEP_MM + 1.3;
    let right = LEFT_MM + LENGTH_MM + 3.0;
    drawing.down(right, TOP_MM, bottom - TOP_MM);
    drawing.across(right - 1.0, TOP_MM, 2.0);
    drawing.across(right - 1.0, bottom, 2.0);
    drawing.text(right + 1.2, (TOP_MM + bottom) / 2.0 + 1.2, &format!("{height_mm:.2}"), Style::bold(3.2));
    drawing.text(right + 1.2, (TOP_MM + bottom) / 2.0 + 4.6, "mm", Style::plain(3.0));
}

/// One film's picture with its number and its place in the stack.
fn cell(
    content: &mut Content,
    drawing: &mut Drawing,
    job: &PrintJob,
    film: usize,
    picture: &Picture,
    (x, y): (f64, f64),
) {
    let room = CELL_MM - 4.0;
    let longer = picture.width.max(picture.height) as f64;
    let (width, height) = (room * picture.width as f64 / longer, room * picture.height as f64 / longer);
    let bottom = points(HEIGHT_MM - y - height) as f32;
    content.save_state();
    content.transform([points(width) as f32, 0.0, 0.0, points(height) as f32, points(x) as f32, bottom]);
    content.x_object(Name(format!("F{film}").as_bytes()));
    content.restore_state();
    let used = drawing.text(x, y + room + 4.2, &format!("{:02}", film + 1), Style::bold(4.2));
    let sheet = job.sheets.iter().position(|sheet| sheet.films.iter().any(|place| place.film == film + 1));
    let place = match film {
        0 => "top, ".to_owned(),
        _ if film + 1 == job.request.stack.films => "bottom, ".to_owned(),
        _ => String::new(),
    };
    let where_to_find = format!("{place}sheet {}", sheet.unwrap_or_default() + 1);
    drawing.text(x + used + 1.5, y + room + 4.2, &where_to_find, Style::plain(2.8));
}

/// A film in small.
struct Picture {
    width: usize,
    height: usize,
    /// Interleaved RGB, 1 for full.
    ink: Vec<f32>,
}

impl Picture {
    /// Every pixel of the picture is the mean of those it stands for.
    fn of(job: &PrintJob, film: usize, open: OpenFilm<'_>) -> Result<Self, PrintError> {
        let stack = &job.request.stack;
        let longer = stack.width_px.max(stack.height_px);
        let size = |pixels: usize| (pixels * PICTURE_PX.min(longer) / longer).max(1);
        let (width, height) = (size(stack.width_px), size(stack.height_px));
        let mut sums = vec![0u64; width * height * CHANNELS];
        let mut counts = vec![0u64; width * height];
        let mut rows = open(film)?;
        for row in 0..stack.height_px {
            let samples = rows.next_row()?;
            let line = row * height / stack.height_px * width;
            for (column, pixel) in samples.as_chunks::<CHANNELS>().0.iter().enumerate() {
                let at = line + column * width / stack.width_px;
                counts[at] += 1;
                for (sum, sample) in sums[at * CHANNELS..].iter_mut().zip(pixel) {
                    *sum += u64::from(*sample);
                }
            }
        }
        let ink = sums.iter().enumerate().map(|(at, &sum)| {
            let full = counts[at / CHANNELS].max(1) as f32 * f32::from(u16::MAX);
            sum as f32 / full
        });
        Ok(Self { width, height, ink: ink.collect() })
    }

    /// Puts the picture into the file, so bright that `brightest` is white.
    fn put(&self, file: &mut PdfFile<Vec<u8>>, brightest: f32) -> std::io::Result<Ref> {
        // A square root shows faint ink, much as a screen's curve does.
        let code = |ink: &f32| (255.0 * (ink / brightest.max(f32::MIN_POSITIVE)).sqrt()).round() as u8;
        let samples: Vec<u8> = self.ink.iter().map(code).collect();
        let mut stream = Stream::new();
        stream.push(&Deflater::new().piece(&samples));
        let (id, bytes) = (file.reserve(), stream.finish());
        file.object(id, |chunk| {
            let mut picture = chunk.image_xobject(id, &bytes);
            picture.width(self.width as i32).height(self.height as i32).bits_per_component(8);
            picture.color_space().device_rgb();
            picture.filter(Filter::FlateDecode);
        })?;
        Ok(id)
    }
}
