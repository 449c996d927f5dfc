//! `vitrine controller`: the controller, simulated on this computer.

use std::path::PathBuf;
use std::sync::mpsc::channel;

use clap::Args;
use miette::{Diagnostic, Report};
use serde_json::json;
use thiserror::Error;
use vitrine::build_folder::Interrupt;
use vitrine::controller::{Clock, DEFAULT_PORT, FlashFile, Pace, VirtualController, Walk, serve, try_place};
use vitrine::link::Address;
use vitrine::plain;
use vitrine_protocol::Refusal;

use super::output::Output;

/// Simulate a controller on this computer, in real time, until it is interrupted.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine controller
  vitrine controller --listen tcp:7480 --flash exhibit.flash --visitor
  vitrine controller --flash exhibit.flash --dry-run
  vitrine upload build --to tcp:127.0.0.1:7480")]
pub(super) struct Controller {
    /// Where to listen: tcp:PORT on this computer, or tcp:HOST:PORT.
    #[arg(long, value_name = "tcp:PORT", default_value_t = default_address())]
    listen: Address,
    /// The file that holds its flash memory; without it, all is forgotten at the end.
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// Only tell whether it could: nothing is listened to, and the flash file stays as it is.
    #[arg(long)]
    dry_run: bool,
    /// Let a visitor come, walk back and forth, and go, again and again.
    #[arg(long)]
    visitor: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum ControllerFailure {
    #[error("a simulated controller cannot listen at {0}")]
    #[diagnostic(code(vitrine::controller::no_tcp), help("give --listen tcp:PORT or tcp:HOST:PORT"))]
    NoTcp(Address),
    #[error("the simulated controller does not start: {0}")]
    #[diagnostic(code(vitrine::controller::start), help("give another --flash file"))]
    Start(Refusal),
    #[error("`vitrine devices` will not find this controller")]
    #[diagnostic(code(vitrine::controller::announce), help("say where it is with --to"))]
    Announce(#[source] std::io::Error),
}

impl Controller {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let Address::Tcp(place) = &self.listen else {
            return Err(ControllerFailure::NoTcp(self.listen).into());
        };
        if self.dry_run {
            return self.look(place, output);
        }
        let flash = match &self.flash {
            Some(path) => FlashFile::open(path)?,
            None => FlashFile::in_memory(),
        };
        let mut controller =
            VirtualController::new(flash, Clock::Computer).map_err(ControllerFailure::Start)?;
        if self.visitor {
            controller.set_walk(Walk::back_and_forth());
        }
        // Whoever reads the address may interrupt at once.
        let (ending, ends) = channel();
        let _interrupt = Interrupt::does(move || {
            let _ = ending.send(());
        });
        let mut served = serve(controller, place, Pace::RealTime)?;
        if let Err(error) = served.announce() {
            output.error(&ControllerFailure::Announce(error).into());
        }
        let address = format!("tcp:{}", served.address());
        output.result(&json!({ "listening": address, "started": true }), || address.clone());
        output.note("listening; Ctrl-C ends it");
        // The sender is kept until it sends.
        let _ = ends.recv();
        drop(served);
        Ok(())
    }
}

impl Controller {
    /// Looks whether place and flash can be had.
    fn look(&self, place: &str, output: Output) -> Result<(), Report> {
        try_place(place)?;
        let is_there = self.flash.as_deref().map(FlashFile::look).transpose()?;
        output.result(&json!({ "listening": self.listen.to_string(), "started": false }), || {
            let flash = match (&self.flash, is_there) {
                (Some(path), Some(true)) => format!("go on with the flash memory in {}", plain::path(path)),
                (Some(path), _) => format!("keep its flash memory in {}, which is new", plain::path(path)),
                (None, _) => "forget all at the end".to_owned(),
            };
            format!("would listen at {}, and {flash}", self.listen)
        });
        Ok(())
    }
}

fn default_address() -> Address {
    Address::Tcp(format!("127.0.0.1:{DEFAULT_PORT}"))
}
