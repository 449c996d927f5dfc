//! Who may ask for what. A page of another site may neither read this one's nor command the exhibit through the browser
//! of somebody who can reach it: by a name of its own that it has turned to this computer's address (DNS rebinding), or
//! by a request that the browser sends along for it (cross-site request forgery).

use std::net::IpAddr;

use super::http::Request;
use super::token::Token;

/// Why a request is turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// It names another host than this one.
    Host,
    /// It comes from a page of another site.
    Origin,
    /// There are no commands here.
    ReadOnly,
    /// It has no token, or a wrong one.
    Token,
}

/// Lets requests in, or not.
pub(super) struct Gate {
    port: u16,
    names: Vec<String>,
    token: Option<Token>,
}

impl Gate {
    /// A gate of a server at `port` that is also called by `names`; without a token nobody may command.
    pub(super) fn new(port: u16, names: Vec<String>, token: Option<Token>) -> Self {
        Self { port, names, token }
    }

    /// Whether somebody may look.
    pub(super) fn lets_look(&self, request: &Request) -> Result<(), Refused> {
        let host = request.header("host").ok_or(Refused::Host)?;
        if !self.is_ours(host) {
            return Err(Refused::Host);
        }
        match request.header("origin") {
            Some(origin) if origin != format!("http://{host}") => Err(Refused::Origin),
            _ => Ok(()),
        }
    }

    /// Whether somebody may command: only a page of this very server, with the token.
    pub(super) fn lets_command(&self, request: &Request) -> Result<(), Refused> {
        self.lets_look(request)?;
        let of_this_site = request.header("sec-fetch-site").is_none_or(|site| site == "same-origin");
        // A form of another site can send text, but no JSON, without asking first.
        let is_json = request.header("content-type") == Some("application/json");
        if !of_this_site || !is_json {
            return Err(Refused::Origin);
        }
        let token = self.token.as_ref().ok_or(Refused::ReadOnly)?;
        let given = request.header("authorization").and_then(|value| value.strip_prefix("Bearer "));
        given.filter(|given| token.is(given)).map(|_| ()).ok_or(Refused::Token)
    }

    /// An address of digits cannot be turned elsewhere, and localhost is this computer.
    fn is_ours(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.ends_with(']') => (name, port.parse().ok()),
            _ => (host, Some(80)),
        };
        let digits = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        let named = || self.names.iter().any(|own| own.eq_ignore_ascii_case(name));
        port == Some(self.port)
            && (digits.parse::<IpAddr>().is_ok() || name.eq_ignore_ascii_case("localhost") || named())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(headers: &[(&str, &str)]) -> Request {
        let all = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect::<String>();
        let head = format!("POST /ask HTTP/1.1\r\n{all}content-length: 0\r\n\r\n");
        Request::read(&mut head.as_bytes()).unwrap()
    }

    fn gate() -> (Gate, String) {
        let token = Token::random().unwrap();
        let told = format!("Bearer {}", token.reveal());
        (Gate::new(7471, vec!["gallery.local".to_owned()], Some(token)), told)
    }

    #[test]
    fn only_this_servers_own_names_are_answered() {
        let look = |host| gate().0.lets_look(&request(&[("Host", host)]));
        for host in [
            "localhost:7471",
            "LOCALHOST:7471",
            "127.0.0.1:7471",
            "[::1]:7471",
            "10.0.0.7:7471",
            "Gallery.local:7471",
        ] {
            assert_eq!(look(host), Ok(()), "{host}");
        }
        for host in [
            "evil.example:7471",
            "localhost",
            "localhost:80",
            "127.0.0.1.evil.example:7471",
            "",
            ":7471",
            "[::1]",
        ] {
            assert_eq!(look(host), Err(Refused::Host), "{host}");
        }
        assert_eq!(gate().0.lets_look(&request(&[])), Err(Refused::Host));
    }

    #[test]
    fn pages_of_other_sites_are_not_answered() {
        let look = |origin| gate().0.lets_look(&request(&[("Host", "localhost:7471"), ("Origin", origin)]));
        assert_eq!(look("http://localhost:7471"), Ok(()));
        for origin in [
            "http://evil.example",
            "null",
            "https://localhost:7471",
            "http://127.0.0.1:7471",
            "http://localhost",
        ] {
            assert_eq!(look(origin), Err(Refused::Origin), "{origin}");
        }
    }

    #[test]
    fn commands_need_json_of_this_site_and_the_token() {
        let (gate, told) = gate();
        let good = [
            ("Host", "localhost:7471"),
            ("Origin", "http://localhost:7471"),
            ("Content-Type", "application/json"),
            ("Authorization", told.as_str()),
        ];
        assert_eq!(gate.lets_command(&request(&good)), Ok(()));
        let with = |name: &str, value: &str| {
            let changed = good.map(|header| if header.0 == name { (header.0, value) } else { header });
            gate.lets_command(&request(&changed))
        };
        assert_eq!(with("Content-Type", "text/plain"), Err(Refused::Origin));
        assert_eq!(with("Origin", "http://evil.example"), Err(Refused::Origin));
        for wrong in ["", "Bearer", "Bearer ", "Bearer 0", &told[1..], &told[..told.len() - 1]] {
            assert_eq!(with("Authorization", wrong), Err(Refused::Token), "{wrong}");
        }
        let across = [good.as_slice(), &[("Sec-Fetch-Site", "cross-site")]].concat();
        assert_eq!(gate.lets_command(&request(&across)), Err(Refused::Origin));
        let closed = Gate::new(7471, Vec::new(), None);
        assert_eq!(closed.lets_command(&request(&good)), Err(Refused::ReadOnly));
    }
}
