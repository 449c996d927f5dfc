//! The dose ledger: what the stack has received, reserved in flash before it is spent.
//!
//! The record in flash always holds at least what the lamps have given: before lamps may light, a reservation
//! for the next minute is written, and the record says that it is spent. A power cut can therefore only over-count,
//! by one reservation. The flash's owner writes [`DoseLedger::to_store`] and tells what it has written by
//! [`StoredReservation`]; until then the governor keeps the lamps dark.

use serde::{Deserialize, Serialize};

use crate::units::{Dose, Irradiance, Milliseconds, PerLamp};

/// How long a reservation lasts at the present irradiance.
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
    /// Powered time in the ledger's day in ms; ends the day where no clock is valid.
    pub day_ms: u32,
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
        let mut ledger = Self { spent, stored: record, wanted: None };
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

    /// Takes note of what is in flash.
    pub fn stored(&mut self, stored: StoredReservation) {
        if let Some(record) = self.wanted.take_if(|record| record.sequence == stored.sequence) {
            self.stored = record;
        }
    }

    /// Books what the lamps have given over a time.
    pub fn book(&mut self, given: PerLamp<Irradiance>, full: PerLamp<Irradiance>, elapsed: Milliseconds) {
        let spent = &mut self.spent;
        spent.day_ms = spent.day_ms.saturating_add(elapsed.0);
        for (account, (given, full)) in [
            (&mut spent.lamps.top, (given.top, full.top)),
            (&mut spent.lamps.bottom, (given.bottom, full.bottom)),
        ] {
            if given.0 > 0 {
                let dose = given.over(elapsed);
                account.day = account.day.plus(dose);
                account.life = account.life.plus(dose);
                account.lit_ms = account.lit_ms.saturating_add(u64::from(elapsed.0));
                account.full_ms = account.full_ms.saturating_add(dose.0 / u64::from(full.0.max(1)));
            }
        }
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

    /// Tells whether enough is reserved in flash to light the lamps until the next steps.
    pub fn covers(&self, irradiance: PerLamp<Irradiance>) -> bool {
        let covered = |stored: &LampAccount, spent: &LampAccount, irradiance: Irradiance| {
            irradiance.0 == 0 || stored.life >= spent.life.plus(irradiance.over(LEAST_RESERVED))
        };
        let (stored, spent) = (&self.stored.lamps, &self.spent.lamps);
        self.stored.sequence > 0
            && covered(&stored.top, &spent.top, irradiance.top)
            && covered(&stored.bottom, &spent.bottom, irradiance.bottom)
    }

    /// Begins the ledger's next day when the local day has changed, or 24 powered hours have gone without a clock.
    /// Tells whether a day began. A clock that goes back does not give a new day.
    pub fn day(&mut self, local_day: Option<u32>) -> bool {
        let begins = match local_day {
            Some(day) => day > self.spent.day,
            None => self.spent.day_ms >= 86_400_000,
        };
        if begins {
            self.spent.day = local_day.unwrap_or(self.spent.day.saturating_add(1));
            self.spent.day_ms = 0;
            self.spent.lamps.top.day = Dose(0);
            self.spent.lamps.bottom.day = Dose(0);
        }
        begins
    }

    /// Begins the life of a fresh stack.
    pub fn new_stack(&mut self) {
        self.spent.stacks = self.spent.stacks.saturating_add(1);
        self.spent.lamps.top.life = Dose(0);
        self.spent.lamps.bottom.life = Dose(0);
        self.want(Dose(0), Dose(0));
    }

    /// Ends the count of resets that followed each other quickly.
    pub fn ran_well(&mut self) {
        if self.spent.quick_resets > 0 {
            self.spent.quick_resets = 0;
            self.want(Dose(0), Dose(0));
        }
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
