//! Secret keys, in files as OpenSSL reads and writes them.

use std::{fs, io, path::Path, path::PathBuf};

use ed25519_dalek::{
    SigningKey,
    pkcs8::{DecodePrivateKey, EncodePrivateKey, EncodePublicKey, spki::der::pem::LineEnding},
};
use miette::Diagnostic;
use thiserror::Error;
use vitrine_boot::DEVELOPMENT_KEY;

/// The development key's secret part, which everybody may read.
const DEVELOPMENT_SECRET: &str = include_str!("../../../firmware/boot/keys/development.secret.pem");

/// A key that signs images.
#[derive(Clone, Debug)]
pub struct SecretKey(pub(super) SigningKey);

/// Why there is no key.
#[derive(Debug, Error, Diagnostic)]
pub enum KeyError {
    /// The file cannot be read.
    #[error("the key file {} cannot be read", path.display())]
    #[diagnostic(
        code(vitrine::firmware::key_file),
        help("is it there, and may you read it? `vitrine firmware keygen` makes a key")
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file holds no Ed25519 secret key.
    #[error("{} holds no Ed25519 secret key in PEM", path.display())]
    #[diagnostic(
        code(vitrine::firmware::no_key),
        help("`vitrine firmware keygen` makes one, and so does `openssl genpkey -algorithm ed25519`")
    )]
    NoKey {
        /// The file.
        path: PathBuf,
    },
    /// The operating system gives no random numbers.
    #[error("this computer gives no random numbers: {0}")]
    #[diagnostic(code(vitrine::firmware::no_randomness), help("make the key on another computer"))]
    NoRandomness(getrandom::Error),
    /// The key cannot be written as text.
    #[error("the key cannot be encoded")]
    #[diagnostic(code(vitrine::firmware::key_encoding), help("please report it"))]
    Encoding,
}

impl SecretKey {
    /// A new key from the computer's random numbers.
    ///
    /// # Errors
    /// The computer gives none.
    pub fn generate() -> Result<Self, KeyError> {
        let mut seed = [0; 32];
        getrandom::fill(&mut seed).map_err(KeyError::NoRandomness)?;
        Ok(Self(SigningKey::from_bytes(&seed)))
    }

    /// The published key, for tests and fresh clones.
    pub fn development() -> Self {
        let Ok(key) = SigningKey::from_pkcs8_pem(DEVELOPMENT_SECRET) else {
            unreachable!("a test of vitrine-boot reads this file")
        };
        Self(key)
    }

    /// Reads a key file: PKCS#8 in PEM.
    ///
    /// # Errors
    /// The file cannot be read, or holds no such key.
    pub fn read(path: &Path) -> Result<Self, KeyError> {
        let text = fs::read_to_string(path)
            .map_err(|source| KeyError::Unreadable { path: path.to_owned(), source })?;
        SigningKey::from_pkcs8_pem(&text).map(Self).map_err(|_| KeyError::NoKey { path: path.to_owned() })
    }

    /// The key as a file holds it.
    ///
    /// # Errors
    /// The encoding fails, which no key makes it do.
    pub fn secret_pem(&self) -> Result<String, KeyError> {
        self.0.to_pkcs8_pem(LineEnding::LF).map(|text| text.to_string()).map_err(|_| KeyError::Encoding)
    }

    /// Its public part as a file holds it: what `VITRINE_PUBLIC_KEY` names for firmware/build.sh.
    ///
    /// # Errors
    /// The encoding fails, which no key makes it do.
    pub fn public_pem(&self) -> Result<String, KeyError> {
        self.0.verifying_key().to_public_key_pem(LineEnding::LF).map_err(|_| KeyError::Encoding)
    }

    /// The first bytes of its public part, in hexadecimal digits, as images name it.
    pub fn fingerprint(&self) -> String {
        fingerprint(&self.0.verifying_key().to_bytes()[..8])
    }

    /// Whether this is the development key: what it signs proves nothing.
    pub fn is_development(&self) -> bool {
        self.0.verifying_key().to_bytes() == DEVELOPMENT_KEY
    }
}

pub(super) fn fingerprint(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
