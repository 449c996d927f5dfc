//! The pedestal: light everywhere, from which the optimiser can take away where views disagree.

use super::request::Tone;
use crate::picture::Picture;

/// Returns the pattern (code values) with its black lifted by `pedestal`, 0 or greater, in the values in which films
/// add up: T becomes (T + p) / (1 + p), so that white stays white and the contrast falls to (1 + p) / p.
pub fn lifted(pattern: &Picture, pedestal: f64, tone: Tone) -> Picture {
    if pedestal == 0.0 {
        return pattern.clone();
    }
    let pedestal = pedestal as f32;
    let lift = |value: f32| (value + pedestal) / (1.0 + pedestal);
    match tone {
        Tone::Code => pattern.map(lift),
        Tone::Linear => pattern.decoded().map(lift).encoded(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_is_lifted_in_the_values_that_add_up_and_white_stays() {
        let pattern = Picture::from_values(2, 1, [0.0, 1.0].repeat(3)).unwrap();
        let black = |tone| lifted(&pattern, 0.25, tone).values()[0];
        assert!((black(Tone::Code) - 0.2).abs() < 1e-6);
        assert!((crate::picture::srgb_decode(black(Tone::Linear)) - 0.2).abs() < 1e-5);
        assert!((lifted(&pattern, 0.25, Tone::Linear).values()[1] - 1.0).abs() < 1e-6);
        assert_eq!(lifted(&pattern, 0.0, Tone::Linear), pattern);
    }
}
