//! The documents of the hardware agree with each other, and with what the chip can do.

use std::collections::{BTreeMap, BTreeSet};
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
    references();
}

/// All references of the parts list.
fn references() -> BTreeSet<String> {
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
    seen
}

/// Every net with the parts' pins on it.
fn nets() -> BTreeMap<String, Vec<String>> {
    let line = |line: &str| {
        let (net, pins) = line.split_once(',').unwrap_or_else(|| panic!("no connections: {line}"));
        (net.to_owned(), pins.split(' ').map(str::to_owned).collect())
    };
    document("nets.csv").lines().skip(1).map(line).collect()
}

/// The net that a part's pin is on.
fn net_of<'a>(nets: &'a BTreeMap<String, Vec<String>>, pin: &str) -> &'a str {
    let on = nets.iter().find(|(_, pins)| pins.iter().any(|other| other == pin));
    on.unwrap_or_else(|| panic!("{pin} is not connected")).0
}

/// The two nets that a part of two ends connects.
fn ends<'a>(nets: &'a BTreeMap<String, Vec<String>>, part: &str) -> [&'a str; 2] {
    [net_of(nets, &format!("{part}.1")), net_of(nets, &format!("{part}.2"))]
}

#[test]
fn every_part_is_connected_and_no_net_ends_in_the_air() {
    let nets = nets();
    let mut seen = BTreeSet::new();
    for (net, pins) in &nets {
        assert!(pins.len() >= 2, "{net} ends in the air");
        for pin in pins {
            assert!(seen.insert(pin), "{pin} is on two nets");
        }
    }
    let connected: BTreeSet<String> =
        seen.iter().filter_map(|pin| pin.split_once('.')).map(|(part, _)| part.to_owned()).collect();
    assert_eq!(connected, references());
}

#[test]
fn the_nets_are_those_of_the_pins() {
    let nets = nets();
    let of_the_controller = nets.values().flatten().filter(|pin| pin.starts_with("U1.GP")).count();
    let wired = board().pin.into_iter().filter(|pin| pin.net != "STATUS_LED");
    let wired: Vec<Pin> = wired.collect();
    assert_eq!(of_the_controller, wired.len());
    for pin in wired {
        assert_eq!(net_of(&nets, &format!("U1.GP{}", pin.gp)), pin.net);
    }
}

#[test]
fn what_keeps_the_lamps_dark_is_connected() {
    let nets = nets();
    for (part, net, other) in [
        ("R3", "LAMP_TOP_DIM", "GND"),
        ("R4", "LAMP_BOTTOM_DIM", "GND"),
        ("R5", "LAMP_ENABLE", "GND"),
        ("R6", "3V3", "INTERLOCK_A"),
        ("R7", "3V3", "INTERLOCK_B"),
        ("R12", "LED_SUPPLY_DOORS", "LED_SWITCH_GATE"),
    ] {
        assert_eq!(ends(&nets, part), [net, other], "{part}");
    }
    // From each loop to ground, and from the fuse to the switch, there is no way but through a contact of either door.
    for (from, to, contact) in [
        ("INTERLOCK_A", "GND", 'A'),
        ("INTERLOCK_B", "GND", 'B'),
        ("LED_SUPPLY_FUSED", "LED_SUPPLY_DOORS", 'C'),
    ] {
        let across = |door: &str| {
            [1, 2]
                .map(|end| net_of(&nets, &format!("{door}.{contact}{end}")))
                .into_iter()
                .collect::<BTreeSet<_>>()
        };
        let (first, second) = (across("S1"), across("S2"));
        let between: Vec<_> = first.intersection(&second).collect();
        assert_eq!(between.len(), 1, "{contact}: the doors are not in series");
        let ends: BTreeSet<_> = first.symmetric_difference(&second).copied().collect();
        assert_eq!(ends, BTreeSet::from([from, to]));
        assert_eq!(
            nets[**between.first().expect("one")].len(),
            2,
            "{contact}: something joins between the doors"
        );
    }
    // The drivers' supply comes through Q1 alone, on the high side of a ground that all share.
    assert_eq!((net_of(&nets, "Q1.S"), net_of(&nets, "Q1.D")), ("LED_SUPPLY_DOORS", "LED_SUPPLY"));
    assert_eq!((net_of(&nets, "Q2.G"), net_of(&nets, "Q2.S")), ("LAMP_ENABLE", "GND"));
    for driver in ["U2", "U3"] {
        assert_eq!(net_of(&nets, &format!("{driver}.VIN")), "LED_SUPPLY");
        assert_eq!(net_of(&nets, &format!("{driver}.GND")), "GND");
    }
}

/// "D1-D4" is four references.
fn expand(text: &str) -> Vec<String> {
    let Some((first, last)) = text.split_once('-') else { return vec![text.to_owned()] };
    let letters = first.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let number = |reference: &str| reference.trim_start_matches(letters).parse::<u32>().expect("a number");
    (number(first)..=number(last)).map(|number| format!("{letters}{number}")).collect()
}
