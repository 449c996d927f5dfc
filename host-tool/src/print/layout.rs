//! Many films on few sheets.
//!
//! All pieces of a stack have the same size and lie alike, so a sheet is a grid of pieces. What is left is whether they
//! stand upright or lie a quarter turn clockwise, and where the legend (ruler, wedge, name) goes. All ways are tried: the
//! legend below the grid and beside it, the pieces upright and turned. The way with the fewest sheets is taken, then that
//! with the least paper, then upright.

use kurbo::Affine;
use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use super::paper::Paper;

/// What printers do not reach at the paper's edges, in mm.
pub(super) const MARGIN_MM: f64 = 5.0;
/// What a film's marks take around its picture, in mm.
pub(super) const BORDER_MM: f64 = 7.0;
/// The side ruler, in mm.
pub(super) const SIDE_RULER_MM: f64 = 4.0;
/// Between films without marks, in mm.
const GAP_MM: f64 = 2.0;
/// The legend is this high where its ruler and its wedge lie side by side, and so long it has to be for that.
pub(super) const LEGEND_MM: f64 = 24.0;
pub(super) const LONG_LEGEND_MM: f64 = 172.0;
/// The legend's height where the wedge lies below the ruler.
const STACKED_LEGEND_MM: f64 = 40.0;
/// The shortest sheet of a single film: its rulers of 100 mm need room.
const SHORTEST_MM: f64 = 106.0;
/// Sheets of a roll are no longer than this unless a single film is.
const ROLL_SHEET_MM: f64 = 2000.0;
/// What floating point arithmetic may add to a length.
const SLACK_MM: f64 = 1e-6;

/// How films are put on sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrangement {
    /// As many as the paper holds.
    On(Paper),
    /// Every film on a sheet of its own, just as large as it needs.
    Each,
}

/// The films of a stack as they are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pieces {
    pub(super) films: usize,
    /// Of the picture.
    pub(super) width_mm: f64,
    pub(super) height_mm: f64,
    pub(super) marks: bool,
}

/// Where all films go.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) sheets: Vec<SheetLayout>,
    /// Whether films lie a quarter turn clockwise.
    pub(super) turned: bool,
    /// The part of the paper that is no film, with its marks, 0..=1.
    pub(super) waste: f64,
}

/// Where the films of one sheet go.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SheetLayout {
    pub(super) width_mm: f64,
    pub(super) height_mm: f64,
    /// Each film with the upper left corner of its piece.
    pub(super) places: Vec<(usize, f64, f64)>,
    pub(super) legend: Option<Legend>,
}

/// Where the legend goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Legend {
    pub(super) side: Side,
    /// Upper left corner of its band.
    pub(super) x_mm: f64,
    pub(super) y_mm: f64,
    /// Along the band.
    pub(super) length_mm: f64,
    /// The second ruler, across to the first: upper left corner and length.
    pub(super) side_ruler: (f64, f64, f64),
}

/// On which side of the films something lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    Beside,
}

/// A paper that not even one film fits on.
#[derive(Clone, Debug, Error, Diagnostic, PartialEq, Serialize)]
#[error(
    "a film with its marks takes {piece_width_mm:.1} x {piece_height_mm:.1} mm, and the paper has room for \
     {room_width_mm:.1} x {room_height_mm:.1} mm"
)]
#[diagnostic(
    code("vitrine::print::paper_too_small"),
    help("print on {advice}, or every film on a sheet of its own with --each")
)]
pub struct PaperTooSmall {
    /// The film with its marks.
    pub piece_width_mm: f64,
    /// The film with its marks.
    pub piece_height_mm: f64,
    /// What the paper's margins and the legend leave.
    pub room_width_mm: f64,
    /// What the paper's margins and the legend leave.
    pub room_height_mm: f64,
    /// A paper that is large enough.
    pub advice: String,
}

impl Pieces {
    /// What marks take on each side.
    pub(super) fn border_mm(&self) -> f64 {
        if self.marks { BORDER_MM } else { 0.0 }
    }

    pub(super) fn piece_mm(&self) -> (f64, f64) {
        (self.width_mm + 2.0 * self.border_mm(), self.height_mm + 2.0 * self.border_mm())
    }

    fn gap_mm(&self) -> f64 {
        if self.marks { 0.0 } else { GAP_MM }
    }

    /// What lays an upright piece on its side, a quarter turn clockwise: its upper left corner goes to the upper right.
    pub(super) fn quarter_turn(&self) -> Affine {
        Affine::new([0.0, 1.0, -1.0, 0.0, self.piece_mm().1, 0.0])
    }

    fn turned(&self) -> Self {
        Self { width_mm: self.height_mm, height_mm: self.width_mm, ..*self }
    }

    /// Lays all films out, upright or where it `may_turn` them also turned.
    ///
    /// # Errors
    /// When the paper is too small for a single film.
    pub(super) fn laid_out(&self, arrangement: Arrangement, may_turn: bool) -> Result<Layout, PaperTooSmall> {
        let (paper, may_turn) = match arrangement {
            Arrangement::On(paper) => (paper, may_turn),
            Arrangement::Each => (self.own_sheet(), false),
        };
        let best = self.grids(paper, may_turn).min_by(|a, b| {
            let cost = |grid: &Grid| (grid.sheets(self.films), grid.paper_mm2(self.films));
            let ((sheets, paper), (other_sheets, other_paper)) = (cost(a), cost(b));
            sheets.cmp(&other_sheets).then(paper.total_cmp(&other_paper))
        });
        let grid = best.ok_or_else(|| self.too_small(paper, may_turn))?;
        let each = match arrangement {
            Arrangement::On(_) => grid.columns * grid.rows,
            Arrangement::Each => 1,
        };
        let sheets: Vec<SheetLayout> = (0..self.films)
            .step_by(each)
            .map(|first| grid.sheet(first..(first + each).min(self.films)))
            .collect();
        let area: f64 = sheets.iter().map(|sheet| sheet.width_mm * sheet.height_mm).sum();
        let (width, height) = self.piece_mm();
        let waste = 1.0 - self.films as f64 * width * height / area;
        Ok(Layout { sheets, turned: grid.pieces != *self, waste })
    }

    /// The ways to lay pieces on `paper` that leave room for any.
    fn grids(&self, paper: Paper, may_turn: bool) -> impl Iterator<Item = Grid> {
        let ways = [Some(*self), may_turn.then(|| self.turned())];
        let sides = move |pieces: Self| [Side::Below, Side::Beside].map(|side| pieces.grid(paper, side));
        ways.into_iter().flatten().flat_map(sides).filter(|grid| grid.columns * grid.rows > 0)
    }

    /// The smallest sheet that holds one film.
    fn own_sheet(&self) -> Paper {
        let (piece_width, piece_height) = self.piece_mm();
        if !self.marks {
            let (width_mm, height_mm) = (piece_width + 2.0 * MARGIN_MM, piece_height + 2.0 * MARGIN_MM);
            return Paper::Sheet { width_mm, height_mm };
        }
        let width = (piece_width + SIDE_RULER_MM).max(SHORTEST_MM);
        let height = piece_height.max(SHORTEST_MM) + legend_mm(width);
        Paper::Sheet { width_mm: width + 2.0 * MARGIN_MM, height_mm: height + 2.0 * MARGIN_MM }
    }

    /// What fits on `paper` with the legend on `side`.
    fn grid(&self, paper: Paper, side: Side) -> Grid {
        let (piece_width, piece_height) = self.piece_mm();
        let gap = self.gap_mm();
        let count =
            |room: f64, piece: f64| ((room + gap + SLACK_MM) / (piece + gap)).floor().max(0.0) as usize;
        let room_width = paper.width_mm() - 2.0 * MARGIN_MM;
        // A roll is cut: its legend lies below.
        let (longest, side) = match paper.height_mm() {
            Some(height) => (height - 2.0 * MARGIN_MM, side),
            None => {
                let single = piece_height + legend_mm(room_width);
                ((ROLL_SHEET_MM - 2.0 * MARGIN_MM).max(single), Side::Below)
            }
        };
        let (below, beside) = match (self.marks, side) {
            (false, _) => (0.0, 0.0),
            (true, Side::Below) => (legend_mm(room_width), SIDE_RULER_MM),
            (true, Side::Beside) => (SIDE_RULER_MM, legend_mm(longest)),
        };
        let columns = count(room_width - beside, piece_width);
        let most_rows = count(longest - below, piece_height);
        let rows = match paper {
            Paper::Sheet { .. } => most_rows,
            Paper::Roll { .. } => most_rows.min(self.films.div_ceil(columns.max(1))),
        };
        let used = (rows as f64 * (piece_height + gap) - gap).max(0.0);
        let height_mm = paper.height_mm().unwrap_or(used + below + 2.0 * MARGIN_MM);
        Grid {
            columns,
            rows,
            side,
            pieces: *self,
            width_mm: paper.width_mm(),
            height_mm,
            room_mm: (room_width - beside, height_mm - 2.0 * MARGIN_MM - below),
        }
    }

    fn too_small(&self, paper: Paper, may_turn: bool) -> PaperTooSmall {
        let (piece_width_mm, piece_height_mm) = self.piece_mm();
        let grid = self.grid(paper, Side::Below);
        let (room_width_mm, mut room_height_mm) = grid.room_mm;
        if paper.height_mm().is_none() {
            room_height_mm = f64::INFINITY;
        }
        let fits = |name: &&&str| {
            let paper = name.parse().ok();
            paper.is_some_and(|paper| self.grids(paper, may_turn).next().is_some())
        };
        let papers =
            ["A4", "A4 landscape", "A3", "A3 landscape", "A2", "A2 landscape", "A1", "A1 landscape", "A0"];
        let narrowest = if may_turn { piece_width_mm.min(piece_height_mm) } else { piece_width_mm };
        let roll = narrowest + SIDE_RULER_MM + 2.0 * MARGIN_MM;
        let advice = match papers.iter().find(fits) {
            Some(name) => format!("paper = \"{name}\" or larger"),
            None => {
                format!("a roll at least {:.0} mm wide: paper = \"roll {:.0}\"", roll.ceil(), roll.ceil())
            }
        };
        PaperTooSmall { piece_width_mm, piece_height_mm, room_width_mm, room_height_mm, advice }
    }
}

/// How high a legend of this length is.
pub(super) fn legend_mm(length_mm: f64) -> f64 {
    if length_mm >= LONG_LEGEND_MM { LEGEND_MM } else { STACKED_LEGEND_MM }
}

/// A sheet's rows and columns of pieces.
struct Grid {
    columns: usize,
    rows: usize,
    side: Side,
    pieces: Pieces,
    width_mm: f64,
    height_mm: f64,
    /// What is left for pieces.
    room_mm: (f64, f64),
}

impl Grid {
    fn sheets(&self, films: usize) -> usize {
        films.div_ceil(self.columns * self.rows)
    }

    fn paper_mm2(&self, films: usize) -> f64 {
        self.sheets(films) as f64 * self.width_mm * self.height_mm
    }

    fn sheet(&self, films: std::ops::Range<usize>) -> SheetLayout {
        let (piece_width, piece_height) = self.pieces.piece_mm();
        let gap = self.pieces.gap_mm();
        let place = |(index, film): (usize, usize)| {
            let (row, column) = (index / self.columns, index % self.columns);
            let x = MARGIN_MM + column as f64 * (piece_width + gap);
            (film, x, MARGIN_MM + row as f64 * (piece_height + gap))
        };
        let (room_width, room_height) = self.room_mm;
        let (right, bottom) = (MARGIN_MM + room_width, MARGIN_MM + room_height);
        let legend = self.pieces.marks.then_some(match self.side {
            Side::Below => Legend {
                side: Side::Below,
                x_mm: MARGIN_MM,
                y_mm: bottom,
                length_mm: self.width_mm - 2.0 * MARGIN_MM,
                side_ruler: (right, MARGIN_MM, room_height),
            },
            Side::Beside => Legend {
                side: Side::Beside,
                x_mm: right,
                y_mm: MARGIN_MM,
                length_mm: self.height_mm - 2.0 * MARGIN_MM,
                side_ruler: (MARGIN_MM, bottom, room_width),
            },
        });
        SheetLayout {
            width_mm: self.width_mm,
            height_mm: self.height_mm,
            places: films.enumerate().map(place).collect(),
            legend,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn paper(name: &str) -> Arrangement {
        Arrangement::On(name.parse().unwrap())
    }

    const PAPER: Pieces = Pieces { films: 20, width_mm: 35.0, height_mm: 35.0, marks: true };

    #[test]
    fn the_papers_stack_goes_on_one_sheet() {
        for name in ["A4", "letter", "A3", "roll 610"] {
            let layout = PAPER.laid_out(paper(name), true).unwrap();
            assert_eq!(layout.sheets.len(), 1, "{name}");
            assert_eq!(layout.sheets[0].places.len(), 20, "{name}");
        }
        // 20 pieces of 49 mm on 210 x 297 mm.
        let waste = PAPER.laid_out(paper("A4"), true).unwrap().waste;
        assert!((waste - (1.0 - 20.0 * 49.0 * 49.0 / (210.0 * 297.0))).abs() < 1e-12);
        // A roll is no longer than it has to be: two rows of twelve, and the legend.
        let roll = PAPER.laid_out(paper("roll 610"), true).unwrap();
        assert!((roll.sheets[0].height_mm - (2.0 * 49.0 + LEGEND_MM + 10.0)).abs() < 1e-9);
    }

    #[test]
    fn films_are_turned_where_that_saves_paper() {
        // By hand, of 200 x 287 mm inside the margins, less 24 mm of legend and 4 mm of ruler: of 114 x 64 mm one goes
        // beside another nowhere and four go below each other, of 64 x 114 mm three and two.
        let wide = Pieces { width_mm: 100.0, height_mm: 50.0, ..PAPER };
        for (may_turn, sheets) in [(false, 5), (true, 4)] {
            let layout = wide.laid_out(paper("A4"), may_turn).unwrap();
            assert_eq!((layout.sheets.len(), layout.turned), (sheets, may_turn));
        }
        let long = Pieces { width_mm: 60.0, height_mm: 120.0, ..PAPER };
        // On a roll of 610 mm: eight columns and three rows of 134 mm, or four columns and five rows of 74 mm.
        let roll = long.laid_out(paper("roll 610"), true).unwrap();
        assert!(roll.turned && (roll.sheets[0].height_mm - (5.0 * 74.0 + LEGEND_MM + 10.0)).abs() < 1e-9);
        // Nothing is turned for nothing, and a film that only lies on its side does.
        assert!(!Pieces { films: 2, ..long }.laid_out(paper("A4"), true).unwrap().turned);
        let wide = Pieces { width_mm: 240.0, ..long };
        assert!(wide.laid_out(paper("A4"), false).is_err());
        assert!(wide.laid_out(paper("A4"), true).unwrap().turned);
    }

    #[test]
    fn every_film_may_have_a_sheet_of_its_own() {
        let layout = PAPER.laid_out(Arrangement::Each, true).unwrap();
        assert_eq!(layout.sheets.len(), 20);
        let legend = layout.sheets[0].legend.unwrap();
        assert!(legend.length_mm >= 100.0 && legend.side_ruler.2 >= 100.0, "{legend:?}");
    }

    #[test]
    fn a_paper_that_is_too_small_is_refused_with_one_that_is_not() {
        let large = Pieces { width_mm: 250.0, height_mm: 250.0, ..PAPER };
        let error = large.laid_out(paper("A4"), true).unwrap_err();
        assert_eq!((error.piece_width_mm, error.advice.as_str()), (264.0, "paper = \"A3\" or larger"));
        let signage = Pieces { width_mm: 841.0, height_mm: 1189.0, ..PAPER };
        let error = signage.laid_out(paper("A0"), true).unwrap_err();
        assert!(error.advice.contains("\"roll 869\""), "{}", error.advice);
        assert_eq!(signage.laid_out(paper("roll 869"), true).unwrap().sheets.len(), 20);
    }

    proptest! {
        #[test]
        fn films_lie_inside_the_margins_and_not_upon_each_other(
            films in 1..60usize, width_mm in 5.0..120.0f64, height_mm in 5.0..120.0f64, marks: bool, may_turn: bool,
            name in 0..5usize
        ) {
            let pieces = Pieces { films, width_mm, height_mm, marks };
            let arrangement = [paper("A4"), paper("A3 landscape"), paper("letter"), paper("roll 432"), Arrangement::Each];
            let layout = pieces.laid_out(arrangement[name], may_turn).unwrap();
            prop_assert!(may_turn || !layout.turned);
            let (width, height) = if layout.turned { pieces.turned() } else { pieces }.piece_mm();
            let mut next = 0;
            for sheet in &layout.sheets {
                for (index, &(film, x, y)) in sheet.places.iter().enumerate() {
                    prop_assert_eq!(film, next);
                    next += 1;
                    prop_assert!(x >= MARGIN_MM && x + width <= sheet.width_mm - MARGIN_MM + 1e-5);
                    prop_assert!(y >= MARGIN_MM && y + height <= sheet.height_mm - MARGIN_MM + 1e-5);
                    if let Some(legend) = sheet.legend {
                        match legend.side {
                            Side::Below => prop_assert!(y + height <= legend.y_mm + 1e-5),
                            Side::Beside => prop_assert!(x + width <= legend.x_mm + 1e-5),
                        }
                    }
                    for &(_, other_x, other_y) in &sheet.places[..index] {
                        let apart = (x - other_x).abs() > width - 1e-5 || (y - other_y).abs() > height - 1e-5;
                        prop_assert!(apart);
                    }
                }
            }
            prop_assert_eq!(next, films);
            prop_assert!((0.0..1.0).contains(&layout.waste));
        }
    }
}
