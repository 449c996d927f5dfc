//! What is known of the exhibit, for everybody who looks.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};

use super::super::model::{Connection, Model};
use super::super::rows::rows;
use super::super::status::as_json;
use super::super::words;

/// The last that was heard, as JSON.
#[derive(Clone, Default)]
pub(super) struct Heard {
    /// Counts what was published.
    pub(super) version: u64,
    /// What the page shows.
    pub(super) page: Arc<str>,
    /// What `vitrine status --json` tells; none while the controller is away.
    pub(super) status: Option<Arc<str>>,
}

/// Hands on what is published to all who wait for it.
pub(super) struct Hub {
    has_commands: bool,
    heard: Mutex<Heard>,
    news: Condvar,
}

impl Hub {
    pub(super) fn new(has_commands: bool) -> Self {
        Self { has_commands, heard: Mutex::default(), news: Condvar::new() }
    }

    /// Tells everybody how the model is.
    pub(super) fn publish(&self, model: &Model) {
        let (page, status) = (self.page(model).to_string(), status(model).map(|status| status.to_string()));
        let mut heard = self.lock();
        heard.version += 1;
        heard.page = page.into();
        heard.status = status.filter(|_| model.is_there()).map(Into::into);
        drop(heard);
        self.news.notify_all();
    }

    /// The last that was heard.
    pub(super) fn heard(&self) -> Heard {
        self.lock().clone()
    }

    /// Waits for something newer than `version`, at most so long.
    pub(super) fn newer(&self, version: u64, patience: Duration) -> Option<Heard> {
        let waited = self.news.wait_timeout_while(self.lock(), patience, |heard| heard.version == version);
        let (heard, _) = waited.unwrap_or_else(PoisonError::into_inner);
        (heard.version != version).then(|| heard.clone())
    }

    fn lock(&self) -> MutexGuard<'_, Heard> {
        // What is heard is replaced as a whole: a thread that fell over it leaves nothing half done.
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn page(&self, model: &Model) -> Value {
        let connection = match &model.connection {
            Connection::Looking => json!({ "state": "looking" }),
            Connection::There => json!({ "state": "there" }),
            Connection::Away { since, why, remedy } => json!({
                "state": "away", "away_s": since.elapsed().as_secs(), "why": why, "remedy": remedy,
            }),
        };
        let told = model.status.as_ref().map(|status| rows(model, status)).unwrap_or_default();
        let told =
            told.into_iter().map(|(what, text, alarm)| json!({ "what": what, "text": text, "alarm": alarm }));
        let views = model.plan.iter().flat_map(|plan| &plan.views).map(|view| view.id.as_str());
        let log = model
            .log
            .iter()
            .rev()
            .map(|entry| json!({ "when": words::moment(entry), "what": words::event(entry.event) }));
        json!({
            "connection": connection,
            "status": status(model),
            "rows": told.collect::<Vec<_>>(),
            "views": views.collect::<Vec<_>>(),
            "log": log.collect::<Vec<_>>(),
            "note": model.note,
            "has_commands": self.has_commands,
        })
    }
}

fn status(model: &Model) -> Option<Value> {
    let (address, hello) = model.who.as_ref()?;
    Some(as_json(address, hello, model.status.as_ref()?, None))
}
