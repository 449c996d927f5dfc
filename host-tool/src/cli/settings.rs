//! `vitrine settings`: what belongs to a controller's board and its place.

use clap::Args;
use miette::{Diagnostic, Report};
use serde_json::{Map, Value, json};
use thiserror::Error;
use vitrine::plain::is_plain;
use vitrine_exhibit::settings::{ServicePort, Settings as Kept, SettingsError};
use vitrine_exhibit::units::CentiDegrees;

use super::connect::To;
use super::output::Output;

/// Tell the settings of a controller's board and its place, or change some of them.
///
/// They stay when another plan is uploaded. Those that correct sensors decide how hot and how bright the controller
/// believes the lamps to be: they change over a cable at the exhibit only, and with --yes.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine settings
  vitrine settings --set place=\"Hall 3, left case\" --yes
  vitrine settings --set top_beta_kelvin=3435 --set bottom_beta_kelvin=3435 --dry-run
  vitrine settings --json | jq .supply_divider

Settings: place, service_port (cable or network), top_beta_kelvin, bottom_beta_kelvin, supply_divider, \
ultraviolet_gain, viewer_yaw_deg, viewer_pitch_deg, viewer_beside_mm. `default` gives one its default back.")]
pub(super) struct Settings {
    /// Change this setting; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = assignment)]
    assignments: Vec<(String, String)>,
    /// Confirm the change.
    #[arg(long)]
    yes: bool,
    /// Only tell what would change.
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    to: To,
}

#[derive(Debug, Error, Diagnostic)]
enum SettingsFailure {
    #[error("there is no setting \"{key}\"")]
    #[diagnostic(code(vitrine::settings::no_such_setting), help("{help}"))]
    NoSuchSetting { key: String, help: String },
    #[error("{key} cannot be \"{value}\"")]
    #[diagnostic(code(vitrine::settings::value), help("give {wanted}"))]
    Value { key: &'static str, value: String, wanted: &'static str },
    #[error("{0}")]
    #[diagnostic(code(vitrine::settings::bounds), help("give a value within those bounds"))]
    Bounds(SettingsError),
}

/// One setting as a person reads and writes it.
struct Entry {
    key: &'static str,
    wanted: &'static str,
    field: fn(&mut Kept) -> Field<'_>,
}

/// Where a setting is kept, and in which parts of what a person writes.
enum Field<'a> {
    Name(&'a mut heapless::String<32>),
    Port(&'a mut ServicePort),
    Whole(&'a mut u16),
    Permille(&'a mut u16),
    Angle(&'a mut CentiDegrees),
}

const ENTRIES: [Entry; 9] = [
    Entry {
        key: "place",
        wanted: "a name of at most 32 bytes on one line",
        field: |kept| Field::Name(&mut kept.place),
    },
    Entry {
        key: "service_port",
        wanted: "cable, where a computer beside the exhibit is at its end, or network",
        field: |kept| Field::Port(&mut kept.service_port),
    },
    Entry {
        key: "top_beta_kelvin",
        wanted: "the NTC's beta, 2000 to 6000",
        field: |kept| Field::Whole(&mut kept.top_beta_kelvin),
    },
    Entry {
        key: "bottom_beta_kelvin",
        wanted: "the NTC's beta, 2000 to 6000",
        field: |kept| Field::Whole(&mut kept.bottom_beta_kelvin),
    },
    Entry {
        key: "supply_divider",
        wanted: "the lamp supply over what its divider gives, 5 to 20",
        field: |kept| Field::Permille(&mut kept.supply_divider_permille),
    },
    Entry {
        key: "ultraviolet_gain",
        wanted: "what the sensor's reading is multiplied by, 0.5 to 2",
        field: |kept| Field::Permille(&mut kept.ultraviolet_gain_permille),
    },
    Entry {
        key: "viewer_yaw_deg",
        wanted: "the viewer sensors' angle to either side, 10 to 25 degrees",
        field: |kept| Field::Angle(&mut kept.viewer_yaw),
    },
    Entry {
        key: "viewer_pitch_deg",
        wanted: "the viewer sensors' angle upwards, -30 to 30 degrees",
        field: |kept| Field::Angle(&mut kept.viewer_pitch),
    },
    Entry {
        key: "viewer_beside_mm",
        wanted: "the viewer sensors' distance from the stack's middle, 0 to 100 mm",
        field: |kept| Field::Whole(&mut kept.viewer_beside_mm),
    },
];

impl Entry {
    /// The setting's value, as a person writes it.
    fn read(&self, kept: &Kept) -> Value {
        match (self.field)(&mut kept.clone()) {
            Field::Name(name) => json!(name.as_str()),
            Field::Port(ServicePort::Cable) => json!("cable"),
            Field::Port(ServicePort::Network) => json!("network"),
            Field::Whole(whole) => json!(whole),
            Field::Permille(permille) => json!(f64::from(*permille) / 1000.0),
            Field::Angle(angle) => json!(f64::from(angle.0) / 100.0),
        }
    }

    /// Sets it to what a person has written; nothing where that is no such value.
    fn write(&self, kept: &mut Kept, text: &str) -> Option<()> {
        match (self.field)(kept) {
            Field::Name(name) => *name = Some(text).filter(|text| is_plain(text))?.try_into().ok()?,
            Field::Port(port) => {
                *port = match text {
                    "cable" => ServicePort::Cable,
                    "network" => ServicePort::Network,
                    _ => return None,
                }
            }
            Field::Whole(whole) => *whole = text.parse().ok()?,
            Field::Permille(permille) => *permille = parts(text, 1000.0)?,
            Field::Angle(angle) => *angle = CentiDegrees(parts(text, 100.0)?),
        }
        Some(())
    }
}

/// The settings by their keys, with units in them.
pub(super) fn as_json(kept: &Kept) -> Map<String, Value> {
    ENTRIES.iter().map(|entry| (entry.key.to_owned(), entry.read(kept))).collect()
}

impl Settings {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let mut client = self.to.open()?;
        let before = client.settings()?;
        let after = changed(&before, &self.assignments)?;
        let writes = after != before && !self.dry_run;
        if writes {
            if self.yes {
                client.confirm_more();
            }
            client.change_settings(&after)?;
        }
        let mut told = as_json(&after);
        told.insert("changed".to_owned(), json!(writes));
        output.result(&told, || as_text(&before, &after, writes));
        Ok(())
    }
}

/// The settings with these changes, within their bounds.
fn changed(before: &Kept, assignments: &[(String, String)]) -> Result<Kept, SettingsFailure> {
    let mut after = before.clone();
    for (key, value) in assignments {
        let Some(entry) = ENTRIES.iter().find(|entry| entry.key == key) else {
            let keys = ENTRIES.map(|entry| entry.key).join(", ");
            return Err(SettingsFailure::NoSuchSetting {
                key: key.clone(),
                help: format!("there are {keys}"),
            });
        };
        let default = || plain(entry.read(&Kept::default()));
        let wanted = if value == "default" { default() } else { value.clone() };
        if entry.write(&mut after, &wanted).is_none() {
            let (key, value) = (entry.key, value.clone());
            return Err(SettingsFailure::Value { key, value, wanted: entry.wanted });
        }
    }
    after.check().map_err(SettingsFailure::Bounds)?;
    Ok(after)
}

fn as_text(before: &Kept, after: &Kept, written: bool) -> String {
    let shown = |kept: &Kept, entry: &Entry| match plain(entry.read(kept)) {
        text if text.is_empty() => "not named".to_owned(),
        text => text,
    };
    let line = |entry: &Entry| {
        let (was, is) = (shown(before, entry), shown(after, entry));
        let change = match (was == is, written) {
            (true, _) => String::new(),
            (false, true) => format!("  (was {was})"),
            (false, false) => format!("  (is {was} until it is set)"),
        };
        format!("{:<20} {is}{change}", entry.key)
    };
    ENTRIES.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn plain(value: Value) -> String {
    match value {
        Value::String(text) => text,
        other => other.to_string(),
    }
}

fn assignment(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("give KEY=VALUE, such as place=\"Hall 3\"")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Reads a number as a whole count of its parts.
fn parts<T: TryFrom<i64>>(text: &str, parts: f64) -> Option<T> {
    let number: f64 = text.parse().ok()?;
    let counted = (number * parts).round();
    (counted.abs() < 1e6).then_some(counted as i64).and_then(|counted| T::try_from(counted).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(key: &str, value: &str) -> Result<Kept, SettingsFailure> {
        changed(&Kept::default(), &[(key.to_owned(), value.to_owned())])
    }

    #[test]
    fn every_setting_can_be_written_read_and_put_back() {
        let values =
            ["Hall 3", "network", "3435", "3436", "11.05", "1.08", "24.0", "-3.5", "25"].map(str::to_owned);
        for (entry, value) in ENTRIES.iter().zip(values) {
            let after = set(entry.key, &value).unwrap();
            assert_ne!(after, Kept::default(), "{}", entry.key);
            assert_eq!(plain(entry.read(&after)), value, "{}", entry.key);
            let back = changed(&after, &[(entry.key.to_owned(), "default".to_owned())]).unwrap();
            assert_eq!(back, Kept::default(), "{}", entry.key);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert!(matches!(set("beta", "1"), Err(SettingsFailure::NoSuchSetting { .. })));
        for (key, value) in [
            ("top_beta_kelvin", "hot"),
            ("top_beta_kelvin", "70000"),
            ("supply_divider", "NaN"),
            ("supply_divider", "1e300"),
            ("viewer_pitch_deg", "400"),
            ("service_port", "radio"),
            ("place", "a name that is longer than what the board keeps of it"),
        ] {
            assert!(matches!(set(key, value), Err(SettingsFailure::Value { .. })), "{key} {value}");
        }
        assert!(matches!(set("top_beta_kelvin", "1999"), Err(SettingsFailure::Bounds(_))));
    }
}
