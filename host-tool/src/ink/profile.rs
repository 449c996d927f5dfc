//! ICC profiles of the inks (ICC.1:2022, version 4.3): what light the coverages of a print give, and the way back.
//!
//! The light of the inks adds up: with the coverages c, the curves f and the shares w of [`Separator`], ink i gives the
//! part f_i(c_i) / w_i of what it has in white, and all inks together the colour
//!
//! ```text
//! (X, Y, Z) = sum over i of  P_i f_i(c_i) / w_i
//! ```
//!
//! P being the primaries of sRGB, in which films are designed; no ink is black, and equal film values are the white of
//! the profile's connection space. That is a curve for each ink and a matrix, which a `lutAToBType` holds without a table
//! of colours. The crate `moxcms` reads and writes profiles, but no names of inks, which ink spaces have to have.

use moxcms::{ColorProfile, Matrix3d};

use super::curve::Curve;
use super::separate::Separator;
use crate::volume::CHANNELS;

/// What the numbers of a file are to a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileSpace {
    /// Coverages of three inks of their own names, as a PDF has them.
    Inks,
    /// RGB samples, full for no ink, as a TIFF has them.
    Samples,
}

/// Entries of a curve's table.
const ENTRIES: usize = 1024;
/// The largest value of the connection space's X, Y and Z: 1 + 32,767 / 32,768 (ICC.1, table 11).
const MOST_XYZ: f64 = 1.0 + 32_767.0 / 32_768.0;
/// X, Y and Z of the connection space's white, D50 (ICC.1, 7.2.16).
const WHITE: [f64; 3] = [0.9642, 1.0, 0.8249];
/// Steps along each axis of the table that tells which colours the inks can give.
const GAMUT_STEPS: usize = 33;
/// How far beyond the inks' range a colour still counts as one of theirs: half a step of that table.
const GAMUT_SLACK: f64 = MOST_XYZ / 2.0 / (GAMUT_STEPS - 1) as f64;
const HEADER_BYTES: usize = 128;

/// The profile of inks with these `names`, printed through `separator`, for the numbers of `space`.
pub fn profile(separator: &Separator, names: &[String; CHANNELS], space: ProfileSpace) -> Vec<u8> {
    let light = Light::of(separator, space);
    let (a_to_b, b_to_a) = (light.a_to_b(), light.b_to_a());
    let mut file = Tags::default();
    let title = format!("{} under ultraviolet light", names.join(", "));
    file.add(&[*b"desc"], text(&title));
    file.add(&[*b"cprt"], text("In the public domain"));
    file.add(&[*b"wtpt"], [&b"XYZ \0\0\0\0"[..], &WHITE.map(fixed).concat()].concat());
    file.add(&[*b"A2B0", *b"A2B1", *b"A2B2"], a_to_b);
    file.add(&[*b"B2A0", *b"B2A1", *b"B2A2"], b_to_a);
    file.add(&[*b"gamt"], light.gamut());
    let signature = match space {
        ProfileSpace::Samples => *b"RGB ",
        ProfileSpace::Inks => {
            file.add(&[*b"clrt"], colorants(&light, names));
            *b"3CLR"
        }
    };
    file.finish(signature)
}

/// The way from coverages to light.
struct Light<'a> {
    curves: &'a [Curve; CHANNELS],
    space: ProfileSpace,
    /// From the inks' light, as parts of their own full light, to X, Y and Z.
    matrix: Matrix3d,
}

impl<'a> Light<'a> {
    fn of(separator: &'a Separator, space: ProfileSpace) -> Self {
        let srgb = ColorProfile::new_srgb();
        let primaries = [srgb.red_colorant, srgb.green_colorant, srgb.blue_colorant];
        let shares = separator.shares().map(f64::from);
        let row = |part: fn(&moxcms::Xyzd) -> f64| [0, 1, 2].map(|ink| part(&primaries[ink]) / shares[ink]);
        let matrix = Matrix3d { v: [row(|xyz| xyz.x), row(|xyz| xyz.y), row(|xyz| xyz.z)] };
        Self { curves: separator.curves(), space, matrix }
    }

    /// A `lutAToBType`: curves, then the matrix.
    fn a_to_b(&self) -> Vec<u8> {
        let curves = self
            .curves
            .each_ref()
            .map(|curve| table(|number| f64::from(curve.light(self.coverage(number) as f32))));
        matrix_and_curves(*b"mAB ", scaled(&self.matrix, 1.0 / MOST_XYZ), &curves)
    }

    /// A `lutBToAType`: the matrix, then curves.
    fn b_to_a(&self) -> Vec<u8> {
        let curves = self
            .curves
            .each_ref()
            .map(|curve| table(|light| self.coverage(f64::from(curve.coverage(light as f32)))));
        matrix_and_curves(*b"mBA ", scaled(&self.matrix.inverse(), MOST_XYZ), &curves)
    }

    /// The coverage that a number of a file stands for, and back.
    fn coverage(&self, number: f64) -> f64 {
        match self.space {
            ProfileSpace::Inks => number,
            ProfileSpace::Samples => 1.0 - number,
        }
    }

    /// A `lutBToAType` with 0 for what the inks can give and 1 for what they cannot.
    fn gamut(&self) -> Vec<u8> {
        const CURVES: usize = 32;
        const TABLE: usize = CURVES + CHANNELS * LINEAR.len();
        const VALUES: usize = GAMUT_STEPS * GAMUT_STEPS * GAMUT_STEPS;
        const LAST: usize = TABLE + 20 + VALUES.next_multiple_of(4);
        let back = self.matrix.inverse();
        let value = |index: usize| {
            let at =
                [index / (GAMUT_STEPS * GAMUT_STEPS), index / GAMUT_STEPS % GAMUT_STEPS, index % GAMUT_STEPS];
            let xyz = at.map(|step| step as f64 / (GAMUT_STEPS - 1) as f64 * MOST_XYZ);
            let lights = back.v.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]);
            let within = lights.iter().all(|light| (-GAMUT_SLACK..=1.0 + GAMUT_SLACK).contains(light));
            if within { 0 } else { u8::MAX }
        };
        let mut grid = [0u8; 16];
        grid[..CHANNELS].fill(GAMUT_STEPS as u8);
        let mut values: Vec<u8> = (0..VALUES).map(value).collect();
        values.resize(LAST - TABLE - 20, 0);
        let offsets = [CURVES, 0, 0, TABLE, LAST].map(|offset| (offset as u32).to_be_bytes());
        [
            &b"mBA \0\0\0\0\x03\x01\0\0"[..],
            &offsets.concat(),
            &LINEAR.repeat(CHANNELS),
            &grid,
            &[1, 0, 0, 0],
            &values,
            &LINEAR,
        ]
        .concat()
    }
}

/// A `curveType` that changes nothing.
const LINEAR: [u8; 12] = *b"curv\0\0\0\0\0\0\0\0";

/// A `curveType` with the values of a function over 0..=1.
fn table(value: impl Fn(f64) -> f64) -> Vec<u8> {
    let values = (0..ENTRIES).flat_map(|entry| {
        let value = value(entry as f64 / (ENTRIES - 1) as f64).clamp(0.0, 1.0);
        ((value * f64::from(u16::MAX)).round() as u16).to_be_bytes()
    });
    let mut bytes = [&b"curv\0\0\0\0"[..], &(ENTRIES as u32).to_be_bytes()].concat();
    bytes.extend(values);
    bytes
}

/// A `lutAToBType` or `lutBToAType` of a matrix with `curves` on the inks' side.
fn matrix_and_curves(kind: [u8; 4], matrix: Matrix3d, curves: &[Vec<u8>; CHANNELS]) -> Vec<u8> {
    const PLAIN: u32 = 32;
    const MATRIX: u32 = PLAIN + (CHANNELS * LINEAR.len()) as u32;
    const CURVES: u32 = MATRIX + 48;
    let offsets = [PLAIN, MATRIX, CURVES, 0, 0].map(u32::to_be_bytes);
    let factors = matrix.v.map(|row| row.map(fixed).concat());
    [
        &kind[..],
        &[0, 0, 0, 0, CHANNELS as u8, CHANNELS as u8, 0, 0],
        &offsets.concat(),
        &LINEAR.repeat(CHANNELS),
        &factors.concat(),
        &[0; 12],
        &curves.concat(),
    ]
    .concat()
}

fn scaled(matrix: &Matrix3d, factor: f64) -> Matrix3d {
    Matrix3d { v: matrix.v.map(|row| row.map(|value| value * factor)) }
}

/// A `s15Fixed16Number`.
fn fixed(value: f64) -> [u8; 4] {
    ((value * 65_536.0).round() as i32).to_be_bytes()
}

/// A `multiLocalizedUnicodeType` in English.
fn text(text: &str) -> Vec<u8> {
    let letters: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let numbers = [1, 12].map(u32::to_be_bytes).concat();
    let place = [letters.len() as u32, 28].map(u32::to_be_bytes).concat();
    [&b"mluc\0\0\0\0"[..], &numbers, b"enUS", &place, &letters].concat()
}

/// A `colorantTableType`: the inks' names, and the colour of each at full coverage.
fn colorants(light: &Light<'_>, names: &[String; CHANNELS]) -> Vec<u8> {
    const NAME_BYTES: usize = 32;
    let mut bytes = [&b"clrt\0\0\0\0"[..], &(CHANNELS as u32).to_be_bytes()].concat();
    for (ink, name) in names.iter().enumerate() {
        let mut field = [0; NAME_BYTES];
        // It ends with a zero, and has room for ASCII alone.
        let letters =
            name.bytes().map(|byte| if byte.is_ascii_graphic() || byte == b' ' { byte } else { b'?' });
        field[..NAME_BYTES - 1].iter_mut().zip(letters).for_each(|(place, letter)| *place = letter);
        bytes.extend(field);
        bytes.extend(light.matrix.v.iter().flat_map(|row| {
            let value = (row[ink] / MOST_XYZ).clamp(0.0, 1.0) * f64::from(u16::MAX);
            (value.round() as u16).to_be_bytes()
        }));
    }
    bytes
}

/// The tagged elements of a profile.
#[derive(Default)]
struct Tags {
    /// Name, place among the bytes, and length.
    entries: Vec<([u8; 4], usize, usize)>,
    bytes: Vec<u8>,
}

impl Tags {
    /// Adds an element under all of these names; each begins at a multiple of four bytes.
    fn add(&mut self, names: &[[u8; 4]], element: Vec<u8>) {
        let (place, length) = (self.bytes.len(), element.len());
        self.entries.extend(names.iter().map(|name| (*name, place, length)));
        self.bytes.extend(element);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// The whole profile, of an output device whose numbers are of this space.
    fn finish(self, space: [u8; 4]) -> Vec<u8> {
        const VERSION: [u8; 4] = [4, 0x30, 0, 0];
        const RELATIVE_COLORIMETRIC: u32 = 1;
        // The same inks have the same profile, bit for bit: its date is that of version 4.3.
        const DATE: [u16; 6] = [2010, 12, 1, 0, 0, 0];
        let start = HEADER_BYTES + 4 + 12 * self.entries.len();
        let length = (start + self.bytes.len()) as u32;
        let mut file = Vec::with_capacity(length as usize);
        file.extend(length.to_be_bytes());
        file.extend([0; 4]);
        file.extend(VERSION);
        file.extend(b"prtr");
        file.extend(space);
        file.extend(b"XYZ ");
        file.extend(DATE.map(u16::to_be_bytes).as_flattened());
        file.extend(b"acsp");
        file.extend([0; 24]);
        file.extend(RELATIVE_COLORIMETRIC.to_be_bytes());
        file.extend(WHITE.map(fixed).as_flattened());
        file.resize(HEADER_BYTES, 0);
        file.extend((self.entries.len() as u32).to_be_bytes());
        for (name, place, length) in self.entries {
            file.extend(name);
            file.extend(((start + place) as u32).to_be_bytes());
            file.extend((length as u32).to_be_bytes());
        }
        file.extend(self.bytes);
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{Dots, Inks};
    use moxcms::{DataColorSpace, LutWarehouse, ToneReprCurve};

    /// What the curve of an ink has at `place`, straight between its entries.
    fn looked_up(table: &LutWarehouse, ink: usize, place: f64) -> f64 {
        let LutWarehouse::Multidimensional(table) = table else { panic!("{table:?}") };
        let ToneReprCurve::Lut(values) = &table.m_curves[ink] else { panic!("{table:?}") };
        let at = place * (values.len() - 1) as f64;
        let [low, high] = [at.floor(), at.ceil()].map(|at| f64::from(values[at as usize]) / 65_535.0);
        low + at.fract() * (high - low)
    }

    #[test]
    fn profiles_hold_the_curves_and_lead_back_to_the_same_coverages() {
        let curves = [0.5, 1.0, 2.0].map(Curve::quenching);
        let separator = Separator::new(&Inks { curves, dots: Dots::Continuous, ..Inks::default() });
        let names = ["rose".to_owned(), "grün".to_owned(), "blue".to_owned()];
        for (space, wanted) in
            [(ProfileSpace::Inks, DataColorSpace::Color3), (ProfileSpace::Samples, DataColorSpace::Rgb)]
        {
            let bytes = profile(&separator, &names, space);
            assert_eq!(bytes, profile(&separator, &names, space));
            let read = ColorProfile::new_from_slice(&bytes).unwrap();
            assert_eq!(read.color_space, wanted);
            let [a_to_b, b_to_a] =
                [read.lut_a_to_b_colorimetric, read.lut_b_to_a_colorimetric].map(Option::unwrap);
            for ink in 0..CHANNELS {
                let fullest = f64::from(separator.curves()[ink].fullest());
                for step in 0..=20 {
                    let coverage = f64::from(step) / 20.0 * fullest;
                    let number = if space == ProfileSpace::Inks { coverage } else { 1.0 - coverage };
                    let light = looked_up(&a_to_b, ink, number);
                    let wanted = f64::from(separator.curves()[ink].light(coverage as f32));
                    assert!((light - wanted).abs() < 1e-3, "{number}: {light}, not {wanted}");
                    // Where the curve is level, light tells coverages apart badly.
                    let back = looked_up(&b_to_a, ink, light);
                    assert!((back - number).abs() < 0.02, "{number}: {back}");
                }
            }
        }
        let inks = profile(&separator, &names, ProfileSpace::Inks);
        assert!(inks.windows(6).any(|bytes| bytes == b"gr??n\0"), "names are ASCII");
    }
}
