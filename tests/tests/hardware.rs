//! The documents of the hardware agree with each other, and with what the chip can do.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use vitrine_pins::{Board, Pin};

fn document(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hardware").join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn board() -> Board {
    Board::read().expect("pins.toml")
}

fn net(board: &Board, name: &str) -> Pin {
    board.net(name).expect("a net").clone()
}

/// The rows of a document's tables that begin with a number.
fn numbered_rows(name: &str) -> Vec<String> {
    document(name)
        .lines()
        .filter(|line| line.starts_with('|'))
        .filter(|line| line.trim_start_matches("| ").starts_with(|letter: char| letter.is_ascii_digit()))
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_readme_wires_what_the_pins_say() {
    let wanted: Vec<String> =
        board().pin.iter().map(|pin| format!("| {} | {} | {} |", pin.gp, pin.net, pin.function)).collect();
    assert_eq!(numbered_rows("../README.md"), wanted);
}

#[test]
fn the_wiring_table_is_that_of_the_pins() {
    let wanted: Vec<String> = board()
        .pin
        .iter()
        .map(|pin| {
            format!("| {} | {} | {} | {} | {} |", pin.gp, pin.net, pin.direction, pin.reset, pin.function)
        })
        .collect();
    assert_eq!(numbered_rows("wiring.md"), wanted);
}

#[test]
fn every_pin_is_one_of_the_board() {
    for pin in &board().pin {
        assert!(["in", "out", "both"].contains(&pin.direction.as_str()), "GP{}", pin.gp);
        assert!(["low", "high", "analogue"].contains(&pin.reset.as_str()), "GP{}", pin.gp);
        assert!(pin.gp <= 22 || (25..=28).contains(&pin.gp), "GP{} is not on the board", pin.gp);
    }
}

/// The functions of the RP2040's pins (data sheet, table 278).
#[test]
fn the_chip_can_do_what_the_pins_are_for() {
    let board = board();
    let peripheral = |group: &str, role: &str| board.group[group].peripherals[role].clone();

    let (top, bottom) = (net(&board, "LAMP_TOP_DIM").gp, net(&board, "LAMP_BOTTOM_DIM").gp);
    assert_eq!((top % 2, bottom), (0, top + 1), "both lamps on channels A and B of one slice");
    assert_eq!(peripheral("lamps", "slice"), format!("PWM_SLICE{}", top / 2 % 8));

    let i2c = |gp: u8| format!("I2C{}", gp / 2 % 2);
    let (sda, scl) = (net(&board, "SENSOR_SDA").gp, net(&board, "SENSOR_SCL").gp);
    assert_eq!((sda % 2, scl % 2), (0, 1));
    assert_eq!((i2c(sda), i2c(scl)), (peripheral("sensors", "i2c"), peripheral("sensors", "i2c")));

    for (group, send, receive) in [("service", "SERVICE_TX", "SERVICE_RX"), ("radar", "RADAR_TX", "RADAR_RX")]
    {
        let uart = |gp: u8| format!("UART{}", (gp + 4) / 8 % 2);
        let (send, receive) = (net(&board, send).gp, net(&board, receive).gp);
        assert_eq!((send % 4, receive), (0, send + 1), "{group}");
        assert_eq!(uart(send), peripheral(group, "uart"), "{group}");
    }

    for pin in board.pin.iter().filter(|pin| pin.reset == "analogue") {
        assert!((26..=28).contains(&pin.gp), "GP{} is no input of the converter", pin.gp);
    }
}

#[test]
fn whatever_lights_a_lamp_is_low_in_reset_and_has_its_pull_down() {
    let board = board();
    let parts = document("parts.csv");
    for name in ["LAMP_TOP_DIM", "LAMP_BOTTOM_DIM", "LAMP_ENABLE"] {
        let pin = net(&board, name);
        assert_eq!((pin.direction.as_str(), pin.reset.as_str()), ("out", "low"), "{name}");
        let pulled = parts
            .lines()
            .any(|part| part.contains("pull-down") && part.contains("2.2 kOhm") && part.contains(name));
        assert!(pulled, "parts.csv has no 2.2 kOhm pull-down on {name}");
    }
    for name in ["INTERLOCK_A", "INTERLOCK_B"] {
        let pin = net(&board, name);
        assert_eq!(
            (pin.direction.as_str(), pin.reset.as_str()),
            ("in", "high"),
            "{name}: a broken wire reads open"
        );
    }
}

#[test]
fn the_parts_list_counts_its_references() {
    let parts = document("parts.csv");
    let mut seen = BTreeSet::new();
    for line in parts.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), 7, "{line}");
        let references: Vec<String> = fields[0].split(' ').flat_map(expand).collect();
        assert_eq!(references.len().to_string(), fields[2], "{line}");
        for reference in references {
            assert!(seen.insert(reference.clone()), "{reference} is listed twice");
        }
    }
}

/// "D1-D4" is four references.
fn expand(text: &str) -> Vec<String> {
    let Some((first, last)) = text.split_once('-') else { return vec![text.to_owned()] };
    let letters = first.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let number = |reference: &str| reference.trim_start_matches(letters).parse::<u32>().expect("a number");
    (number(first)..=number(last)).map(|number| format!("{letters}{number}")).collect()
}
