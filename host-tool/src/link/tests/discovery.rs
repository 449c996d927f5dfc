use super::served;
use crate::{
    controller::FlashFile,
    link::{Address, Announcement, choose, discovery::announced_in},
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
