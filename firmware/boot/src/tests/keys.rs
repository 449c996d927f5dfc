//! The keys in the tree, and the arithmetic behind them.

use ed25519_dalek::VerifyingKey;

use super::bench::signing_key;
use crate::{DEVELOPMENT_KEY, Key, PUBLIC_KEY, public_key, takes_development_key};

#[test]
fn the_development_keys_two_halves_belong_together() {
    assert_eq!(signing_key().verifying_key().to_bytes(), DEVELOPMENT_KEY);
    assert_eq!(takes_development_key(), PUBLIC_KEY == DEVELOPMENT_KEY);
    assert_eq!(public_key().expect("a key").to_bytes(), PUBLIC_KEY);
}

/// RFC 8032, 7.1, test 3.
#[test]
fn a_published_signature_verifies() {
    let bytes = |text: &str| -> std::vec::Vec<u8> {
        (0..text.len()).step_by(2).map(|at| u8::from_str_radix(&text[at..at + 2], 16).expect("hex")).collect()
    };
    let public = bytes("fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025");
    let signature = bytes(
        "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28dc027beceea1ec40a",
    );
    let key = VerifyingKey::from_bytes(&public.try_into().expect("32 bytes")).expect("a key");
    let mut signature: [u8; 64] = signature.try_into().expect("64 bytes");
    assert!(key.has_signed(&[0xaf, 0x82], &signature));
    assert!(!key.has_signed(&[0xaf, 0x83], &signature));
    signature[40] ^= 1;
    assert!(!key.has_signed(&[0xaf, 0x82], &signature));
}
