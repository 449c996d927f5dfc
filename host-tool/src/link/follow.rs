//! Follows a controller for as long as one looks: tells how it is, and finds it again when it has been away.

use std::{
    sync::mpsc::{Receiver, RecvTimeoutError, SendError, Sender, channel},
    thread,
    time::Duration,
};

use vitrine_exhibit::{plan::Plan, units::Milliseconds};
use vitrine_protocol::{Hello, Status, message::LogEntry};

use super::{Address, Client, LinkError};

/// How often the controller is asked how it is.
const PERIOD: Duration = Duration::from_millis(200);
/// How long after a failure it is looked for again.
const RETRY: Duration = Duration::from_secs(1);
/// How many of the log's newest entries are read at first.
const FIRST_ENTRIES: u32 = 20;

/// What a person asks for while watching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Show the view of this index for a while.
    Hold(u8, Milliseconds),
    /// Both lamps off for a while.
    Dark(Milliseconds),
    /// End hold and dark.
    Release,
    /// Re-arm.
    Rearm,
}

/// What there is to know.
#[derive(Debug)]
pub enum Update {
    /// A controller was found.
    Found(Address, Hello),
    /// How the exhibit is.
    Status(Box<Status>),
    /// The plan that is active now; none if there is none, or this vitrine cannot read it.
    Plan(Option<Box<Plan>>),
    /// New entries of the log, oldest first.
    Logged(Vec<LogEntry>),
    /// What was asked is done, or refused.
    Answered(Ask, Result<(), LinkError>),
    /// The controller is not there, or not any more; it is looked for again.
    Lost(LinkError),
}

/// A controller being followed; following ends when this is dropped.
#[derive(Debug)]
pub struct Follower {
    updates: Receiver<Update>,
    asks: Sender<Ask>,
}

impl Follower {
    /// Follows the controller that `find` finds: it is asked anew after each loss, as a port may get another name.
    pub fn new(find: impl FnMut() -> Result<Address, LinkError> + Send + 'static) -> Self {
        let (update, updates) = channel();
        let (asks, asked) = channel();
        thread::spawn(move || {
            let _nobody_looks_any_more = follow(find, &update, &asked);
        });
        Self { updates, asks }
    }

    /// Waits at most so long for what there is to know; none if there is nothing new.
    pub fn next(&self, patience: Duration) -> Option<Update> {
        self.updates.recv_timeout(patience).ok()
    }

    /// Asks the controller, as soon as it is there.
    pub fn ask(&self, ask: Ask) {
        let _the_thread_lives_as_long_as_this = self.asks.send(ask);
    }
}

/// Nobody looks any more.
struct Gone;

impl From<SendError<Update>> for Gone {
    fn from(_: SendError<Update>) -> Self {
        Self
    }
}

fn follow(
    mut find: impl FnMut() -> Result<Address, LinkError>,
    update: &Sender<Update>,
    asked: &Receiver<Ask>,
) -> Result<(), Gone> {
    loop {
        let error = match find().and_then(|address| Client::open(&address)) {
            Ok(mut client) => {
                update.send(Update::Found(client.address().clone(), client.hello().clone()))?;
                stay(&mut client, update, asked)?
            }
            Err(error) => error,
        };
        update.send(Update::Lost(error))?;
        thread::sleep(RETRY);
        // What was asked of a controller that was not there is old by now.
        while asked.try_recv().is_ok() {}
    }
}

/// Stays with a controller until it is lost.
fn stay(client: &mut Client, update: &Sender<Update>, asked: &Receiver<Ask>) -> Result<LinkError, Gone> {
    let mut known = Known::default();
    loop {
        match known.catch_up(client) {
            Ok(updates) => {
                for news in updates {
                    update.send(news)?;
                }
            }
            Err(error) => return Ok(error),
        }
        match asked.recv_timeout(PERIOD) {
            Ok(ask) => {
                let outcome = put(client, ask);
                update.send(Update::Answered(ask, outcome))?;
            }
            Err(RecvTimeoutError::Timeout) => {}
            // Nobody looks any more: the next update will not arrive either.
            Err(RecvTimeoutError::Disconnected) => thread::sleep(PERIOD),
        }
    }
}

/// What has been told of a controller.
#[derive(Default)]
struct Known {
    next_entry: Option<u32>,
    plan_crc: Option<Option<u32>>,
}

impl Known {
    /// Asks for what is new.
    fn catch_up(&mut self, client: &mut Client) -> Result<Vec<Update>, LinkError> {
        let status = client.status()?;
        let mut updates = Vec::new();
        let plan_crc = status.plan.as_ref().map(|plan| plan.crc);
        if self.plan_crc != Some(plan_crc) {
            let plan = match plan_crc {
                Some(_) => client.active_plan()?.map(Box::new),
                None => None,
            };
            updates.push(Update::Plan(plan));
            self.plan_crc = Some(plan_crc);
        }
        let log_next = status.log_next;
        updates.push(Update::Status(Box::new(status)));
        let from = self.next_entry.unwrap_or_else(|| log_next.saturating_sub(FIRST_ENTRIES));
        if from < log_next {
            updates.push(Update::Logged(client.log(from)?));
        }
        self.next_entry = Some(log_next);
        Ok(updates)
    }
}

fn put(client: &mut Client, ask: Ask) -> Result<(), LinkError> {
    match ask {
        Ask::Hold(view, lease) => client.hold(view, lease),
        Ask::Dark(lease) => client.dark(lease),
        Ask::Release => client.release(),
        Ask::Rearm => client.rearm(),
    }
}
