//! A flash with small places, and images signed for it.

use std::{cell::RefCell, collections::HashMap, vec, vec::Vec};

use ed25519_dalek::{Signer, SigningKey, VerifyingKey, pkcs8::DecodePrivateKey};
use vitrine_protocol::firmware::Progress;
use vitrine_storage::map::SECTOR_BYTES;
use vitrine_storage::mock::{EraseOrder, LastStep, MockError, MockFlash};
use vitrine_storage::{Error, TwoSlots};

use crate::{HEADER_BYTES, Header, Key, Layout, SIGNED_BYTES, Slot, Staging, Start, progress, start};

/// Places of two sectors.
pub(super) const PLACE: u32 = 2 * SECTOR_BYTES;

pub(super) const LAYOUT: Layout = Layout {
    board: *b"rp2040\0\0",
    active: Slot::new(0x1_0000, PLACE),
    new: Slot::new(0x1_0000 + PLACE, PLACE),
    old: Slot::new(0x1_0000 + 2 * PLACE, PLACE),
    progress: TwoSlots::new(0x1_0000 - PLACE, SECTOR_BYTES),
};

pub(super) fn signing_key() -> SigningKey {
    SigningKey::from_pkcs8_pem(include_str!("../../keys/development.secret.pem"))
        .expect("the development key")
}

/// The development key, which remembers what it has judged: the same images are verified thousands of times.
pub(super) struct Remembering {
    key: VerifyingKey,
    judged: RefCell<HashMap<Vec<u8>, bool>>,
}

impl Remembering {
    pub(super) fn new() -> Self {
        Self { key: signing_key().verifying_key(), judged: RefCell::default() }
    }
}

impl Key for Remembering {
    fn hint(&self) -> [u8; 8] {
        self.key.hint()
    }

    fn has_signed(&self, message: &[u8], signature: &[u8; 64]) -> bool {
        let question = [message, signature].concat();
        *self.judged.borrow_mut().entry(question).or_insert_with(|| self.key.has_signed(message, signature))
    }
}

/// An image of `length` bytes behind its header, signed with the development key.
pub(super) fn image(version: &str, length: usize) -> Vec<u8> {
    let seed: u32 = version.bytes().map(u32::from).sum();
    let body: Vec<u8> = (0..length as u32).map(|i| (seed + i * 7 + i / 251) as u8).collect();
    signed(header(version, &body), &body)
}

/// The same, signed once in a thread: what runs is held against it thousands of times.
fn remembered_image(version: &str, length: usize) -> Vec<u8> {
    std::thread_local! {
        static SIGNED: RefCell<HashMap<(std::string::String, usize), Vec<u8>>> = RefCell::default();
    }
    SIGNED.with_borrow_mut(|signed| {
        signed.entry((version.into(), length)).or_insert_with(|| image(version, length)).clone()
    })
}

pub(super) fn header(version: &str, body: &[u8]) -> Header {
    Header {
        board: LAYOUT.board,
        version: version.try_into().expect("short"),
        address: LAYOUT.address(),
        length: body.len() as u32,
        digest: blake3::hash(body).into(),
        key: signing_key().verifying_key().hint(),
        signature: [0; 64],
    }
}

pub(super) fn signed(mut header: Header, body: &[u8]) -> Vec<u8> {
    header.signature = signing_key().sign(&header.to_bytes()[..SIGNED_BYTES]).to_bytes();
    [&header.to_bytes()[..], body].concat()
}

/// The flash of a board whose active place holds this image.
pub(super) fn flash_with(active: &[u8]) -> MockFlash {
    let mut flash = MockFlash::new(0x1_0000 - PLACE, 0x1_0000 + 3 * PLACE);
    put(&mut flash, LAYOUT.active, active);
    flash
}

/// Puts bytes into a place as a programmer would.
pub(super) fn put(flash: &mut MockFlash, slot: Slot, bytes: &[u8]) {
    let at = (slot.start() - (0x1_0000 - PLACE)) as usize;
    flash.bytes_mut()[at..at + slot.bytes() as usize].fill(0xff);
    flash.bytes_mut()[at..at + bytes.len()].copy_from_slice(bytes);
}

/// What a place begins with.
pub(super) fn held(flash: &mut MockFlash, slot: Slot, length: usize) -> Vec<u8> {
    let at = (slot.start() - (0x1_0000 - PLACE)) as usize;
    flash.bytes_mut()[at..at + length].to_vec()
}

pub(super) fn tearing(flash: &MockFlash, order: EraseOrder, last_step: LastStep) -> MockFlash {
    flash.clone().tearing(order, last_step)
}

/// Sends an image in messages and has it installed at the next start.
pub(super) fn stage(flash: &mut MockFlash, key: &impl Key, image: &[u8]) -> Result<(), Error<MockError>> {
    let mut staging = Staging::begin(flash, &LAYOUT, image.len() as u32)?;
    for part in image.chunks(256) {
        staging.append(flash, part)?;
    }
    staging.finish(flash, key)?.expect("an image for this board");
    Ok(())
}

/// Starts the board; gives the version that runs, and whether on trial. Panics where what runs is not whole.
pub(super) fn boot(flash: &mut MockFlash, key: &impl Key) -> (std::string::String, bool) {
    match start(flash, &LAYOUT, key).expect("flash with power") {
        Start::Image { header, on_trial } => {
            let length = (HEADER_BYTES + header.length) as usize;
            let expected = remembered_image(&header.version, header.length as usize);
            assert_eq!(held(flash, LAYOUT.active, length), expected, "a mixed image runs");
            (header.version.as_str().into(), on_trial)
        }
        Start::Nothing => panic!("nothing runs"),
    }
}

pub(super) fn stage_of(flash: &mut MockFlash) -> Progress {
    progress(flash, &LAYOUT).expect("flash with power")
}

pub(super) fn erased(length: usize) -> Vec<u8> {
    vec![0xff; length]
}
