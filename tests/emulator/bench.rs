//! The bench: an emulated board in a process of its own, and what one does with a board on a bench.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use defmt_decoder::{DecodeError, Table};
use serde_json::{Value, json};
use vitrine_storage::map::ACTIVE_IMAGE;

use crate::signals::Edge;

pub(crate) const LAMP_TOP: u8 = 2;
pub(crate) const LAMP_BOTTOM: u8 = 3;
pub(crate) const LAMP_ENABLE: u8 = 8;
pub(crate) const LAMP_PINS: [u8; 3] = [LAMP_TOP, LAMP_BOTTOM, LAMP_ENABLE];
pub(crate) const INTERLOCK_A: u8 = 6;
pub(crate) const INTERLOCK_B: u8 = 7;

pub(crate) const MICROSECOND: u64 = 1_000;
pub(crate) const MILLISECOND: u64 = 1_000_000;
pub(crate) const SECOND: u64 = 1_000_000_000;

/// No command of the real tool may take longer than this in real time.
const COMMAND_TIMEOUT: Duration = Duration::from_secs(300);

/// A board on the bench, with 24 V, warm lamp boards, a closed interlock and no sensors on its bus.
pub(crate) struct Bench {
    image: PathBuf,
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// Simulated time in ns.
    pub(crate) now: u64,
}

/// How an opening of the interlock went.
pub(crate) struct Trip {
    /// From the change of the input to each lamp pin's last fall, in ns.
    pub(crate) latencies: Vec<u64>,
    pub(crate) dark: bool,
    /// The lamps' drivers were enabled when the input changed.
    pub(crate) was_lit: bool,
}

/// An erase of a sector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Erase {
    /// Where the sector lies in flash.
    pub(crate) start: u32,
    /// How long the lamps' pins had done the same until then, in ns.
    pub(crate) steady_for: u64,
}

impl Erase {
    /// Whether the lamps were dark or at a steady level: for five of the controller's steps, less what a level needs to its pin.
    pub(crate) fn is_in_steady_light(&self) -> bool {
        self.steady_for >= 40 * MILLISECOND
    }
}

impl Bench {
    /// Puts the image of `firmware/build.sh` on the bench, without power.
    pub(crate) fn new() -> Self {
        Self::with_image("vitrine-pico.elf")
    }

    pub(crate) fn with_image(name: &str) -> Self {
        Self::with(name, None)
    }

    /// Puts the boot loader on the bench, with this signed image in the active place.
    pub(crate) fn with_bootloader(signed: &[u8]) -> Self {
        let mut bench = Self::with("vitrine-pico.elf", Some(built("vitrine-bootloader.elf")));
        bench.flash_write(ACTIVE_IMAGE, signed);
        bench
    }

    fn with(name: &str, bootloader: Option<PathBuf>) -> Self {
        let image = built(name);
        let here = workspace().join("tests/emulator");
        assert!(
            here.join("node_modules/rp2040js").is_dir(),
            "no emulator: run 'npm ci' in {}",
            here.display()
        );
        let mut process = Command::new("node")
            .arg(here.join("bench.mjs"))
            .arg(&image)
            .args(bootloader)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("Node.js starts: install it");
        let requests = process.stdin.take().expect("a pipe");
        let answers = BufReader::new(process.stdout.take().expect("a pipe"));
        let mut bench = Self { image, process, requests, answers, now: 0 };
        bench.pin(INTERLOCK_A, false);
        bench.pin(INTERLOCK_B, false);
        bench.analog(2, supply_reading(24_000));
        bench
    }

    /// Writes flash as a programmer would.
    pub(crate) fn flash_write(&mut self, start: u32, bytes: &[u8]) {
        self.call(json!({"op": "flash_write", "start": start, "bytes": hex(bytes)}));
    }

    /// Reads flash as a programmer would.
    pub(crate) fn flash_read(&mut self, start: u32, length: u32) -> Vec<u8> {
        unhex(
            self.call(json!({"op": "flash", "start": start, "length": length}))["bytes"]
                .as_str()
                .expect("bytes"),
        )
    }

    /// Does one operation of the line protocol (bench.mjs).
    pub(crate) fn call(&mut self, request: Value) -> Value {
        writeln!(self.requests, "{request}").expect("the bench runs");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("the bench answers");
        let answer: Value = serde_json::from_str(&line).unwrap_or_else(|_| panic!("no answer to {request}"));
        assert!(answer["error"].is_null(), "{request}: {}", answer["error"]);
        self.now = answer["now"].as_u64().expect("the time");
        answer
    }

    pub(crate) fn power_on(&mut self) {
        self.call(json!({"op": "power_on"}));
    }

    pub(crate) fn power_off(&mut self) {
        self.call(json!({"op": "power_off"}));
    }

    /// Runs for so many nanoseconds; tells whether the board has power afterwards.
    pub(crate) fn run(&mut self, ns: u64) -> bool {
        self.call(json!({"op": "run", "ns": ns}))["cut"] == json!(false)
    }

    /// Cuts the power at this step of the flash, counted from now, with a part of the step done in this order.
    pub(crate) fn cut_at(&mut self, step: u64, part: f64, order: &str) {
        self.call(json!({"op": "cut", "step": step, "part": part, "order": order}));
    }

    /// How many steps the flash has made: sectors erased and pages programmed.
    pub(crate) fn flash_steps(&mut self) -> u64 {
        self.call(json!({"op": "flash_steps"}))["steps"].as_u64().expect("a number")
    }

    /// Sets how long the flash takes to erase a sector.
    pub(crate) fn erase_time(&mut self, ns: u64) {
        self.call(json!({"op": "erase_time", "ns": ns}));
    }

    /// Takes the erases since the last call.
    pub(crate) fn erases(&mut self) -> Vec<Erase> {
        let answer = self.call(json!({"op": "erases"}));
        serde_json::from_value::<Vec<(u32, f64)>>(answer["erases"].clone())
            .expect("erases")
            .into_iter()
            .map(|(start, steady_for)| Erase { start, steady_for: steady_for as u64 })
            .collect()
    }

    pub(crate) fn pin(&mut self, gp: u8, high: bool) {
        self.call(json!({"op": "pin", "gp": gp, "high": high}));
    }

    pub(crate) fn analog(&mut self, channel: u8, value: u16) {
        self.call(json!({"op": "analog", "channel": channel, "value": value}));
    }

    /// Puts bytes into a bus device's registers; a device that has none yet appears on the bus.
    pub(crate) fn device(&mut self, address: u8, start: u8, bytes: &[u8]) {
        self.call(json!({"op": "i2c", "address": address, "start": start, "bytes": hex(bytes)}));
    }

    /// Sends bytes to the board's USB port, without a host behind it, and runs until it has taken them; gives what it
    /// has sent meanwhile.
    pub(crate) fn usb(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.call(json!({"op": "usb_write", "bytes": hex(bytes)}));
        for _ in 0..10_000 {
            self.run(2 * MILLISECOND);
            if self.call(json!({"op": "usb_pending"}))["bytes"] == json!(0) {
                self.run(2 * MILLISECOND);
                return unhex(self.call(json!({"op": "usb_read"}))["bytes"].as_str().expect("bytes"));
            }
        }
        panic!("the board takes no more bytes over USB");
    }

    /// Reads a word of the image's memory.
    pub(crate) fn peek(&mut self, symbol: &str) -> u64 {
        self.call(json!({"op": "peek", "symbol": symbol}))["value"].as_u64().expect("a number")
    }

    /// Sends bytes to the service port.
    pub(crate) fn service(&mut self, bytes: &[u8]) {
        self.call(json!({"op": "serial_write", "bytes": hex(bytes)}));
    }

    /// Takes what the service port has sent since the last call.
    pub(crate) fn service_answers(&mut self) -> Vec<u8> {
        unhex(self.call(json!({"op": "serial_read"}))["bytes"].as_str().expect("bytes"))
    }

    /// Sends bytes over the radar's wire.
    pub(crate) fn radar(&mut self, bytes: &[u8]) {
        self.call(json!({"op": "radar_write", "bytes": hex(bytes)}));
    }

    /// Takes how many instructions each step of the state took since the last call; on the bench image only.
    pub(crate) fn step_instructions(&mut self) -> Vec<u64> {
        let answer = self.call(json!({"op": "step_instructions"}));
        serde_json::from_value(answer["counts"].clone()).expect("counts")
    }

    /// Takes the edges of all watched pins since the last call.
    pub(crate) fn edges(&mut self) -> Vec<Edge> {
        let answer = self.call(json!({"op": "edges"}));
        serde_json::from_value::<Vec<(f64, u8, u8)>>(answer["edges"].clone())
            .expect("edges")
            .into_iter()
            .map(|(at, pin, level)| Edge { at: at.round() as u64, pin, high: level == 1 })
            .collect()
    }

    /// Sums what these pins do from now on, instead of keeping their edges: how often each rose since the last call, and how
    /// long it was high in ns.
    pub(crate) fn sums<const PINS: usize>(&mut self, gps: [u8; PINS]) -> [(u64, f64); PINS] {
        let answer = self.call(json!({"op": "sums", "gps": gps.as_slice()}));
        let sums: Vec<(u64, f64)> = serde_json::from_value(answer["sums"].clone()).expect("sums");
        sums.try_into().expect("one for each pin")
    }

    /// Writes a word into the image's memory; bench.mjs finds the symbol.
    pub(crate) fn poke(&mut self, symbol: &str, value: u32) {
        self.call(json!({"op": "poke", "symbol": symbol, "value": value}));
    }

    /// Paints the stack anew: the boot loader has used it before the firmware.
    pub(crate) fn paint_stack(&mut self) {
        self.call(json!({"op": "paint_stack"}));
    }

    /// The most of the stack that was used since the power came or it was painted, in bytes, and its size.
    pub(crate) fn stack(&mut self) -> (u64, u64) {
        let answer = self.call(json!({"op": "stack"}));
        (answer["used"].as_u64().expect("bytes"), answer["of"].as_u64().expect("bytes"))
    }

    /// Tells whether the lamps are dark at this moment.
    pub(crate) fn is_dark(&mut self) -> bool {
        let answer = self.call(json!({"op": "levels", "gps": LAMP_PINS}));
        answer["levels"] == json!([false, false, false])
    }

    /// Resets of the chip since the last call.
    pub(crate) fn take_resets(&mut self) -> usize {
        self.call(json!({"op": "resets"}))["resets"].as_array().map_or(0, Vec::len)
    }

    /// Changes an input `after` ns from now and runs until the lamps' pins are low, at most `limit` ns.
    pub(crate) fn trip(&mut self, gp: u8, high: bool, after: u64, limit: u64) -> Trip {
        let request =
            json!({"op": "trip", "gp": gp, "high": high, "after": after, "limit": limit, "gps": LAMP_PINS});
        let answer = self.call(request);
        let latencies = answer["latencies"].as_array().expect("latencies");
        Trip {
            latencies: latencies.iter().map(|at| at.as_f64().expect("ns").round() as u64).collect(),
            dark: answer["dark"] == json!(true),
            was_lit: answer["was_lit"] == json!(true),
        }
    }

    /// Takes what the image has logged since the last call, decoded with the image's own table.
    pub(crate) fn log(&mut self) -> Vec<String> {
        let bytes = self.rtt();
        let image = std::fs::read(&self.image).expect("the image");
        let table = Table::parse(&image).expect("a table").expect("an image with defmt");
        let mut decoder = table.new_stream_decoder();
        decoder.received(&bytes);
        let mut lines = Vec::new();
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(frame.display_message().to_string()),
                Err(DecodeError::UnexpectedEof) => return lines,
                Err(DecodeError::Malformed) => lines.push("(lost)".to_owned()),
            }
        }
    }

    /// The same, as a probe reads it.
    pub(crate) fn rtt(&mut self) -> Vec<u8> {
        unhex(self.call(json!({"op": "log"}))["bytes"].as_str().expect("bytes"))
    }

    /// Offers the board's USB serial port; gives its address for `--to`.
    pub(crate) fn listen(&mut self) -> String {
        let port = self.call(json!({"op": "listen"}))["port"].as_u64().expect("a port");
        format!("tcp:127.0.0.1:{port}")
    }

    /// When USB was up, in ns since the power came.
    pub(crate) fn usb_up_at(&mut self) -> Option<u64> {
        self.call(json!({"op": "usb"}))["connected_at"].as_f64().map(|at| at as u64)
    }

    /// Runs the real `vitrine` with these arguments while the board lives on; gives what it printed.
    pub(crate) fn vitrine(&mut self, arguments: &[&str]) -> String {
        let (succeeded, stdout, stderr) = self.vitrine_meanwhile(arguments, |_| {});
        assert!(succeeded, "vitrine {arguments:?} failed:\n{stdout}{stderr}");
        stdout
    }

    /// The same, whether it succeeds or not, with something done again and again meanwhile; gives what it printed to both
    /// streams.
    pub(crate) fn vitrine_meanwhile(
        &mut self,
        arguments: &[&str],
        mut meanwhile: impl FnMut(&mut Self),
    ) -> (bool, String, String) {
        let mut command = Command::new(vitrine_command())
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let began = Instant::now();
        while command.try_wait().expect("the command's state").is_none() {
            if began.elapsed() > COMMAND_TIMEOUT {
                command.kill().expect("the command ends");
                panic!("vitrine {arguments:?} did not end");
            }
            self.run(10 * MILLISECOND);
            meanwhile(self);
        }
        let output = command.wait_with_output().expect("the command's output");
        let (stdout, stderr) =
            (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        (output.status.success(), stdout.into_owned(), stderr.into_owned())
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The converter's reading of a lamp supply in mV, through its divider of 11 and a reference of 3.3 V.
pub(crate) fn supply_reading(millivolts: u32) -> u16 {
    (millivolts * 4095 / 36_300) as u16
}

pub(crate) fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace").to_owned()
}

/// What firmware/build.sh has left.
pub(crate) fn built(name: &str) -> PathBuf {
    let image = workspace().join("target/firmware").join(name);
    assert!(image.is_file(), "no image at {}: run firmware/build.sh", image.display());
    image
}

/// The command built beside these tests.
pub(crate) fn vitrine_command() -> PathBuf {
    let tests = std::env::current_exe().expect("this test");
    let profile = tests.parent().and_then(Path::parent).expect("target/PROFILE/deps");
    let command = profile.join("vitrine");
    assert!(command.is_file(), "no command at {}: run 'cargo build -p vitrine'", command.display());
    command
}

/// The number that a variable of the environment gives, for runs longer than the usual one.
pub(crate) fn number_of(variable: &str, usual: u64) -> u64 {
    std::env::var(variable)
        .ok()
        .map_or(usual, |text| text.parse().unwrap_or_else(|_| panic!("{variable}={text} is no number")))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let digits = text.as_bytes().as_chunks::<2>().0;
    digits.iter().filter_map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect()
}
