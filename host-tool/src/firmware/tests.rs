use vitrine_boot::{HEADER_BYTES, LAYOUT};
use vitrine_protocol::firmware::ImageFault;

use super::{SecretKey, SignedImage, join, sign, uf2};

#[test]
fn what_is_signed_is_read_back_and_damage_is_found() {
    let key = SecretKey::generate().expect("random numbers");
    let signed = sign(&[5; 1_000], "1.2.3", &key);
    let read = SignedImage::from_bytes(signed.clone()).expect("whole");
    assert_eq!((read.header.version.as_str(), read.header.length), ("1.2.3", 1_000));
    assert_eq!(read.key_fingerprint(), key.fingerprint());
    assert!(!read.is_of_development_key());
    assert!(
        SignedImage::from_bytes(sign(&[5; 10], "1", &SecretKey::development()))
            .expect("whole")
            .is_of_development_key()
    );
    let fault = |bytes: &[u8]| SignedImage::from_bytes(bytes.to_vec()).expect_err("no image");
    let mut flipped = signed.clone();
    flipped[600] ^= 1;
    assert_eq!(fault(&flipped), ImageFault::Damaged);
    assert_eq!(fault(&signed[..signed.len() - 1]), ImageFault::Damaged);
    assert_eq!(fault(&[&signed[..], &[0]].concat()), ImageFault::Damaged);
    let mut long = signed.clone();
    long[44..48].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(fault(&long), ImageFault::Length);
    let mut elsewhere = signed.clone();
    elsewhere[8..16].copy_from_slice(b"rp2350\0\0");
    assert_eq!(fault(&elsewhere), ImageFault::OtherBoard);
    assert_eq!(fault(&signed[..100]), ImageFault::NoImage);
    assert_eq!(fault(&[]), ImageFault::NoImage);
}

#[test]
fn keys_survive_their_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("key.pem");
    let key = SecretKey::generate().expect("random numbers");
    std::fs::write(&path, key.secret_pem().expect("text")).expect("written");
    let read = SecretKey::read(&path).expect("a key");
    assert_eq!(read.public_pem().expect("text"), key.public_pem().expect("text"));
    std::fs::write(&path, key.public_pem().expect("text")).expect("written");
    assert!(SecretKey::read(&path).is_err(), "a public key does not sign");
    assert!(SecretKey::development().is_development() && !key.is_development());
}

#[test]
fn a_new_board_gets_boot_loader_image_and_no_update_under_way() {
    let signed = sign(&[5; 300], "1.2.3", &SecretKey::development());
    let flash = join(&[1; 500], &signed);
    let active = LAYOUT.active.start() as usize;
    assert_eq!(flash.len(), active + HEADER_BYTES as usize + 300);
    assert_eq!(flash[active..], signed);
    assert_eq!(flash[..500], [1; 500]);
    assert!(flash[500..active].iter().all(|byte| *byte == 0xff));
}

/// Each block as the format's document lays it out.
#[test]
fn a_uf2_file_is_made_of_blocks() {
    let flash: Vec<u8> = (0..700_u32).map(|i| i as u8).collect();
    let file = uf2(&flash);
    assert_eq!(file.len(), 3 * 512);
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes"));
    let mut read = Vec::new();
    for (number, at) in (0..file.len()).step_by(512).enumerate() {
        assert_eq!(file[at..at + 4], *b"UF2\n");
        assert_eq!((word(at + 4), word(at + 508)), (0x9e5d_5157, 0x0ab1_6f30));
        assert_eq!((word(at + 8), word(at + 28)), (0x2000, 0xe48b_ff56));
        assert_eq!(word(at + 12), 0x1000_0000 + 256 * number as u32);
        assert_eq!((word(at + 16), word(at + 20), word(at + 24)), (256, number as u32, 3));
        read.extend_from_slice(&file[at + 32..at + 288]);
        assert!(file[at + 288..at + 508].iter().all(|byte| *byte == 0));
    }
    assert_eq!(read[..700], flash);
    assert!(read[700..].iter().all(|byte| *byte == 0xff));
}
