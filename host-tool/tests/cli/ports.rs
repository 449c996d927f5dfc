//! Ports that cannot be used, each named with its reason and its remedy, and controllers that go and come back.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use serde_json::Value;
use serialport::{SerialPort, TTYPort};
use vitrine_protocol::frame::{self, Deframer};
use vitrine_protocol::{Hello, Reply, Request, Response};

use super::link::json;
use super::support::{Finished, Simulated, Workshop};

/// Lets `devices` find what is at `place`, as a simulated controller announces itself.
pub(super) fn announce(workshop: &Workshop, place: &str) {
    let folder = workshop.runtime().join("vitrine-controllers");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(place.replace(':', "_")), place).unwrap();
}

/// Answers every connection by `answer`, for as long as the test runs.
pub(super) fn serve(answer: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || listener.incoming().flatten().for_each(answer));
    place
}

fn as_a_web_server(mut stream: TcpStream) {
    let mut ignored = [0; 512];
    while stream.read(&mut ignored).is_ok_and(|count| count > 0) {
        let _gone = stream.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n\0");
    }
}

/// Greets as a controller whose firmware is of a later version.
fn as_a_later_controller(mut stream: TcpStream) {
    let mut deframer = Deframer::new();
    let mut bytes = [0; 512];
    while let Ok(count @ 1..) = stream.read(&mut bytes) {
        for byte in &bytes[..count] {
            let Some(Ok(body)) = deframer.push(*byte) else { continue };
            let Some((sequence, Request::Hello { .. })) = frame::decode(body) else { continue };
            let hello = Hello {
                version: vitrine_protocol::VERSION + 1,
                fingerprint: 0,
                serial_number: "E6614C31".try_into().unwrap(),
                firmware: "9.9.9".try_into().unwrap(),
                name: heapless::String::new(),
            };
            let reply = frame::encode(sequence, &Reply::Ok(Response::Hello(hello))).unwrap();
            let _gone = stream.write_all(&reply);
        }
    }
}

#[test]
fn devices_says_of_every_port_why_it_cannot_be_used_and_what_to_do() {
    let workshop = Workshop::new();
    let ready = Simulated::start(&workshop, &[]);
    let missing = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let stranger = serve(as_a_web_server);
    let later = serve(as_a_later_controller);
    for place in [&missing, &stranger, &later] {
        announce(&workshop, place);
    }
    let told = json(&workshop.succeed(&["devices", "--json"]));
    let text = workshop.succeed(&["devices"]);
    let device = |address: &str| {
        let found = told.as_array().unwrap().iter().find(|device| device["port"] == address);
        found.unwrap_or_else(|| panic!("{address} in {told}"))
    };
    assert_eq!(device(&ready.address)["ready"], true);
    for (place, reason, remedy) in [
        (&missing, "missing", "vitrine controller --listen"),
        (&stranger, "not ours", "is its firmware Vitrine's"),
        (&later, "other version", "vitrine"),
    ] {
        let address = format!("tcp:{place}");
        let device = device(&address);
        assert_eq!((&device["ready"], &device["reason"]), (&Value::from(false), &Value::from(reason)));
        assert!(device["help"].as_str().is_some_and(|help| help.contains(remedy)), "{device}");
        let line = text.lines().find(|line| line.starts_with(&address)).unwrap();
        assert!(line.contains(reason) && line.contains(remedy), "{line}");
    }
    assert_eq!(device(&format!("tcp:{later}"))["serial_number"], Value::Null);
    let doctor = json(&workshop.succeed(&["doctor"]));
    assert_eq!(doctor["ports"].as_array().unwrap().len(), told.as_array().unwrap().len());
    assert_eq!(doctor["controllers"][0]["status"]["serial_number"], "SIMULATED");
    assert_eq!(doctor["controllers"][0]["settings"]["supply_divider"], 11.0);
}

/// The command as somebody who may open nothing but what everybody may.
#[cfg(target_os = "linux")]
fn as_nobody(workshop: &Workshop, arguments: &[&str]) -> Finished {
    let vitrine = workshop.command(arguments);
    let id = Command::new("id").arg("-u").output().unwrap();
    if id.stdout.trim_ascii() != b"0" {
        return workshop.run(arguments);
    }
    let copy = tempfile::Builder::new().permissions(open_to_all()).tempdir().unwrap();
    let program = copy.path().join("vitrine");
    std::fs::copy(vitrine.get_program(), &program).unwrap();
    let mut command = Command::new("setpriv");
    command.args(["--reuid", "65534", "--clear-groups"]).arg(program).args(arguments).current_dir("/");
    Finished::from(command.output().unwrap())
}

#[cfg(target_os = "linux")]
fn open_to_all() -> std::fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o755)
}

#[cfg(target_os = "linux")]
#[test]
fn a_port_that_another_has_or_that_one_may_not_open_is_named_so() {
    let workshop = Workshop::new();
    let (_board, mut host) = TTYPort::pair().unwrap();
    let port = host.name().unwrap();
    host.set_exclusive(true).unwrap();
    let busy = workshop.run(&["status", "--to", &port]);
    assert_eq!(busy.code, Some(1));
    assert!(
        busy.stderr.contains("vitrine::link::busy") && busy.stderr.contains("ModemManager"),
        "{}",
        busy.stderr
    );
    std::fs::set_permissions(&port, std::os::unix::fs::PermissionsExt::from_mode(0o000)).unwrap();
    let refused = as_nobody(&workshop, &["status", "--to", &port]);
    assert_eq!(refused.code, Some(1));
    let told = &refused.stderr;
    assert!(told.contains("vitrine::link::no_permission") && told.contains("dialout"), "{told}");
}

#[test]
fn what_is_no_port_and_what_is_elsewhere_have_remedies_of_their_own() {
    let workshop = Workshop::new();
    workshop.write("note.txt", "no port");
    let place = workshop.path("note.txt");
    let file = workshop.run(&["status", "--to", place.to_str().unwrap()]);
    assert!(
        file.stderr.contains("vitrine::link::open") && file.stderr.contains("serial port?"),
        "{}",
        file.stderr
    );
    let elsewhere = workshop.run(&["status", "--to", "tcp:no-such-host.invalid:7470"]);
    assert!(elsewhere.stderr.contains("vitrine::link::missing"), "{}", elsewhere.stderr);
    assert!(!elsewhere.stderr.contains("vitrine controller"), "{}", elsewhere.stderr);
}

/// A command that runs on, ended when dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A controller that is killed leaves its announcement, and comes back at the same place.
fn again(workshop: &Workshop, first: Simulated) -> Simulated {
    let address = first.address.clone();
    drop(first);
    Simulated::start(workshop, &["--listen", &address, "--flash", "flash.bin"])
}

#[test]
fn watching_line_by_line_goes_on_when_the_controller_comes_back() {
    let workshop = Workshop::new();
    let first = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let mut command = workshop.command(&["watch", "--every", "0.1", "--json", "--to", &first.address]);
    let mut watching = Running(command.stdout(Stdio::piped()).spawn().unwrap());
    let mut lines = BufReader::new(watching.0.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut starts = |before: u64| {
        let mut looks = lines.by_ref().map(|line| json(&line)["power_cycles"].as_u64().unwrap());
        looks.find(|starts| *starts > before).unwrap()
    };
    let before = starts(0);
    let _second = again(&workshop, first);
    assert_eq!(starts(before), before + 1);
}

/// What a program writes to its terminal, until `wanted` stands in it.
#[cfg(target_os = "linux")]
fn until(terminal: &mut ChildStdout, wanted: &str) {
    let mut seen = Vec::new();
    let mut bytes = [0; 4096];
    while !String::from_utf8_lossy(&seen).contains(wanted) {
        let count = terminal.read(&mut bytes).unwrap();
        assert!(count > 0, "{wanted} never came: {}", String::from_utf8_lossy(&seen));
        seen.extend_from_slice(&bytes[..count]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_watch_on_a_terminal_goes_on_when_the_controller_comes_back() {
    let workshop = Workshop::new();
    let first = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let vitrine = workshop.command(&["watch"]);
    let line = format!(
        "stty cols 100 rows 40; exec {} watch --to {}",
        vitrine.get_program().display(),
        first.address
    );
    let typescript = Path::new("/dev/null");
    let mut command = Command::new("script");
    command.args(["--quiet", "--flush", "--command", &line]).arg(typescript).env("TERM", "xterm");
    let mut watching = Running(command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap());
    let mut terminal = watching.0.stdout.take().unwrap();
    // Only cells that change are drawn: "looking" and "connected" share the second letter.
    until(&mut terminal, "nnected");
    let address = first.address.clone();
    drop(first);
    until(&mut terminal, "away for");
    let _second = Simulated::start(&workshop, &["--listen", &address, "--flash", "flash.bin"]);
    until(&mut terminal, "nnected");
    watching.0.stdin.take().unwrap().write_all(b"q").unwrap();
    assert!(watching.0.wait().unwrap().success());
}
