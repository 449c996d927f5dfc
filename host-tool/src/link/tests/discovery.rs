use super::served;
use crate::{
    controller::FlashFile,
    link::{
        Address, Announcement, Device, LinkError, choose,
        discovery::{announced_in, by_serial_number},
    },
};

#[test]
fn an_announcement_is_found_until_it_is_withdrawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_served, address) = served(FlashFile::in_memory());
    let Address::Tcp(place) = &address else { panic!("{address}") };
    let announcement = Announcement::in_folder(folder.path(), place).expect("announced");
    let other = Announcement::in_folder(folder.path(), "[::1]:7470").expect("announced");
    let mut found = announced_in(folder.path());
    found.sort_by_key(ToString::to_string);
    let mut expected = vec![address, Address::Tcp("[::1]:7470".into())];
    expected.sort_by_key(ToString::to_string);
    assert_eq!(found, expected);
    drop((announcement, other));
    assert_eq!(announced_in(folder.path()), []);
    assert_eq!(announced_in(&folder.path().join("none")), []);
}

#[test]
fn a_given_address_is_taken_as_it_is() {
    let given = Address::Serial("/dev/ttyACM9".into());
    assert_eq!(choose(Some(given.clone())).expect("taken"), given);
}

#[test]
fn a_controller_is_found_by_how_its_serial_number_begins() {
    let device = |port: &str, serial_number: &str| {
        let address = Address::Serial(port.into());
        let state = Err(LinkError::NotOurs { address: address.clone() });
        Device { address, kind: String::new(), serial_number: Some(serial_number.into()), state }
    };
    let devices = || vec![device("/dev/ttyACM0", "E6614C31"), device("/dev/ttyACM1", "E6617A02")];
    let found = |wanted: &str| by_serial_number(wanted, devices());
    assert_eq!(found("e6617").expect("found"), Address::Serial("/dev/ttyACM1".into()));
    assert!(matches!(found("E661"), Err(LinkError::SeveralFound { found }) if found.len() == 2));
    let unknown = found("F0").expect_err("unknown");
    assert!(
        matches!(&unknown, LinkError::NoSuchSerialNumber { known, .. } if known == &["E6614C31", "E6617A02"])
    );
}
