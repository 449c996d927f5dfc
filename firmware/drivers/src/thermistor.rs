//! Temperature of a heat sink from an NTC below a resistor of its own nominal value.
//!
//! With the NTC's nominal resistance at 25 °C also above it, the converter's reading r of full scale f gives
//! R/R0 = r / (f - r), and the beta equation 1/T = 1/T0 + ln(R/R0)/beta gives the temperature. All in integers: a
//! logarithm of 16 fractional bits is good to 0.01 °C.

/// A temperature in hundredths of a degree Celsius.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CentiCelsius(pub i16);

/// Why there is no temperature: both cut the lamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorFault {
    /// The reading is at full scale: the wire is broken or the sensor missing.
    Open,
    /// The reading is near zero: the wires touch.
    Shorted,
}

/// Converter steps of full scale.
const FULL_SCALE: i32 = 4095;

/// An NTC of 10 kΩ is beyond -50 °C above this reading: nothing a lamp's heat sink reaches.
const OPEN_ABOVE: u16 = 4055;

/// An NTC of 10 kΩ is beyond 170 °C below this reading.
const SHORTED_BELOW: u16 = 40;

/// 25 °C in hundredths of a kelvin, where an NTC has its nominal resistance.
const NOMINAL_CENTIKELVIN: i64 = 29_815;

/// 0 °C in hundredths of a kelvin.
const FREEZING_CENTIKELVIN: i64 = 27_315;

/// Gives the temperature for a 12-bit reading and the NTC's beta in kelvin (1,000 to 10,000).
///
/// # Errors
/// [`SensorFault`] for a reading that only a broken sensor gives.
pub fn temperature(reading: u16, beta_kelvin: u16) -> Result<CentiCelsius, SensorFault> {
    if reading > OPEN_ABOVE {
        return Err(SensorFault::Open);
    }
    if reading < SHORTED_BELOW {
        return Err(SensorFault::Shorted);
    }
    let above = u32::try_from(FULL_SCALE - i32::from(reading)).unwrap_or(1);
    let ratio = natural_logarithm(u32::from(reading)) - natural_logarithm(above);
    let beta = i64::from(beta_kelvin.clamp(1_000, 10_000));
    // T = beta T0 / (beta + T0 ln(R/R0)), with T0 in kelvin and the logarithm in 1/65,536.
    let numerator = beta * NOMINAL_CENTIKELVIN * 100 * 65_536;
    let denominator = beta * 100 * 65_536 + NOMINAL_CENTIKELVIN * i64::from(ratio);
    let centikelvin = if denominator > 0 { numerator / denominator } else { i64::MAX };
    let centicelsius = centikelvin.saturating_sub(FREEZING_CENTIKELVIN);
    Ok(CentiCelsius(i16::try_from(centicelsius).unwrap_or(i16::MAX)))
}

/// Gives the natural logarithm of a number from 1 in 1/65,536, by squaring the mantissa bit for bit.
fn natural_logarithm(value: u32) -> i32 {
    const LN_2_IN_65536THS: i64 = 45_426;
    let whole = 31 - value.max(1).leading_zeros();
    // The mantissa in 1.0..2.0 with 31 fractional bits.
    let mut mantissa = u64::from(value.max(1)) << (31 - whole);
    let mut logarithm = i64::from(whole);
    for _ in 0..16 {
        mantissa = (mantissa * mantissa) >> 31;
        let bit = mantissa >> 32;
        mantissa >>= bit;
        logarithm = logarithm * 2 + i64::from(bit == 1);
    }
    i32::try_from((logarithm * LN_2_IN_65536THS) >> 16).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    fn by_floats(reading: u16, beta: f64) -> f64 {
        let ratio = f64::from(reading) / (4095.0 - f64::from(reading));
        1.0 / (1.0 / 298.15 + ratio.ln() / beta) - 273.15
    }

    #[test]
    fn agrees_with_the_beta_equation() {
        for beta in [3380_u16, 3435, 3950] {
            for reading in 100..=4000 {
                let exact = by_floats(reading, f64::from(beta));
                let CentiCelsius(got) = temperature(reading, beta).unwrap();
                assert!((f64::from(got) / 100.0 - exact).abs() < 0.03, "{reading} {beta}: {got} {exact}");
            }
        }
    }

    #[test]
    fn half_scale_is_the_nominal_temperature() {
        let CentiCelsius(got) = temperature(2048, 3950).unwrap();
        assert!((2495..=2500).contains(&got), "{got}");
    }

    #[test]
    fn broken_sensors_are_faults() {
        assert_eq!(temperature(4095, 3950), Err(SensorFault::Open));
        assert_eq!(temperature(u16::MAX, 3950), Err(SensorFault::Open));
        assert_eq!(temperature(0, 3950), Err(SensorFault::Shorted));
    }

    #[test]
    fn no_setting_makes_it_panic() {
        for reading in (0..=u16::MAX).step_by(7) {
            for beta in [0, 1, 999, 1_000, 10_000, u16::MAX] {
                let _ = temperature(reading, beta);
            }
        }
    }
}
