//! Requests and responses. The order of variants and fields is the wire format: append, never insert.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};
pub use vitrine_exhibit::events::LogEntry;
use vitrine_exhibit::{settings::Settings, units::UtcSeconds};

use crate::{MAX_CHUNK, Refusal, Status, firmware::FirmwareState, status::ClockState};

/// A part of a plan or of an image, at most [`MAX_CHUNK`] bytes.
pub type Chunk = Vec<u8, MAX_CHUNK>;

/// The most log entries in one response.
pub const MAX_LOG_ENTRIES: usize = 8;

/// What a host asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "messages live one at a time, in a buffer of the largest")]
pub enum Request {
    /// Who is there? The first request on every link; frozen in all versions.
    Hello {
        /// The host's [`crate::VERSION`].
        version: u16,
        /// The host's [`crate::FINGERPRINT`].
        fingerprint: u32,
    },
    /// How is the exhibit?
    Status,
    /// What time is it?
    Clock,
    /// Sets the clock.
    SetClock {
        /// The time at which this request is sent.
        now: UtcSeconds,
    },
    /// Begins an upload, or goes on with the same one. The active plan stays until the commit.
    BeginUpload {
        /// The plan's length in bytes.
        length: u32,
        /// CRC-32/ISO-HDLC of all its bytes.
        crc: u32,
    },
    /// The next part of the plan or the image. A part that is already there is accepted again. Frozen in all versions.
    UploadChunk {
        /// Where the part begins, in bytes.
        offset: u32,
        /// The part.
        bytes: Chunk,
    },
    /// Verifies the upload, and makes a plan the active one; an image is installed by the next start. Frozen in all versions.
    CommitUpload {
        /// The CRC of [`Request::BeginUpload`] or [`Request::BeginUpdate`].
        crc: u32,
    },
    /// Reads the active plan back.
    ReadPlan {
        /// Where to begin, in bytes.
        offset: u32,
    },
    /// Asks the exhibit to hold a view, to go dark, to re-arm and the like, each with its lease.
    Exhibit(vitrine_exhibit::inputs::Request),
    /// Reads the event log.
    ReadLog {
        /// The sequence number of the first entry wanted.
        from: u32,
    },
    /// Reads what the firmware tells a technician as it runs, in defmt's encoding.
    ReadLive {
        /// Where the answer before ended; none to begin with the oldest that is still there.
        from: Option<u16>,
    },
    /// Reads the settings.
    ReadSettings,
    /// Changes all settings; wants a confirmation.
    ChangeSettings(Settings),
    /// Confirms what this link has asked for last, by the code of [`Response::Confirm`].
    Confirm {
        /// The code.
        code: u32,
    },
    /// What firmware runs, and how far is its update? Frozen in all versions.
    Firmware,
    /// Begins the upload of a firmware image, or goes on with the same one. Frozen in all versions.
    BeginUpdate {
        /// The length of the signed image in bytes, its header among them.
        length: u32,
        /// CRC-32/ISO-HDLC of all its bytes.
        crc: u32,
    },
    /// Restarts the controller, and with it installs an image that was committed. Frozen in all versions.
    Restart,
}

impl Request {
    /// Tells whether a host of any version may ask this, so that any host can update any controller.
    pub const fn is_of_an_update(&self) -> bool {
        matches!(
            self,
            Self::Firmware
                | Self::BeginUpdate { .. }
                | Self::UploadChunk { .. }
                | Self::CommitUpload { .. }
                | Self::Restart
        )
    }
}

/// What the controller answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "messages live one at a time, in a buffer of the largest")]
pub enum Response {
    /// To [`Request::Hello`]; frozen in all versions.
    Hello(Hello),
    /// To [`Request::Status`].
    Status(Status),
    /// To [`Request::Clock`] and [`Request::SetClock`].
    Clock(ClockState),
    /// To [`Request::BeginUpload`], [`Request::BeginUpdate`] and [`Request::UploadChunk`]; frozen in all versions.
    Upload {
        /// How many bytes have arrived, from its beginning on: the next chunk's offset.
        received: u32,
    },
    /// To [`Request::CommitUpload`]; frozen in all versions.
    Committed {
        /// The CRC of the plan that is active now, or of the image that the next start installs.
        crc: u32,
    },
    /// To [`Request::ReadPlan`].
    PlanPart {
        /// The plan's length in bytes.
        length: u32,
        /// Where the part begins.
        offset: u32,
        /// The part; empty at the end of the plan.
        bytes: Chunk,
    },
    /// To [`Request::Exhibit`]: the exhibit has been told; and to [`Request::Restart`]. Frozen in all versions.
    Done,
    /// To [`Request::ReadLog`].
    Log(LogPage),
    /// To [`Request::ReadLive`].
    Live {
        /// Where to go on.
        next: u16,
        /// What was told since; whoever asks too seldom misses some.
        bytes: Chunk,
    },
    /// To [`Request::ReadSettings`].
    Settings(Settings),
    /// To a request that asks for more than the exhibit gives now: it is carried out once it is confirmed, on the same
    /// link and within [`crate::server::CONFIRM_WITHIN_MS`].
    Confirm {
        /// What [`Request::Confirm`] has to say.
        code: u32,
    },
    /// To [`Request::Firmware`]; frozen in all versions.
    Firmware(FirmwareState),
}

/// A controller's answer: a response, or why it refuses.
pub type Reply = Result<Response, Refusal>;

/// Who the controller is. Frozen in all versions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// The controller's [`crate::VERSION`].
    pub version: u16,
    /// The controller's [`crate::FINGERPRINT`].
    pub fingerprint: u32,
    /// Its serial number: that of its flash chip, as 16 hexadecimal digits, or a name of a virtual controller.
    pub serial_number: String<24>,
    /// Its firmware's version, as in "0.1.0".
    pub firmware: String<24>,
    /// The active plan's name; empty without a plan.
    pub name: String<48>,
}

/// A piece of the event log, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogPage {
    /// The oldest entry still kept.
    pub oldest: u32,
    /// The sequence number that the next event will get. When `entries` is empty, there is nothing more to read.
    pub next: u32,
    /// The entries.
    pub entries: Vec<LogEntry, MAX_LOG_ENTRIES>,
}
