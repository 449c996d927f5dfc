//! What `watch` and `serve` show: the last that was heard, and whether it is still true.

use std::collections::VecDeque;
use std::time::Instant;

use miette::Diagnostic;
use vitrine::link::{Address, Ask, Update};
use vitrine_exhibit::plan::Plan;
use vitrine_exhibit::units::Milliseconds;
use vitrine_protocol::message::LogEntry;
use vitrine_protocol::{Hello, Status};

/// How long a view is held.
const HOLD: Milliseconds = Milliseconds(600_000);
/// How long it is kept dark.
const DARK: Milliseconds = Milliseconds(3_600_000);
/// Entries of the log that are kept.
const ENTRIES: usize = 100;

/// A key or a button with its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    Quit,
    Dark,
    Release,
    Rearm,
    /// Hold the view of this index.
    View(u8),
    Other,
}

/// Whether a controller is there.
#[derive(Debug)]
pub(super) enum Connection {
    /// Not heard of yet.
    Looking,
    /// There.
    There,
    /// Not there since, and why, with the remedy.
    Away { since: Instant, why: String, remedy: Option<String> },
}

/// What is known of the exhibit.
#[derive(Debug)]
pub(super) struct Model {
    pub(super) connection: Connection,
    pub(super) who: Option<(Address, Hello)>,
    pub(super) status: Option<Box<Status>>,
    pub(super) plan: Option<Box<Plan>>,
    pub(super) log: VecDeque<LogEntry>,
    /// The answer to the last key or button.
    pub(super) note: String,
    quit: bool,
}

impl Model {
    pub(super) fn new() -> Self {
        Self {
            connection: Connection::Looking,
            who: None,
            status: None,
            plan: None,
            log: VecDeque::new(),
            note: String::new(),
            quit: false,
        }
    }

    pub(super) const fn wants_to_quit(&self) -> bool {
        self.quit
    }

    pub(super) fn is_there(&self) -> bool {
        matches!(self.connection, Connection::There)
    }

    /// Takes what is new.
    pub(super) fn take(&mut self, update: Update) {
        match update {
            Update::Found(address, hello) => {
                let other =
                    self.who.as_ref().is_none_or(|(_, known)| known.serial_number != hello.serial_number);
                if other {
                    self.log.clear();
                }
                self.who = Some((address, hello));
                self.connection = Connection::There;
                self.note.clear();
            }
            Update::Status(status) => self.status = Some(status),
            Update::Plan(plan) => self.plan = plan,
            Update::Logged(entries) => {
                if self.is_another_log(&entries) {
                    self.log.clear();
                }
                let known = self.log.back().map_or(0, |last| last.sequence);
                self.log.extend(entries.into_iter().filter(|entry| entry.sequence > known));
                self.log.drain(..self.log.len().saturating_sub(ENTRIES));
            }
            Update::Answered(ask, Ok(())) => self.note = self.done(ask),
            Update::Answered(_, Err(error)) => self.note = error.to_string(),
            Update::Lost(error) => {
                let since = match self.connection {
                    Connection::Away { since, .. } => since,
                    Connection::Looking | Connection::There => Instant::now(),
                };
                let remedy = error.help().map(|help| help.to_string());
                self.connection = Connection::Away { since, why: error.to_string(), remedy };
            }
        }
    }

    /// Whether a log has begun anew since it was last heard, as that of a board does whose flash was erased.
    fn is_another_log(&self, entries: &[LogEntry]) -> bool {
        let ends_before =
            |last: &LogEntry| self.log.back().is_some_and(|known| last.sequence < known.sequence);
        let contradicts = |entry: &LogEntry| {
            self.log.iter().any(|known| known.sequence == entry.sequence && known != entry)
        };
        entries.last().is_some_and(ends_before) || entries.iter().any(contradicts)
    }

    /// Takes a key; gives what it asks of the controller.
    pub(super) fn press(&mut self, key: Key) -> Option<Ask> {
        let ask = match key {
            Key::Quit => {
                self.quit = true;
                return None;
            }
            Key::Other => return None,
            Key::Dark => Ask::Dark(DARK),
            Key::Release => Ask::Release,
            Key::Rearm => Ask::Rearm,
            Key::View(view) => Ask::Hold(view, HOLD),
        };
        if !self.is_there() {
            self.note = "the controller is not there: nothing was asked".to_owned();
            return None;
        }
        Some(ask)
    }

    /// The name of a view.
    pub(super) fn view_name(&self, view: u8) -> String {
        let id = self.plan.as_ref().and_then(|plan| plan.views.get(usize::from(view))).map(|view| &view.id);
        id.map_or_else(|| format!("view {}", u16::from(view) + 1), ToString::to_string)
    }

    fn done(&self, ask: Ask) -> String {
        match ask {
            Ask::Hold(view, lease) => {
                format!("{} is held for {} min", self.view_name(view), lease.0 / 60_000)
            }
            Ask::Dark(lease) => format!("dark for {} min", lease.0 / 60_000),
            Ask::Release => "released".to_owned(),
            Ask::Rearm => "re-arm asked for; the log tells whether it was granted".to_owned(),
        }
    }
}
