//! The marks around a film and the legend of a sheet.

use kurbo::Affine;

use super::drawing::{ALL, Align, Drawing, Style};
use super::layout::{BORDER_MM, LEGEND_MM, LONG_LEGEND_MM, Legend, SIDE_RULER_MM, Side};

/// What the marks say.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Labels {
    pub(super) exhibit: String,
    pub(super) films: usize,
    /// The first digits of the volume's BLAKE3.
    pub(super) volume: String,
    pub(super) inks: [String; 3],
    /// How the sheets are printed: resolution, mirrored or not.
    pub(super) printing: String,
    /// Diameter of the pins, and of the holes for them.
    pub(super) pin_mm: f64,
}

/// Steps of the wedge from no ink to full ink, beside the first.
const WEDGE_STEPS: usize = 10;

/// The longest ruler.
const RULER_MM: f64 = 100.0;

impl Labels {
    /// Draws the marks of film `film` (0 on top), whose piece has its upper left corner at the origin and whose picture is
    /// `width` x `height`.
    pub(super) fn film(&self, drawing: &mut Drawing, film: usize, (width, height): (f64, f64)) {
        let (right, bottom) = (width + 2.0 * BORDER_MM, height + 2.0 * BORDER_MM);
        let half = BORDER_MM / 2.0;
        for (corner_x, inward_x) in [(0.0, half), (right, -half)] {
            for (corner_y, inward_y) in [(0.0, half), (bottom, -half)] {
                drawing.cross(corner_x, corner_y, 2.0);
                let (hole_x, hole_y) = (corner_x + inward_x, corner_y + inward_y);
                drawing.ring(hole_x, hole_y, self.pin_mm / 2.0);
                drawing.cross(hole_x, hole_y, self.pin_mm / 2.0 * 0.6);
            }
        }
        drawing.target(half, bottom / 2.0, 2.2);
        drawing.target(right - half, bottom / 2.0, 2.2);
        self.head(drawing, film, BORDER_MM, 0.0, width);
        self.caption(drawing, film, BORDER_MM, bottom - BORDER_MM, width);
    }

    /// Above the picture: which way is up, which side is the front, and the collation mark. In a stack in order these
    /// step along its upper edge from left to right.
    fn head(&self, drawing: &mut Drawing, film: usize, left: f64, top: f64, width: f64) {
        let step = width / self.films as f64;
        drawing.rectangle(left + film as f64 * step, top, step.max(0.5), 1.2, ALL);
        drawing.target(left + width / 2.0, top + 4.2, 1.8);
        let letters = Style::bold(2.4);
        let arrow_x = left + width * 0.08;
        drawing.arrow_up(arrow_x, top + 2.0, 4.2);
        drawing.text(arrow_x + 2.4, top + 5.4, "UP", letters.within(width * 0.25));
        let style = letters.aligned(Align::Right).within(width * 0.38);
        drawing.text(left + width, top + 5.4, "FRONT", style);
    }

    /// Below the picture: the film's number, and what it belongs to.
    fn caption(&self, drawing: &mut Drawing, film: usize, left: f64, top: f64, width: f64) {
        let baseline = top + 5.4;
        let number = format!("{:02}", film + 1);
        let used = drawing.text(left, baseline, &number, Style::bold(5.2).within(width * 0.3));
        let of = format!("of {}", self.films);
        let used = used
            + 0.8
            + drawing.text(left + used + 0.8, baseline, &of, Style::plain(2.2).within(width * 0.2));
        let rest = Style::plain(2.0).aligned(Align::Right).within((width - used - 1.5).max(1.0));
        drawing.text(left + width, top + 2.9, &self.exhibit, rest);
        drawing.text(left + width, baseline, &format!("volume {}", self.volume), rest);
    }

    /// Draws the legend of sheet `number` of `sheets`, which holds the films of these numbers, and its second ruler.
    pub(super) fn legend(
        &self,
        drawing: &mut Drawing,
        legend: &Legend,
        sheet: (usize, usize),
        films: (usize, usize),
    ) {
        let mut band = Drawing::new(drawing.hairline_mm());
        self.band(&mut band, legend.length_mm, sheet, films);
        let (x, y, length) = legend.side_ruler;
        let mut ruler = Drawing::new(drawing.hairline_mm());
        ruler_along(&mut ruler, length, SIDE_RULER_MM, 1.7);
        let turned =
            |x: f64, y: f64| Affine::translate((x, y)) * Affine::rotate(-std::f64::consts::FRAC_PI_2);
        match legend.side {
            Side::Below => {
                drawing.add(band, Affine::translate((legend.x_mm, legend.y_mm)));
                drawing.add(ruler, turned(x, y + length));
            }
            Side::Beside => {
                drawing.add(band, turned(legend.x_mm, legend.y_mm + legend.length_mm));
                drawing.add(ruler, Affine::translate((x, y)));
            }
        }
    }

    fn band(&self, band: &mut Drawing, length: f64, (number, sheets): (usize, usize), films: (usize, usize)) {
        let long = length >= LONG_LEGEND_MM;
        let text_width = if long { 106.0 } else { length };
        band.text(1.0, 6.0, &self.exhibit, Style::bold(4.4).within(text_width - 1.0));
        let (first, last) = films;
        let held = if first == last { format!("film {first}") } else { format!("films {first} to {last}") };
        let text = format!(
            "sheet {number} of {sheets}: {held} of {}, volume {}, {}",
            self.films, self.volume, self.printing
        );
        band.text(1.0, 10.0, &text, Style::plain(2.5).within(text_width - 1.0));
        let mut ruler = Drawing::new(band.hairline_mm());
        ruler_along(&mut ruler, text_width, 9.0, 2.6);
        band.add(ruler, Affine::translate((1.0, 13.0)));
        let place = if long { (112.0, 3.0) } else { (1.0, LEGEND_MM + 1.0) };
        self.wedge(band, place, if long { 5.0 } else { 3.6 }, (length - place.0).min(60.0));
    }

    /// Every ink by itself and all together, from none to full, as the printer's channels have it: no curve is applied.
    fn wedge(&self, band: &mut Drawing, (left, top): (f64, f64), row_mm: f64, length: f64) {
        let names = length * 0.16;
        let step = (length - names) / (WEDGE_STEPS + 1) as f64;
        for row in 0..4 {
            let y = top + row as f64 * row_mm;
            let name = self.inks.get(row).map_or("all", String::as_str);
            band.text(left, y + row_mm * 0.68, name, Style::plain(2.4).within(names - 1.0));
            for patch in 0..=WEDGE_STEPS {
                let amount = (patch * usize::from(u16::MAX) / WEDGE_STEPS) as u16;
                let ink = std::array::from_fn(|channel| if row == 3 || row == channel { amount } else { 0 });
                band.rectangle(left + names + patch as f64 * step, y, step, row_mm, ink);
            }
            band.frame(left + names, y, step * (WEDGE_STEPS + 1) as f64, row_mm);
        }
    }
}

/// A ruler of 100 mm, or as many tens as `length` has, from the origin to the right; its zero is 1 mm away from the end.
fn ruler_along(drawing: &mut Drawing, length: f64, height: f64, letters_mm: f64) {
    let tens = ((length - 2.0).min(RULER_MM) / 10.0).floor().max(0.0) as usize;
    let long = height - letters_mm;
    drawing.across(0.0, 0.0, tens as f64 * 10.0);
    for mm in 0..=tens * 10 {
        let reach = if mm % 10 == 0 {
            1.0
        } else if mm % 5 == 0 {
            0.75
        } else {
            0.5
        };
        drawing.down(mm as f64, 0.0, long * reach);
    }
    for ten in 0..=tens {
        let (text, align) = match ten {
            0 => ("0 mm".to_owned(), Align::Left),
            _ => ((ten * 10).to_string(), Align::Middle),
        };
        drawing.text(
            ten as f64 * 10.0,
            height - letters_mm * 0.1,
            &text,
            Style::plain(letters_mm).aligned(align),
        );
    }
}
