//! What can go wrong on the way to a controller, each with its remedy.

use std::io;

use miette::Diagnostic;
use thiserror::Error;
use vitrine_protocol::{Hello, Refusal};

use super::Address;
use crate::firmware::fault_help;

/// What went wrong between this computer and a controller.
#[derive(Debug, Error, Diagnostic)]
pub enum LinkError {
    /// The port does not exist, or nothing listens there.
    #[error("there is nothing at {address}")]
    #[diagnostic(code(vitrine::link::missing), help("{}", missing_help(address)))]
    Missing {
        /// Where.
        address: Address,
    },
    /// The operating system does not let this user open the port.
    #[error("{address} may not be opened by this user")]
    #[diagnostic(
        code(vitrine::link::no_permission),
        help(
            "add yourself to the group that owns the port (`sudo usermod -a -G dialout $USER` on Debian), then log in anew"
        )
    )]
    NoPermission {
        /// Where.
        address: Address,
    },
    /// Another program has the port.
    #[error("{address} is in use by another program")]
    #[diagnostic(
        code(vitrine::link::busy),
        help("close what uses it: another vitrine (`watch`, `upload`), a terminal program, ModemManager")
    )]
    Busy {
        /// Where.
        address: Address,
    },
    /// The port cannot be opened for another reason.
    #[error("{address} cannot be opened")]
    #[diagnostic(
        code(vitrine::link::open),
        help(
            "is it a serial port? `vitrine devices` lists them; if it is, unplug the controller, wait a second, plug it in again"
        )
    )]
    Open {
        /// Where.
        address: Address,
        /// What the operating system says.
        source: io::Error,
    },
    /// What is there does not answer as a controller does.
    #[error("what is at {address} does not answer as an exhibit's controller")]
    #[diagnostic(
        code(vitrine::link::not_ours),
        help("`vitrine devices` lists the controllers; is this one running, and is its firmware Vitrine's?")
    )]
    NotOurs {
        /// Where.
        address: Address,
    },
    /// The controller speaks an older or newer version.
    #[error(
        "the controller at {address} speaks version {theirs} of the protocol, this computer version {ours}",
        theirs = hello.version,
        ours = vitrine_protocol::VERSION
    )]
    #[diagnostic(code(vitrine::link::other_version), help("{}", version_help(hello)))]
    OtherVersion {
        /// Where.
        address: Address,
        /// How it greeted.
        hello: Box<Hello>,
    },
    /// The controller's messages have the same version but another layout.
    #[error(
        "the controller at {address} (firmware {firmware}) and this vitrine ({}) were built from different sources: fingerprints {theirs:08x} and {:08x}",
        env!("CARGO_PKG_VERSION"),
        vitrine_protocol::FINGERPRINT,
        firmware = hello.firmware,
        theirs = hello.fingerprint
    )]
    #[diagnostic(
        code(vitrine::link::other_build),
        help("install the firmware and the vitrine command of the same release")
    )]
    OtherBuild {
        /// Where.
        address: Address,
        /// How it greeted.
        hello: Box<Hello>,
    },
    /// The controller was there, and is gone.
    #[error("the connection to {address} broke")]
    #[diagnostic(
        code(vitrine::link::lost),
        help(
            "check cable and power; the exhibit runs on by itself, and what was not committed is not active"
        )
    )]
    Lost {
        /// Where.
        address: Address,
        /// What the operating system says.
        source: io::Error,
    },
    /// The controller is there but does not answer.
    #[error("the controller at {address} does not answer within {seconds:.1} s")]
    #[diagnostic(
        code(vitrine::link::silent),
        help("try again; if it stays silent, its power has to be switched off and on")
    )]
    Silent {
        /// Where.
        address: Address,
        /// How long it was waited for.
        seconds: f64,
    },
    /// The controller answers with what was not asked.
    #[error("the controller at {address} gave an answer that does not belong to the question")]
    #[diagnostic(code(vitrine::link::wrong_answer), help("a fault of the firmware: please report it"))]
    WrongAnswer {
        /// Where.
        address: Address,
    },
    /// The controller refuses, and says why.
    #[error("the controller at {address} refuses: {refusal}")]
    #[diagnostic(code(vitrine::link::refused), help("{}", refusal_help(refusal)))]
    Refused {
        /// Where.
        address: Address,
        /// Why.
        refusal: Refusal,
    },
    /// The plan has no bytes or too many.
    #[error("a plan of {length} bytes cannot be uploaded: a controller keeps 1 to {most} bytes")]
    #[diagnostic(code(vitrine::link::plan_length), help("use fewer views, schedule rules or closed days"))]
    PlanLength {
        /// Its length.
        length: usize,
        /// The most bytes.
        most: usize,
    },
    /// What is read back is not what was sent.
    #[error("the plan read back from {address} differs from the one sent, from byte {offset} on")]
    #[diagnostic(
        code(vitrine::link::read_back),
        help("upload it again; if it happens again, the controller's flash memory is failing")
    )]
    ReadBack {
        /// Where.
        address: Address,
        /// The first byte that differs.
        offset: usize,
    },
    /// The controller wants to hear it twice, and nobody has confirmed it.
    #[error("the controller at {address} does not {what} without confirmation")]
    #[diagnostic(code(vitrine::link::unconfirmed), help("{help}"))]
    Unconfirmed {
        /// Where.
        address: Address,
        /// What it was asked to do.
        what: &'static str,
        /// How to confirm it.
        help: &'static str,
    },
    /// No controller was found.
    #[error("no controller was found")]
    #[diagnostic(
        code(vitrine::link::none_found),
        help(
            "plug one in, start one with `vitrine controller`, or say where it is with --to; `vitrine devices` tells what is wrong with each port"
        )
    )]
    NoneFound,
    /// No controller has the serial number.
    #[error("no controller's serial number begins with {wanted}")]
    #[diagnostic(code(vitrine::link::no_such_serial_number), help("{}", serial_number_help(known)))]
    NoSuchSerialNumber {
        /// What was asked for.
        wanted: String,
        /// The serial numbers of the ports that have one.
        known: Vec<String>,
    },
    /// More than one controller was found.
    #[error("there are several controllers: {}", found.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))]
    #[diagnostic(code(vitrine::link::several_found), help("say which one is meant with --to"))]
    SeveralFound {
        /// Where they are.
        found: Vec<Address>,
    },
}

impl LinkError {
    /// The reason in one word, for lists and JSON.
    pub fn reason(&self) -> &'static str {
        match self {
            Self::Missing { .. } => "missing",
            Self::NoPermission { .. } => "no permission",
            Self::Busy { .. } => "busy",
            Self::Open { .. } => "cannot be opened",
            Self::NotOurs { .. } => "not ours",
            Self::OtherVersion { .. } | Self::OtherBuild { .. } => "other version",
            Self::Lost { .. } => "lost",
            Self::Silent { .. } => "silent",
            Self::WrongAnswer { .. } => "wrong answer",
            Self::Refused { .. } => "refused",
            Self::PlanLength { .. } => "plan length",
            Self::ReadBack { .. } => "read back",
            Self::Unconfirmed { .. } => "unconfirmed",
            Self::NoneFound => "none found",
            Self::NoSuchSerialNumber { .. } => "no such serial number",
            Self::SeveralFound { .. } => "several found",
        }
    }

    /// Tells whether the controller may answer again later: it is gone, silent or not yet there.
    pub const fn is_passing(&self) -> bool {
        matches!(
            self,
            Self::Missing { .. }
                | Self::Busy { .. }
                | Self::Open { .. }
                | Self::Lost { .. }
                | Self::Silent { .. }
        )
    }

    /// Names what the operating system says about a port that does not open.
    pub(super) fn from_open(address: &Address, error: io::Error) -> Self {
        let address = address.clone();
        match error.kind() {
            io::ErrorKind::NotFound
            | io::ErrorKind::ConnectionRefused
            | io::ErrorKind::HostUnreachable
            | io::ErrorKind::NetworkUnreachable
            | io::ErrorKind::TimedOut => Self::Missing { address },
            io::ErrorKind::PermissionDenied => Self::NoPermission { address },
            io::ErrorKind::ResourceBusy | io::ErrorKind::WouldBlock => Self::Busy { address },
            _ => Self::Open { address, source: error },
        }
    }
}

/// Whether `HOST:PORT` is on this computer.
fn is_here(place: &str) -> bool {
    ["127.", "[::1]", "localhost"].iter().any(|start| place.starts_with(start))
}

fn missing_help(address: &Address) -> String {
    match address {
        Address::Serial(_) => {
            "is the controller plugged in, and its cable one that carries data? `vitrine devices` lists the ports"
                .to_owned()
        }
        Address::Tcp(place) if is_here(place) => {
            format!("start a simulated controller there with `vitrine controller --listen tcp:{place}`")
        }
        Address::Tcp(_) => {
            "is the other computer's name right, is it on, and does a controller or a serial server listen there?"
                .to_owned()
        }
    }
}

fn serial_number_help(known: &[String]) -> String {
    match known {
        [] => {
            "no port has a serial number; is the controller plugged in? A port's own name is its whole path"
                .to_owned()
        }
        known => format!("there are {}; a port's own name is its whole path", known.join(", ")),
    }
}

fn version_help(hello: &Hello) -> String {
    if hello.version < vitrine_protocol::VERSION {
        format!("update the controller's firmware ({})", hello.firmware)
    } else {
        format!("update this vitrine ({}): the controller's firmware is newer", env!("CARGO_PKG_VERSION"))
    }
}

fn refusal_help(refusal: &Refusal) -> &'static str {
    match refusal {
        Refusal::Unacquainted { .. } | Refusal::UnknownRequest => {
            "install the firmware and the vitrine command of the same release"
        }
        Refusal::TooManyRequests { .. } | Refusal::LampsInMotion { .. } | Refusal::OtherUpload { .. } => {
            "wait a little and try again"
        }
        Refusal::NoUpload
        | Refusal::Gap { .. }
        | Refusal::PastEnd { .. }
        | Refusal::Incomplete { .. }
        | Refusal::Checksum { .. } => "upload the plan again",
        Refusal::PlanLength { .. } => "use fewer views, schedule rules or closed days",
        Refusal::UnreadablePlan => {
            "install the firmware of this vitrine's release, or design the exhibit anew"
        }
        Refusal::UnfitPlan(_) => "change exhibit.toml, and design it anew; `vitrine check` tells where",
        Refusal::NoPlan => "`vitrine upload BUILD` gives it one",
        Refusal::NoSuchView { .. } => "`vitrine status` lists the plan's views",
        Refusal::Lease { .. } => "ask for a shorter time, and again when it ends",
        Refusal::StillAtFault => "`vitrine status` tells what is wrong; mend it, then re-arm",
        Refusal::ImplausibleTime => "set this computer's clock first",
        Refusal::ClockFailed => "check the battery clock and its battery",
        Refusal::StorageFailed => "try again; if it happens again, the controller's flash memory is failing",
        Refusal::AnswerTooLarge => "please report it",
        Refusal::CableOnly => "go to the exhibit and plug a computer into it, or use its staff key",
        Refusal::NothingToConfirm => "give the command again",
        Refusal::UnfitSettings(_) => "give a value within those bounds",
        Refusal::ImageLength { .. } => "give the file that `vitrine firmware sign` or `build` has written",
        Refusal::UnfitImage(fault) => fault_help(*fault),
        Refusal::OnTrial { .. } => "wait until it has confirmed itself or has been gone back from",
        Refusal::NoBootLoader => "flash boot loader and firmware over the board's own USB disk or a probe",
        Refusal::NoSupply => "switch the lamps' supply on; `vitrine status` tells what is measured",
    }
}
