//! Tells when a part of a stack's or a lamp's life is used.

use super::LedgerRecord;
use crate::events::{Event, Events};
use crate::limits;
use crate::units::{Dose, Lamp, PerLamp};

/// Parts of the life's dose at which a notice is given, in percent.
const PARTS: [u8; 3] = [75, 90, 100];
const HOUR_MS: u64 = 3_600_000;

/// How many of the marks a lamp has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Passed {
    dose: u8,
    hours: u8,
}

/// The marks passed until now; a start does not repeat those of before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Notices {
    passed: Option<PerLamp<Passed>>,
}

impl Notices {
    /// Notices at a start.
    pub const fn new() -> Self {
        Self { passed: None }
    }

    /// Tells the marks that have been passed since the call before.
    pub fn update(&mut self, spent: &LedgerRecord, life_dose: Dose, events: &mut Events) {
        let now = spent.lamps.map(|account| Passed {
            dose: PARTS.into_iter().filter(|part| account.life >= part_of(life_dose, *part)).count() as u8,
            hours: HOURS.into_iter().filter(|hours| account.full_ms >= u64::from(*hours) * HOUR_MS).count()
                as u8,
        });
        let before = self.passed.replace(now).unwrap_or(now);
        for lamp in [Lamp::Top, Lamp::Bottom] {
            let (now, before) = (now.get(lamp), before.get(lamp));
            for part in marks(&PARTS, before.dose, now.dose) {
                events.push(Event::LifeDoseUsed(lamp, part));
            }
            for hours in marks(&HOURS, before.hours, now.hours) {
                events.push(Event::LampHours(lamp, hours));
            }
        }
    }
}

const HOURS: [u16; 2] = [limits::LAMP_NOTICE_H, limits::LAMP_SERVICE_H];

fn marks<T: Copy>(marks: &[T], before: u8, now: u8) -> impl Iterator<Item = T> {
    marks.iter().copied().take(usize::from(now)).skip(usize::from(before))
}

const fn part_of(dose: Dose, percent: u8) -> Dose {
    Dose(dose.0 / 100 * percent as u64)
}
