//! Ink in 16 bits: half the memory, and as near as any film is written.

/// Full ink.
const FULL: f32 = 65_535.0;

/// Numbers from here to twice this lie 1 / 65,536 apart, so that the last 16 bits of one tell how far it is from here.
const ANCHOR: f32 = 128.0;

/// The ink in 0..=1 as a part of 65,535, rounded to the nearest.
#[inline(always)]
pub(super) fn to_sixteen_bits(ink: f32) -> u16 {
    (ink * (FULL / (FULL + 1.0)) + ANCHOR).to_bits() as u16
}

/// The ink that 16 bits stand for, 0..=1.
#[inline(always)]
pub(super) fn from_sixteen_bits(bits: u16) -> f32 {
    f32::from(bits) * (1.0 / FULL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sixteen_bits_come_back_and_all_else_is_rounded_to_the_nearest() {
        for bits in 0..=u16::MAX {
            let ink = from_sixteen_bits(bits);
            assert!((0.0..=1.0).contains(&ink));
            assert_eq!(to_sixteen_bits(ink), bits);
            for beside in [-0.49, 0.49] {
                let ink = (f32::from(bits) + beside) / FULL;
                assert_eq!(to_sixteen_bits(ink.clamp(0.0, 1.0)), bits, "{bits} {beside}");
            }
        }
    }
}
