//! ams OSRAM AS7331, the sensor that watches the lamps' ultraviolet, at 0x74.
//!
//! Only its UVA channel (315-410 nm, peak 360 nm) is used, in continuous mode at gain 16 and 64 ms. The full-scale range
//! at gain 1 is 348,160 µW/cm² over 65,536 clocks (data sheet DS001047, 7.4), so that one count is 3.3203125 mW/m² and
//! full scale 217 W/m²: four times what the hardware lets a lamp give. The 385 counts a µW/cm² at gain
//! 2,048 of a published driver agree with that scale to 0.2 %.
//!
//! Its own temperature stands for the enclosure's air, in which it hangs: 0.05 °C a count of 12 bits from -66.9 °C on. The
//! data sheet's section on it was not read: SparkFun's, Adafruit's and Tlera's drivers reckon so, and the first two give
//! 0x922 = 50 °C as the data sheet's example. By Adafruit's notes on the data sheet (v4-00) it is good to 10 K only: it
//! guards against a blocked vent, not against a few degrees.

use embedded_hal_async::i2c::I2c;
use vitrine_exhibit::units::CentiCelsius;

/// The sensor's bus address with both address pins low.
pub const ADDRESS: u8 = 0x74;

const OPERATIONAL_STATE: u8 = 0x00;
const IDENTITY: u8 = 0x02;
const GAIN_AND_TIME: u8 = 0x06;
const MODE_AND_CLOCK: u8 = 0x08;

const AS7331_IDENTITY: u8 = 0x21;
const CONFIGURE: u8 = 0x02;
const MEASURE_AND_START: u8 = 0x83;
/// Gain 2^(11 - 7) = 16, conversion time 2^6 = 64 ms.
const GAIN_16_TIME_64_MS: u8 = 0x76;
/// Continuous, 1.024 MHz.
const CONTINUOUS: u8 = 0x00;

/// Bits of the status byte: converter overdriven, result register overflowed.
const OVERFLOW: u8 = 0x60;

/// Why there is no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UvError<E> {
    /// The bus failed, or the sensor did not answer.
    Bus(E),
    /// Another device answers at the address, with this identity.
    Identity(u8),
}

/// What the sensor says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// UVA irradiance in mW/m²; full scale where the sensor is overdriven.
    pub irradiance_mw_m2: u32,
    /// Its own temperature, that is, the air's in the enclosure.
    pub air: CentiCelsius,
}

/// Sets continuous measurement; readings are good 70 ms later.
///
/// # Errors
/// What the bus reports, or a device that is no AS7331.
pub async fn set_up<Bus: I2c>(bus: &mut Bus) -> Result<(), UvError<Bus::Error>> {
    bus.write(ADDRESS, &[OPERATIONAL_STATE, CONFIGURE]).await.map_err(UvError::Bus)?;
    let mut identity = [0];
    bus.write_read(ADDRESS, &[IDENTITY], &mut identity).await.map_err(UvError::Bus)?;
    if identity != [AS7331_IDENTITY] {
        return Err(UvError::Identity(u8::from_le_bytes(identity)));
    }
    for setting in [
        [GAIN_AND_TIME, GAIN_16_TIME_64_MS],
        [MODE_AND_CLOCK, CONTINUOUS],
        [OPERATIONAL_STATE, MEASURE_AND_START],
    ] {
        bus.write(ADDRESS, &setting).await.map_err(UvError::Bus)?;
    }
    Ok(())
}

/// Reads irradiance and temperature. A sensor that is overdriven reads its full scale: brighter than anything allowed.
///
/// # Errors
/// What the bus reports.
pub async fn read<Bus: I2c>(bus: &mut Bus) -> Result<Reading, UvError<Bus::Error>> {
    let mut registers = [0; 6];
    bus.write_read(ADDRESS, &[OPERATIONAL_STATE], &mut registers).await.map_err(UvError::Bus)?;
    let [_, status, air_low, air_high, low, high] = registers;
    let counts = if status & OVERFLOW == 0 { u16::from_le_bytes([low, high]) } else { u16::MAX };
    Ok(Reading {
        irradiance_mw_m2: milliwatts_per_square_metre(counts),
        air: temperature(u16::from_le_bytes([air_low, air_high])),
    })
}

/// Gives the temperature of a count of 12 bits.
fn temperature(counts: u16) -> CentiCelsius {
    let centi_degrees = i32::from(counts & 0x0fff) * 5 - 6_690;
    CentiCelsius(i16::try_from(centi_degrees).unwrap_or(i16::MAX))
}

/// Gives the irradiance of a count at gain 16 and 64 ms: 348,160 / 16 / 65,536 µW/cm² is 425 / 128 mW/m².
fn milliwatts_per_square_metre(counts: u16) -> u32 {
    u32::from(counts) * 425 / 128
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bus::{block_on, broken, nack};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
    extern crate std;
    use std::vec;

    #[test]
    fn sets_up_and_reads() {
        let mut bus = Mock::new(&[
            Transaction::write(0x74, vec![0x00, 0x02]),
            Transaction::write_read(0x74, vec![0x02], vec![0x21]),
            Transaction::write(0x74, vec![0x06, 0x76]),
            Transaction::write(0x74, vec![0x08, 0x00]),
            Transaction::write(0x74, vec![0x00, 0x83]),
            Transaction::write_read(0x74, vec![0x00], vec![0x83, 0x08, 0x32, 0x07, 0x00, 0x0c]),
        ]);
        block_on(set_up(&mut bus)).unwrap();
        let reading = Reading { irradiance_mw_m2: 10_200, air: CentiCelsius(2_520) };
        assert_eq!(block_on(read(&mut bus)), Ok(reading));
        bus.done();
    }

    #[test]
    fn the_count_follows_the_data_sheet() {
        assert_eq!(milliwatts_per_square_metre(0), 0);
        // Full scale: 348,160 µW/cm² / 16 = 21,760 µW/cm² = 217.6 W/m², less one count.
        assert_eq!(milliwatts_per_square_metre(u16::MAX), 217_596);
    }

    #[test]
    fn the_temperature_follows_the_published_example() {
        assert_eq!(temperature(0x922), CentiCelsius(5_000));
        assert_eq!(temperature(0xf922), CentiCelsius(5_000));
        assert_eq!(temperature(0), CentiCelsius(-6_690));
    }

    #[test]
    fn faults_are_told_apart() {
        let mut bus = Mock::new(&[
            Transaction::write(0x74, vec![0x00, 0x02]),
            Transaction::write_read(0x74, vec![0x02], vec![0x00]),
            Transaction::write(0x74, vec![0x00, 0x02]).with_error(nack()),
            Transaction::write_read(0x74, vec![0x00], vec![0x83, 0x20, 0, 0, 0, 0]),
            Transaction::write_read(0x74, vec![0x00], vec![0; 6]).with_error(broken()),
        ]);
        assert_eq!(block_on(set_up(&mut bus)), Err(UvError::Identity(0)));
        assert_eq!(block_on(set_up(&mut bus)), Err(UvError::Bus(nack())));
        assert_eq!(block_on(read(&mut bus)).map(|reading| reading.irradiance_mw_m2), Ok(217_596));
        assert_eq!(block_on(read(&mut bus)), Err(UvError::Bus(broken())));
        bus.done();
    }
}
