//! A plan as bytes: postcard, then CRC-32/ISCSI (Castagnoli's, as in iSCSI and ext4) of it, little-endian. `plan.bin`,
//! and what is uploaded.
//!
//! The upload's own CRC, by which the plan is named, is CRC-32/ISO-HDLC of all these bytes. The checksum within is of
//! another polynomial because the CRC of bytes that end with their own CRC is the same for all of them.

use crc::{CRC_32_ISCSI, Crc};
use serde::Deserialize;
use vitrine_exhibit::plan::Plan;

use crate::frame::CRC;

/// The checksum at the end of a plan.
const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// The most bytes of a plan.
pub const MAX_PLAN_BYTES: usize = 4096;

/// Why bytes are no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanFileError {
    /// The checksum at the end does not fit.
    Checksum,
    /// The checksum fits, but this version reads plans in another layout.
    Layout,
}

impl core::fmt::Display for PlanFileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Checksum => "the plan is damaged: its checksum does not fit",
            Self::Layout => "the plan was written by another version",
        })
    }
}

impl core::error::Error for PlanFileError {}

/// Writes a plan into `bytes`, which has to be large enough ([`MAX_PLAN_BYTES`] is); gives the part used.
pub fn encode<'a>(plan: &Plan, bytes: &'a mut [u8]) -> Option<&'a mut [u8]> {
    postcard::to_slice_crc32(plan, bytes, CHECKSUM.digest()).ok()
}

/// Reads a plan, apart from its caller: what the reading needs of a board's stack is free again afterwards. Whether it makes
/// sense is another question: [`ValidPlan::new`](vitrine_exhibit::plan::ValidPlan::new) answers it.
#[inline(never)]
pub fn decode(bytes: &[u8]) -> Result<Plan, PlanFileError> {
    let (encoded, checksum) = bytes.split_last_chunk::<4>().ok_or(PlanFileError::Checksum)?;
    if CHECKSUM.checksum(encoded) != u32::from_le_bytes(*checksum) {
        return Err(PlanFileError::Checksum);
    }
    let mut reader = postcard::Deserializer::from_bytes(encoded);
    let plan = Plan::deserialize(&mut reader).map_err(|_| PlanFileError::Layout)?;
    match reader.finalize() {
        Ok([]) => Ok(plan),
        _ => Err(PlanFileError::Layout),
    }
}

/// The CRC by which an upload is announced and by which the active plan is named: that of all its bytes.
pub fn crc(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}
