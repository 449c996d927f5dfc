//! What is answered to a request: the page with its script and style, the status, the news, and commands.

use std::sync::Arc;

use serde::Deserialize;

use super::Commands;
use super::gate::{Gate, Refused};
use super::http::{Answer, Request};
use super::hub::Hub;
use crate::cli::model::Key;

const PAGE: &str = include_str!("page.html");
const SCRIPT: &str = include_str!("page.js");
const STYLE: &str = include_str!("page.css");

/// What a person asks for, as JSON such as `{"ask": "hold", "view": 0}`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
enum Asked {
    Hold { view: u8 },
    Dark {},
    Release {},
    Rearm {},
}

/// Answers a request.
pub(super) fn answer(request: &Request, gate: &Gate, hub: &Hub, commands: &Commands) -> Answer {
    let path = request.path.split('?').next().unwrap_or_default();
    let let_in = match path {
        "/ask" | "/unlock" => gate.lets_command(request),
        _ => gate.lets_look(request),
    };
    if let Err(refused) = let_in {
        return turned_away(refused);
    }
    match (request.method.as_str(), path) {
        ("GET", "/") => file("text/html; charset=utf-8", PAGE),
        ("GET", "/page.js") => file("text/javascript; charset=utf-8", SCRIPT),
        ("GET", "/page.css") => file("text/css; charset=utf-8", STYLE),
        ("GET", "/status.json") => status(hub),
        ("GET", "/events") => Answer::Events,
        ("POST", "/ask") => ask(request, hub, commands),
        ("POST", "/unlock") => Answer::words("200 OK", "this is the access token"),
        (_, "/" | "/page.js" | "/page.css" | "/status.json" | "/events" | "/ask" | "/unlock") => {
            Answer::words("405 Method Not Allowed", "this is not done with what is here")
        }
        _ => Answer::words("404 Not Found", "there is nothing here; the page is /, the status /status.json"),
    }
}

fn turned_away(refused: Refused) -> Answer {
    match refused {
        Refused::Host => Answer::words(
            "421 Misdirected Request",
            "this computer is not known by that name: use its address, or start `vitrine serve --name NAME`",
        ),
        Refused::Origin => Answer::words("403 Forbidden", "pages of other sites are not answered"),
        Refused::ReadOnly => {
            Answer::words("403 Forbidden", "read-only: `vitrine serve --commands` allows commands")
        }
        Refused::Token => Answer::words("401 Unauthorized", "this is not the access token"),
    }
}

fn file(kind: &'static str, text: &'static str) -> Answer {
    Answer::Whole { status: "200 OK", kind, body: text.as_bytes().into() }
}

fn status(hub: &Hub) -> Answer {
    match hub.heard().status {
        Some(status) => {
            Answer::Whole { status: "200 OK", kind: "application/json", body: Arc::from(status.as_bytes()) }
        }
        None => Answer::words("503 Service Unavailable", "the controller is not there"),
    }
}

fn ask(request: &Request, hub: &Hub, commands: &Commands) -> Answer {
    let key = match serde_json::from_slice(&request.body) {
        Ok(Asked::Hold { view }) => Key::View(view),
        Ok(Asked::Dark {}) => Key::Dark,
        Ok(Asked::Release {}) => Key::Release,
        Ok(Asked::Rearm {}) => Key::Rearm,
        Err(error) => return Answer::words("400 Bad Request", &error.to_string()),
    };
    if hub.heard().status.is_none() {
        return Answer::words("503 Service Unavailable", "the controller is not there: nothing was asked");
    }
    match commands.send(key) {
        Ok(()) => Answer::words("202 Accepted", "asked; the events tell what came of it"),
        Err(_) => Answer::words("503 Service Unavailable", "vitrine serve is ending"),
    }
}
