//! The commands: one file each, data on stdout, everything else on stderr.

mod calibrate;
mod changes;
mod check;
mod clock;
mod connect;
mod controller;
mod demo;
mod design;
mod devices;
mod doctor;
mod experiment;
mod exposure;
mod firmware;
mod frontier;
mod live;
mod log;
mod man;
mod materials;
mod model;
mod new;
mod outlook;
mod output;
mod print;
mod progress;
mod requests;
mod rows;
mod schema;
mod self_test;
mod serve;
mod settings;
mod setup;
mod slice;
mod status;
mod strips;
mod told;
mod turn;
mod upload;
mod view;
mod watch;
mod words;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use miette::{Diagnostic, Report};
use thiserror::Error;

use output::Output;

/// Designs, previews, uploads and runs film-stack exhibits.
#[derive(Parser)]
#[command(name = "vitrine", version, about, max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print results, and errors, as JSON.
    #[arg(long, global = true)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  vitrine demo                        the whole chain on the bundled photographs
  vitrine new my-exhibit              start an exhibit of your own
  vitrine design my-exhibit/exhibit.toml -o build
  vitrine upload build --to /dev/ttyACM0

Exit codes: 0 done, 1 failed (a wrong exhibit.toml too), 2 wrong usage of the command line, 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    Demo(demo::Demo),
    New(new::New),
    Check(check::Check),
    Design(design::Design),
    Slice(slice::Slice),
    View(view::View),
    Turn(turn::TurnCommand),
    Calibrate(calibrate::Calibrate),
    Materials(materials::Materials),
    Experiment(experiment::Experiment),
    Print(print::Print),
    Devices(devices::Devices),
    Upload(upload::Upload),
    Status(status::Status),
    Watch(watch::Watch),
    Serve(serve::Serve),
    Log(log::Log),
    Clock(clock::Clock),
    Hold(requests::Hold),
    Dark(requests::Dark),
    Open(requests::Open),
    Release(requests::Release),
    Rearm(requests::Rearm),
    NewStack(requests::NewStack),
    SelfTest(self_test::SelfTest),
    Settings(settings::Settings),
    Controller(controller::Controller),
    Schema(schema::Schema),
    Firmware(firmware::Firmware),
    Explain(setup::Explain),
    Doctor(doctor::Doctor),
    Completions(setup::Completions),
    Man(man::Man),
}

/// Runs the command that the process was started with.
pub(crate) fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    let output = Output::new(cli.json);
    if let Err(error) = vitrine::build_folder::clean_up_on_interrupt() {
        output.note(&format!("an interrupt will leave unfinished folders behind: {error}"));
    }
    match run(cli.command, output) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            output.error(&report);
            exit_code(&report)
        }
    }
}

/// The command line is wrong, or asks for help.
#[derive(Debug, Error, Diagnostic)]
#[error("{0}")]
#[diagnostic(code(vitrine::cli::usage), help("`vitrine COMMAND --help` has examples"))]
struct Usage(String);

/// Says what is wrong with the command line, as JSON where that is asked for; or helps.
fn usage(error: &clap::Error) -> ExitCode {
    if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
        let text = error.render().to_string();
        let told = text.trim().trim_start_matches("error: ").to_owned();
        Output::new(true).error(&Usage(told).into());
    } else if vitrine::plain::is_plain(&error.to_string().replace(['\n', '\t'], "")) {
        // A reader that has gone away is no reason to fail.
        let _ = error.print();
    } else {
        // Without colours, as a name on the command line holds what a terminal obeys.
        Output::new(false).note(error.to_string().trim_end());
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

fn exit_code(report: &Report) -> ExitCode {
    match report.downcast_ref() {
        Some(design::DesignFailure::Stopped | design::DesignFailure::Paused { .. }) => {
            ExitCode::from(vitrine::build_folder::INTERRUPTED)
        }
        _ => ExitCode::from(1),
    }
}

fn run(command: Command, output: Output) -> Result<(), Report> {
    match command {
        Command::Demo(command) => command.run(output),
        Command::New(command) => command.run(output),
        Command::Check(command) => command.run(output),
        Command::Design(command) => command.run(output),
        Command::Slice(command) => command.run(output),
        Command::View(command) => command.run(output),
        Command::Turn(command) => command.run(output),
        Command::Calibrate(command) => command.run(output),
        Command::Materials(command) => command.run(output),
        Command::Experiment(command) => command.run(output),
        Command::Print(command) => command.run(output),
        Command::Devices(command) => command.run(output),
        Command::Upload(command) => command.run(output),
        Command::Status(command) => command.run(output),
        Command::Watch(command) => command.run(output),
        Command::Serve(command) => command.run(output),
        Command::Log(command) => command.run(output),
        Command::Clock(command) => command.run(output),
        Command::Hold(command) => command.run(output),
        Command::Dark(command) => command.run(output),
        Command::Open(command) => command.run(output),
        Command::Release(command) => command.run(output),
        Command::Rearm(command) => command.run(output),
        Command::NewStack(command) => command.run(output),
        Command::SelfTest(command) => command.run(output),
        Command::Settings(command) => command.run(output),
        Command::Controller(command) => command.run(output),
        Command::Schema(command) => command.run(output),
        Command::Firmware(command) => command.run(output),
        Command::Explain(command) => command.run(output),
        Command::Doctor(command) => command.run(output),
        Command::Completions(command) => command.run(output),
        Command::Man(command) => command.run(output),
    }
}
