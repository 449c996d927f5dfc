//! The boot loader and new firmware on the board: the very boot loader, the signed firmware, and small programs signed for the
//! tests.
//!
//! `VITRINE_UPDATE_CUTS` says how often the power is cut; usually it is once at each step of the flash, beyond that again in
//! other parts and orders.

use std::path::Path;
use std::process::Command;

use ed25519_dalek::pkcs8::DecodePrivateKey;
use ed25519_dalek::{Signer, SigningKey};
use vitrine_boot::{HEADER_BYTES, Header, Key, LAYOUT, Progress, SIGNED_BYTES};
use vitrine_protocol::firmware::{FirmwareState, ImageFault, Outcome};
use vitrine_protocol::message::Chunk;
use vitrine_protocol::{MAX_CHUNK, Refusal, Request, Response, plan_file};
use vitrine_storage::map::{ACTIVE_IMAGE, NEW_IMAGE, PROGRESS, SECTOR_BYTES};

use crate::bench::{
    Bench, LAMP_PINS, MILLISECOND, SECOND, built, number_of, supply_reading, vitrine_command, workspace,
};
use crate::hosts::Host;
use crate::measures::hold_stack_to_its_budget;

const STATUS_LED: u8 = 25;

/// GP16 and GP17 are not connected: a small program drives one of them high.
const OLD_PIN: u8 = 16;
const NEW_PIN: u8 = 17;

/// The converter's channel of the lamp supply.
const SUPPLY: u8 = 2;

/// Signs the real firmware with the real command.
fn firmware(folder: &Path, version: &str) -> std::path::PathBuf {
    let signed = folder.join(format!("{version}.signed"));
    let status = Command::new(vitrine_command())
        .args(["firmware", "sign", "--version", version, "-o"])
        .args([&signed, &built("vitrine-pico.elf")])
        .output()
        .expect("the command runs");
    assert!(status.status.success(), "{}", String::from_utf8_lossy(&status.stderr));
    signed
}

/// A board with boot loader and firmware 1.0.0, and new firmware of other versions.
fn board(folder: &Path) -> Bench {
    Bench::with_bootloader(&std::fs::read(firmware(folder, "1.0.0")).expect("just written"))
}

fn signed(body: &[u8], version: &str) -> Vec<u8> {
    let secret = workspace().join("firmware/boot/keys/development.secret.pem");
    let secret = std::fs::read_to_string(secret).expect("the development key");
    let key = SigningKey::from_pkcs8_pem(&secret).expect("a key");
    let mut header = Header {
        board: LAYOUT.board,
        version: version.try_into().expect("short"),
        address: LAYOUT.address(),
        length: body.len() as u32,
        digest: blake3::hash(body).into(),
        key: key.verifying_key().hint(),
        signature: [0; 64],
    };
    header.signature = key.sign(&header.to_bytes()[..SIGNED_BYTES]).to_bytes();
    [&header.to_bytes()[..], body].concat()
}

/// A program that drives a pin high and hangs, without feeding the watchdog.
fn program(pin: u8, version: &str) -> Vec<u8> {
    const CODE_AT: u32 = 0x40;
    // ldr r0, =control; movs r1, #5; str r1, [r0]; ldr r1, =mask; ldr r0, =enable; str r1, [r0]; ldr r0, =set; str r1, [r0]; b .
    let code: [u16; 10] = [0x4804, 0x2105, 0x6001, 0x4905, 0x4803, 0x6001, 0x4804, 0x6001, 0xe7fe, 0x46c0];
    let control = 0x4001_4004 + 8 * u32::from(pin);
    let words = [control, 0xd000_0024, 1 << pin, 0xd000_0014];
    let mut body = [0x2001_0000, LAYOUT.address() + CODE_AT + 1].map(u32::to_le_bytes).concat();
    body.resize(CODE_AT as usize, 0);
    code.iter().for_each(|half| body.extend_from_slice(&half.to_le_bytes()));
    words.iter().for_each(|word| body.extend_from_slice(&word.to_le_bytes()));
    signed(&body, version)
}

fn state(bench: &mut Bench) -> FirmwareState {
    let address = bench.listen();
    let mut host = Host::greet(bench, &address);
    let Ok(Response::Firmware(state)) = host.ask(bench, &Request::Firmware) else { panic!("no state") };
    state
}

#[test]
fn a_start_through_the_boot_loader_is_dark_and_quick() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bench = board(folder.path());
    bench.power_on();
    bench.run(500 * MILLISECOND);
    let up = bench.usb_up_at().expect("enumerated");
    println!("reset to USB up through the boot loader: {} ms", up / MILLISECOND);
    assert!(up <= 500 * MILLISECOND, "{up} ns");
    assert_eq!(state(&mut bench).version.as_str(), "1.0.0");
    let edges = bench.edges();
    assert!(
        edges.iter().any(|edge| edge.pin == STATUS_LED && edge.high),
        "the boot loader tells that it works"
    );
    assert!(edges.iter().all(|edge| !(edge.high && LAMP_PINS.contains(&edge.pin))), "a lamp line was high");
    bench.run(10 * SECOND);
    assert_eq!(bench.take_resets(), 0, "the boot loader's watchdog is taken over");
}

#[test]
fn a_board_without_an_image_that_verifies_stays_dark_and_blinks() {
    let mut flipped = program(OLD_PIN, "1.0.0");
    *flipped.last_mut().expect("bytes") ^= 1;
    let mut bench = Bench::with_bootloader(&flipped);
    bench.power_on();
    // The first three blinks; waiting in a loop, it gives the bench no sleep to skip.
    bench.run(2 * SECOND);
    let edges = bench.edges();
    assert!(edges.iter().all(|edge| !(edge.high && [OLD_PIN, 2, 3, 8].contains(&edge.pin))));
    let blinks = edges.iter().filter(|edge| edge.pin == STATUS_LED && edge.high).count();
    assert_eq!(blinks, 3);
    assert_eq!(bench.usb_up_at(), None);
}

#[test]
fn an_update_over_usb_goes_through_and_one_without_supply_is_gone_back_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bench = board(folder.path());
    bench.power_on();
    bench.run(SECOND);
    let address = bench.listen();
    let new = firmware(folder.path(), "2.0.0").display().to_string();
    let began = bench.now;
    let told = bench.vitrine(&["firmware", "update", &new, "--to", &address]);
    assert!(told.contains("firmware 2.0.0 runs, and has confirmed itself"), "{told}");
    println!("update over USB, to its confirmation: {} s", (bench.now - began) / SECOND);
    assert_eq!(bench.take_resets(), 1);
    let log = bench.log();
    assert!(log.iter().any(|line| line.contains("restarted as it was to be")), "{log:#?}");
    assert_eq!(state(&mut bench).version.as_str(), "2.0.0");

    // The supply goes with the restart into the next one.
    let next = firmware(folder.path(), "3.0.0").display().to_string();
    let arguments = ["firmware", "update", &next, "--to", &address];
    let (succeeded, stdout, stderr) = bench.vitrine_meanwhile(&arguments, |bench| {
        if bench.take_resets() > 0 {
            bench.analog(SUPPLY, 0);
        }
    });
    assert!(!succeeded && stderr.contains("vitrine::firmware::went_back"), "{stdout}{stderr}");
    let state = state(&mut bench);
    assert_eq!((state.version.as_str(), state.progress), ("2.0.0", Progress::Settled(Outcome::WentBack)));
    assert!(bench.is_dark());
    bench.analog(SUPPLY, supply_reading(24_000));
}

/// Sends an image message by message, as the command would if it did not look at it first.
fn send(bench: &mut Bench, host: &mut Host, image: &[u8]) -> Result<Response, Refusal> {
    let crc = plan_file::crc(image);
    host.patiently(bench, &Request::BeginUpdate { length: image.len() as u32, crc }).expect("power");
    for (index, part) in image.chunks(MAX_CHUNK).enumerate() {
        let bytes = Chunk::from_slice(part).expect("a chunk");
        host.patiently(bench, &Request::UploadChunk { offset: (index * MAX_CHUNK) as u32, bytes })
            .expect("power");
    }
    // Verified once, and put off until the watchdog was fed.
    let mut reply = host.ask(bench, &Request::CommitUpload { crc });
    for _ in 0..20 {
        let Err(Some(retry)) = reply.as_ref().map_err(Refusal::retry) else { break };
        bench.run(u64::from(retry.0) * MILLISECOND);
        reply = host.ask(bench, &Request::CommitUpload { crc });
    }
    reply
}

#[test]
fn changed_firmware_is_refused_and_firmware_that_hangs_is_gone_back_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bench = board(folder.path());
    bench.power_on();
    bench.run(SECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    bench.paint_stack();
    let hangs = program(NEW_PIN, "2.0.0");
    let mut flipped = hangs.clone();
    flipped[HEADER_BYTES as usize + 70] ^= 4;
    let refused = send(&mut bench, &mut host, &flipped);
    assert_eq!(refused, Err(Refusal::UnfitImage(ImageFault::Damaged)));
    let mut renamed = hangs.clone();
    renamed[16] ^= 1;
    let refused = send(&mut bench, &mut host, &renamed);
    assert_eq!(refused, Err(Refusal::UnfitImage(ImageFault::Signature)));

    let crc = plan_file::crc(&hangs);
    assert_eq!(send(&mut bench, &mut host, &hangs), Ok(Response::Committed { crc }));
    hold_stack_to_its_budget(&mut bench, "three updates' signatures");
    bench.edges();
    assert_eq!(host.ask(&mut bench, &Request::Restart), Ok(Response::Done));
    bench.run(20 * SECOND);
    let ran = bench.edges().iter().any(|edge| edge.pin == NEW_PIN && edge.high);
    assert!(ran, "the new firmware has run");
    assert_eq!(bench.take_resets(), 2, "the host's, and the boot loader's watchdog");
    let state = state(&mut bench);
    assert_eq!((state.version.as_str(), state.progress), ("1.0.0", Progress::Settled(Outcome::WentBack)));
}

#[test]
fn an_update_goes_through_where_every_erase_takes_its_longest() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bench = board(folder.path());
    bench.power_on();
    bench.run(SECOND);
    bench.erase_time(400 * MILLISECOND);
    let address = bench.listen();
    let mut host = Host::greet(&mut bench, &address);
    let image = program(NEW_PIN, "2.0.0");
    let crc = plan_file::crc(&image);
    assert_eq!(send(&mut bench, &mut host, &image), Ok(Response::Committed { crc }));
    assert_eq!(bench.take_resets(), 0);
}

/// Every step of the flash in an installation and in going back from it is a page programmed or a sector erased; the steps of
/// each byte are tried in `vitrine-boot`.
#[test]
fn a_power_cut_at_any_step_of_the_installation_leaves_an_image_that_runs() {
    let mut bench = Bench::with_bootloader(&program(OLD_PIN, "1.0.0"));
    bench.flash_write(NEW_IMAGE, &program(NEW_PIN, "2.0.0"));
    bench.flash_write(PROGRESS.start(), &wanted());
    bench.call(serde_json::json!({"op": "flash_save"}));
    bench.power_on();
    let before = bench.flash_steps();
    assert_eq!(runs(&mut bench), Some(NEW_PIN));
    bench.power_off();
    assert_eq!(runs_after(&mut bench), OLD_PIN, "nothing confirmed it");
    let steps = bench.flash_steps() - before;
    bench.power_off();
    assert!(steps > 15, "{steps} steps are no installation and return");
    let cuts = number_of("VITRINE_UPDATE_CUTS", steps);
    let (mut old, mut new) = (0, 0);
    for cut in 0..cuts {
        let step = 1 + cut % steps;
        let order = ["rising", "falling", "shuffled"][((cut + cut / steps) % 3) as usize];
        bench.call(serde_json::json!({"op": "flash_restore"}));
        bench.power_on();
        bench.cut_at(step, [0.3, 0.99, 0.0, 0.7][((cut + cut / steps) % 4) as usize], order);
        // The cut falls into the first start or, going back, into the second.
        if runs(&mut bench).is_some() {
            bench.power_off();
            bench.power_on();
            assert_eq!(runs(&mut bench), None, "step {step}: the power went");
        }
        let pin = runs_after(&mut bench);
        old += u64::from(pin == OLD_PIN);
        new += u64::from(pin == NEW_PIN);
        bench.power_off();
        assert_eq!(runs_after(&mut bench), OLD_PIN, "step {step}: nothing confirmed the new one");
        bench.power_off();
    }
    println!("{cuts} cuts over {steps} steps: {old} times the old image, {new} times the new one");
    assert_eq!(old + new, cuts);
}

/// Flash in which a new image waits for its installation, as the firmware would leave it.
fn wanted() -> Vec<u8> {
    use embedded_storage::nor_flash::ReadNorFlash;
    let mut flash = vitrine_storage::mock::MockFlash::new(PROGRESS.start(), ACTIVE_IMAGE);
    vitrine_boot::store_progress(&mut flash, &LAYOUT, Progress::Wanted).expect("stored");
    let mut bytes = vec![0; 2 * SECTOR_BYTES as usize];
    flash.read(PROGRESS.start(), &mut bytes).expect("read");
    bytes
}

fn runs_after(bench: &mut Bench) -> u8 {
    bench.power_on();
    runs(bench).expect("an image runs")
}

/// Runs until a program shows itself; gives its pin. None when the power goes first.
fn runs(bench: &mut Bench) -> Option<u8> {
    bench.edges();
    for _ in 0..300 {
        if !bench.run(20 * MILLISECOND) {
            return None;
        }
        let pins: Vec<u8> = bench.edges().iter().filter(|edge| edge.high).map(|edge| edge.pin).collect();
        if let Some(pin) = pins.into_iter().find(|pin| [OLD_PIN, NEW_PIN].contains(pin)) {
            return Some(pin);
        }
    }
    panic!("nothing runs");
}
