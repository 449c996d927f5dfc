//! Trigonometry in hundredths of a degree, without floating point.

/// A radian in hundredths of a degree.
pub(crate) const RADIAN: i32 = 5_730;

/// The cosine of an angle of -90 to 90 degrees, as a part of 32,768.
///
/// Bhaskara I's approximation (7th century), within 0.0017: `(32400 - 4 d²) / (32400 + d²)` for `d` degrees.
pub(crate) fn cosine(angle: i32) -> i32 {
    let angle = i64::from(angle.clamp(-9_000, 9_000));
    let square = angle * angle;
    ((324_000_000 - 4 * square) * 32_768 / (324_000_000 + square)) as i32
}

/// The angle whose tangent is `y / x` in the half plane of positive `x`, in hundredths of a degree.
///
/// Rajan et al., IEEE Signal Processing Magazine 23(3), 2006: `π/4 z - z (|z| - 1) (0.2447 + 0.0663 |z|)`, within
/// 0.0015 rad for |z| up to 1; beyond that by the complement.
pub(crate) fn arc_tangent(y: i32, x: i32) -> i32 {
    let (x, height) = (i64::from(x.max(0)), i64::from(y).abs());
    if x == 0 && height == 0 {
        return 0;
    }
    let steep = height > x;
    let (part, whole) = if steep { (x, height) } else { (height, x) };
    let z = part * 32_768 / whole;
    // The factors of the formula in hundredths of a degree.
    let bend = 14_020 + 3_799 * z / 32_768;
    let angle = (45_000 * z + bend * (z * (32_768 - z) / 32_768)) / 32_768 / 10;
    let angle = if steep { 9_000 - angle } else { angle } as i32;
    if y < 0 { -angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosines_are_within_two_thousandths() {
        for angle in (-9_000..=9_000_i32).step_by(if cfg!(miri) { 100 } else { 1 }) {
            let exact = (f64::from(angle) / 100.0).to_radians().cos();
            assert!((f64::from(cosine(angle)) / 32_768.0 - exact).abs() < 0.002, "{angle}");
        }
    }

    #[test]
    fn arc_tangents_are_within_a_tenth_of_a_degree() {
        for y in (-3_000..=3_000_i32).step_by(if cfg!(miri) { 100 } else { 1 }) {
            for x in [0, 1, 37, 600, 2_999, 30_000] {
                let exact = f64::from(y).atan2(f64::from(x)).to_degrees();
                assert!((f64::from(arc_tangent(y, x)) / 100.0 - exact).abs() < 0.1, "{y} {x}");
            }
        }
    }
}
