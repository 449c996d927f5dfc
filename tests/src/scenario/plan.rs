//! What a scenario changes in the standard plan.

use serde::Deserialize;
use vitrine_exhibit::plan::calendar::{ClosedDays, Date, MinuteOfDay, ScheduleRule, TimeZone, Weekdays};
use vitrine_exhibit::plan::{BelowFloor, Between, CurvePoint, Paging, Plan, Policy, ViewerSensor};
use vitrine_exhibit::units::{CentiDegrees, Dose, Irradiance, Milliseconds, PerLamp};

use crate::bench::{level, view};

/// Changes to the standard plan; what is left out stays.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanChanges {
    views: Option<Vec<ViewLine>>,
    sensor: Option<String>,
    policy: Option<String>,
    smooth: bool,
    neutral: Option<(f64, f64)>,
    idle_level: Option<f64>,
    hold_s: Option<f64>,
    idle_s: Option<f64>,
    /// Top and bottom level for each two views: the first and the second, the first and the third and on.
    shared: Vec<(f64, f64)>,
    /// "time" or "step".
    paging: Option<String>,
    page_s: Option<f64>,
    step_deg: Option<f64>,
    turn_s: Option<f64>,
    fade_s: Option<f64>,
    dead_zone_deg: Option<f64>,
    full_level_w_m2: Option<f64>,
    ceiling_w_m2: Option<f64>,
    daily_dose_j_m2: Option<f64>,
    life_dose_j_m2: Option<f64>,
    continuous_s: Option<f64>,
    rest_s: Option<f64>,
    dither: bool,
    /// Both lamps' calibration: level and duty, from 0 to 1.
    curve: Vec<(f64, f64)>,
    zone: Option<String>,
    /// Days (Monday first, such as "1111100"), from and to in minutes of the day, level, first and last date.
    rules: Vec<Rule>,
    /// First and last date of closed days.
    closed: Vec<(String, String)>,
}

/// Id, horizontal and vertical angle in degrees, top and bottom level.
type ViewLine = (String, f64, f64, f64, f64);

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rule {
    days: String,
    from: String,
    to: String,
    #[serde(default = "full")]
    level: f64,
    first: Option<String>,
    last: Option<String>,
}

const fn full() -> f64 {
    1.0
}

impl PlanChanges {
    /// Changes a plan.
    ///
    /// # Errors
    /// A value that is not understood.
    pub fn apply(&self, mut plan: Plan) -> Result<Plan, String> {
        if let Some(views) = &self.views {
            plan.views =
                views.iter().map(|(id, h, v, top, bottom)| view(id, *h, *v, *top, *bottom)).collect();
        }
        self.apply_viewer(&mut plan)?;
        self.apply_limits(&mut plan);
        if let Some(zone) = &self.zone {
            plan.calendar.time_zone = TimeZone::from_posix(zone).map_err(|error| error.to_string())?;
        }
        plan.calendar.rules = self.rules.iter().map(Rule::read).collect::<Result<_, _>>()?;
        let closed = |(first, last): &(String, String)| {
            Ok::<_, String>(ClosedDays { first: date(first)?, last: date(last)? })
        };
        plan.calendar.closed = self.closed.iter().map(closed).collect::<Result<_, _>>()?;
        Ok(plan)
    }

    fn apply_viewer(&self, plan: &mut Plan) -> Result<(), String> {
        plan.viewer.sensor = match self.sensor.as_deref() {
            None | Some("either") => ViewerSensor::Either,
            Some("thermal") => ViewerSensor::Thermal,
            Some("radar") => ViewerSensor::Radar,
            Some(other) => return Err(format!("no such sensor: {other}")),
        };
        plan.viewer.policy = match self.policy.as_deref() {
            None | Some("first") => Policy::First,
            Some("nearest") => Policy::Nearest,
            Some("shared") => Policy::Shared,
            Some("alternating") => Policy::Alternating,
            Some(other) => return Err(format!("no such policy: {other}")),
        };
        if self.smooth {
            plan.viewer.between = Between::Smooth;
        }
        plan.viewer.paging = match self.paging.as_deref() {
            None | Some("time") => Paging::Time,
            Some("step") => Paging::Step,
            Some(other) => return Err(format!("pages are not turned by {other}")),
        };
        plan.shared =
            self.shared.iter().map(|&(top, bottom)| PerLamp::new(level(top), level(bottom))).collect();
        if let Some((top, bottom)) = self.neutral {
            plan.neutral.top = level(top);
            plan.neutral.bottom = level(bottom);
        }
        set(&mut plan.presence.idle_level, self.idle_level.map(level));
        set(&mut plan.presence.hold, self.hold_s.map(milliseconds));
        set(&mut plan.presence.idle, self.idle_s.map(milliseconds));
        set(&mut plan.viewer.page, self.page_s.map(milliseconds));
        set(&mut plan.viewer.turn, self.turn_s.map(milliseconds));
        set(&mut plan.viewer.fade, self.fade_s.map(milliseconds));
        let angle = |degrees: f64| CentiDegrees((degrees * 100.0) as i16);
        set(&mut plan.viewer.dead_zone, self.dead_zone_deg.map(angle));
        set(&mut plan.viewer.step, self.step_deg.map(angle));
        Ok(())
    }

    fn apply_limits(&self, plan: &mut Plan) {
        for lamp in [&mut plan.lamps.top, &mut plan.lamps.bottom] {
            set(&mut lamp.full_level, self.full_level_w_m2.map(irradiance));
            let point = |&(at, duty): &(f64, f64)| CurvePoint { level: level(at), duty: level(duty).0 };
            lamp.curve = self.curve.iter().map(point).collect();
            if self.dither {
                lamp.below_floor = BelowFloor::Dither;
            }
        }
        set(&mut plan.limits.ceiling, self.ceiling_w_m2.map(irradiance));
        set(&mut plan.limits.daily_dose, self.daily_dose_j_m2.map(dose));
        set(&mut plan.limits.life_dose, self.life_dose_j_m2.map(dose));
        set(&mut plan.limits.continuous, self.continuous_s.map(milliseconds));
        set(&mut plan.limits.rest, self.rest_s.map(milliseconds));
    }
}

impl Rule {
    fn read(&self) -> Result<ScheduleRule, String> {
        let days = self.days.chars().zip(0_u8..).map(|(day, bit)| u8::from(day == '1') << bit).sum();
        Ok(ScheduleRule {
            days: Weekdays(days),
            from: minute(&self.from)?,
            to: minute(&self.to)?,
            first: self.first.as_deref().map(date).transpose()?,
            last: self.last.as_deref().map(date).transpose()?,
            level: level(self.level),
        })
    }
}

fn set<T>(place: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *place = value;
    }
}

fn minute(text: &str) -> Result<MinuteOfDay, String> {
    let (hours, minutes) = text.split_once(':').ok_or_else(|| format!("not a time: {text}"))?;
    let number = |text: &str| text.parse::<u16>().map_err(|error| format!("{text}: {error}"));
    Ok(MinuteOfDay(number(hours)? * 60 + number(minutes)?))
}

fn date(text: &str) -> Result<Date, String> {
    let date: jiff::civil::Date = text.parse().map_err(|error| format!("{text}: {error}"))?;
    Ok(Date { year: date.year() as u16, month: date.month() as u8, day: date.day() as u8 })
}

fn milliseconds(seconds: f64) -> Milliseconds {
    Milliseconds((seconds * 1_000.0).round() as u32)
}

fn irradiance(w_m2: f64) -> Irradiance {
    Irradiance((w_m2 * 1_000.0).round() as u32)
}

fn dose(j_m2: f64) -> Dose {
    Dose((j_m2 * 1e6).round() as u64)
}
