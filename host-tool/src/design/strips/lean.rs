//! Strips that lean with the rays of who looks at them.
//!
//! A ray that meets the picture u below its middle meets the film at the height z by `u - z (u n + t)` below the film's,
//! n being 1 by the eye's height above the stack's middle plane and t the slope of the view (see [`crate::projection`]).
//! Near the edges of large films the rays of a viewer before their middle so climb hundreds of rows on their way through
//! the stack, and rows that go straight down would have little to do with each other.
//!
//! So strips lie between lines that lean: `u - z (u n + t)` with n and t midway between the least and the greatest of the
//! views. The line between two strips is the same for both, rounded to whole rows on each film, and no line crosses
//! another, so every row of every film belongs to one strip. Where a film ends before the picture does, or goes on
//! beyond it, lines through rows that the picture does not have, above and below it, part what is left.
//!
//! To be solved, a strip leans by its middle's line: each film's rows are moved by whole ones (see
//! [`crate::stack::StripPlace`]), and the rays of its views climb only as far as they differ from that line. Straight lines
//! stay straight, so nothing of the geometry is lost.

use std::ops::Range;

use crate::design::request::DesignRequest;
use crate::projection::ViewerDistance;
use crate::stack::{Stack, StripPlace};

/// How far a line may lean apart from the next on its way from the middle plane to the outermost film, as a part of
/// their distance: lines would cross at 1.
const MOST_PART: f64 = 0.9;

/// How lines lean.
#[derive(Clone, Debug)]
pub(super) struct Lean {
    /// n and t of the lines.
    line: Sight,
    /// Those of each view.
    views: Vec<Sight>,
    /// How far the outermost films lie from the middle of the stack.
    deepest_mm: f64,
}

/// How rays climb: by `below * per_mm + slope` for each mm toward the viewer, where they meet the picture `below` its middle.
#[derive(Clone, Copy, Debug)]
struct Sight {
    per_mm: f64,
    slope: f64,
}

/// A strip of all films.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    /// The rows of each film; none where there are no more of them.
    pub(super) films: Vec<Range<usize>>,
    /// How far its middle line climbs for each mm toward the viewer.
    climbs: f64,
    /// How far any ray climbs beside that line, at most, on its way from the picture to a film.
    pub(super) apart_mm: f64,
}

/// All strips.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    stack: Stack,
    lean: Lean,
    /// Rows of the picture that a strip has.
    rows: usize,
    /// The first strip's first; negative above the picture's top edge.
    first_row: i64,
    count: usize,
}

/// The rows of the picture that these rows of films, which lean so, lie below; `None` where there are none.
pub(super) fn picture_rows(leaning: &Stack, films: &[Range<usize>]) -> Option<Range<i64>> {
    let rows = films.iter().enumerate().filter(|(_, rows)| !rows.is_empty()).map(|(film, rows)| {
        let down = leaning.first_row(film) - leaning.first_picture_row();
        (rows.start as i64 - down, rows.end as i64 - down)
    });
    let rows = rows.reduce(|(first, last), (start, end)| (first.min(start), last.max(end)))?;
    Some(rows.0..rows.1)
}

impl Sight {
    fn climbs(self, below_mm: f64) -> f64 {
        below_mm * self.per_mm + self.slope
    }
}

impl Lean {
    /// Between the views of `small`, an exhibit of which only the pixels do not count.
    fn new(small: &DesignRequest) -> Self {
        let stack = &small.stack;
        let views = small.views.iter().map(|view| {
            let (x, y) = view.direction.slope(stack.index);
            let per_mm = match view.distance.unwrap_or(small.distance) {
                ViewerDistance::Parallel => 0.0,
                ViewerDistance::Millimetres(distance) => (1.0 + x * x + y * y).sqrt() / distance,
            };
            Sight { per_mm, slope: y }
        });
        let views: Vec<Sight> = views.collect();
        let midway = |of: fn(&Sight) -> f64| {
            let (least, most) = views
                .iter()
                .map(of)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (value.min(a), value.max(b)));
            (least + most) / 2.0
        };
        let deepest_mm = stack.depth_mm() / 2.0;
        let line = Sight {
            per_mm: midway(|sight| sight.per_mm).min(MOST_PART / deepest_mm),
            slope: midway(|sight| sight.slope),
        };
        Self { line, views, deepest_mm }
    }

    /// How far rays that meet the picture at most `half_mm` beside `below_mm` climb beside the line through that.
    fn apart_mm(&self, below_mm: f64, half_mm: f64) -> f64 {
        let line = self.line.climbs(below_mm);
        let ends = [below_mm - half_mm, below_mm + half_mm];
        let rays = self.views.iter().flat_map(|view| ends.map(|end| (view.climbs(end) - line).abs()));
        self.deepest_mm * rays.fold(0.0, f64::max)
    }

    /// By which part of its rows a strip is higher on the outermost films, or its rays climb beside its middle line.
    pub(super) fn spread(&self) -> f64 {
        self.deepest_mm * self.views.iter().map(|view| view.per_mm).fold(self.line.per_mm, f64::max)
    }
}

impl Tile {
    /// The films of `stack`, of any pixels, as they lean for this strip: from the row 0 of the picture on.
    pub(super) fn leaning(&self, stack: &Stack) -> Stack {
        let rows_down_per_mm = -self.climbs / stack.pixel_mm();
        let strip = StripPlace { whole_px: stack.height_px, first_row: 0, rows_down_per_mm };
        Stack { strip: Some(strip), ..stack.clone() }
    }

    /// How many rows of films with these pixels any ray climbs beside the strip's line, at most.
    pub(super) fn climb(&self, stack: &Stack) -> usize {
        // Films are moved by whole rows, and rays go between two.
        if self.apart_mm == 0.0 { 0 } else { (self.apart_mm / stack.pixel_mm()).ceil() as usize + 1 }
    }
}

impl Tiles {
    /// Strips of `rows` rows of the picture, for the views of the exhibit in small.
    pub(super) fn new(stack: &Stack, small: &DesignRequest, rows: usize) -> Self {
        let mut tiles =
            Self { stack: stack.clone(), lean: Lean::new(small), rows: rows.max(1), first_row: 0, count: 0 };
        let height = stack.height_px as f64;
        let films = 0..stack.films;
        let tops = films.clone().map(|film| tiles.line_through(film, 0.0).floor() as i64);
        let bottoms = films.map(|film| tiles.line_through(film, height).ceil() as i64);
        let (first, end) = (tops.min().unwrap_or_default(), bottoms.max().unwrap_or_default());
        tiles.first_row = first;
        tiles.count = ((end - first).max(1) as usize).div_ceil(tiles.rows);
        tiles
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// How they lean.
    pub(super) fn lean(&self) -> &Lean {
        &self.lean
    }

    /// Strip `index`.
    pub(super) fn tile(&self, index: usize) -> Tile {
        let first = self.first_row + (index * self.rows) as i64;
        let end = first + self.rows as i64;
        let films = (0..self.stack.films).map(|film| self.film_row(film, first)..self.film_row(film, end));
        let below_mm = self.below_middle_mm((first + end) as f64 / 2.0);
        let half_mm = self.rows as f64 / 2.0 * self.stack.pixel_mm();
        Tile {
            films: films.collect(),
            climbs: self.lean.line.climbs(below_mm),
            apart_mm: self.lean.apart_mm(below_mm, half_mm),
        }
    }

    /// The first row of a film below the line through the picture above its row `row`.
    fn film_row(&self, film: usize, row: i64) -> usize {
        let climbs = self.lean.line.climbs(self.below_middle_mm(row as f64));
        let down = -climbs * self.stack.film_z_mm(film) / self.stack.pixel_mm();
        (row as f64 + down).round().clamp(0.0, self.stack.height_px as f64) as usize
    }

    /// Where the line that passes a film above its row `row` meets the picture: the reverse of [`Tiles::film_row`].
    fn line_through(&self, film: usize, row: f64) -> f64 {
        let z = self.stack.film_z_mm(film);
        let Sight { per_mm, slope } = self.lean.line;
        let half = self.stack.height_px as f64 / 2.0;
        half + (row - half + z * slope / self.stack.pixel_mm()) / (1.0 - z * per_mm)
    }

    fn below_middle_mm(&self, row: f64) -> f64 {
        (row - self.stack.height_px as f64 / 2.0) * self.stack.pixel_mm()
    }
}
