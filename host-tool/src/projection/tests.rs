use super::*;
use crate::optics::{LampPair, film_weights};
use proptest::prelude::*;

/// Sums over films, pixel by pixel, as the module's first lines say, in double precision.
fn oracle(
    volume: &Volume,
    stack: &Stack,
    direction: Direction,
    distance: ViewerDistance,
    weights: &[f64],
) -> Vec<f64> {
    let (width, height) = (stack.width_px, stack.height_px);
    let (s, t) = direction.slope(stack.index);
    let pixel = stack.pixel_mm();
    let (cx, cy) = ((width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0);
    let mut picture = Vec::new();
    for channel in 0..CHANNELS {
        for j in 0..height {
            for i in 0..width {
                let (u, v) = ((i as f64 - cx) * pixel, (cy - j as f64) * pixel);
                let sum = (0..stack.films).map(|k| {
                    let z = stack.film_z_mm(k);
                    let (x, y) = match distance {
                        ViewerDistance::Parallel => (u + z * s, v + z * t),
                        ViewerDistance::Millimetres(d) => {
                            let eye_z = d / (1.0 + s * s + t * t).sqrt();
                            // From the eye through (u, v, 0) to the height z.
                            (u + (s * eye_z - u) * z / eye_z, v + (t * eye_z - v) * z / eye_z)
                        }
                    };
                    weights[k]
                        * sample(volume.film(channel, k), width, height, x / pixel + cx, cy - y / pixel)
                });
                picture.push(sum.sum());
            }
        }
    }
    picture
}

fn sample(film: &[f32], width: usize, height: usize, column: f64, row: f64) -> f64 {
    let inside = |at: f64, len: usize| at >= -1e-7 && at <= len as f64 - 1.0 + 1e-7;
    if !inside(column, width) || !inside(row, height) {
        return 0.0;
    }
    let mut sum = 0.0;
    for (r, wr) in [(row.floor(), 1.0 - row + row.floor()), (row.floor() + 1.0, row - row.floor())] {
        for (c, wc) in
            [(column.floor(), 1.0 - column + column.floor()), (column.floor() + 1.0, column - column.floor())]
        {
            let (r, c) =
                (r.clamp(0.0, height as f64 - 1.0) as usize, c.clamp(0.0, width as f64 - 1.0) as usize);
            sum += wr * wc * f64::from(film[r * width + c]);
        }
    }
    sum
}

/// Numbers in 0..1 that follow from `seed`.
fn noise(seed: u64, len: usize) -> Vec<f32> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    (0..len)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        })
        .collect()
}

fn any_distance() -> impl Strategy<Value = ViewerDistance> {
    prop_oneof![Just(ViewerDistance::Parallel), (60.0..2000.0f64).prop_map(ViewerDistance::Millimetres)]
}

prop_compose! {
    fn any_stack()(films in 1usize..6, width in 2usize..40, height in 2usize..20, pitch in 0.1..3.0f64,
                   index in prop_oneof![Just(1.0), 1.0..1.7f64]) -> Stack {
        Stack { films, width_px: width, height_px: height, spacer_mm: pitch, index, ..Stack::default() }
    }
}

proptest! {
    #[test]
    fn projection_is_the_sum_over_films(stack in any_stack(), distance in any_distance(),
                                        h in -50.0..50.0f64, v in -50.0..50.0f64, seed in any::<u64>()) {
        let direction = Direction::new(h, v);
        let weights = film_weights(&stack, direction, LampPair::new(1.0, 0.3));
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        let values = noise(seed, volume.values().len());
        volume.values_mut().copy_from_slice(&values);
        let picture = project(&volume, &stack, direction, distance, &weights);
        let expected = oracle(&volume, &stack, direction, distance, &weights);
        for (value, expected) in picture.values().iter().zip(expected) {
            prop_assert!((f64::from(*value) - expected).abs() < 1e-4, "{} {}", value, expected);
        }
    }

    #[test]
    fn back_projection_is_the_exact_transpose(stack in any_stack(), distance in any_distance(),
                                              h in prop_oneof![Just(0.0), -50.0..50.0f64],
                                              v in prop_oneof![Just(0.0), -50.0..50.0f64], seed in any::<u64>()) {
        let direction = Direction::new(h, v);
        let weights = film_weights(&stack, direction, LampPair::new(0.4, 1.0));
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        let values = noise(seed, volume.values().len());
        volume.values_mut().copy_from_slice(&values);
        let mut picture = Picture::new(stack.width_px, stack.height_px);
        let values = noise(seed ^ 77, picture.values().len());
        picture.values_mut().copy_from_slice(&values);
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(&x, &y)| f64::from(x) * f64::from(y)).sum::<f64>();
        let forward = dot(project(&volume, &stack, direction, distance, &weights).values(), picture.values());
        let back = dot(volume.values(), back_project(&picture, &stack, direction, distance, &weights).values());
        prop_assert!((forward - back).abs() <= 1e-5 * forward.abs().max(1e-3), "{} {}", forward, back);
    }

    #[test]
    fn lines_agree_with_planes(width in 3usize..40, h in -40.0..40.0f64, seed in any::<u64>()) {
        let stack = Stack { films: 4, width_px: width, height_px: 2, ..Stack::default() };
        let rays = Rays::new(&stack, Direction::new(h, 0.0), ViewerDistance::Parallel);
        prop_assert!(rays.rows_are_apart());
        let lines = noise(seed, 4 * width);
        let planes: Vec<f32> = lines.chunks(width).flat_map(|line| [line, line].concat()).collect();
        let weights = [1.0, 0.5, 0.25, 0.125];
        let (mut picture, mut line) = (vec![0.0; 2 * width], vec![0.0; width]);
        rays.project(&planes, &weights, &mut picture);
        for (film, (films, &weight)) in lines.chunks(width).zip(&weights).enumerate() {
            rays.project_film_line(film, films, weight, &mut line);
        }
        prop_assert_eq!(&picture[..width], &line[..]);
        prop_assert_eq!(&picture[width..], &line[..]);
    }
}

#[test]
fn a_viewer_to_the_right_sees_the_top_film_moved_left() {
    let stack = Stack {
        films: 3,
        width_px: 101,
        height_px: 5,
        width_mm: 101.0,
        film_mm: 1.0,
        spacer_mm: 9.0,
        ..Stack::default()
    };
    let mut volume = Volume::new(3, 5, 101);
    volume.film_mut(0, 0)[2 * 101 + 50] = 1.0;
    let picture = project(&volume, &stack, Direction::new(45.0, 0.0), ViewerDistance::Parallel, &[1.0; 3]);
    assert_eq!(picture.channel(0)[2 * 101 + 40], 1.0);
}

#[test]
fn a_viewer_above_sees_the_top_film_moved_down() {
    let stack = Stack {
        films: 3,
        width_px: 5,
        height_px: 101,
        width_mm: 5.0,
        film_mm: 1.0,
        spacer_mm: 9.0,
        ..Stack::default()
    };
    let mut volume = Volume::new(3, 101, 5);
    volume.film_mut(1, 0)[50 * 5 + 2] = 1.0;
    let picture = project(&volume, &stack, Direction::new(0.0, 45.0), ViewerDistance::Parallel, &[1.0; 3]);
    assert_eq!(picture.channel(1)[60 * 5 + 2], 1.0);
}

#[test]
fn a_misplaced_film_moves_with_its_shift() {
    let stack = Stack { films: 1, width_px: 11, height_px: 11, width_mm: 11.0, ..Stack::default() };
    let mut volume = Volume::new(1, 11, 11);
    volume.film_mut(0, 0)[5 * 11 + 5] = 1.0;
    let rays = Rays::misplaced(&stack, Direction::default(), ViewerDistance::Parallel, &[(2.0, 3.0)]);
    let picture = project_along(&volume, &rays, &[1.0]);
    assert_eq!(picture.channel(0)[2 * 11 + 7], 1.0);
}
