//! All sheets of a stack: what is on them, and where.

use kurbo::Affine;
use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use super::dots::{DotAxis, INCH_MM, Resolution, TooCoarse};
use super::drawing::Drawing;
use super::layout::{Arrangement, PaperTooSmall, Pieces};
use super::marks::Labels;
use crate::config::Exhibit;
use crate::stack::Stack;
use crate::volume::CHANNELS;

/// How a stack is to be printed.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintRequest {
    /// All films.
    pub stack: Stack,
    /// Those to be printed, 0 on top, each once: all of them, or what is printed anew.
    pub films: Vec<usize>,
    /// The exhibit's name.
    pub exhibit: String,
    /// BLAKE3 of the volume in hexadecimal digits.
    pub volume_blake3: String,
    /// Names of the inks in the three channels.
    pub inks: [String; 3],
    /// Dots per inch.
    pub resolution: Resolution,
    /// What is printed on.
    pub arrangement: Arrangement,
    /// Whether registration marks, captions and legends are printed.
    pub marks: bool,
    /// Whether left and right change places, for the back of the film.
    pub mirrored: bool,
    /// Diameter of the pins that hold the films.
    pub pin_mm: f64,
    /// ICC profiles to put into the sheets.
    pub profiles: Option<Profiles>,
}

/// What the numbers on sheets are to a colour management: ICC profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Profiles {
    /// Of a TIFF's RGB samples.
    pub samples: Vec<u8>,
    /// Of the three inks' coverages.
    pub inks: Vec<u8>,
}

/// Why sheets cannot be laid out.
#[derive(Debug, Error, Diagnostic)]
pub enum LayoutError {
    /// The printer's dots are coarser than the pixels.
    #[error(transparent)]
    #[diagnostic(
        code("vitrine::print::too_coarse"),
        help("raise `dpi_x` and `dpi_y` in [print], or --dpi, or design fewer `pixels` in [stack]")
    )]
    TooCoarse(#[from] TooCoarse),
    /// The paper is too small for one film.
    #[error(transparent)]
    #[diagnostic(transparent)]
    PaperTooSmall(#[from] PaperTooSmall),
}

/// All sheets of a stack.
#[derive(Clone, Debug)]
pub struct PrintJob {
    pub(super) request: PrintRequest,
    pub(super) across: DotAxis,
    pub(super) down: DotAxis,
    /// Whether films lie on their sheets a quarter turn clockwise.
    pub(super) turned: bool,
    pub(super) sheets: Vec<Sheet>,
    pub(super) waste: f64,
}

/// One sheet in dots.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) films: Vec<PlacedFilm>,
    pub(super) drawing: Drawing,
}

/// A film on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PlacedFilm {
    /// Its number, 1 on top.
    pub film: usize,
    /// Dots from the sheet's left edge to the picture.
    pub x_dots: usize,
    /// Dots from the sheet's upper edge to the picture.
    pub y_dots: usize,
}

/// How many digits of the volume's hash the marks show.
const SHOWN_DIGITS: usize = 12;
/// Bytes of films that may be turned: their columns are rows of the sheet, so they are held whole.
const MOST_TURNED_BYTES: usize = 1 << 29;
/// The thinnest lines in mm; where dots are larger, a dot.
const HAIRLINE_MM: f64 = 0.1;

impl PrintRequest {
    /// As the exhibit's `[print]` says, on sheets laid out by `arrangement`.
    pub fn new(exhibit: &Exhibit, volume_blake3: String, arrangement: Arrangement) -> Self {
        let print = &exhibit.print;
        let stack = exhibit.film_stack();
        Self {
            films: (0..stack.films).collect(),
            stack,
            exhibit: exhibit.name.clone(),
            volume_blake3,
            inks: print.inks.clone(),
            resolution: Resolution { dpi_x: print.dpi_x, dpi_y: print.dpi_y },
            arrangement,
            marks: print.marks,
            mirrored: print.mirrored,
            pin_mm: print.pin_mm,
            profiles: None,
        }
    }
}

impl PrintJob {
    /// Lays the films out.
    ///
    /// # Errors
    /// When the printer is too coarse for the pixels, or the paper too small for one film.
    pub fn new(request: PrintRequest) -> Result<Self, LayoutError> {
        let (stack, resolution) = (&request.stack, request.resolution);
        // A printer too coarse for the films as they stand is told, though it may lay them on their side.
        let upright = request.axes(false)?;
        let turned = request.axes(true).ok().filter(|_| request.film_bytes() <= MOST_TURNED_BYTES);
        let pieces = Pieces {
            films: request.films.len(),
            width_mm: stack.width_mm,
            height_mm: stack.height_mm(),
            marks: request.marks,
        };
        let layout = pieces.laid_out(request.arrangement, turned.is_some())?;
        let [across, down] = turned.filter(|_| layout.turned).unwrap_or(upright);
        let labels = request.labels();
        let border = pieces.border_mm();
        let count = layout.sheets.len();
        let mut sheets = Vec::new();
        for (index, planned) in layout.sheets.iter().enumerate() {
            let width = resolution.x(planned.width_mm);
            let mut drawing = Drawing::new(request.hairline_mm());
            let mut films = Vec::new();
            for &(piece, x, y) in &planned.places {
                let film = request.films[piece];
                let left = resolution.x(x + border);
                let mirrored = width.saturating_sub(left + across.dots());
                let x_dots = if request.mirrored { mirrored } else { left };
                films.push(PlacedFilm { film: film + 1, x_dots, y_dots: resolution.y(y + border) });
                if request.marks {
                    let mut marks = Drawing::new(drawing.hairline_mm());
                    labels.film(&mut marks, film, (pieces.width_mm, pieces.height_mm));
                    let place = Affine::translate((x, y));
                    drawing.add(marks, if layout.turned { place * pieces.quarter_turn() } else { place });
                }
            }
            if let (Some(legend), [first, .., last] | [first @ last]) = (&planned.legend, films.as_slice()) {
                labels.legend(&mut drawing, legend, (index + 1, count), (first.film, last.film));
            }
            if request.mirrored {
                drawing.mirror(width as f64 / resolution.dpi_x * INCH_MM);
            }
            sheets.push(Sheet { width, height: resolution.y(planned.height_mm), films, drawing });
        }
        Ok(Self { across, down, turned: layout.turned, sheets, waste: layout.waste, request })
    }

    /// How many sheets there are.
    pub fn sheets(&self) -> usize {
        self.sheets.len()
    }

    /// The part of the paper that is no film with its marks, 0..=1.
    pub fn waste(&self) -> f64 {
        self.waste
    }

    /// What was asked for.
    pub fn request(&self) -> &PrintRequest {
        &self.request
    }

    /// Whether films lie on their sheets a quarter turn clockwise: their upper edges to the right.
    pub fn is_turned(&self) -> bool {
        self.turned
    }

    /// Width and height of a film's picture in dots, as it lies on its sheet.
    pub fn film_dots(&self) -> (usize, usize) {
        (self.across.dots(), self.down.dots())
    }

    /// A film's picture by itself.
    pub(super) fn alone(&self, film: usize) -> Sheet {
        let (width, height) = self.film_dots();
        let films = vec![PlacedFilm { film, x_dots: 0, y_dots: 0 }];
        Sheet { width, height, films, drawing: Drawing::new(HAIRLINE_MM) }
    }
}

impl PrintRequest {
    /// The films' axes along the sheet's width and height.
    fn axes(&self, turned: bool) -> Result<[DotAxis; 2], TooCoarse> {
        let (stack, Resolution { dpi_x, dpi_y }) = (&self.stack, self.resolution);
        let (wide, high) = ((stack.width_px, stack.width_mm), (stack.height_px, stack.height_mm()));
        let ((columns, width_mm), (rows, height_mm)) = if turned { (high, wide) } else { (wide, high) };
        Ok([DotAxis::new(columns, width_mm, dpi_x)?, DotAxis::new(rows, height_mm, dpi_y)?])
    }

    /// Bytes of all films' samples.
    fn film_bytes(&self) -> usize {
        self.films.len() * self.stack.film_len() * CHANNELS * size_of::<u16>()
    }

    fn labels(&self) -> Labels {
        let Resolution { dpi_x, dpi_y } = self.resolution;
        let way = if self.mirrored { "mirrored: front through the film" } else { "not mirrored" };
        Labels {
            exhibit: self.exhibit.clone(),
            films: self.stack.films,
            volume: self.short_hash().to_owned(),
            inks: self.inks.clone(),
            printing: format!("{dpi_x} x {dpi_y} dpi, {way}"),
            pin_mm: self.pin_mm,
        }
    }

    /// The first digits of the volume's hash.
    pub(super) fn short_hash(&self) -> &str {
        self.volume_blake3.get(..SHOWN_DIGITS).unwrap_or(&self.volume_blake3)
    }

    fn hairline_mm(&self) -> f64 {
        let coarser = self.resolution.dpi_x.min(self.resolution.dpi_y);
        HAIRLINE_MM.max(INCH_MM / coarser * 1.001)
    }
}

impl Sheet {
    /// Width and height of the sheet in mm, to the dot.
    pub(super) fn size_mm(&self, resolution: Resolution) -> (f64, f64) {
        (self.width as f64 / resolution.dpi_x * INCH_MM, self.height as f64 / resolution.dpi_y * INCH_MM)
    }
}
