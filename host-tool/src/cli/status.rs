//! `vitrine status`: how the exhibit is.

use std::path::PathBuf;

use clap::Args;
use miette::Report;
use serde_json::{Value, json};
use vitrine::build_folder::BuildFolder;
use vitrine::link::{Address, Client};
use vitrine_exhibit::Snapshot;
use vitrine_exhibit::units::{CentiCelsius, Dose, Irradiance, Lamp, Level, PerLamp};
use vitrine_protocol::{Hello, Status as Told, plan_file};

use super::clock::{drift_text, source_text, time_text};
use super::connect::To;
use super::exposure::Exposure;
use super::output::Output;
use super::words;

/// Tell how the exhibit is: viewer, view, lamps, dose, interlock, clock, faults.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine status
  vitrine status --exposure           what films and eyes receive, too
  vitrine status --build build        says whether the controller runs this build
  vitrine status --json --to tcp:127.0.0.1:7470 | jq .lamps")]
pub(super) struct Status {
    /// Compare the controller's plan with this build's.
    #[arg(long, value_name = "BUILD")]
    build: Option<PathBuf>,
    /// Also tell what each film has received, and what reaches an eye before the window.
    #[arg(long)]
    exposure: bool,
    #[command(flatten)]
    to: To,
}

impl Status {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let built = match &self.build {
            Some(path) => Some(plan_file::crc(&BuildFolder::open(path)?.plan_file()?)),
            None => None,
        };
        let mut client = self.to.open()?;
        let status = client.status()?;
        let in_sync = built.map(|crc| status.plan.as_ref().is_some_and(|plan| plan.crc == crc));
        let plan = if self.exposure { client.active_plan()? } else { None };
        let exposure = plan.map(|plan| Exposure::of(&status.snapshot, &plan));
        let mut told = as_json(client.address(), client.hello(), &status, in_sync);
        if let Some(exposure) = &exposure {
            told["exposure"] = exposure.as_json();
        }
        output.result(&told, || {
            let lines = exposure.iter().flat_map(Exposure::lines);
            let more: String = lines.map(|(what, text)| format!("\n{what:<11} {text}")).collect();
            as_text(&client, &status, in_sync) + &more
        });
        Ok(())
    }
}

fn as_text(client: &Client, status: &Told, in_sync: Option<bool>) -> String {
    let snapshot = &status.snapshot;
    let (name, view) = match &status.plan {
        Some(plan) => (plan.name.as_str(), plan.view_id.as_str()),
        None => ("without a plan", ""),
    };
    let hello = client.hello();
    let mut lines =
        vec![format!("{name} at {}, {}, firmware {}", client.address(), hello.serial_number, hello.firmware)];
    let mut line = |what: &str, text: String| lines.push(format!("{what:<11} {text}"));
    if let Some(in_sync) = in_sync {
        let text = if in_sync {
            "in sync: the controller runs this build"
        } else if status.plan.is_none() {
            "stale: the controller runs no plan; `vitrine upload` sends this build"
        } else {
            "stale: the controller runs another plan; `vitrine upload` sends this build"
        };
        line("build", text.to_owned());
    }
    let place = snapshot.bearing.map(|bearing| format!(", {}", words::bearing(bearing))).unwrap_or_default();
    line("viewer", format!("{}{place}", words::presence(snapshot.presence)));
    line("view", if view.is_empty() { "none".to_owned() } else { view.to_owned() });
    if let Some(asked) = words::lease(snapshot.lease) {
        line("asked for", asked);
    }
    line(
        "lamps",
        both(snapshot.levels.zip(snapshot.irradiance), |(level, irradiance)| {
            format!("{:.1} % ({:.2} W/m2)", percent(level), watts(irradiance))
        }),
    );
    if let Some(reason) = snapshot.dark {
        line("dark", reason.to_string());
    }
    for lamp in [Lamp::Top, Lamp::Bottom] {
        for cut in snapshot.cuts.get(lamp).iter() {
            line("dimmed", format!("{}: {}", words::lamp(lamp), words::cut(cut)));
        }
    }
    line("interlock", words::interlock(snapshot.interlock).to_owned());
    line(
        "boards",
        both(snapshot.boards, |board| {
            board.map_or_else(|| "no reading".to_owned(), |board| format!("{:.1} C", celsius(board)))
        }),
    );
    line(
        "enclosure",
        snapshot.enclosure.map_or_else(|| "no reading".to_owned(), |air| format!("{:.1} C", celsius(air))),
    );
    line("ultraviolet", ultraviolet_text(snapshot));
    line("dose today", both(snapshot.day_dose, |dose| format!("{:.1} kJ/m2", kilojoules(dose))));
    line("dose, life", both(snapshot.life_dose, |dose| format!("{:.1} kJ/m2", kilojoules(dose))));
    line("hours", both(snapshot.lit_s, |seconds| format!("{:.1}", f64::from(seconds) / 3600.0)));
    line(
        "clock",
        match status.clock.now {
            Some(now) => format!("{} from {}", time_text(now), source_text(status.clock.source)),
            None => "not known: `vitrine clock --set`".to_owned(),
        },
    );
    if let Some(drift) = drift_text(status.clock.record).filter(|_| status.clock.record.drifts()) {
        line("", drift);
    }
    line("starts", format!("{}, {} after a fault", snapshot.power_cycles, snapshot.watchdog_resets));
    lines.join("\n")
}

fn ultraviolet_text(snapshot: &Snapshot) -> String {
    match snapshot.ultraviolet {
        _ if snapshot.ultraviolet_lost => {
            "the sensor on which the plan counts is silent: service is due".to_owned()
        }
        Some(reading) => format!("{:.3} W/m2 at the sensor", watts(reading)),
        None => "no sensor".to_owned(),
    }
}

fn both<T>(pair: PerLamp<T>, text: impl Fn(T) -> String) -> String {
    let texts = pair.map(text);
    format!("top {}, bottom {}", texts.top, texts.bottom)
}

/// What a controller tells of itself, with units in the keys.
pub(super) fn as_json(address: &Address, hello: &Hello, status: &Told, in_sync: Option<bool>) -> Value {
    let snapshot = &status.snapshot;
    let lamp = |which: Lamp| {
        json!({
            "level": percent(*snapshot.levels.get(which)) / 100.0,
            "irradiance_w_m2": watts(*snapshot.irradiance.get(which)),
            "dimmed": snapshot.cuts.get(which).iter().map(words::cut).collect::<Vec<_>>(),
            "board_celsius": snapshot.boards.get(which).map(celsius),
            "day_dose_j_m2": kilojoules(*snapshot.day_dose.get(which)) * 1000.0,
            "life_dose_j_m2": kilojoules(*snapshot.life_dose.get(which)) * 1000.0,
            "lit_s": snapshot.lit_s.get(which),
            "full_level_s": snapshot.full_s.get(which),
        })
    };
    json!({
        "port": address.to_string(),
        "serial_number": hello.serial_number.as_str(),
        "firmware": hello.firmware.as_str(),
        "exhibit": status.plan.as_ref().map(|plan| plan.name.as_str()),
        "plan_crc": status.plan.as_ref().map(|plan| format!("{:08x}", plan.crc)),
        "runs_this_build": in_sync,
        "uptime_s": snapshot.uptime_ms as f64 / 1000.0,
        "presence": words::presence(snapshot.presence),
        "viewers": snapshot.viewers,
        "bearing": snapshot.bearing.map(|bearing| json!({
            "horizontal_deg": f64::from(bearing.horizontal.0) / 100.0,
            "vertical_deg": f64::from(bearing.vertical.0) / 100.0,
        })),
        "view": status.plan.as_ref().map(|plan| plan.view_id.as_str()).filter(|id| !id.is_empty()),
        "lamps": { "top": lamp(Lamp::Top), "bottom": lamp(Lamp::Bottom) },
        "enabled": snapshot.enabled,
        "dark": snapshot.dark.map(|reason| reason.to_string()),
        "interlock": words::interlock(snapshot.interlock),
        "enclosure_celsius": snapshot.enclosure.map(celsius),
        "supply_v": snapshot.supply.map(|supply| f64::from(supply.0) / 1000.0),
        "ultraviolet_w_m2": snapshot.ultraviolet.map(watts),
        "ultraviolet_sensor_lost": snapshot.ultraviolet_lost,
        "viewer_sensor_lost": snapshot.viewer_sensor_lost,
        "clock": { "now": status.clock.now.map(time_text), "source": source_text(status.clock.source) },
        "lease_s": f64::from(snapshot.lease.0) / 1000.0,
        "power_cycles": snapshot.power_cycles,
        "fault_resets": snapshot.watchdog_resets,
        "log_next": status.log_next,
        "damaged_frames": status.damaged_frames,
    })
}

fn percent(level: Level) -> f64 {
    100.0 * f64::from(level.0) / f64::from(Level::FULL.0)
}

fn watts(irradiance: Irradiance) -> f64 {
    f64::from(irradiance.0) / 1000.0
}

fn kilojoules(dose: Dose) -> f64 {
    dose.0 as f64 / 1e9
}

fn celsius(temperature: CentiCelsius) -> f64 {
    f64::from(temperature.0) / 100.0
}
