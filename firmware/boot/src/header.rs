//! What stands in front of an image, and vouches for it.

use vitrine_protocol::firmware::{Digest, ImageFault, Version};

/// Bytes of a header; the processor's vector table, which comes right behind it, wants a multiple of this.
pub const HEADER_BYTES: u32 = 256;

/// Bytes of a header that its signature covers: all before it.
pub const SIGNED_BYTES: usize = HEADER_BYTES as usize - SIGNATURE_BYTES;

const SIGNATURE_BYTES: usize = 64;
const MAGIC: [u8; 8] = *b"VITRINE1";

/// What is known of an image. Its bytes, numbers little-endian:
///
/// | at | bytes | |
/// |---|---|---|
/// | 0 | 8 | `VITRINE1` |
/// | 8 | 8 | the board that it is for, as in `rp2040`, filled up with zeros |
/// | 16 | 24 | its version, as in `0.1.0`, filled up with zeros |
/// | 40 | 4 | the address that it is linked to, where its vector table lies |
/// | 44 | 4 | its length behind the header, in bytes |
/// | 48 | 32 | BLAKE3 of it |
/// | 80 | 8 | the first bytes of the public key, to tell another key from damage |
/// | 88 | 104 | zeros |
/// | 192 | 64 | Ed25519 signature (RFC 8032) of all before it |
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// The board that it is for.
    pub board: [u8; 8],
    /// Its version.
    pub version: Version,
    /// The address of its vector table.
    pub address: u32,
    /// Its length behind the header, in bytes.
    pub length: u32,
    /// BLAKE3 of it.
    pub digest: Digest,
    /// The first bytes of the public key whose secret key has signed it.
    pub key: [u8; 8],
    /// The signature of all before it.
    pub signature: [u8; SIGNATURE_BYTES],
}

impl Header {
    /// The bytes, the signature among them.
    pub fn to_bytes(&self) -> [u8; HEADER_BYTES as usize] {
        let mut bytes = [0; HEADER_BYTES as usize];
        let mut version = [0; 24];
        for (place, letter) in version.iter_mut().zip(self.version.bytes()) {
            *place = letter;
        }
        let (address, length) = (self.address.to_le_bytes(), self.length.to_le_bytes());
        let fields: [(usize, &[u8]); 8] = [
            (0, &MAGIC),
            (8, &self.board),
            (16, &version),
            (40, &address),
            (44, &length),
            (48, &self.digest),
            (80, &self.key),
            (SIGNED_BYTES, &self.signature),
        ];
        for (at, field) in fields {
            for (place, byte) in bytes.iter_mut().skip(at).zip(field) {
                *place = *byte;
            }
        }
        bytes
    }

    /// Reads a header; whether its signature is right is another question ([`crate::verify`]).
    ///
    /// # Errors
    /// The bytes are no header.
    pub fn from_bytes(bytes: &[u8; HEADER_BYTES as usize]) -> Result<Self, ImageFault> {
        if field::<8>(bytes, 0) != MAGIC {
            return Err(ImageFault::NoImage);
        }
        let version = field::<24>(bytes, 16);
        let version = version.split(|byte| *byte == 0).next().unwrap_or_default();
        let version = core::str::from_utf8(version).map_err(|_| ImageFault::NoImage)?;
        Ok(Self {
            board: field(bytes, 8),
            version: Version::try_from(version).map_err(|_| ImageFault::NoImage)?,
            address: u32::from_le_bytes(field(bytes, 40)),
            length: u32::from_le_bytes(field(bytes, 44)),
            digest: field(bytes, 48),
            key: field(bytes, 80),
            signature: field(bytes, SIGNED_BYTES),
        })
    }
}

/// The bytes of a field of known place.
fn field<const N: usize>(bytes: &[u8; HEADER_BYTES as usize], at: usize) -> [u8; N] {
    let mut field = [0; N];
    for (place, byte) in field.iter_mut().zip(bytes.iter().skip(at)) {
        *place = *byte;
    }
    field
}
