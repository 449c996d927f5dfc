//! Plots of `report.html`, as SVG in the page's own colours.

use maud::{Markup, html};

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 220.0;
const LEFT: f64 = 56.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 40.0;
/// About the width of a character.
const CHARACTER: f64 = 7.0;

/// A plot with its axes: from and to which value each goes, and where it is marked.
pub(super) struct Chart<'a> {
    /// What it shows, for those who do not see it.
    pub(super) description: &'a str,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

/// One axis of a plot.
pub(super) struct Axis {
    pub(super) title: &'static str,
    pub(super) from: f64,
    pub(super) to: f64,
    /// The values that are marked, with their words.
    pub(super) marks: Vec<(f64, String)>,
}

/// One line of a plot.
pub(super) struct Line {
    /// The style's name: `top`, `bottom`, `dose`, `budget`; with `back` it is drawn fainter.
    pub(super) class: &'static str,
    pub(super) points: Vec<(f64, f64)>,
}

impl Axis {
    /// An axis from 0 to full, marked every quarter in percent.
    pub(super) fn percent(title: &'static str) -> Self {
        let marks = [0, 25, 50, 75, 100].map(|percent| (f64::from(percent), format!("{percent} %")));
        Self { title, from: 0.0, to: 100.0, marks: marks.to_vec() }
    }

    fn part(&self, value: f64) -> f64 {
        ((value - self.from) / (self.to - self.from)).clamp(0.0, 1.0)
    }
}

impl Chart<'_> {
    /// Draws the lines, and a note above each of `notes`' places on the x axis.
    pub(super) fn draw(&self, lines: &[Line], notes: &[(f64, String)]) -> Markup {
        let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
        html! {
            svg class="chart" role="img" aria-label=(self.description) viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } {
                @for (value, words) in &self.y.marks {
                    line class="grid" x1=(LEFT) x2=(right) y1=(number(self.y(*value))) y2=(number(self.y(*value))) {}
                    text x=(LEFT - 6.0) y=(number(self.y(*value) + 4.0)) text-anchor="end" { (words) }
                }
                @for (value, words) in &self.x.marks {
                    line class="grid" x1=(number(self.x(*value))) x2=(number(self.x(*value))) y1=(bottom) y2=(bottom + 4.0) {}
                    text x=(number(self.x(*value))) y=(bottom + 17.0) text-anchor="middle" { (words) }
                }
                @for (value, words) in notes {
                    line class="note" x1=(number(self.x(*value))) x2=(number(self.x(*value))) y1=(TOP) y2=(bottom) {}
                    text class="note" x=(number(self.x(*value))) y=(TOP - 4.0) text-anchor="middle" { (words) }
                }
                @for line in lines {
                    path class=(line.class) d=(self.path(&line.points)) {}
                }
                text x=((LEFT + right) / 2.0) y=(HEIGHT - 6.0) text-anchor="middle" { (self.x.title) }
                text x=(LEFT) y=(TOP - 4.0) text-anchor="end" { (self.y.title) }
            }
        }
    }

    /// Whether notes at these places, from left to right, stand clear of each other.
    pub(super) fn has_room_for(&self, notes: &[(f64, String)]) -> bool {
        notes.windows(2).all(|pair| {
            let characters = pair[0].1.chars().count() + pair[1].1.chars().count() + 1;
            self.x(pair[1].0) - self.x(pair[0].0) > CHARACTER * characters as f64 / 2.0
        })
    }

    fn x(&self, value: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * self.x.part(value)
    }

    fn y(&self, value: f64) -> f64 {
        HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * self.y.part(value)
    }

    fn path(&self, points: &[(f64, f64)]) -> String {
        let mut path = String::new();
        for (index, (x, y)) in points.iter().enumerate() {
            let command = if index == 0 { 'M' } else { 'L' };
            path += &format!("{command}{} {}", number(self.x(*x)), number(self.y(*y)));
        }
        path
    }
}

/// A length with a tenth of a unit.
fn number(value: f64) -> String {
    let rounded = (value * 10.0).round() / 10.0;
    format!("{rounded}")
}

/// What the lines of a plot are, below it; `classes` are their styles.
pub(super) fn legend(entries: &[(&str, &str)]) -> Markup {
    html! {
        ul class="legend" {
            @for (class, words) in entries {
                li { svg viewBox="0 0 28 8" aria-hidden="true" { path class=(class) d="M0 4L28 4" {} } " " (words) }
            }
        }
    }
}
