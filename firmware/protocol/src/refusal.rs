//! Why a controller refuses a request. The order of variants is the wire format: append, never insert.

use core::fmt;

use serde::{Deserialize, Serialize};
use vitrine_exhibit::units::Milliseconds;

/// Why a controller refuses a request, with what the host needs to do better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The link did not begin with a hello of this version and fingerprint.
    Unacquainted {
        /// The controller's version.
        version: u16,
        /// The controller's fingerprint.
        fingerprint: u32,
    },
    /// The message is none of this version's.
    UnknownRequest,
    /// Requests come too fast.
    TooManyRequests {
        /// When to ask again.
        retry: Milliseconds,
    },
    /// Flash is erased only while the lamps are dark or steady.
    LampsInMotion {
        /// When to ask again.
        retry: Milliseconds,
    },
    /// Another host is uploading.
    OtherUpload {
        /// After how long without a word from it this host may begin.
        retry: Milliseconds,
    },
    /// A chunk or a commit without a begin, or after a failed commit.
    NoUpload,
    /// The plan has no bytes, or more than the controller keeps.
    PlanLength {
        /// The most bytes of a plan.
        most: u32,
    },
    /// A chunk that begins after the end of what has arrived.
    Gap {
        /// The offset of the chunk to send.
        expected: u32,
    },
    /// A chunk that ends after the announced length.
    PastEnd {
        /// The announced length.
        length: u32,
    },
    /// A commit before all bytes arrived.
    Incomplete {
        /// Bytes that arrived.
        received: u32,
        /// The announced length.
        length: u32,
    },
    /// What was written does not have the announced CRC. The active plan stays.
    Checksum {
        /// The announced CRC.
        expected: u32,
        /// The CRC of what was read back.
        found: u32,
    },
    /// The bytes arrived whole, but this firmware cannot read them as a plan. The active plan stays.
    UnreadablePlan,
    /// The plan contradicts itself or the firmware's limits. The active plan stays.
    UnfitPlan(vitrine_exhibit::plan::PlanError),
    /// There is no plan.
    NoPlan,
    /// The plan has no such view.
    NoSuchView {
        /// How many it has.
        views: u8,
    },
    /// The lease is zero or too long.
    Lease {
        /// The longest lease.
        most: Milliseconds,
    },
    /// The cause of the latched fault is still there.
    StillAtFault,
    /// The time is not between 2024 and 2099.
    ImplausibleTime,
    /// The battery clock does not take the time.
    ClockFailed,
    /// The flash does not take or give the bytes.
    StorageFailed,
    /// The answer is larger than a frame. A fault of the firmware.
    AnswerTooLarge,
    /// What asks for more is taken over a local cable only.
    CableOnly,
    /// Nothing waits for this confirmation on this link, or it came too late.
    NothingToConfirm,
    /// The settings lie outside their bounds. The settings before stay.
    UnfitSettings(vitrine_exhibit::settings::SettingsError),
    /// The image has no bytes behind its header, or more than its place.
    ImageLength {
        /// The most bytes of a signed image.
        most: u32,
    },
    /// The bytes arrived whole, but are no image for this board. The firmware stays as it is.
    UnfitImage(crate::firmware::ImageFault),
    /// The firmware that runs is new itself and has not yet confirmed itself.
    OnTrial {
        /// When to ask again.
        retry: Milliseconds,
    },
    /// New firmware could not confirm itself: the lamp supply is out of its bounds.
    NoSupply,
    /// The firmware was started without a boot loader, and nothing would install another.
    NoBootLoader,
}

impl Refusal {
    /// When the same request may be sent again, if that is all it takes.
    pub const fn retry(&self) -> Option<Milliseconds> {
        match *self {
            Self::TooManyRequests { retry } | Self::LampsInMotion { retry } | Self::OnTrial { retry } => {
                Some(retry)
            }
            _ => None,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unacquainted { version, fingerprint } => {
                write!(f, "it wants a greeting in its own version first ({version}, {fingerprint:08x})")
            }
            Self::UnknownRequest => f.write_str("it does not know this request"),
            Self::TooManyRequests { retry } => {
                write!(f, "requests come too fast; it listens again in {} ms", retry.0)
            }
            Self::LampsInMotion { retry } => write!(
                f,
                "it writes flash only while the lamps are dark or steady, and they are fading; again in {} ms",
                retry.0
            ),
            Self::OtherUpload { retry } => {
                write!(f, "another host is uploading; free after {} s of silence", retry.0.div_ceil(1000))
            }
            Self::NoUpload => f.write_str("no upload has begun, or it was given up"),
            Self::PlanLength { most } => write!(f, "a plan has 1 to {most} bytes"),
            Self::Gap { expected } => write!(f, "bytes are missing; it waits for offset {expected}"),
            Self::PastEnd { length } => write!(f, "the bytes reach past the announced length of {length}"),
            Self::Incomplete { received, length } => {
                write!(f, "only {received} of {length} bytes have arrived")
            }
            Self::Checksum { expected, found } => {
                write!(
                    f,
                    "the bytes were damaged: CRC {found:08x} instead of {expected:08x}; the old plan stays"
                )
            }
            Self::UnreadablePlan => f.write_str("this firmware cannot read the plan; the old plan stays"),
            Self::UnfitPlan(error) => write!(f, "{error}; the old plan stays"),
            Self::NoPlan => f.write_str("there is no plan yet; upload one"),
            Self::NoSuchView { views: 1 } => f.write_str("there is no such view; the plan has one"),
            Self::NoSuchView { views } => write!(f, "there is no such view; the plan has {views}"),
            Self::Lease { most } => write!(f, "a lease lasts 1 ms to {} s", most.0 / 1000),
            Self::StillAtFault => f.write_str("the cause of the fault is still there"),
            Self::ImplausibleTime => f.write_str("the time is not between 2024 and 2099"),
            Self::ClockFailed => f.write_str("the battery clock does not take the time"),
            Self::StorageFailed => f.write_str("its flash memory failed"),
            Self::AnswerTooLarge => f.write_str("the answer does not fit a frame: a fault of its firmware"),
            Self::CableOnly => f.write_str(
                "over a network it may only be asked for less; this is taken over a cable at the exhibit",
            ),
            Self::NothingToConfirm => {
                f.write_str("nothing waits for this confirmation, or it came too late; ask once more")
            }
            Self::UnfitSettings(error) => write!(f, "{error}; the settings before stay"),
            Self::ImageLength { most } => write!(f, "a signed firmware image has 257 to {most} bytes"),
            Self::UnfitImage(fault) => write!(f, "{fault}; the firmware stays as it is"),
            Self::OnTrial { retry } => write!(
                f,
                "its firmware is new and has not yet confirmed itself; again in {} s",
                retry.0.div_ceil(1000)
            ),
            Self::NoBootLoader => {
                f.write_str("it runs without a boot loader, which would install new firmware")
            }
            Self::NoSupply => f.write_str(
                "the lamp supply is out of its bounds, and without it new firmware cannot confirm itself",
            ),
        }
    }
}

impl core::error::Error for Refusal {}
