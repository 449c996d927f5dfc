use crate::link::{Address, AddressError};

#[test]
fn addresses_are_read_and_written() {
    for (text, expected) in [
        ("/dev/ttyACM0", Address::Serial("/dev/ttyACM0".into())),
        ("COM3", Address::Serial("COM3".into())),
        ("tcp:museum.local:7470", Address::Tcp("museum.local:7470".into())),
        ("tcp:[::1]:7470", Address::Tcp("[::1]:7470".into())),
    ] {
        assert_eq!(text.parse(), Ok(expected.clone()));
        assert_eq!(expected.to_string(), text);
    }
    assert_eq!("tcp:7470".parse(), Ok(Address::Tcp("127.0.0.1:7470".into())));
    assert_eq!("tcp::7470".parse(), Ok(Address::Tcp("127.0.0.1:7470".into())));
}

#[test]
fn what_is_no_address_says_so() {
    assert_eq!("".parse::<Address>(), Err(AddressError::Empty));
    for text in ["tcp:", "tcp:host", "tcp:host:", "tcp:host:99999", "tcp:host:http"] {
        assert_eq!(text.parse::<Address>(), Err(AddressError::Port(text.into())));
    }
}
