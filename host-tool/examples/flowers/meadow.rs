//! A meadow as points: units are mm, x to the right, y up, z toward the viewer, the origin in the middle.
//!
//! No two points share a voxel of the prototype's 300 x 300 pixels on 20 films, so that its films show as many points as
//! there are.

use std::collections::HashMap;

/// Points of the cloud.
pub(crate) const POINTS: usize = 51_767;
/// The prototype: pixels of a film's side, films, and mm.
const PIXELS: f64 = 300.0;
const FILMS: f64 = 20.0;
const SIDE_MM: f64 = 35.0;
const DEPTH_MM: f64 = 12.5;
/// Samples that are drawn of every surface.
const DRAWN: usize = 400_000;

type Vector = [f64; 3];
type Colour = [f64; 3];

/// A surface: from two numbers of 0..1 to a place and its colour, where there is something.
type Surface = Box<dyn Fn(f64, f64) -> Option<(Vector, Colour)>>;

/// The meadow as a binary PLY file.
pub(crate) fn ply() -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\ncomment flowers and butterflies; mm\nelement vertex {POINTS}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    .into_bytes();
    for (place, colour) in points() {
        file.extend(place.iter().flat_map(|value| (*value as f32).to_le_bytes()));
        file.extend(colour.map(|value| (value * 255.0).round().clamp(0.0, 255.0) as u8));
    }
    file
}

/// As many points as are wanted of all voxels that the surfaces meet, chosen by chance.
fn points() -> Vec<(Vector, Colour)> {
    let mut chance = Chance(51_767);
    let mut voxels: HashMap<[i64; 3], (Vector, Colour)> = HashMap::new();
    let mut order = Vec::new();
    for surface in meadow() {
        for _ in 0..DRAWN {
            let (u, v) = (chance.next(), chance.next());
            let Some((place, colour)) = surface(u, v) else { continue };
            if let Some(voxel) = voxel(place) {
                voxels.entry(voxel).or_insert_with(|| {
                    order.push(voxel);
                    (place, colour)
                });
            }
        }
    }
    assert!(order.len() >= POINTS, "the meadow has room for {} points only", order.len());
    for at in (1..order.len()).rev() {
        order.swap(at, (chance.next() * (at + 1) as f64) as usize);
    }
    order.truncate(POINTS);
    order.iter().map(|voxel| voxels[voxel]).collect()
}

/// The prototype's voxel in which a place lies, if it keeps clear of its faces: as 32 bits it must lie there too.
fn voxel(place: Vector) -> Option<[i64; 3]> {
    let [x, y, z] = place.map(|value| f64::from(value as f32));
    let at = [(x / SIDE_MM + 0.5) * PIXELS, (y / SIDE_MM + 0.5) * PIXELS, (z / DEPTH_MM + 0.5) * FILMS];
    let inside = at.iter().zip([PIXELS, PIXELS, FILMS]).all(|(at, count)| *at >= 0.0 && *at < count);
    let clear = at.iter().all(|at| (0.01..0.99).contains(&at.fract()));
    (inside && clear).then(|| at.map(|at| at as i64))
}

/// Even numbers from 0 to 1, always the same (Steele, Lea and Flood 2014: splitmix64).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut value = self.0;
        value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (value ^ (value >> 31)) as f64 / 2.0f64.powi(64)
    }
}

fn meadow() -> Vec<Surface> {
    let mut surfaces = Vec::new();
    let flower = |surfaces: &mut Vec<Surface>, flower: Flower| {
        surfaces.push(stem(flower.middle, flower.foot_mm));
        surfaces.push(leaf(flower.middle, flower.foot_mm));
        surfaces.push(flower.heart());
        surfaces.push(flower.petals());
    };
    let rose = Flower {
        middle: [-8.0, 6.0, -1.0],
        radius_mm: 8.2,
        petals: 8,
        cup: 0.45,
        inner: [1.0, 0.85, 0.3],
        outer: [1.0, 0.12, 0.35],
        foot_mm: -6.0,
    };
    let violet = Flower {
        middle: [8.8, -3.5, 0.0],
        radius_mm: 7.0,
        petals: 5,
        cup: 0.3,
        inner: [1.0, 0.9, 0.9],
        outer: [0.55, 0.15, 1.0],
        foot_mm: 7.0,
    };
    let daisy = Flower {
        middle: [9.2, 11.3, -4.0],
        radius_mm: 5.2,
        petals: 13,
        cup: 0.1,
        inner: [0.95, 0.95, 1.0],
        outer: [0.75, 0.85, 1.0],
        foot_mm: 12.0,
    };
    let poppy = Flower {
        middle: [-10.0, -9.0, 2.0],
        radius_mm: 5.8,
        petals: 6,
        cup: 0.35,
        inner: [1.0, 0.9, 0.1],
        outer: [1.0, 0.45, 0.0],
        foot_mm: -11.0,
    };
    for grown in [rose, violet, daisy, poppy] {
        flower(&mut surfaces, grown);
    }
    let monarch = Butterfly {
        middle: [0.8, -10.5, 3.6],
        wing_mm: 5.6,
        heading_deg: 20.0,
        fold_deg: 28.0,
        inner: [1.0, 0.65, 0.05],
        outer: [1.0, 0.3, 0.0],
        edge: [0.30, 0.12, 0.04],
        spots: [1.0, 1.0, 0.9],
    };
    let morpho = Butterfly {
        middle: [1.5, 4.2, 4.2],
        wing_mm: 5.0,
        heading_deg: -28.0,
        fold_deg: 24.0,
        inner: [0.3, 0.95, 1.0],
        outer: [0.05, 0.35, 1.0],
        edge: [0.05, 0.08, 0.32],
        spots: [0.9, 1.0, 1.0],
    };
    let brimstone = Butterfly {
        middle: [-1.0, 14.0, 2.0],
        wing_mm: 3.4,
        heading_deg: 35.0,
        fold_deg: 40.0,
        inner: [1.0, 1.0, 0.35],
        outer: [0.85, 0.95, 0.1],
        edge: [0.5, 0.55, 0.05],
        spots: [1.0, 0.5, 0.1],
    };
    for flying in [monarch, morpho, brimstone] {
        surfaces.extend([flying.wings(1.0), flying.wings(-1.0), flying.body(), flying.feelers()]);
    }
    surfaces
}

#[derive(Clone, Copy)]
struct Flower {
    middle: Vector,
    radius_mm: f64,
    petals: u32,
    /// How far the petals' tips rise toward the viewer, as a part of the radius.
    cup: f64,
    inner: Colour,
    outer: Colour,
    /// Where the stem stands at the bottom, in x.
    foot_mm: f64,
}

impl Flower {
    fn petals(self) -> Surface {
        Box::new(move |u, v| {
            let share = std::f64::consts::TAU / f64::from(self.petals);
            let petal = (u * f64::from(self.petals)).floor();
            let across = 2.0 * (u * f64::from(self.petals)).fract() - 1.0;
            // Even over the area, the petal's base being in the heart.
            let along = 0.18 + 0.82 * v.sqrt();
            let width = (std::f64::consts::PI * along.powf(1.4)).sin().max(0.0).powf(0.55);
            let angle = petal * share + across * width * share * 0.47 + 0.3;
            let radius = self.radius_mm * along * (1.0 - 0.06 * across * across);
            let rise = self.cup * self.radius_mm * (along * along - 0.25 * across * across * along);
            let vein = 0.86 + 0.14 * (across * 11.0).cos();
            let shade = vein * (1.0 - 0.35 * across.abs().powi(3));
            let colour = mixed(self.inner, self.outer, ((along - 0.2) / 0.55).clamp(0.0, 1.0));
            let place = [radius * angle.cos(), radius * angle.sin(), rise];
            Some((moved(place, self.middle), colour.map(|value| value * shade)))
        })
    }

    fn heart(self) -> Surface {
        Box::new(move |u, v| {
            let (angle, radius) = (u * std::f64::consts::TAU, v.sqrt());
            let size = 0.24 * self.radius_mm;
            let dots = (angle * 8.0 + radius * 30.0).sin() * (radius * 14.0).cos();
            let colour = if dots > 0.1 { [1.0, 0.62, 0.05] } else { [1.0, 0.88, 0.2] };
            let place = [
                size * radius * angle.cos(),
                size * radius * angle.sin(),
                size * (0.9 - 0.7 * radius * radius),
            ];
            Some((moved(place, self.middle), colour))
        })
    }
}

/// The middle of a stem, `part` of the way from the ground to the flower.
fn on_stem(flower: Vector, foot_mm: f64, part: f64) -> Vector {
    let bend = 1.3 * (std::f64::consts::PI * part).sin();
    [
        foot_mm + (flower[0] - foot_mm) * part.powf(1.6) + bend,
        -17.2 + (flower[1] + 17.2) * part,
        flower[2] - 0.9 + 0.8 * (part - 1.0),
    ]
}

fn stem(flower: Vector, foot_mm: f64) -> Surface {
    Box::new(move |u, v| {
        let angle = v * std::f64::consts::TAU;
        let round = [0.33 * angle.cos(), 0.0, 0.33 * angle.sin()];
        Some((moved(round, on_stem(flower, foot_mm, 0.97 * u)), [0.1, 0.62 + 0.2 * angle.sin(), 0.12]))
    })
}

fn leaf(flower: Vector, foot_mm: f64) -> Surface {
    Box::new(move |u, v| {
        let side = if foot_mm < 0.0 { 1.0 } else { -1.0 };
        let across = 2.0 * v - 1.0;
        let width = 1.15 * (std::f64::consts::PI * u).sin();
        let place = [
            side * (5.4 * u + 0.5 * across * width),
            3.6 * u - 1.8 * u * u + across * width,
            1.6 * (std::f64::consts::PI * u).sin() - 0.8 * across * across,
        ];
        let vein =
            if across.abs() < 0.09 || (u * 9.0 - across.abs()).fract().abs() < 0.12 { 0.55 } else { 1.0 };
        let green = [0.2, 0.85, 0.15].map(|value| value * vein);
        Some((moved(place, on_stem(flower, foot_mm, 0.2)), green))
    })
}

#[derive(Clone, Copy)]
struct Butterfly {
    middle: Vector,
    wing_mm: f64,
    /// Where it flies to, to the left of up.
    heading_deg: f64,
    /// How far the wings rise toward the viewer.
    fold_deg: f64,
    inner: Colour,
    outer: Colour,
    edge: Colour,
    spots: Colour,
}

impl Butterfly {
    fn wings(self, side: f64) -> Surface {
        Box::new(move |u, v| {
            let (out, ahead) = (1.15 * u, 1.75 * v - 0.85);
            // The fore wing, and the hind wing behind it.
            let fore = ellipse([out, ahead], [0.56, 0.40], [0.60, 0.31], 33.0);
            let hind = ellipse([out, ahead], [0.40, -0.26], [0.43, 0.40], -35.0);
            let depth = fore.max(hind);
            if depth < 0.0 {
                return None;
            }
            let vein = ((ahead - 0.05).atan2(out + 0.05) * 13.0).sin().abs() < 0.13 && out > 0.2;
            let border = depth < 0.26;
            let rim = ((ahead * 9.0).sin() * (out * 9.0).cos()) > 0.45 && (0.07..0.2).contains(&depth);
            let colour = match (border, rim, vein) {
                (true, true, _) => self.spots,
                (true, false, _) | (false, _, true) => self.edge,
                _ => mixed(self.inner, self.outer, (out * 1.1).min(1.0)),
            };
            let fold = (self.fold_deg + 10.0 * out).to_radians();
            let place = [side * out * fold.cos(), ahead, out * fold.sin()];
            Some((self.placed(place), colour))
        })
    }

    fn body(self) -> Surface {
        Box::new(move |u, v| {
            let angle = v * std::f64::consts::TAU;
            let thick = 0.075 * (std::f64::consts::PI * (0.06 + 0.9 * u)).sin().powf(0.5);
            let stripe = if (u * 9.0).fract() < 0.3 { 0.6 } else { 1.0 };
            let place = [thick * angle.cos(), 0.95 * u - 0.5, 0.04 + thick * angle.sin()];
            Some((self.placed(place), [0.62, 0.36, 0.2].map(|value| value * stripe)))
        })
    }

    fn feelers(self) -> Surface {
        Box::new(move |u, v| {
            let side = if v < 0.5 { -1.0 } else { 1.0 };
            let thick = if u > 0.9 { 0.035 } else { 0.014 };
            let angle = 2.0 * v * std::f64::consts::TAU;
            let place = [
                side * (0.03 + 0.3 * u * u) + thick * angle.cos(),
                0.45 + 0.5 * u,
                0.06 + 0.2 * u + thick * angle.sin(),
            ];
            Some((self.placed(place), [0.75, 0.5, 0.25]))
        })
    }

    /// From wing lengths about the body's middle to the meadow.
    fn placed(&self, [x, y, z]: Vector) -> Vector {
        let (sine, cosine) = self.heading_deg.to_radians().sin_cos();
        let turned = [x * cosine - y * sine, x * sine + y * cosine, z];
        moved(turned.map(|value| value * self.wing_mm), self.middle)
    }
}

/// How deep a place lies in an ellipse: 1 in its middle, 0 at its edge, less outside.
fn ellipse([x, y]: [f64; 2], middle: [f64; 2], radii: [f64; 2], turn_deg: f64) -> f64 {
    let (sine, cosine) = turn_deg.to_radians().sin_cos();
    let (dx, dy) = (x - middle[0], y - middle[1]);
    let (along, across) = ((dx * cosine + dy * sine) / radii[0], (dy * cosine - dx * sine) / radii[1]);
    1.0 - (along * along + across * across).sqrt()
}

fn mixed(from: Colour, to: Colour, part: f64) -> Colour {
    [0, 1, 2].map(|channel| from[channel] + part * (to[channel] - from[channel]))
}

fn moved(place: Vector, by: Vector) -> Vector {
    [0, 1, 2].map(|axis| place[axis] + by[axis])
}
