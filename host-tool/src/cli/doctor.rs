//! `vitrine doctor`: all that a person needs to help.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::Args;
use miette::{Diagnostic, Report};
use serde_json::{Value, json};
use vitrine::build_folder::BuildFolder;
use vitrine::link::{Address, Client, Device, LinkError, devices};
use vitrine_protocol::plan_file;

use super::output::Output;

/// Collect what a person needs to help: versions, ports, controllers and their last events.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine doctor
  vitrine doctor --build build > doctor.json

It reads, and changes nothing. Send what it prints along when you ask for help.")]
pub(super) struct Doctor {
    /// Also tell of this build: what was designed, how well, and whether the controllers run it.
    #[arg(long, value_name = "BUILD")]
    build: Option<PathBuf>,
}

impl Doctor {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let build = self.build.as_deref().map(BuildFolder::open).transpose()?;
        let crc =
            build.as_ref().map(|build| build.plan_file().map(|bytes| plan_file::crc(&bytes))).transpose()?;
        let ports = devices();
        let ready = ports.iter().filter(|port| port.state.is_ok());
        let controllers: Vec<Value> = ready.map(|port| controller(port, crc)).collect();
        let told = json!({
            "vitrine": env!("CARGO_PKG_VERSION"),
            "protocol": vitrine_protocol::VERSION,
            "fingerprint": format!("{:08x}", vitrine_protocol::FINGERPRINT),
            "system": format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            "processors": std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            "terminal": terminal(),
            "ports": ports.iter().map(super::devices::as_json).collect::<Vec<_>>(),
            "controllers": controllers,
            "build": build.as_ref().map(about_build),
        });
        // One form serves both: it is to be sent to somebody who helps.
        let text = serde_json::to_string_pretty(&told).unwrap_or_default();
        output.result(&told, || text);
        Ok(())
    }
}

/// What decides how results look here.
fn terminal() -> Value {
    let said = |name: &str| std::env::var(name).ok();
    json!({
        "output": std::io::stdout().is_terminal(),
        "errors": std::io::stderr().is_terminal(),
        "TERM": said("TERM"),
        "NO_COLOR": said("NO_COLOR"),
        "LANG": said("LANG"),
    })
}

fn about_build(build: &BuildFolder) -> Value {
    let manifest = build.manifest();
    json!({
        "folder": build.path(),
        "vitrine": manifest.vitrine,
        "exhibit": manifest.exhibit,
    })
}

/// All that a controller tells of itself, or why it does not.
fn controller(device: &Device, crc: Option<u32>) -> Value {
    ask_controller(&device.address, crc).unwrap_or_else(|error| {
        let help = error.help().map(|help| help.to_string());
        json!({ "port": device.address.to_string(), "error": error.to_string(), "help": help })
    })
}

fn ask_controller(address: &Address, crc: Option<u32>) -> Result<Value, LinkError> {
    const LAST_EVENTS: u32 = 50;
    let mut client = Client::open(address)?;
    let status = client.status()?;
    let events = client.log(status.log_next.saturating_sub(LAST_EVENTS))?;
    let settings = client.settings()?;
    let firmware = client.firmware()?;
    let in_sync = crc.map(|crc| status.plan.as_ref().is_some_and(|plan| plan.crc == crc));
    Ok(json!({
        "port": address.to_string(),
        "status": super::status::as_json(client.address(), client.hello(), &status, in_sync),
        "settings": super::settings::as_json(&settings),
        "firmware": { "version": firmware.version.as_str(), "blake3": blake3::Hash::from(firmware.digest).to_hex().as_str() },
        "last_events": events.iter().map(super::log::as_json).collect::<Vec<_>>(),
    }))
}
