//! Refuses plans that the controller could not or must not keep.

use core::fmt;
use core::hash::{Hash, Hasher};

use serde::{Deserialize, Serialize};

use super::calendar::{Calendar, Date, TimeZone, Transition};
use super::{LampCalibration, Limits, Plan, PresenceSettings, ViewerSettings};
use crate::limits;
use crate::units::{CentiDegrees, Milliseconds};

/// Why a plan is refused, and where in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlanError {
    /// There is no view.
    NoViews,
    /// The view of this index has an empty name or the name of an earlier view.
    ViewName(u8),
    /// The view of this index lies more than 80 degrees from the normal.
    ViewAngle(u8),
    /// Both lamps are off in the pair of the view of this index.
    ViewDark(u8),
    /// The volume has no films or no pixels.
    Volume,
    /// A lamp's full level is zero or above the 50 W/m² that the hardware allows.
    FullLevel,
    /// A calibration curve does not rise from level 0 to full level.
    Curve,
    /// The ceiling is zero or above the firmware's 20 W/m².
    Ceiling,
    /// A dose limit is zero or above the firmware's.
    DoseLimit,
    /// The continuous time is zero or longer than the firmware's 10 minutes.
    Continuous,
    /// The rest is shorter than the firmware's minute, or longer than a day.
    Rest,
    /// A viewer setting lies outside its range.
    Viewer,
    /// A presence setting lies outside its range.
    Presence,
    /// The time zone's offset or daylight saving rule is impossible.
    TimeZone,
    /// The schedule rule of this index has an impossible day, time or date.
    Rule(u8),
    /// The closed days of this index have an impossible date, or end before they begin.
    Closed(u8),
    /// The pairs for two views at once are not one for each two views, or both lamps are off in one.
    Shared,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoViews => f.write_str("the plan has no view"),
            Self::ViewName(i) => write!(f, "view {}: its id is empty or taken", i + 1),
            Self::ViewAngle(i) => write!(f, "view {}: more than 80 degrees from the normal", i + 1),
            Self::ViewDark(i) => write!(f, "view {}: both lamps are off in its pair", i + 1),
            Self::Volume => f.write_str("the volume has no films or no pixels"),
            Self::FullLevel => {
                f.write_str("a lamp's irradiance at full level is not within 0.001 to 50 W/m2")
            }
            Self::Curve => f.write_str("a lamp's calibration does not rise from level 0 to full level"),
            Self::Ceiling => f.write_str("the ceiling is not within 0.001 to 20 W/m2"),
            Self::DoseLimit => f.write_str("a dose limit is zero or above 30 kJ/m2 a day, 10 MJ/m2 a life"),
            Self::Continuous => f.write_str("the continuous time is not within 1 to 600 s"),
            Self::Rest => f.write_str("the rest is not within 60 to 86,400 s"),
            Self::Viewer => f.write_str("a viewer setting lies outside its range"),
            Self::Presence => f.write_str("a presence setting lies outside its range"),
            Self::TimeZone => f.write_str("the time zone is impossible"),
            Self::Rule(i) => write!(f, "schedule rule {}: an impossible day, time or date", i + 1),
            Self::Closed(i) => {
                write!(f, "closed days {}: an impossible date, or the end before the start", i + 1)
            }
            Self::Shared => {
                f.write_str("the pairs for two views at once are not one lit pair for each two views")
            }
        }
    }
}

impl core::error::Error for PlanError {}

/// A plan that has passed [`Plan::check`]: the only kind that the controller takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValidPlan {
    plan: Plan,
    fingerprint: u32,
}

impl ValidPlan {
    /// Checks a plan.
    ///
    /// # Errors
    /// The first fault of the plan.
    pub fn new(plan: Plan) -> Result<Self, PlanError> {
        plan.check()?;
        Ok(Self { fingerprint: fingerprint(&plan), plan })
    }

    /// Checks a plan and copies it into a slot, which is emptied first: for a board on whose stack there is no room for many
    /// copies of a plan.
    ///
    /// # Errors
    /// The first fault of the plan.
    #[inline(never)]
    pub fn put<'a>(plan: &Plan, slot: &'a mut Option<Self>) -> Result<&'a Self, PlanError> {
        *slot = None;
        plan.check()?;
        Ok(slot.insert(Self { fingerprint: fingerprint(plan), plan: plan.clone() }))
    }

    /// Tells two plans apart while the controller runs; not the same from one machine to another.
    pub const fn fingerprint(&self) -> u32 {
        self.fingerprint
    }
}

fn fingerprint(plan: &Plan) -> u32 {
    let mut hasher = Fnv(0x811c_9dc5);
    plan.hash(&mut hasher);
    hasher.0
}

impl core::ops::Deref for ValidPlan {
    type Target = Plan;

    fn deref(&self) -> &Plan {
        &self.plan
    }
}

impl Plan {
    /// Refuses what the controller could not or must not keep: the plan may come from anywhere.
    ///
    /// # Errors
    /// The first fault found.
    pub fn check(&self) -> Result<(), PlanError> {
        self.check_views()?;
        let volume = &self.volume;
        if [u32::from(volume.films), volume.width_px, volume.height_px, volume.width_um].contains(&0) {
            return Err(PlanError::Volume);
        }
        check_lamp(&self.lamps.top)?;
        check_lamp(&self.lamps.bottom)?;
        check_limits(&self.limits)?;
        check_viewer(&self.viewer)?;
        check_presence(&self.presence)?;
        check_calendar(&self.calendar)
    }

    fn check_views(&self) -> Result<(), PlanError> {
        if self.views.is_empty() {
            return Err(PlanError::NoViews);
        }
        for (view, i) in self.views.iter().zip(0_u8..) {
            let earlier = self.views.iter().take(usize::from(i));
            if view.id.is_empty() || earlier.into_iter().any(|other| other.id == view.id) {
                return Err(PlanError::ViewName(i));
            }
            let within = |angle: CentiDegrees| angle.0.unsigned_abs() <= limits::WIDEST_VIEW.0.unsigned_abs();
            if !within(view.horizontal) || !within(view.vertical) {
                return Err(PlanError::ViewAngle(i));
            }
            if view.emphasis.top.0 == 0 && view.emphasis.bottom.0 == 0 {
                return Err(PlanError::ViewDark(i));
            }
        }
        let views = self.views.len();
        let complete = self.shared.is_empty() || self.shared.len() == views * (views - 1) / 2;
        if !complete || self.shared.iter().any(|pair| pair.top.0 == 0 && pair.bottom.0 == 0) {
            return Err(PlanError::Shared);
        }
        Ok(())
    }
}

fn check_lamp(lamp: &LampCalibration) -> Result<(), PlanError> {
    let measured = lamp.full_level.max(lamp.ultraviolet_at_full);
    if lamp.full_level.0 == 0 || measured > limits::HARDWARE_CEILING {
        return Err(PlanError::FullLevel);
    }
    let (Some(first), Some(last)) = (lamp.curve.first(), lamp.curve.last()) else {
        return Ok(());
    };
    let rises =
        lamp.curve.iter().zip(lamp.curve.iter().skip(1)).all(|(a, b)| a.level < b.level && a.duty < b.duty);
    if first.level.0 != 0 || first.duty != 0 || last.level.0 != u16::MAX || !rises {
        return Err(PlanError::Curve);
    }
    Ok(())
}

fn check_limits(plan: &Limits) -> Result<(), PlanError> {
    if plan.ceiling.0 == 0 || plan.ceiling > limits::CEILING {
        return Err(PlanError::Ceiling);
    }
    let bounded = |dose: crate::units::Dose, most| dose.0 > 0 && dose <= most;
    if !bounded(plan.daily_dose, limits::DAILY_DOSE) || !bounded(plan.life_dose, limits::LIFE_DOSE) {
        return Err(PlanError::DoseLimit);
    }
    if plan.continuous < Milliseconds(1_000) || plan.continuous > limits::CONTINUOUS {
        return Err(PlanError::Continuous);
    }
    if plan.rest < limits::REST || plan.rest > Milliseconds(86_400_000) {
        return Err(PlanError::Rest);
    }
    Ok(())
}

fn check_viewer(viewer: &ViewerSettings) -> Result<(), PlanError> {
    let angle = |angle: CentiDegrees| (0..=2_000).contains(&angle.0);
    let time = |time: Milliseconds, least: u32, most: u32| (least..=most).contains(&time.0);
    let sound = angle(viewer.hysteresis)
        && angle(viewer.dead_zone)
        && time(viewer.dwell, 0, 10_000)
        && time(viewer.least_hold, 0, 60_000)
        && time(viewer.turn, 1_000, 3_600_000)
        && time(viewer.page, 1_000, 3_600_000)
        // Bearings waver by a degree.
        && (100..=2_000).contains(&viewer.step.0)
        && time(viewer.fade, limits::FASTEST_FADE.0, limits::SLOWEST_FADE.0);
    if sound { Ok(()) } else { Err(PlanError::Viewer) }
}

fn check_presence(presence: &PresenceSettings) -> Result<(), PlanError> {
    let day = 86_400_000;
    let sound = presence.hold.0 <= day
        && presence.idle.0 <= day
        && (limits::FASTEST_FADE..=limits::SLOWEST_FADE).contains(&presence.fade);
    if sound { Ok(()) } else { Err(PlanError::Presence) }
}

fn check_calendar(calendar: &Calendar) -> Result<(), PlanError> {
    if !zone_is_possible(&calendar.time_zone) {
        return Err(PlanError::TimeZone);
    }
    for (rule, i) in calendar.rules.iter().zip(0_u8..) {
        let dates = rule.first.iter().chain(&rule.last).all(|date| date.is_possible());
        let order = rule.first.zip(rule.last).is_none_or(|(first, last)| first <= last);
        let days = (1..=0b111_1111).contains(&rule.days.0);
        if !dates || !order || !days || rule.from.0 >= 1_440 || rule.to.0 > 1_440 {
            return Err(PlanError::Rule(i));
        }
    }
    for (closed, i) in calendar.closed.iter().zip(0_u8..) {
        if !closed.first.is_possible() || !closed.last.is_possible() || closed.last < closed.first {
            return Err(PlanError::Closed(i));
        }
    }
    Ok(())
}

fn zone_is_possible(zone: &TimeZone) -> bool {
    let offset = |minutes: i16| (-24 * 60..=24 * 60).contains(&minutes);
    let moment = |at: &Transition| {
        (1..=12).contains(&at.month)
            && (1..=5).contains(&at.week)
            && at.weekday < 7
            && (-10_020..=10_020).contains(&at.minute)
    };
    let daylight = zone.daylight.is_none_or(|rule| {
        offset(rule.offset_minutes)
            && moment(&rule.start)
            && moment(&rule.end)
            && rule.start.month != rule.end.month
    });
    offset(zone.offset_minutes) && daylight
}

impl Date {
    /// Tells whether this date exists and lies within 1970 to 2199.
    pub const fn is_possible(self) -> bool {
        let leap =
            self.year.is_multiple_of(4) && !self.year.is_multiple_of(100) || self.year.is_multiple_of(400);
        let days = match self.month {
            1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
            4 | 6 | 9 | 11 => 30,
            2 if leap => 29,
            2 => 28,
            _ => return false,
        };
        self.year >= 1970 && self.year <= 2199 && self.day >= 1 && self.day <= days
    }
}

/// The 32-bit FNV-1a hash (Fowler, Noll, Vo).
struct Fnv(u32);

impl Hasher for Fnv {
    fn finish(&self) -> u64 {
        u64::from(self.0)
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
        }
    }
}
