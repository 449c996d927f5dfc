//! `vitrine watch`: the exhibit on a terminal's screen, with keys for what a person may ask of it; or line by line.

mod lines;
mod screen;

use std::io::{IsTerminal, stdout};
use std::time::Duration;

use clap::Args;
use miette::{IntoDiagnostic, Report};
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use vitrine::link::Follower;

use super::connect::To;
use super::model::{Key, Model};
use super::output::Output;

/// How long keys are waited for before the screen is drawn anew.
const FRAME: Duration = Duration::from_millis(100);

/// Watch the exhibit: viewer, view, lamps, temperatures, dose, interlock, clock and the last events.
///
/// On a terminal it fills the screen. Elsewhere, or with --every, --count or --json, it prints a line for each look. Either way
/// it goes on when the controller disappears and comes back; only with --count it then fails.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine watch
  vitrine watch --to tcp:127.0.0.1:7470
  vitrine watch --every 0.2 --count 10 --json

Keys: 1 to 9 hold a view for 10 minutes, d dark for an hour, r release, a re-arm, q quit.")]
pub(super) struct Watch {
    /// Print a line for each look, so many seconds apart (1 if only --count is given).
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    every: Option<Duration>,
    /// Print a line for each look, and end after so many.
    #[arg(long, value_name = "LOOKS")]
    count: Option<u64>,
    #[command(flatten)]
    to: To,
}

impl Watch {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let wants_lines = self.every.is_some() || self.count.is_some() || output.is_json();
        if wants_lines || !stdout().is_terminal() {
            let every = self.every.unwrap_or(Duration::from_secs(1));
            return lines::follow(&self.to, every, self.count, output);
        }
        let follower = Follower::new(move || self.to.find());
        let mut terminal = ratatui::try_init().into_diagnostic()?;
        let outcome = show(&mut terminal, &follower);
        ratatui::restore();
        outcome.into_diagnostic()
    }
}

fn show(terminal: &mut ratatui::DefaultTerminal, follower: &Follower) -> std::io::Result<()> {
    let mut model = Model::new();
    while !model.wants_to_quit() {
        while let Some(update) = follower.next(Duration::ZERO) {
            model.take(update);
        }
        terminal.draw(|frame| screen::draw(frame, &model))?;
        if event::poll(FRAME)?
            && let Event::Key(key) = event::read()?
            && key.kind == KeyEventKind::Press
            && let Some(ask) = model.press(named(key.code, key.modifiers))
        {
            follower.ask(ask);
        }
    }
    Ok(())
}

fn named(code: KeyCode, modifiers: KeyModifiers) -> Key {
    match code {
        KeyCode::Char('c') if modifiers.contains(KeyModifiers::CONTROL) => Key::Quit,
        KeyCode::Char('q') | KeyCode::Esc => Key::Quit,
        KeyCode::Char('d') => Key::Dark,
        KeyCode::Char('r') => Key::Release,
        KeyCode::Char('a') => Key::Rearm,
        KeyCode::Char(digit @ '1'..='9') => Key::View(digit as u8 - b'1'),
        _ => Key::Other,
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "give a number of seconds".to_owned())?;
    if (0.05..=3600.0).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("give 0.05 to 3600 seconds".to_owned())
    }
}
