//! What the firmware holds to whatever a plan or a host says.
//!
//! Numbers are for 365 nm, where both lamps lie. A plan may ask for less, never for more.
//!
//! | number | source |
//! |---|---|
//! | unprotected eye, 315 to 400 nm: 10 kJ/m² in 8 h, 0.347 W/m² on average | ICNIRP 2004, also ACGIH and IEC 62471 4.3.2 (10 W/m² beyond 1,000 s) |
//! | skin and eye, actinic: 30 J/m² weighted by 1.12e-4 at 365 nm, 27 times looser | ICNIRP's fit |
//! | design limit in front of the window: 0.035 W/m² at 0.2 m | a tenth of ICNIRP's mean; the window has optical density 2 |
//! | ceiling 20 W/m² of a hardware ceiling of 50 W/m² a side | this design: working 8 to 10, idle 1 |
//! | dose 30 kJ/m² a day, 10 MJ/m² a life | this design: placeholders until coupons of the inks have been exposed |
//! | 10 min lit, 60 s rest | 3 W 365 nm LEDs last 4,480 h (L70) continuously, 19,814 h cycled: Crystals 10, 1083 (2020) |
//! | boards 60 to 75 °C derated, 80 °C cut; air 40 and 50 °C | this design |
//! | interlock 20 ms, 500 ms | this design; the contact also opens the lamp supply in hardware, within 10 ms |
//! | a loop that opens five times without 10 s of calm between is broken | this design |
//! | ultraviolet above 1.3 times the model, 5 % of full scale, below 0.7 times | this design |
//! | lamp hours 4,000 and 10,000 at full level | this design, after the life times above |
//! | supply 24 V within 10 % | this design |
//! | fades of a minute at most; 1 s in 10 s to stand still for an erase | this design: an erase takes 45 to 400 ms |
//! | dark for 5 s after a fault of supply or temperature sensor | this design |
//! | dark for 2 s after a start, three resets in 10 min, leases of a day at most | this design |
//!
//! This is a reference design, not a certified safety function.

use crate::units::{CentiCelsius, CentiDegrees, Dose, Irradiance, Level, Milliseconds, Millivolts};

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
/// The slowest change of a lamp over its whole range that a plan may ask for.
pub const SLOWEST_FADE: Milliseconds = Milliseconds(60_000);
/// The longest that lamps stand still, whatever wants to move them, because flash is to be erased ...
pub const STILL_FOR: Milliseconds = Milliseconds(1_000);
/// ... and the least time in which they then move freely.
pub const STILL_AGAIN_AFTER: Milliseconds = Milliseconds(10_000);
/// The time of a cut to the idle floor over a lamp's whole range.
pub const CUT_FADE: Milliseconds = Milliseconds(2_000);

/// A loop counts as open once it has read open for this long without a closed reading between.
pub const INTERLOCK_OPEN_AFTER: Milliseconds = Milliseconds(10);
/// Both loops must have been closed for this long before a re-arm counts.
pub const INTERLOCK_CLOSED_FOR: Milliseconds = Milliseconds(500);
/// Loops that differ for longer than this are a fault that only a re-arm clears.
pub const INTERLOCK_DISAGREEMENT: Milliseconds = Milliseconds(500);

/// Brief openings after which a loop counts as broken and asks for a re-arm ...
pub const INTERLOCK_BOUNCES: u8 = 5;
/// ... where no such time lay between them.
pub const INTERLOCK_CALM: Milliseconds = Milliseconds(10_000);

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
/// Warm air has cooled below this.
pub const ENCLOSURE_COOL: CentiCelsius = CentiCelsius(3_800);
/// Lamps that were cut for the enclosure's air may light again below this.
pub const ENCLOSURE_BACK: CentiCelsius = CentiCelsius(4_500);

/// More ultraviolet than this many tenths of what the lamps should give is a fault.
pub const ULTRAVIOLET_BRIGHT_TENTHS: u32 = 13;
/// Readings up to this part of the sensor's reading under both lamps are never a fault: daylight, noise.
pub const ULTRAVIOLET_MARGIN_PERCENT: u32 = 5;
/// Less ultraviolet than this many tenths of what the lamps should give wants service.
pub const ULTRAVIOLET_DIM_TENTHS: u32 = 7;

/// An ultraviolet sensor that the plan counts on and that is silent for so long is lost: it reads five times a second.
pub const ULTRAVIOLET_SILENT: Milliseconds = Milliseconds(5_000);

/// What remains of a wanted level once nine tenths of the stack's life are used.
pub const AGED_LEVEL: Level = Level(49_151);
/// Full-level hours of a lamp at which a notice is given.
pub const LAMP_NOTICE_H: u16 = 4_000;
/// Full-level hours of a lamp at which it is due for service.
pub const LAMP_SERVICE_H: u16 = 10_000;

/// The longest lease of a host's request.
pub const LONGEST_LEASE: Milliseconds = Milliseconds(24 * 3_600_000);
/// Angles of views lie within this of the normal.
pub const WIDEST_VIEW: CentiDegrees = CentiDegrees(8_000);

/// The least lamp supply: 24 V less 10 %.
pub const SUPPLY_LEAST: Millivolts = Millivolts(21_600);
/// The most lamp supply: 24 V and 10 %.
pub const SUPPLY_MOST: Millivolts = Millivolts(26_400);
/// The supply counts as sound once it has been within its bounds for this long.
pub const SUPPLY_SETTLED: Milliseconds = Milliseconds(200);

/// The least time for which lamps are dark that a fault of the supply or of a board's sensor has put out.
pub const CALM: Milliseconds = Milliseconds(5_000);

/// The reset count at which the controller latches dark.
pub const QUICK_RESETS: u8 = 3;
/// Running this long ends the count of quick resets.
pub const RAN_WELL: Milliseconds = Milliseconds(600_000);
