//! The dose ledger: what the stack has received, reserved in flash before it is spent.
//!
//! The record in flash always holds at least what the lamps have given: before lamps may light, a reservation
//! for the next minute is written, and the record says that it is spent. A power cut can therefore only over-count,
//! by one reservation. The flash's owner writes [`DoseLedger::to_store`] and tells what it has written by
//! [`StoredReservation`]; until then the governor keeps the lamps dark.
//!
//! # Days
//!
//! The dose of the day begins anew at local midnight, and where no clock is valid after 24 powered hours. A clock can be
//! set, and whoever set it forward again and again would get a day's dose each time. So a day that begins before the one
//! before it has lasted 24 hours is early, and days may be early by 26 hours in sum: one day, for the first day begins at
//! any hour, and two hours for daylight saving and for a clock that drifts. What is early beyond that waits. Days that
//! last longer make up for it. The hours are those in which the controller ran, and those between, told by the clock at
//! the last record and at the start: a clock that is set meanwhile moves that mark along and proves no time.

mod days;
mod notices;

use serde::{Deserialize, Serialize};

use self::days::Clock;
pub use self::notices::Notices;
use crate::units::{Dose, Irradiance, Lamp, Milliseconds, PerLamp};

/// How long a reservation lasts at the present irradiance; this design: what a power cut may over-count.
pub const RESERVATION: Milliseconds = Milliseconds(60_000);
/// The dose that must still be reserved while lamps are lit: what the ceiling gives until the watchdog bites.
pub const LEAST_RESERVED: Milliseconds = Milliseconds(1_000);

/// What one lamp has given, with what is reserved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LampAccount {
    /// Dose on the nearest film in the ledger's day.
    pub day: Dose,
    /// Dose on the nearest film in the stack's life.
    pub life: Dose,
    /// Time lit in ms.
    pub lit_ms: u64,
    /// Time lit in ms, as if at full level.
    pub full_ms: u64,
}

/// The ledger as it stands in flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LedgerRecord {
    /// Counts the records from the first; the newest is valid.
    pub sequence: u32,
    /// The local day since 1970-01-01 to which the day's dose belongs; 0 where no clock was ever valid.
    pub day: u32,
    /// Both lamps' accounts.
    pub lamps: PerLamp<LampAccount>,
    /// Starts of the controller.
    pub power_cycles: u32,
    /// Starts after the watchdog or a fault.
    pub watchdog_resets: u32,
    /// Starts after the watchdog or a fault since the controller last ran for ten minutes.
    pub quick_resets: u8,
    /// How many stacks have been declared.
    pub stacks: u16,
    /// Time proven since the ledger's day began, in ms.
    pub day_ms: u32,
    /// By how much the ledger's days have begun early in sum, in ms.
    pub early_ms: u32,
    /// What the clock showed, in seconds since 1970; 0 where it was not valid.
    pub clock_s: u32,
}

/// Tells the controller that a ledger record is safely in flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredReservation {
    /// The record's sequence number.
    pub sequence: u32,
}

/// Counts doses and reserves them.
#[derive(Clone, Debug)]
pub struct DoseLedger {
    /// What has really been given.
    spent: LedgerRecord,
    /// The newest record known to be in flash.
    stored: LedgerRecord,
    /// The record that waits to be written.
    wanted: Option<LedgerRecord>,
    /// Dose that has not yet made a full-level millisecond.
    part_ms: PerLamp<u64>,
    /// The clock since the start.
    clock: Clock,
}

impl DoseLedger {
    /// Continues from the newest record in flash, or from an empty one; counts the start.
    ///
    /// `after_fault`: the watchdog, a panic or a fault restarted the controller.
    pub fn new(record: LedgerRecord, after_fault: bool) -> Self {
        let mut spent = record;
        spent.power_cycles = spent.power_cycles.saturating_add(1);
        if after_fault {
            spent.watchdog_resets = spent.watchdog_resets.saturating_add(1);
            spent.quick_resets = spent.quick_resets.saturating_add(1);
        }
        let mut ledger =
            Self { spent, stored: record, wanted: None, part_ms: PerLamp::default(), clock: Clock::new() };
        ledger.want(Dose(0), Dose(0));
        ledger
    }

    /// The record to write to flash, where one waits.
    pub const fn to_store(&self) -> Option<&LedgerRecord> {
        self.wanted.as_ref()
    }

    /// What has been given until now.
    pub const fn spent(&self) -> &LedgerRecord {
        &self.spent
    }

    /// Takes note of what is in flash. Tells whether a new day of the ledger has begun with it.
    pub fn stored(&mut self, stored: StoredReservation) -> bool {
        let Some(record) = self.wanted.take_if(|record| record.sequence == stored.sequence) else {
            return false;
        };
        self.stored = record;
        self.begin_day_of(&record)
    }

    /// Books what the lamps have given over a time.
    pub fn book(&mut self, given: PerLamp<Irradiance>, full: PerLamp<Irradiance>, elapsed: Milliseconds) {
        self.spent.day_ms = self.spent.day_ms.saturating_add(elapsed.0);
        let (lamps, parts) = (&mut self.spent.lamps, &mut self.part_ms);
        book_lamp(&mut lamps.top, &mut parts.top, given.top, full.top, elapsed);
        book_lamp(&mut lamps.bottom, &mut parts.bottom, given.bottom, full.bottom, elapsed);
    }

    /// Asks for a reservation where too little is left for this irradiance.
    pub fn reserve(&mut self, wanted: PerLamp<Irradiance>) {
        let short = |stored: &LampAccount, spent: &LampAccount, irradiance: Irradiance| {
            let half = Milliseconds(RESERVATION.0 / 2);
            irradiance.0 > 0 && stored.life < spent.life.plus(irradiance.over(half))
        };
        let (stored, spent) = (&self.stored.lamps, &self.spent.lamps);
        if self.wanted.is_none()
            && (short(&stored.top, &spent.top, wanted.top)
                || short(&stored.bottom, &spent.bottom, wanted.bottom))
        {
            self.want(wanted.top.over(RESERVATION), wanted.bottom.over(RESERVATION));
        }
    }

    /// Tells whether enough is reserved in flash to light the lamps until the next steps. What was reserved for the stack
    /// before covers nothing of a new one.
    pub fn covers(&self, irradiance: PerLamp<Irradiance>) -> bool {
        let covered = |stored: &LampAccount, spent: &LampAccount, irradiance: Irradiance| {
            irradiance.0 == 0 || stored.life >= spent.life.plus(irradiance.over(LEAST_RESERVED))
        };
        let (stored, spent) = (&self.stored.lamps, &self.spent.lamps);
        self.stored.sequence > 0
            && self.stored.stacks == self.spent.stacks
            && covered(&stored.top, &spent.top, irradiance.top)
            && covered(&stored.bottom, &spent.bottom, irradiance.bottom)
    }

    /// Begins the life of a fresh stack.
    pub fn new_stack(&mut self) {
        let (top, bottom) = (self.left(Lamp::Top), self.left(Lamp::Bottom));
        self.spent.stacks = self.spent.stacks.saturating_add(1);
        self.spent.lamps.top.life = Dose(0);
        self.spent.lamps.bottom.life = Dose(0);
        self.want(top, bottom);
    }

    /// Ends the count of resets that followed each other quickly.
    pub fn ran_well(&mut self) {
        if self.spent.quick_resets > 0 {
            self.spent.quick_resets = 0;
            // The lamps may be lit meanwhile: what is reserved stays so.
            self.want(self.left(Lamp::Top), self.left(Lamp::Bottom));
        }
    }

    /// What of the reservation in flash is not spent yet.
    fn left(&self, lamp: Lamp) -> Dose {
        self.stored.lamps.get(lamp).life.minus(self.spent.lamps.get(lamp).life)
    }

    fn want(&mut self, top: Dose, bottom: Dose) {
        let newest = self.wanted.map_or(self.stored.sequence, |record| record.sequence);
        let mut record = self.spent;
        record.sequence = newest.saturating_add(1);
        for (account, dose) in [(&mut record.lamps.top, top), (&mut record.lamps.bottom, bottom)] {
            account.day = account.day.plus(dose);
            account.life = account.life.plus(dose);
            if dose.0 > 0 {
                account.lit_ms = account.lit_ms.saturating_add(u64::from(RESERVATION.0));
                account.full_ms = account.full_ms.saturating_add(u64::from(RESERVATION.0));
            }
        }
        self.wanted = Some(record);
    }
}

fn book_lamp(
    account: &mut LampAccount,
    part_ms: &mut u64,
    given: Irradiance,
    full: Irradiance,
    elapsed: Milliseconds,
) {
    if given.0 == 0 {
        return;
    }
    let dose = given.over(elapsed);
    account.day = account.day.plus(dose);
    account.life = account.life.plus(dose);
    account.lit_ms = account.lit_ms.saturating_add(u64::from(elapsed.0));
    *part_ms = part_ms.saturating_add(dose.0);
    let whole_ms = match u32::try_from(*part_ms) {
        // The way of every step that is not late: the processor has no 64-bit division.
        Ok(part) => u64::from(part / full.0.max(1)),
        Err(_) => *part_ms / u64::from(full.0.max(1)),
    };
    account.full_ms = account.full_ms.saturating_add(whole_ms);
    *part_ms -= whole_ms * u64::from(full.0.max(1));
}

#[cfg(test)]
mod tests;
