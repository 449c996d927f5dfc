//! From an exhibit and its design to the plan that the controller keeps.

use heapless::{String, Vec};
use jiff::civil;
use vitrine_exhibit::plan::calendar::{self, Calendar, ClosedDays, MinuteOfDay, Weekdays};
use vitrine_exhibit::plan::{
    BelowFloor, Between, CurvePoint, Emphasis, LampCalibration, Limits, Paging, Plan, Policy,
    PresenceSettings, View, ViewerSensor, ViewerSettings, VolumeMetadata,
};
use vitrine_exhibit::units::{CentiDegrees, Dose, Irradiance, Level, Milliseconds, PerLamp};

use super::calendar::closed_spans;
use super::exhibit::{
    BelowFloorSetting, BetweenSetting, Exhibit, PagingSetting, PolicySetting, ScheduleRule, SensorSetting,
};
use super::zone::{ZoneError, time_zone};
use crate::optics::LampPair;

/// The lamp pairs of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanPairs {
    /// Of the views, in their order.
    pub views: std::vec::Vec<LampPair>,
    /// For nobody in particular.
    pub neutral: LampPair,
    /// For each two views at once: the first and the second, the first and the third and on; or none.
    pub shared: std::vec::Vec<LampPair>,
}

impl Exhibit {
    /// The plan of this exhibit, whose printed volume is named by `volume_blake3`. Where the lamps are stronger than the
    /// ceiling allows, all pairs are dimmed alike, so that none loses its balance.
    ///
    /// # Errors
    /// Fails when the time zone is unknown, which a file that was read does not have.
    pub fn plan(&self, pairs: &PlanPairs, volume_blake3: [u8; 32]) -> Result<Plan, ZoneError> {
        let held = |pair: &LampPair| emphasis(pair.scaled(self.level_under_the_ceiling()));
        Ok(Plan {
            name: shortened(&self.name),
            volume: self.volume_metadata(volume_blake3),
            views: self.plan_views(&pairs.views.iter().map(held).collect::<std::vec::Vec<_>>()),
            neutral: held(&pairs.neutral),
            shared: pairs.shared.iter().map(held).collect(),
            lamps: PerLamp::new(self.lamp_calibration(0), self.lamp_calibration(1)),
            limits: self.plan_limits(),
            viewer: self.viewer_settings(),
            presence: self.presence_settings(),
            calendar: self.plan_calendar()?,
        })
    }

    /// The largest level that keeps a lamp under the plan's ceiling, at most 1.
    pub fn level_under_the_ceiling(&self) -> f64 {
        (self.lamps.ceiling_w_m2 / self.lamps.irradiance_w_m2).min(1.0)
    }

    /// The calendar of this exhibit, by which `vitrine check` previews what the controller will keep.
    ///
    /// # Errors
    /// Fails when the time zone is unknown.
    pub fn plan_calendar(&self) -> Result<Calendar, ZoneError> {
        let closed = closed_spans(&self.calendar.closed);
        Ok(Calendar {
            time_zone: time_zone(&self.calendar.time_zone)?,
            rules: self.schedule.iter().map(plan_rule).collect(),
            closed: closed
                .iter()
                .map(|span| ClosedDays { first: date(span.0), last: date(span.1) })
                .collect(),
        })
    }

    /// What the controller may give the stack.
    pub fn plan_limits(&self) -> Limits {
        Limits {
            ceiling: irradiance(self.lamps.ceiling_w_m2),
            daily_dose: dose(self.limits.daily_dose_j_m2),
            life_dose: dose(self.limits.life_dose_j_m2),
            continuous: milliseconds(self.limits.continuous_s),
            rest: milliseconds(self.limits.rest_s),
        }
    }

    /// What one lamp that is wanted at full level gives in the hours of a day with somebody there, as the brightest
    /// rule, the ceiling and the rests allow; 0 where nobody can tell the hours.
    pub fn expected_dose_j_m2(&self) -> f64 {
        let level = self.schedule.iter().map(|rule| rule.level).fold(f64::NAN, f64::max);
        let level = if level.is_nan() { 1.0 } else { level };
        let w_m2 = (self.lamps.irradiance_w_m2 * level).min(self.lamps.ceiling_w_m2);
        let share = self.limits.continuous_s / (self.limits.continuous_s + self.limits.rest_s);
        w_m2 * share * self.presence.expected_h_a_day.unwrap_or(0.0) * 3600.0
    }

    /// Irradiance of one lamp at full level on the nearest film.
    pub fn full_level(&self) -> Irradiance {
        irradiance(self.lamps.irradiance_w_m2)
    }

    fn plan_views(&self, emphases: &[Emphasis]) -> Vec<View, { vitrine_exhibit::plan::MAX_VIEWS }> {
        let pairs = self.views.iter().zip(emphases);
        pairs
            .map(|(view, pair)| View {
                id: shortened(&view.id),
                horizontal: centi_degrees(view.horizontal_deg),
                vertical: centi_degrees(view.vertical_deg),
                emphasis: *pair,
            })
            .collect()
    }

    fn volume_metadata(&self, blake3: [u8; 32]) -> VolumeMetadata {
        let micrometres = |millimetres: f64| (millimetres * 1000.0).round() as u32;
        VolumeMetadata {
            films: self.stack.films as u16,
            width_px: self.stack.pixels[0],
            height_px: self.stack.pixels[1],
            width_um: micrometres(self.stack.width_mm),
            film_pitch_um: micrometres(self.stack.film_pitch_mm()),
            blake3,
        }
    }

    fn viewer_settings(&self) -> ViewerSettings {
        let visitors = &self.visitors;
        ViewerSettings {
            sensor: match visitors.sensor {
                SensorSetting::Either => ViewerSensor::Either,
                SensorSetting::Thermal => ViewerSensor::Thermal,
                SensorSetting::Radar => ViewerSensor::Radar,
            },
            policy: match visitors.policy {
                PolicySetting::First => Policy::First,
                PolicySetting::Nearest => Policy::Nearest,
                PolicySetting::Shared => Policy::Shared,
                PolicySetting::Alternating => Policy::Alternating,
            },
            between: match visitors.between {
                BetweenSetting::Nearest => Between::Nearest,
                BetweenSetting::Smooth => Between::Smooth,
            },
            hysteresis: centi_degrees(visitors.hysteresis_deg),
            dwell: milliseconds(visitors.dwell_s),
            least_hold: milliseconds(visitors.least_hold_s),
            dead_zone: centi_degrees(visitors.dead_zone_deg),
            turn: milliseconds(visitors.turn_s),
            paging: match visitors.paging {
                PagingSetting::Time => Paging::Time,
                PagingSetting::Step => Paging::Step,
            },
            page: milliseconds(visitors.page_s),
            step: centi_degrees(visitors.step_deg),
            fade: milliseconds(visitors.fade_s),
        }
    }

    fn presence_settings(&self) -> PresenceSettings {
        PresenceSettings {
            hold: milliseconds(self.presence.hold_s),
            idle: milliseconds(self.presence.idle_s),
            fade: milliseconds(self.presence.fade_s),
            idle_level: level(self.presence.idle_level),
        }
    }

    /// The calibration of the top lamp (0) or of the bottom lamp (1).
    pub(super) fn lamp_calibration(&self, lamp: usize) -> LampCalibration {
        let curve = self.lamps.calibration.iter();
        LampCalibration {
            full_level: self.full_level(),
            curve: curve
                .map(|[duty, part]| CurvePoint { level: level(*part), duty: level(*duty).0 })
                .collect(),
            below_floor: match self.lamps.below_floor {
                BelowFloorSetting::Cut => BelowFloor::Cut,
                BelowFloorSetting::Dither => BelowFloor::Dither,
            },
            ultraviolet_at_full: irradiance(
                self.lamps.ultraviolet_at_full_w_m2.map_or(0.0, |both| both[lamp]),
            ),
        }
    }
}

fn plan_rule(rule: &ScheduleRule) -> calendar::ScheduleRule {
    let days = rule.days.iter().enumerate().map(|(day, holds)| u8::from(*holds) << day).sum();
    calendar::ScheduleRule {
        days: Weekdays(days),
        from: MinuteOfDay(rule.from_minute),
        to: MinuteOfDay(rule.to_minute),
        first: rule.first.map(date),
        last: rule.last.map(date),
        level: level(rule.level),
    }
}

fn date(date: civil::Date) -> calendar::Date {
    calendar::Date { year: date.year() as u16, month: date.month() as u8, day: date.day() as u8 }
}

/// A lamp pair in the plan's units.
pub fn emphasis(pair: LampPair) -> Emphasis {
    PerLamp::new(level(pair.top), level(pair.bottom))
}

fn level(part: f64) -> Level {
    Level((part.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16)
}

fn centi_degrees(degrees: f64) -> CentiDegrees {
    CentiDegrees((degrees * 100.0).round() as i16)
}

fn irradiance(w_m2: f64) -> Irradiance {
    Irradiance((w_m2 * 1000.0).round() as u32)
}

fn dose(j_m2: f64) -> Dose {
    Dose((j_m2 * 1e6).round() as u64)
}

fn milliseconds(seconds: f64) -> Milliseconds {
    Milliseconds((seconds * 1000.0).round() as u32)
}

/// As much of `text` as fits, whole characters only.
fn shortened<const N: usize>(text: &str) -> String<N> {
    let mut short = String::new();
    for character in text.chars() {
        if short.push(character).is_err() {
            break;
        }
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;
    use vitrine_exhibit::plan::ValidPlan;

    /// The pairs of an exhibit with one view.
    fn one(pair: LampPair) -> PlanPairs {
        PlanPairs { views: vec![pair], neutral: LampPair::FULL, shared: Default::default() }
    }

    #[test]
    fn a_plan_from_exhibit_toml_is_one_the_controller_takes() {
        let text = "\
            [exhibit]\nname = \"Nächte\"\n\
            [[view]]\nid = \"right\"\npattern = \"photos/cat.jpg\"\nhorizontal_deg = 29.996\n\
            [[schedule]]\ndays = [\"mon-wed\", \"sun\"]\nfrom = \"22:00\"\nto = \"02:00\"\nlevel = 0.5\n\
            [lamps]\ncalibration = [[0, 0], [0.25, 0.5], [1, 1]]\nbelow_floor = \"dither\"\n\
            ultraviolet_at_full_w_m2 = [0.21, 0.105]\n\
            [visitors]\npolicy = \"shared\"\nbetween = \"smooth\"\nhysteresis_deg = 3\ndwell_s = 0.5\n\
            [presence]\nhold_s = 15\nidle_level = 0.25\n\
            [calendar]\ntime_zone = \"Europe/Berlin\"\nclosed = [\"2026-12-25\", \"2026-12-24\"]\n";
        let exhibit =
            parse(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("exhibit.toml"), text).unwrap();
        let pairs = one(LampPair::new(1.0, 0.5));
        let plan = exhibit.plan(&pairs, [7; 32]).unwrap();
        assert_eq!(plan.name, "Nächte");
        assert_eq!(plan.views[0].horizontal, CentiDegrees(3000));
        assert_eq!(plan.views[0].emphasis, PerLamp::new(Level::FULL, Level(32_768)));
        assert_eq!(plan.calendar.rules[0].days, Weekdays(0b100_0111));
        assert_eq!((plan.calendar.rules[0].from.0, plan.calendar.rules[0].to.0), (1320, 120));
        assert_eq!(plan.calendar.closed.len(), 1);
        assert_eq!(plan.lamps.top.curve[1], CurvePoint { level: Level(32_768), duty: 16_384 });
        assert_eq!(plan.volume.width_um, 35_000);
        assert_eq!(plan.lamps.bottom.below_floor, BelowFloor::Dither);
        let ultraviolet = plan.lamps.clone().map(|lamp| lamp.ultraviolet_at_full);
        assert_eq!(ultraviolet, PerLamp::new(Irradiance(210), Irradiance(105)));
        assert_eq!((plan.viewer.policy, plan.viewer.between), (Policy::Shared, Between::Smooth));
        assert_eq!((plan.viewer.hysteresis, plan.viewer.dwell), (CentiDegrees(300), Milliseconds(500)));
        assert_eq!((plan.presence.hold, plan.presence.idle_level), (Milliseconds(15_000), Level(16_384)));
        assert!(ValidPlan::new(plan).is_ok());
    }

    #[test]
    fn what_is_left_out_is_the_firmwares_default() {
        let text = "[[view]]\nid = \"front\"\npattern = \"photos/cat.jpg\"\n";
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("exhibit.toml");
        let plan = parse(&path, text).unwrap().plan(&one(LampPair::FULL), [7; 32]).unwrap();
        assert_eq!(plan.viewer, ViewerSettings::default());
        assert_eq!(plan.limits, Limits::default());
        assert_eq!(plan.lamps, PerLamp::default());
        let idle_level = plan.presence.idle_level;
        assert_eq!(PresenceSettings { idle_level, ..PresenceSettings::default() }, plan.presence);
        assert!(idle_level.0.abs_diff(PresenceSettings::default().idle_level.0) <= 1);
    }

    #[test]
    fn pairs_are_dimmed_under_the_ceiling_and_keep_their_balance() {
        let text = "\
            [lamps]\nirradiance_w_m2 = 25\nceiling_w_m2 = 10\n[visitors]\npaging = \"step\"\nstep_deg = 9\n\
            [[view]]\nid = \"a\"\npattern = \"photos/cat.jpg\"\nlamp = \"top\"\n\
            [[view]]\nid = \"b\"\npattern = \"photos/cat.jpg\"\nlamp = \"bottom\"\n";
        let exhibit =
            parse(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("exhibit.toml"), text).unwrap();
        let pairs = PlanPairs {
            views: vec![LampPair::TOP, LampPair::new(0.0, 0.5)],
            neutral: LampPair::FULL,
            shared: vec![LampPair::new(1.0, 0.5)],
        };
        let plan = exhibit.plan(&pairs, [7; 32]).unwrap();
        assert_eq!(plan.views[0].emphasis, PerLamp::new(Level(26_214), Level(0)));
        assert_eq!(plan.views[1].emphasis, PerLamp::new(Level(0), Level(13_107)));
        assert_eq!(plan.shared[0], PerLamp::new(Level(26_214), Level(13_107)));
        assert_eq!(plan.neutral, PerLamp::new(Level(26_214), Level(26_214)));
        assert_eq!((plan.viewer.paging, plan.viewer.step), (Paging::Step, CentiDegrees(900)));
        assert!(ValidPlan::new(plan).is_ok());
    }
}
