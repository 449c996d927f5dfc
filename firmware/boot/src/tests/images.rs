//! What counts as an image.

use proptest::prelude::*;
use vitrine_protocol::firmware::ImageFault;

use super::bench::{LAYOUT, PLACE, flash_with, header, image, put, signed, signing_key};
use crate::{HEADER_BYTES, Header, Key, verify};

fn fault(bytes: &[u8]) -> Option<ImageFault> {
    let key = signing_key().verifying_key();
    verify(&mut flash_with(bytes), &LAYOUT, LAYOUT.active, &key).expect("readable").err()
}

#[test]
fn a_signed_image_verifies_and_is_told_apart_from_what_is_none() {
    let good = image("1.2.3", 5_000);
    assert_eq!(fault(&good), None);
    assert_eq!(fault(&[]), Some(ImageFault::NoImage));
    assert_eq!(fault(&[0; 300]), Some(ImageFault::NoImage));
    let body = &good[HEADER_BYTES as usize..];
    let with = |change: &dyn Fn(&mut Header)| {
        let mut header = header("1.2.3", body);
        change(&mut header);
        fault(&signed(header, body))
    };
    assert_eq!(with(&|_| {}), None);
    assert_eq!(with(&|header| header.board = *b"rp2350\0\0"), Some(ImageFault::OtherBoard));
    assert_eq!(with(&|header| header.address += 256), Some(ImageFault::OtherAddress));
    assert_eq!(with(&|header| header.length = PLACE), Some(ImageFault::Length));
    assert_eq!(with(&|header| header.length = u32::MAX), Some(ImageFault::Length));
    assert_eq!(with(&|header| header.length = 0), Some(ImageFault::Length));
    assert_eq!(with(&|header| header.length -= 1), Some(ImageFault::Damaged));
    assert_eq!(with(&|header| header.key[0] ^= 1), Some(ImageFault::OtherKey));
    assert_eq!(with(&|header| header.digest[31] ^= 1), Some(ImageFault::Damaged));
}

#[test]
fn every_flipped_bit_is_found() {
    let good = image("1.2.3", 300);
    for bit in 0..good.len() * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(fault(&bad).is_some(), "bit {bit}");
    }
}

#[test]
fn an_image_signed_by_somebody_else_is_refused() {
    let key = ed25519_dalek::SigningKey::from_bytes(&[3; 32]).verifying_key();
    let mut flash = flash_with(&image("1.2.3", 300));
    let found = verify(&mut flash, &LAYOUT, LAYOUT.active, &key).expect("readable");
    assert_eq!(found, Err(ImageFault::OtherKey));
    // Also where the header claims to be of the right key.
    let mut header = header("1.2.3", &[1; 300]);
    header.key = key.hint();
    put(&mut flash, LAYOUT.active, &signed(header, &[1; 300]));
    let found = verify(&mut flash, &LAYOUT, LAYOUT.active, &key).expect("readable");
    assert_eq!(found, Err(ImageFault::Signature));
}

proptest! {
    #[test]
    fn any_bytes_are_judged_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..600), magic: bool) {
        let mut bytes = bytes;
        if magic {
            bytes.splice(..0, *b"VITRINE1rp2040\0\0");
        }
        prop_assert!(fault(&bytes).is_some());
    }

    #[test]
    fn headers_are_read_as_they_were_written(
        version in "[ -~]{0,24}", address: u32, length: u32, digest: [u8; 32], key: [u8; 8], signature: [u8; 32],
    ) {
        let written = Header {
            board: LAYOUT.board,
            version: version.as_str().try_into().expect("short"),
            address,
            length,
            digest,
            key,
            signature: [signature, signature].concat().try_into().expect("64 bytes"),
        };
        prop_assert_eq!(Header::from_bytes(&written.to_bytes()), Ok(written));
    }
}
