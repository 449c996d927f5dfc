//! The lamps' supply voltage through its divider.

/// Converter steps of full scale.
const FULL_SCALE: u32 = 4095;

/// The converter's reference in millivolts.
const REFERENCE_MILLIVOLTS: u32 = 3_300;

/// Gives the supply in millivolts for a 12-bit reading behind a divider, in thousandths; a reading beyond full scale counts
/// as full scale. 100 kΩ over 10 kΩ (hardware/wiring.md) is 11,000.
pub fn millivolts(reading: u16, divider_permille: u16) -> u16 {
    let steps = u32::from(reading).min(FULL_SCALE);
    // At most 4,095 steps of 3,300 mV; the divider's thousandths go last, so that nothing leaves 64 bits.
    let scaled = u64::from(steps * REFERENCE_MILLIVOLTS) * u64::from(divider_permille);
    let full_scale = u64::from(FULL_SCALE) * 1_000;
    u16::try_from((scaled + full_scale / 2) / full_scale).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::millivolts;

    #[test]
    fn scales_by_the_divider() {
        assert_eq!(millivolts(0, 11_000), 0);
        assert_eq!(millivolts(4095, 11_000), 36_300);
        assert_eq!(millivolts(u16::MAX, 11_000), 36_300);
        assert!(millivolts(2707, 11_000).abs_diff(24_000) < 10);
        assert_eq!(millivolts(4095, 11_050), 36_465);
        assert_eq!(millivolts(u16::MAX, u16::MAX), u16::MAX);
    }
}
