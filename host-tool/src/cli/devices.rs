//! `vitrine devices`: which controllers there are.

use clap::Args;
use miette::{Diagnostic, Report};
use vitrine::link::{Device, devices};

use super::output::Output;

/// List the controllers, and why a port cannot be used.
#[derive(Args)]
#[command(after_help = "Examples:\n  vitrine devices\n  vitrine devices --json | jq '.[].port'")]
pub(super) struct Devices {}

impl Devices {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let found = devices();
        let list: Vec<serde_json::Value> = found.iter().map(as_json).collect();
        output.result(&list, || found.iter().map(line).collect::<Vec<_>>().join("\n"));
        if found.is_empty() {
            output.note("no controller: plug one in, or start a simulated one with `vitrine controller`");
        }
        Ok(())
    }
}

fn line(device: &Device) -> String {
    let serial = device.serial_number.as_deref().unwrap_or("-");
    let start = format!("{:<24} {serial:<18} {:<22}", device.address.to_string(), device.kind);
    match &device.state {
        Ok(hello) if hello.name.is_empty() => format!("{start} ready, without a plan"),
        Ok(hello) => format!("{start} ready: {}", hello.name),
        Err(error) => {
            let help = error.help().map(|help| format!("; {help}")).unwrap_or_default();
            format!("{start} {}: {error}{help}", error.reason())
        }
    }
}

/// A port and what is behind it.
pub(super) fn as_json(device: &Device) -> serde_json::Value {
    let error = device.state.as_ref().err();
    let hello = device.state.as_ref().ok();
    serde_json::json!({
        "port": device.address.to_string(),
        "kind": device.kind,
        "serial_number": device.serial_number,
        "ready": error.is_none(),
        "firmware": hello.map(|hello| hello.firmware.as_str()),
        "exhibit": hello.map(|hello| hello.name.as_str()),
        "reason": error.map(|error| error.reason()),
        "error": error.map(ToString::to_string),
        "help": error.and_then(|error| error.help()).map(|help| help.to_string()),
    })
}
