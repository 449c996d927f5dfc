//! NXP PCF8563, the clock that runs on its own battery, at 0x51.
//!
//! Seconds to years lie in registers 0x02 to 0x08 as binary-coded decimals. Bit 7 of the seconds says that the
//! oscillator stopped: the time is then not to be trusted until it is set (data sheet rev. 11, 8.4). The clock is kept
//! in UTC; years are 2000 to 2099.

use embedded_hal_async::i2c::I2c;

/// The clock's bus address.
pub const ADDRESS: u8 = 0x51;

const CONTROL_1: u8 = 0x00;
const SECONDS: u8 = 0x02;
const VOLTAGE_LOW: u8 = 0x80;

/// Seconds from 1970-01-01 to 2000-01-01.
const YEAR_2000: i64 = 946_684_800;

const SECONDS_A_DAY: i64 = 86_400;

/// Days from 2000-01-01 to 2100-01-01.
const DAYS_OF_THE_CENTURY: i64 = 36_525;

/// Why there is no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockError<E> {
    /// The bus failed, or the clock did not answer.
    Bus(E),
    /// The oscillator stopped since the clock was set: its battery was empty or out.
    Stopped,
    /// The registers hold no date.
    NoDate,
    /// The time to set lies outside 2000 to 2099.
    OutOfRange,
}

/// Reads the time: whole seconds since 1970-01-01T00:00:00 UTC.
///
/// # Errors
/// Why the time cannot be trusted.
pub async fn read<Bus: I2c>(bus: &mut Bus) -> Result<i64, ClockError<Bus::Error>> {
    let mut registers = [0; 7];
    bus.write_read(ADDRESS, &[SECONDS], &mut registers).await.map_err(ClockError::Bus)?;
    let [seconds, minutes, hours, day, _, month, year] = registers;
    if seconds & VOLTAGE_LOW != 0 {
        return Err(ClockError::Stopped);
    }
    let fields = [
        decimal(seconds, 0x7f, 0..=59),
        decimal(minutes, 0x7f, 0..=59),
        decimal(hours, 0x3f, 0..=23),
        decimal(day, 0x3f, 1..=31),
        decimal(month, 0x1f, 1..=12),
        decimal(year, 0xff, 0..=99),
    ];
    let [Some(seconds), Some(minutes), Some(hours), Some(day), Some(month), Some(year)] = fields else {
        return Err(ClockError::NoDate);
    };
    let Some(days) = days_since_2000(year, month, day) else { return Err(ClockError::NoDate) };
    Ok(YEAR_2000 + days * SECONDS_A_DAY + hours * 3_600 + minutes * 60 + seconds)
}

/// Sets the time, whole seconds since 1970-01-01T00:00:00 UTC, and starts the clock.
///
/// # Errors
/// [`ClockError::OutOfRange`] outside 2000 to 2099, or what the bus reports.
pub async fn set<Bus: I2c>(bus: &mut Bus, utc_seconds: i64) -> Result<(), ClockError<Bus::Error>> {
    let since_2000 = utc_seconds - YEAR_2000;
    let days = since_2000.div_euclid(SECONDS_A_DAY);
    let second_of_day = since_2000.rem_euclid(SECONDS_A_DAY);
    let Some((year, month, day)) = date_since_2000(days) else { return Err(ClockError::OutOfRange) };
    // 2000-01-01 was a Saturday, day 6 of the clock's week.
    let weekday = (days + 6).rem_euclid(7);
    let registers = [
        SECONDS,
        binary_coded(second_of_day % 60),
        binary_coded(second_of_day / 60 % 60),
        binary_coded(second_of_day / 3_600),
        binary_coded(day),
        binary_coded(weekday),
        binary_coded(month),
        binary_coded(year),
    ];
    bus.write(ADDRESS, &[CONTROL_1, 0x00, 0x00]).await.map_err(ClockError::Bus)?;
    bus.write(ADDRESS, &registers).await.map_err(ClockError::Bus)
}

fn decimal(register: u8, mask: u8, range: core::ops::RangeInclusive<i64>) -> Option<i64> {
    let (tens, units) = ((register & mask) >> 4, register & mask & 0x0f);
    let value = i64::from(tens) * 10 + i64::from(units);
    (units <= 9 && tens <= 9 && range.contains(&value)).then_some(value)
}

fn binary_coded(value: i64) -> u8 {
    let value = u8::try_from(value.rem_euclid(100)).unwrap_or(0);
    (value / 10) << 4 | (value % 10)
}

fn is_leap(year: i64) -> bool {
    year % 4 == 0
}

fn days_of_month(year: i64, month: i64) -> i64 {
    match month {
        4 | 6 | 9 | 11 => 30,
        2 if is_leap(year) => 29,
        2 => 28,
        _ => 31,
    }
}

/// Gives the days from 2000-01-01 for a year of the century, or none for a day that the month does not have.
fn days_since_2000(year: i64, month: i64, day: i64) -> Option<i64> {
    let before_this_year = year * 365 + (year + 3) / 4;
    let before_this_month: i64 = (1..month).map(|earlier| days_of_month(year, earlier)).sum();
    (day <= days_of_month(year, month)).then_some(before_this_year + before_this_month + day - 1)
}

fn date_since_2000(days: i64) -> Option<(i64, i64, i64)> {
    if !(0..DAYS_OF_THE_CENTURY).contains(&days) {
        return None;
    }
    let (mut year, mut month, mut left) = (0, 1, days);
    while left >= 365 + i64::from(is_leap(year)) {
        left -= 365 + i64::from(is_leap(year));
        year += 1;
    }
    while left >= days_of_month(year, month) {
        left -= days_of_month(year, month);
        month += 1;
    }
    Some((year, month, left + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bus::{block_on, nack};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
    extern crate std;
    use std::vec;
    use std::vec::Vec;

    fn read_registers(registers: Vec<u8>) -> Result<i64, ClockError<embedded_hal::i2c::ErrorKind>> {
        let mut bus = Mock::new(&[Transaction::write_read(0x51, vec![0x02], registers)]);
        let time = block_on(read(&mut bus));
        bus.done();
        time
    }

    #[test]
    fn reads_a_known_moment() {
        // 2026-11-22T20:37:41Z, a Sunday; the unused bits of the registers are noise.
        let registers = vec![0x41, 0x37 | 0x80, 0x20 | 0xc0, 0x22 | 0x40, 0x00, 0x11 | 0x80, 0x26];
        assert_eq!(read_registers(registers), Ok(1_795_379_861));
    }

    #[test]
    fn a_stopped_clock_has_no_time() {
        assert_eq!(read_registers(vec![0x80, 0, 0, 1, 0, 1, 0]), Err(ClockError::Stopped));
    }

    #[test]
    fn what_is_no_date_is_refused() {
        assert_eq!(read_registers(vec![0, 0, 0, 0x30, 0, 0x02, 0x26]), Err(ClockError::NoDate));
        assert_eq!(read_registers(vec![0x5a, 0, 0, 0x01, 0, 0x02, 0x26]), Err(ClockError::NoDate));
        assert_eq!(read_registers(vec![0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]), Err(ClockError::NoDate));
    }

    #[test]
    fn every_day_of_the_century_survives_the_clock() {
        for day in 0..DAYS_OF_THE_CENTURY {
            let (year, month, day_of_month) = date_since_2000(day).unwrap();
            assert_eq!(days_since_2000(year, month, day_of_month), Some(day));
        }
        assert_eq!(date_since_2000(DAYS_OF_THE_CENTURY), None);
        assert_eq!(date_since_2000(-1), None);
    }

    #[test]
    fn sets_what_it_would_read() {
        let mut bus = Mock::new(&[
            Transaction::write(0x51, vec![0x00, 0x00, 0x00]),
            Transaction::write(0x51, vec![0x02, 0x41, 0x37, 0x20, 0x22, 0x00, 0x11, 0x26]),
        ]);
        block_on(set(&mut bus, 1_795_379_861)).unwrap();
        bus.done();
        let mut bus = Mock::new(&[]);
        assert_eq!(block_on(set(&mut bus, 0)), Err(ClockError::OutOfRange));
        bus.done();
    }

    #[test]
    fn a_missing_clock_is_an_error() {
        let mut bus = Mock::new(&[Transaction::write_read(0x51, vec![0x02], vec![0; 7]).with_error(nack())]);
        assert_eq!(block_on(read(&mut bus)), Err(ClockError::Bus(nack())));
        bus.done();
    }
}
