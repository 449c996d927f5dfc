//! What the firmware holds to whatever a plan or a host says.
//!
//! Numbers for 365 nm. The unprotected eye may receive 10 kJ/m² in 8 hours (ICNIRP), which a window of optical
//! density 2 in front of the stack keeps a tenth of; the remaining numbers are the design values of this
//! reference exhibit. A plan may ask for less, never for more.

use crate::units::{CentiCelsius, CentiDegrees, Dose, Irradiance, Milliseconds, Millivolts};

/// The most irradiance of one lamp on its nearest film: 20 W/m². The driver's sense resistor bounds it at 50 W/m².
pub const CEILING: Irradiance = Irradiance(20_000);
/// The most irradiance a plan may state for a lamp at full level: the bound that the sense resistor sets.
pub const HARDWARE_CEILING: Irradiance = Irradiance(50_000);
/// The most dose of one lamp in a day before it falls to the idle floor: 30 kJ/m².
pub const DAILY_DOSE: Dose = Dose(30_000_000_000);
/// The most dose of one lamp in the life of a stack: 10 MJ/m². A placeholder until coupons have been exposed.
pub const LIFE_DOSE: Dose = Dose(10_000_000_000_000);
/// The longest time lit above the idle floor without a rest.
pub const CONTINUOUS: Milliseconds = Milliseconds(600_000);
/// The least rest after that time.
pub const REST: Milliseconds = Milliseconds(60_000);
/// The irradiance of the idle glow, also while resting and after the day's dose: 1 W/m².
pub const IDLE_FLOOR: Irradiance = Irradiance(1_000);

/// Dark after every start.
pub const START_DWELL: Milliseconds = Milliseconds(2_000);
/// A viewer sensor that gives nothing credible this long after a start is lost: it has had the time to learn its
/// background.
pub const SENSOR_START: Milliseconds = Milliseconds(6_000);
/// The fastest change of a lamp over its whole range.
pub const FASTEST_FADE: Milliseconds = Milliseconds(300);

/// A loop counts as open once it has read open for this long without a closed reading between.
pub const INTERLOCK_OPEN_AFTER: Milliseconds = Milliseconds(10);
/// Both loops must have been closed for this long before a re-arm counts.
pub const INTERLOCK_CLOSED_FOR: Milliseconds = Milliseconds(500);
/// Loops that differ for longer than this are a fault that only a re-arm clears.
pub const INTERLOCK_DISAGREEMENT: Milliseconds = Milliseconds(500);

/// Lamp boards above this temperature are derated.
pub const DERATE_FROM: CentiCelsius = CentiCelsius(6_000);
/// Derating reaches zero here.
pub const DERATE_TO: CentiCelsius = CentiCelsius(7_500);
/// A lamp board at this temperature is cut at once.
pub const BOARD_CUT: CentiCelsius = CentiCelsius(8_000);
/// A cut lamp board may light again below this.
pub const BOARD_BACK: CentiCelsius = CentiCelsius(6_500);
/// Air in the enclosure at which a warning is given.
pub const ENCLOSURE_WARN: CentiCelsius = CentiCelsius(4_000);
/// Air in the enclosure at which the lamps are cut.
pub const ENCLOSURE_CUT: CentiCelsius = CentiCelsius(5_000);

/// The longest lease of a host's request.
pub const LONGEST_LEASE: Milliseconds = Milliseconds(24 * 3_600_000);
/// Angles of views lie within this of the normal.
pub const WIDEST_VIEW: CentiDegrees = CentiDegrees(8_000);

/// The least lamp supply: 24 V less 10 %.
pub const SUPPLY_LEAST: Millivolts = Millivolts(21_600);
/// The most lamp supply: 24 V and 10 %.
pub const SUPPLY_MOST: Millivolts = Millivolts(26_400);

/// The reset count at which the controller latches dark.
pub const QUICK_RESETS: u8 = 3;
/// Running this long ends the count of quick resets.
pub const RAN_WELL: Milliseconds = Milliseconds(600_000);
