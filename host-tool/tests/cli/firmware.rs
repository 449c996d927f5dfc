//! `vitrine firmware`, against a simulated controller.

use serde_json::Value;

use super::link::json;
use super::support::{Simulated, Workshop};

/// Where the active image's vector table lies.
const ADDRESS: u32 = 0x1001_0100;

/// The smallest ELF file with an image for the board: one segment, a stack and an entry in front.
pub(super) fn elf(text: &str) -> Vec<u8> {
    let mut body = [0x2001_0000_u32, ADDRESS + 0x41].map(u32::to_le_bytes).concat();
    body.resize(0x40, 0);
    body.extend_from_slice(text.as_bytes());
    let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    let (executable, arm) = (2_u16, 40_u16);
    [executable, arm].iter().for_each(|half| file.extend_from_slice(&half.to_le_bytes()));
    let words: [u32; 5] = [1, ADDRESS + 0x41, 52, 0, 0];
    words.iter().for_each(|word| file.extend_from_slice(&word.to_le_bytes()));
    let halves: [u16; 6] = [52, 32, 1, 40, 0, 0];
    halves.iter().for_each(|half| file.extend_from_slice(&half.to_le_bytes()));
    let length = body.len() as u32;
    let segment: [u32; 8] = [1, 84, ADDRESS, ADDRESS, length, length, 5, 4];
    segment.iter().for_each(|word| file.extend_from_slice(&word.to_le_bytes()));
    file.extend_from_slice(&body);
    file
}

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("new.elf", elf("new firmware"));
    workshop
}

#[test]
fn signed_firmware_is_installed_and_reports_itself() {
    let workshop = workshop();
    let simulated = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let to = simulated.address.as_str();
    let signed = workshop.run(&["firmware", "sign", "new.elf", "--version", "9.0.0", "-o", "new.signed"]);
    assert_eq!(signed.code, Some(0), "{}", signed.stderr);
    assert!(signed.stderr.contains("development key"), "{}", signed.stderr);

    let dry =
        json(&workshop.succeed(&["firmware", "update", "new.signed", "--to", to, "--dry-run", "--json"]));
    assert_eq!((&dry["sent"], &dry["version"]), (&Value::from(false), &Value::from("9.0.0")));
    let told = json(&workshop.succeed(&["firmware", "update", "new.signed", "--to", to, "--json"]));
    assert_eq!((&told["sent"], &told["confirmed"]), (&Value::from(true), &Value::from(true)));
    let again = workshop.succeed(&["firmware", "update", "new.signed", "--to", to]);
    assert!(again.contains("9.0.0 runs already"), "{again}");

    // It outlives the power.
    drop(simulated);
    let simulated = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let again = workshop.succeed(&["firmware", "update", "new.signed", "--to", &simulated.address]);
    assert!(again.contains("9.0.0 runs already"), "{again}");
}

#[test]
fn a_key_of_ones_own_signs_and_a_board_of_another_key_refuses() {
    let workshop = workshop();
    let keygen = ["firmware", "keygen", "--secret", "my.secret.pem", "--public", "my.public.pem"];
    workshop.succeed(&[&keygen[..], &["--dry-run"]].concat());
    assert!(!workshop.path("my.secret.pem").exists() && !workshop.path("my.public.pem").exists());
    workshop.succeed(&keygen);
    let public = std::fs::read_to_string(workshop.path("my.public.pem")).unwrap();
    assert!(public.starts_with("-----BEGIN PUBLIC KEY-----"), "{public}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::metadata(workshop.path("my.secret.pem")).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    for more in [&[][..], &["--dry-run"]] {
        let again = ["firmware", "keygen", "--secret", "my.secret.pem", "--public", "other.public.pem"];
        let again = workshop.run(&[&again[..], more].concat());
        assert!(again.stderr.contains("vitrine::firmware::key_exists"), "{}", again.stderr);
    }
    assert!(!workshop.path("other.public.pem").exists());

    let sign = ["firmware", "sign", "new.elf", "--key", "my.secret.pem", "-o", "new.signed"];
    let signed = workshop.run(&sign);
    assert_eq!((signed.code, signed.stderr.as_str()), (Some(0), ""));
    let simulated = Simulated::start(&workshop, &[]);
    let refused = workshop.run(&["firmware", "update", "new.signed", "--to", &simulated.address]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("signed with another key"), "{}", refused.stderr);
}

#[test]
fn files_that_are_no_firmware_are_named_with_the_remedy() {
    let workshop = workshop();
    workshop.succeed(&["firmware", "sign", "new.elf", "-o", "new.signed"]);
    let mut flipped = std::fs::read(workshop.path("new.signed")).unwrap();
    flipped[300] ^= 1;
    workshop.write("flipped.signed", flipped);
    workshop.write("other.elf", &elf("x")[..60]);
    workshop.write("text.pem", "no key");
    workshop.write("long.signed", vec![0; 400_000]);
    let whole = std::fs::read(workshop.path("new.signed")).unwrap();
    workshop.write("cut.signed", &whole[..whole.len() - 1]);
    let cut = workshop.run(&["firmware", "update", "cut.signed", "--to", "tcp:127.0.0.1:1"]);
    assert!(cut.stderr.contains("bytes were changed or are missing"), "{}", cut.stderr);
    let other = workshop.run(&["firmware", "update", "long.signed", "--to", "tcp:127.0.0.1:1"]);
    assert!(other.stderr.contains("this is no signed firmware image"), "{}", other.stderr);
    for (arguments, code) in [
        (&["firmware", "update", "flipped.signed", "--to", "tcp:127.0.0.1:1"][..], "no_image"),
        (&["firmware", "update", "new.elf", "--to", "tcp:127.0.0.1:1"], "no_image"),
        (&["firmware", "update", "long.signed", "--to", "tcp:127.0.0.1:1"], "no_image"),
        (&["firmware", "update", "none.signed"], "unreadable"),
        (&["firmware", "sign", "other.elf", "-o", "x"], "no_elf"),
        (&["firmware", "sign", "text.pem", "-o", "x"], "no_elf"),
        (&["firmware", "sign", "new.elf", "--key", "text.pem", "-o", "x"], "no_key"),
        (&["firmware", "sign", "new.elf", "--key", "none.pem", "-o", "x"], "key_file"),
        (&["firmware", "sign", "new.elf", "-o", "none/x"], "write"),
        (&["firmware", "build", "-o", "built"], "no_source"),
    ] {
        let finished = workshop.run(arguments);
        assert_eq!(finished.code, Some(1), "{arguments:?}");
        let code = format!("vitrine::firmware::{code}");
        assert!(finished.stderr.contains(&code), "{arguments:?}: {}", finished.stderr);
    }
    assert!(!workshop.path("x").exists() && !workshop.path("built").exists());
    assert_eq!(workshop.run(&["firmware", "sign", "new.elf", "--version", "a b", "-o", "x"]).code, Some(2));
}
