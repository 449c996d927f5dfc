//! `vitrine serve`: the exhibit as a page in the browser, live; commands only with an access token.

mod gate;
mod http;
mod hub;
mod page;
mod token;

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

use clap::Args;
use miette::{Diagnostic, Report};
use thiserror::Error;
use vitrine::link::Follower;

use self::gate::Gate;
use self::hub::Hub;
use self::token::Token;
use super::connect::To;
use super::model::{Key, Model};
use super::output::Output;

/// The port where none is asked for: one above the simulated controller's.
const PORT: u16 = 7471;
/// How long updates are waited for before commands are looked at.
const TURN: Duration = Duration::from_millis(50);

/// Show the exhibit as a page in the browser, live, as `watch` does on a terminal.
///
/// Everybody who reaches the page may look. Commands (hold, dark, release, re-arm) need an access token, and without
/// --commands or --token-file there are none. Only this computer reaches the page unless --listen says otherwise; the
/// connection is not encrypted, so listen to a network only where it is trusted.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine serve
  vitrine serve --commands            prints an access token for the buttons
  vitrine serve --listen 0.0.0.0:8080 --name gallery.local --token-file token.txt
  curl http://127.0.0.1:7471/status.json | jq .lamps

/status.json is what `vitrine status --json` tells.")]
pub(super) struct Serve {
    /// Where to listen: PORT on this computer, or ADDRESS:PORT.
    #[arg(long, value_name = "[ADDRESS:]PORT", default_value_t = default_place(), value_parser = place)]
    listen: SocketAddr,
    /// A name by which browsers may call this computer, beside localhost and its addresses; may be given again.
    #[arg(long = "name", value_name = "NAME")]
    names: Vec<String>,
    /// Allow commands to whoever has the access token, which is made anew and printed.
    #[arg(long)]
    commands: bool,
    /// Allow commands to whoever has the access token in this file, of at least 16 characters.
    #[arg(long, value_name = "FILE", conflicts_with = "commands")]
    token_file: Option<PathBuf>,
    #[command(flatten)]
    to: To,
}

/// Why the page cannot be served.
#[derive(Debug, Error, Diagnostic)]
enum ServeFailure {
    #[error("cannot listen at {place}")]
    #[diagnostic(code(vitrine::serve::listen), help("{}", listen_help(source)))]
    Listen { place: SocketAddr, source: io::Error },
}

fn listen_help(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::AddrInUse => {
            "another program has the port, perhaps another `vitrine serve` or a simulated controller: give another with --listen"
        }
        io::ErrorKind::AddrNotAvailable => {
            "this computer has no such address: give one of its own, or 0.0.0.0 for all of them"
        }
        io::ErrorKind::PermissionDenied => {
            "ports below 1024 need an administrator: give a higher one with --listen"
        }
        _ => "give another port or address with --listen",
    }
}

impl Serve {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let token = match (&self.token_file, self.commands) {
            (Some(path), _) => Some(Token::read(path)?),
            (None, true) => Some(Token::random()?),
            (None, false) => None,
        };
        let fail = |source| ServeFailure::Listen { place: self.listen, source };
        let listener = TcpListener::bind(self.listen).map_err(fail)?;
        let place = listener.local_addr().map_err(fail)?;
        tell(output, place, token.as_ref(), self.token_file.is_none());
        let hub = Arc::new(Hub::new(token.is_some()));
        let (commands, commanded) = channel();
        let gate = Arc::new(Gate::new(place.port(), self.names, token));
        let visited = Arc::clone(&hub);
        thread::spawn(move || http::serve(&listener, &gate, &visited, &commands));
        let to = self.to;
        follow(&Follower::new(move || to.find()), &hub, &commanded);
        Ok(())
    }
}

fn tell(output: Output, place: SocketAddr, token: Option<&Token>, is_new: bool) {
    let shown = match place.ip() {
        ip if ip.is_unspecified() => SocketAddr::new(Ipv4Addr::LOCALHOST.into(), place.port()),
        _ => place,
    };
    let address = format!("http://{shown}/");
    let told = token.filter(|_| is_new).map(Token::reveal);
    output.result(&serde_json::json!({ "listening": address, "token": told }), || address.clone());
    match told {
        Some(token) => output.note(&format!("Access token for commands: {token}")),
        None if token.is_none() => {
            output.note("Read-only: --commands allows commands to whoever has the token");
        }
        None => {}
    }
    if !place.ip().is_loopback() {
        output.note("note: everybody on the network can look, and the connection is not encrypted");
    }
    output.note("Open it in a browser; Ctrl-C ends it");
}

/// Passes on what the controller tells and what it is asked, for ever.
fn follow(follower: &Follower, hub: &Hub, commanded: &Receiver<Key>) {
    let mut model = Model::new();
    hub.publish(&model);
    loop {
        let mut news = false;
        let mut patience = TURN;
        while let Some(update) = follower.next(patience) {
            model.take(update);
            news = true;
            patience = Duration::ZERO;
        }
        while let Ok(key) = commanded.try_recv() {
            if let Some(ask) = model.press(key) {
                follower.ask(ask);
            }
            news = true;
        }
        if news {
            hub.publish(&model);
        }
    }
}

fn default_place() -> SocketAddr {
    SocketAddr::new(Ipv4Addr::LOCALHOST.into(), PORT)
}

/// Reads a port, or an address with a port.
fn place(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().map(|port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    port.or_else(|_| text.parse())
        .map_err(|_| "give a port such as 8080, or an address with one such as 0.0.0.0:8080".to_owned())
}

/// Where commands go.
type Commands = Sender<Key>;
