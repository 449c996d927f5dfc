//! The lamps' supply voltage through its divider.

/// Converter steps of full scale.
const FULL_SCALE: u32 = 4095;

/// The converter's reference in millivolts.
const REFERENCE_MILLIVOLTS: u32 = 3_300;

/// 100 kΩ over 10 kΩ (hardware/wiring.md).
const DIVIDER: u32 = 11;

/// Gives the supply in millivolts for a 12-bit reading; a reading beyond full scale counts as full scale.
pub fn millivolts(reading: u16) -> u16 {
    let steps = u32::from(reading).min(FULL_SCALE);
    let millivolts = (steps * REFERENCE_MILLIVOLTS * DIVIDER + FULL_SCALE / 2) / FULL_SCALE;
    u16::try_from(millivolts).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::millivolts;

    #[test]
    fn scales_by_the_divider() {
        assert_eq!(millivolts(0), 0);
        assert_eq!(millivolts(4095), 36_300);
        assert_eq!(millivolts(u16::MAX), 36_300);
        assert!(millivolts(2707).abs_diff(24_000) < 10);
    }
}
