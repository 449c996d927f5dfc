//! Where a model stands in the stack.

use crate::config::{CentreSetting, ObjectSettings};
use crate::stack::Stack;

use super::shape::{Box3, Vector};

/// What a fitted model leaves of the stack's room, so that no point lies on its upper faces, which are outside.
const FIT: f64 = 1.0 - 1e-6;

/// From the model's units to mm in the stack: `unit_mm * R (p - centre)`.
///
/// R turns about the x axis, then the y axis, then the z axis by the angles a, b, c of `turn_deg`:
/// R = Rz(c) Ry(b) Rx(a), with Rx(a) = [1 0 0; 0 cos a -sin a; 0 sin a cos a] and so on, so that positive angles turn
/// y toward z, z toward x and x toward y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rows of `unit_mm * R`.
    rows: [[f64; 3]; 3],
    /// What stands in the middle of the stack, in the model's units.
    centre: [f64; 3],
    /// Millimetres that one unit of the model stands for.
    pub unit_mm: f64,
}

impl Placement {
    /// Turns the model about its own origin, one unit being a millimetre.
    pub fn turned(turn_deg: [f64; 3]) -> Self {
        Self { rows: rotation(turn_deg), centre: [0.0; 3], unit_mm: 1.0 }
    }

    /// Lays a model into the stack as the settings say; `turned` is the box around it after
    /// [`Placement::turned`].
    ///
    /// Where the model is to fit, its unit becomes the least of the stack's width, height and depth (films times film
    /// pitch) over the box's, less a millionth. A model of no extent keeps the unit of 1 mm.
    pub fn new(settings: &ObjectSettings, turned: &Box3, stack: &Stack) -> Self {
        let room = [stack.width_mm, stack.height_mm(), stack.films as f64 * stack.film_pitch_mm()];
        let unit_mm = settings.unit_mm.unwrap_or_else(|| {
            let ratios = turned.size().into_iter().zip(room).filter(|(size, _)| *size > 0.0);
            let unit = ratios.map(|(size, room)| FIT * room / size).fold(f64::INFINITY, f64::min);
            if unit.is_finite() { unit } else { 1.0 }
        });
        let turn = rotation(settings.turn_deg);
        let centre = match settings.centre {
            CentreSetting::Origin => [0.0; 3],
            // The inverse of a rotation is its transpose.
            CentreSetting::Box => {
                let middle = turned.middle();
                [0, 1, 2].map(|axis| (0..3).map(|row| turn[row][axis] * middle[row]).sum())
            }
        };
        Self { rows: turn.map(|row| row.map(|value| unit_mm * value)), centre, unit_mm }
    }

    /// Whether the place depends on how large the model is.
    pub fn needs_box(settings: &ObjectSettings) -> bool {
        settings.unit_mm.is_none() || settings.centre == CentreSetting::Box
    }

    /// Where a point of the model lies in the stack, in mm from its middle.
    #[inline]
    pub fn place(&self, position: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = [0, 1, 2].map(|axis| position[axis] - self.centre[axis]);
        self.rows.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }
}

fn rotation([x_deg, y_deg, z_deg]: [f64; 3]) -> [Vector; 3] {
    let (sin_x, cos_x) = sine_and_cosine(x_deg);
    let (sin_y, cos_y) = sine_and_cosine(y_deg);
    let (sin_z, cos_z) = sine_and_cosine(z_deg);
    let about_x = [[1.0, 0.0, 0.0], [0.0, cos_x, -sin_x], [0.0, sin_x, cos_x]];
    let about_y = [[cos_y, 0.0, sin_y], [0.0, 1.0, 0.0], [-sin_y, 0.0, cos_y]];
    let about_z = [[cos_z, -sin_z, 0.0], [sin_z, cos_z, 0.0], [0.0, 0.0, 1.0]];
    product(about_z, product(about_y, about_x))
}

/// Sine and cosine, exact at quarter turns.
fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => degrees.to_radians().sin_cos(),
    }
}

fn product(a: [Vector; 3], b: [Vector; 3]) -> [Vector; 3] {
    a.map(|row| [0, 1, 2].map(|column| (0..3).map(|at| row[at] * b[at][column]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_follow_the_right_hand() {
        let turned = |turn_deg, point| Placement::turned(turn_deg).place(point);
        assert_eq!(turned([90.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(turned([0.0, 90.0, 0.0], [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(turned([0.0, 0.0, 90.0], [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        // About x first: y goes to z, and about y then to x.
        assert_eq!(turned([90.0, 90.0, 0.0], [0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_fitted_model_touches_the_nearest_walls_from_within() {
        let stack = Stack { films: 10, ..Stack::default() };
        let around = Box3 { least: [100.0, -2.0, 5.0], most: [104.0, 0.0, 6.0] };
        let place = Placement::new(&ObjectSettings::default(), &around, &stack);
        // 10 films of 0.6 mm are 6 mm deep: 35 / 4 mm a unit is wider than deep enough, so depth decides.
        assert!((place.unit_mm - 6.0 * FIT).abs() < 1e-9, "{}", place.unit_mm);
        let corner = place.place(around.most);
        assert!(corner[2] < 3.0 && corner[2] > 3.0 - 1e-4, "{corner:?}");
        assert_eq!(place.place(around.middle()), [0.0; 3]);
    }

    #[test]
    fn the_origin_stays_where_it_is_to_stand_in_the_middle() {
        let settings = ObjectSettings {
            unit_mm: Some(1000.0),
            centre: CentreSetting::Origin,
            turn_deg: [0.0, 0.0, 180.0],
            ..ObjectSettings::default()
        };
        assert!(!Placement::needs_box(&settings));
        let place = Placement::new(&settings, &Box3::EMPTY, &Stack::default());
        assert_eq!(place.place([0.001, 0.002, 0.003]), [-1.0, -2.0, 3.0]);
    }
}
