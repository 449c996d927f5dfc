//! Signed images, and the flash of a new board.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use ed25519_dalek::Signer;
use vitrine_boot::{DEVELOPMENT_KEY, HEADER_BYTES, Header, Key, LAYOUT, SIGNED_BYTES};
use vitrine_protocol::firmware::ImageFault;

use super::{FirmwareError, SecretKey, key::fingerprint};

/// A signed image as an update sends it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignedImage {
    /// What stands in front.
    pub header: Header,
    /// All bytes, the header's among them.
    pub bytes: Vec<u8>,
}

impl SignedImage {
    /// Reads a signed image, and checks everything that can be checked without knowing the board's key.
    ///
    /// # Errors
    /// The file cannot be read, or holds no whole image for this board.
    pub fn read(path: &Path) -> Result<Self, FirmwareError> {
        let unreadable = |source| FirmwareError::Unreadable { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        // A larger file is no image, and need not be read whole to say why.
        let most = u64::from(LAYOUT.active.bytes()) + 1;
        let read = File::open(path).and_then(|file| file.take(most).read_to_end(&mut bytes));
        read.map_err(unreadable)?;
        Self::from_bytes(bytes).map_err(|fault| FirmwareError::NoImage { path: path.to_owned(), fault })
    }

    /// The same of bytes.
    ///
    /// # Errors
    /// They are no whole image for this board.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, ImageFault> {
        let (front, body) = bytes.split_first_chunk().ok_or(ImageFault::NoImage)?;
        // The board's own judge, but for the signature: a board may take another key than this computer knows.
        let header = LAYOUT.vouch(front, &Anybody(*front))?;
        let is_whole = body.len() == header.length as usize;
        if !is_whole || *blake3::hash(body).as_bytes() != header.digest {
            return Err(ImageFault::Damaged);
        }
        Ok(Self { header, bytes })
    }

    /// Whether it is signed with the development key: then anybody could have signed it.
    pub fn is_of_development_key(&self) -> bool {
        DEVELOPMENT_KEY.starts_with(&self.header.key)
    }

    /// The BLAKE3 hash of the image behind the header, in hexadecimal digits.
    pub fn digest(&self) -> String {
        fingerprint(&self.header.digest)
    }

    /// The first bytes of the public key that it names, in hexadecimal digits.
    pub fn key_fingerprint(&self) -> String {
        fingerprint(&self.header.key)
    }
}

/// Takes whatever key a header names.
struct Anybody([u8; HEADER_BYTES as usize]);

impl Key for Anybody {
    fn hint(&self) -> [u8; 8] {
        Header::from_bytes(&self.0).map(|header| header.key).unwrap_or_default()
    }

    fn has_signed(&self, _: &[u8], _: &[u8; 64]) -> bool {
        true
    }
}

/// Puts a signed header in front of an image; the version has at most 24 bytes.
pub fn sign(image: &[u8], version: &str, key: &SecretKey) -> Vec<u8> {
    let mut header = Header {
        board: LAYOUT.board,
        version: version.chars().filter(char::is_ascii).take(24).collect(),
        address: LAYOUT.address(),
        length: image.len() as u32,
        digest: blake3::hash(image).into(),
        key: key.0.verifying_key().hint(),
        signature: [0; 64],
    };
    header.signature = key.0.sign(&header.to_bytes()[..SIGNED_BYTES]).to_bytes();
    [&header.to_bytes()[..], image].concat()
}

/// The flash of a new board from its beginning on: boot loader, no update under way, the signed image in the active place.
/// What lies between is erased flash.
pub fn join(bootloader: &[u8], signed: &[u8]) -> Vec<u8> {
    let mut flash = vec![0xff; LAYOUT.active.start() as usize];
    flash[..bootloader.len()].copy_from_slice(bootloader);
    flash.extend_from_slice(signed);
    flash
}
