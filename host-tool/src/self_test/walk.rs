//! The walk through the parts.

use std::thread::sleep;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use vitrine_exhibit::Presence;
use vitrine_exhibit::events::DarkReason;
use vitrine_exhibit::interlock::InterlockState;
use vitrine_exhibit::limits::{
    BOARD_BACK, ENCLOSURE_WARN, SUPPLY_LEAST, SUPPLY_MOST, ULTRAVIOLET_BRIGHT_TENTHS, ULTRAVIOLET_DIM_TENTHS,
};
use vitrine_exhibit::plan::Plan;
use vitrine_exhibit::units::{Lamp, Level, Milliseconds, PerLamp};
use vitrine_protocol::{Refusal, Status, plan_file};

use super::sheet::{Finding, Sheet, Verdict};
use crate::link::{Client, LinkError};

/// How long the lamps may take to reach a pair: the start-up dwell, a slow fade, and a look.
const LAMP_PATIENCE: Duration = Duration::from_secs(8);
/// How long a person's act may take to be seen by the controller.
const ACT_PATIENCE: Duration = Duration::from_secs(4);
/// How often it is looked.
const LOOK: Duration = Duration::from_millis(100);
/// For how long views are held and darkness is asked for: all of the test's use, should the computer disappear.
const LEASE: Milliseconds = Milliseconds(60_000);
/// The clock may differ from this computer's by so much: a schedule is kept to the minute.
const CLOCK_ERROR_S: i64 = 5;
/// No room is colder or hotter than this, in hundredths of a degree: a sensor that says so is broken.
const ROOM_CENTI_CELSIUS: std::ops::RangeInclusive<i16> = -1_000..=4_500;
/// A lamp has reached its level when it is this near, as a part of full level: fades end exactly, dithering does not.
const LEVEL_TOLERANCE: u16 = 655;

/// Somebody who can reach the exhibit.
pub trait Person {
    /// Tells the person what to do; true once it is done, false where nobody does it.
    fn does(&mut self, what: &str) -> bool;
}

/// Walks through all parts of the exhibit behind `client`, and leaves it as it was.
///
/// # Errors
/// Where the link breaks. What the controller refuses is a finding.
pub fn walk(client: &mut Client, person: &mut dyn Person) -> Result<Sheet, LinkError> {
    let began = Timestamp::now();
    let mut walk = Walk { findings: Vec::new(), plan: None };
    let walked = walk.all(client, person);
    let released = client.release();
    walked.and(released)?;
    let hello = client.hello();
    Ok(Sheet {
        exhibit: walk.plan.map(|plan| plan.name.to_string()).unwrap_or_default(),
        serial_number: hello.serial_number.to_string(),
        firmware: hello.firmware.to_string(),
        began: began.strftime("%Y-%m-%dT%H:%M:%SZ").to_string(),
        findings: walk.findings,
    })
}

struct Walk {
    findings: Vec<Finding>,
    plan: Option<Plan>,
}

impl Walk {
    fn all(&mut self, client: &mut Client, person: &mut dyn Person) -> Result<(), LinkError> {
        let hello = client.hello();
        let greeting = format!("{} answers, firmware {}", hello.serial_number, hello.firmware);
        self.add("link", Verdict::Passed, greeting);
        self.flash(client)?;
        let status = client.status()?;
        self.clock(&status);
        self.supply(&status);
        self.temperatures(&status);
        self.viewer_sensors(client)?;
        self.interlock_at_rest(&status);
        self.lamps(client)?;
        self.door(client, person)?;
        self.staff_key(client, person)?;
        self.visitor(client, person)
    }

    fn add(&mut self, part: &'static str, verdict: Verdict, found: impl Into<String>) {
        self.findings.push(Finding { part, verdict, found: found.into() });
    }

    /// The plan and the log come back from the flash memory.
    fn flash(&mut self, client: &mut Client) -> Result<(), LinkError> {
        match client.read_plan() {
            Ok(bytes) => {
                self.plan = plan_file::decode(&bytes).ok();
                let found = match &self.plan {
                    Some(plan) => format!("{} views, CRC {:08x}", plan.views.len(), plan_file::crc(&bytes)),
                    None => "cannot be read: upload the build again".to_owned(),
                };
                self.add("plan", Verdict::of(self.plan.is_some()), found);
            }
            Err(LinkError::Refused { refusal: Refusal::NoPlan, .. }) => {
                self.add("plan", Verdict::Failed, "there is none: `vitrine upload BUILD`");
            }
            Err(error) => return Err(error),
        }
        let entries = client.log(0)?;
        let gapless = entries.windows(2).all(|pair| pair[1].sequence == pair[0].sequence.wrapping_add(1));
        let found = format!("{} entries{}", entries.len(), if gapless { "" } else { ", with gaps" });
        self.add("event log", Verdict::of(gapless), found);
        Ok(())
    }

    fn clock(&mut self, status: &Status) {
        let Some(now) = status.clock.now else {
            self.add("clock", Verdict::Failed, "the time is not known: `vitrine clock --set`");
            return;
        };
        let ahead_s = now.0 - Timestamp::now().as_second();
        let side = if ahead_s < 0 { "behind" } else { "ahead of" };
        let found = format!("{} s {side} this computer", ahead_s.abs());
        self.add("clock", Verdict::of(ahead_s.abs() <= CLOCK_ERROR_S), found);
    }

    fn supply(&mut self, status: &Status) {
        let supply = status.snapshot.supply;
        let sound = supply.is_some_and(|supply| (SUPPLY_LEAST..=SUPPLY_MOST).contains(&supply));
        let found = supply
            .map_or_else(|| "no reading".to_owned(), |supply| format!("{:.2} V", f64::from(supply.0) / 1e3));
        self.add("lamp supply", Verdict::of(sound), found);
    }

    fn temperatures(&mut self, status: &Status) {
        for (part, lamp) in [("top board", Lamp::Top), ("bottom board", Lamp::Bottom)] {
            let board = *status.snapshot.boards.get(lamp);
            let sound =
                board.is_some_and(|board| board.0 >= *ROOM_CENTI_CELSIUS.start() && board < BOARD_BACK);
            let found = board.map_or_else(
                || "no reading".to_owned(),
                |board| format!("{:.1} C", f64::from(board.0) / 100.0),
            );
            self.add(part, Verdict::of(sound), found);
        }
        match status.snapshot.enclosure {
            None => self.add("enclosure air", Verdict::NotTried, "no sensor is fitted"),
            Some(air) => {
                let sound = ROOM_CENTI_CELSIUS.contains(&air.0) && air < ENCLOSURE_WARN;
                self.add("enclosure air", Verdict::of(sound), format!("{:.1} C", f64::from(air.0) / 100.0));
            }
        }
    }

    /// After a start they first learn what the empty room looks like.
    fn viewer_sensors(&mut self, client: &mut Client) -> Result<(), LinkError> {
        let credible =
            look(client, LAMP_PATIENCE, |status| status.snapshot.presence != Presence::Unknown)?.is_ok();
        let found = if credible { "give credible frames" } else { "give nothing credible" };
        self.add("viewer sensors", Verdict::of(credible), found);
        Ok(())
    }

    fn interlock_at_rest(&mut self, status: &Status) {
        let armed = status.snapshot.interlock == InterlockState::Armed;
        let found =
            if armed { "closed and armed" } else { "not armed: close the door, then `vitrine rearm`" };
        self.add("interlock", Verdict::of(armed), found);
    }

    /// Darkness first, then each lamp by the view that gives most of it.
    fn lamps(&mut self, client: &mut Client) -> Result<(), LinkError> {
        client.dark(LEASE)?;
        let dark = look(client, ACT_PATIENCE, |status| {
            status.snapshot.levels == PerLamp::default() && !status.snapshot.enabled
        })?;
        let found = if dark.is_ok() { "both lamps off, drivers disabled" } else { "the lamps stay lit" };
        self.add("dark", Verdict::of(dark.is_ok()), found);
        client.release()?;
        let Some(plan) = self.plan.clone() else {
            for part in ["top lamp", "bottom lamp"] {
                self.add(part, Verdict::NotTried, "there is no plan to light it by");
            }
            return Ok(());
        };
        for (part, lamp) in [("top lamp", Lamp::Top), ("bottom lamp", Lamp::Bottom)] {
            self.lamp(client, &plan, part, lamp)?;
        }
        client.release()
    }

    fn lamp(
        &mut self,
        client: &mut Client,
        plan: &Plan,
        part: &'static str,
        lamp: Lamp,
    ) -> Result<(), LinkError> {
        let level = |index: usize| plan.views.get(index).map_or(Level(0), |view| *view.emphasis.get(lamp));
        let Some(view) = (0..plan.views.len()).max_by_key(|&index| level(index)) else { return Ok(()) };
        let wanted = level(view);
        if wanted == Level(0) {
            self.add(part, Verdict::NotTried, "no view of the plan uses it");
            return Ok(());
        }
        if let Some(refused) = refused(client.open_outside_hours(LEASE))? {
            self.add(part, Verdict::Failed, refused);
            return Ok(());
        }
        if let Some(refused) = refused(client.hold(view as u8, LEASE))? {
            self.add(part, Verdict::Failed, refused);
            return Ok(());
        }
        let reached = look(client, LAMP_PATIENCE, |status| {
            status.snapshot.dark.is_none()
                && status.snapshot.levels.get(lamp).0.abs_diff(wanted.0) <= LEVEL_TOLERANCE
        })?;
        let percent = |level: Level| 100.0 * f64::from(level.0) / f64::from(Level::FULL.0);
        match reached {
            Ok(status) => {
                let reached = *status.snapshot.levels.get(lamp);
                self.add(part, Verdict::Passed, format!("reaches {:.1} %", percent(reached)));
                self.ultraviolet(plan, &status);
            }
            Err(status) => {
                let why = match (status.snapshot.dark, status.snapshot.cuts.get(lamp).iter().next()) {
                    (Some(reason), _) => format!("dark: {reason}"),
                    (None, Some(cut)) => format!("dimmed: {cut:?}"),
                    (None, None) => "no reason is told".to_owned(),
                };
                let level = *status.snapshot.levels.get(lamp);
                let found = format!("{:.1} % instead of {:.1} %; {why}", percent(level), percent(wanted));
                self.add(part, Verdict::Failed, found);
            }
        }
        Ok(())
    }

    /// The built-in sensor against what it read under both lamps at commissioning.
    fn ultraviolet(&mut self, plan: &Plan, status: &Status) {
        let expected: u64 = [Lamp::Top, Lamp::Bottom]
            .into_iter()
            .map(|lamp| {
                let full = u64::from(plan.lamps.get(lamp).ultraviolet_at_full.0);
                full * u64::from(status.snapshot.levels.get(lamp).0) / u64::from(Level::FULL.0)
            })
            .sum();
        let (verdict, found) = match status.snapshot.ultraviolet {
            _ if expected == 0 => (
                Verdict::NotTried,
                "not measured at commissioning: `ultraviolet_at_full_w_m2` in [lamps]".to_owned(),
            ),
            None => (Verdict::Failed, "no reading".to_owned()),
            Some(read) => {
                let tenths = 10 * u64::from(read.0) / expected;
                let sound = (u64::from(ULTRAVIOLET_DIM_TENTHS)..u64::from(ULTRAVIOLET_BRIGHT_TENTHS))
                    .contains(&tenths);
                let found = format!("{} mW/m2, {expected} expected", read.0);
                (Verdict::of(sound), found)
            }
        };
        self.add("ultraviolet", verdict, found);
    }

    /// The door: dark as it opens, dark until it is re-armed.
    fn door(&mut self, client: &mut Client, person: &mut dyn Person) -> Result<(), LinkError> {
        if !person.does("Open the door of the case, and leave it open.") {
            self.add("door", Verdict::NotTried, "nobody opened it");
            return Ok(());
        }
        let open = look(client, ACT_PATIENCE, |status| {
            status.snapshot.interlock == InterlockState::Open && !status.snapshot.enabled
        })?;
        let found = if open.is_ok() { "opening it darkens" } else { "opening it is not noticed" };
        self.add("door", Verdict::of(open.is_ok()), found);
        let is_closed = person.does("Close the door.");
        if !is_closed || open.is_err() {
            let why = if is_closed { "the door's opening was not noticed" } else { "nobody closed the door" };
            self.add("re-arm", Verdict::NotTried, why);
            return Ok(());
        }
        let waits =
            look(client, ACT_PATIENCE, |status| status.snapshot.interlock == InterlockState::WaitsForRearm)?;
        let refusal = refused(client.rearm())?;
        let armed = look(client, ACT_PATIENCE, |status| status.snapshot.interlock == InterlockState::Armed)?;
        let found = match (waits.is_ok(), armed.is_ok(), refusal) {
            (true, true, _) => "waits for a re-arm, and takes it".to_owned(),
            (false, true, _) => "was armed without being asked".to_owned(),
            (_, false, Some(refusal)) => refusal,
            (_, false, None) => "does not arm".to_owned(),
        };
        self.add("re-arm", Verdict::of(waits.is_ok() && armed.is_ok()), found);
        Ok(())
    }

    /// The staff key: dark, and back.
    fn staff_key(&mut self, client: &mut Client, person: &mut dyn Person) -> Result<(), LinkError> {
        if !person.does("Press the staff key shortly.") {
            self.add("staff key", Verdict::NotTried, "nobody pressed it");
            return Ok(());
        }
        let dark =
            look(client, ACT_PATIENCE, |status| status.snapshot.dark == Some(DarkReason::StaffKey))?.is_ok();
        if !dark {
            self.add("staff key", Verdict::Failed, "pressing it does nothing");
            return Ok(());
        }
        let back = person.does("Press the staff key shortly once more.")
            && look(client, ACT_PATIENCE, |status| status.snapshot.dark != Some(DarkReason::StaffKey))?
                .is_ok();
        let found = if back { "darkens, and lights again" } else { "darkens, but does not light again" };
        self.add("staff key", Verdict::of(back), found);
        Ok(())
    }

    /// A person to the left is left.
    fn visitor(&mut self, client: &mut Client, person: &mut dyn Person) -> Result<(), LinkError> {
        for (part, side, is_there) in [
            ("visitor, right", "right", (|centi_degrees| centi_degrees > 500) as fn(i16) -> bool),
            ("visitor, left", "left", |centi_degrees| centi_degrees < -500),
        ] {
            let ask = format!(
                "Stand a metre before the exhibit, well to the {side} of its middle as you look at it, and stay."
            );
            if !person.does(&ask) {
                self.add(part, Verdict::NotTried, "nobody stood there");
                continue;
            }
            let seen = look(client, LAMP_PATIENCE, |status| {
                status.snapshot.bearing.is_some_and(|bearing| is_there(bearing.horizontal.0))
            })?;
            let found = match &seen {
                Ok(status) | Err(status) => status.snapshot.bearing.map_or_else(
                    || "nobody is seen".to_owned(),
                    |bearing| format!("seen at {:.1} degrees", f64::from(bearing.horizontal.0) / 100.0),
                ),
            };
            self.add(part, Verdict::of(seen.is_ok()), found);
        }
        Ok(())
    }
}

/// Looks until `wanted` is so: the status that had it, or the last one that had not.
fn look(
    client: &mut Client,
    patience: Duration,
    wanted: impl Fn(&Status) -> bool,
) -> Result<Result<Status, Status>, LinkError> {
    let deadline = Instant::now() + patience;
    loop {
        let status = client.status()?;
        if wanted(&status) {
            return Ok(Ok(status));
        }
        if Instant::now() >= deadline {
            return Ok(Err(status));
        }
        sleep(LOOK);
    }
}

/// What the controller says against it, if it refuses.
fn refused(answer: Result<(), LinkError>) -> Result<Option<String>, LinkError> {
    match answer {
        Ok(()) => Ok(None),
        Err(LinkError::Refused { refusal, .. }) => Ok(Some(format!("refused: {refusal}"))),
        Err(error) => Err(error),
    }
}
