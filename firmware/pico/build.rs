//! Tells the linker about the memory, and generates two tables from their one source: the pins from
//! hardware/pins.toml and the flash regions from memory.x.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use vitrine_pins::Board;

/// Flash begins here in the processor's memory; the flash driver counts from it.
const FLASH_BASE: u32 = 0x1000_0000;
const FLASH_BYTES: u32 = 2 * 1024 * 1024;
const ERASE_BYTES: u32 = 4096;
const BOOTLOADER_BYTES: u32 = 56 * 1024;
/// An image's header lies before what the linker places.
const HEADER_BYTES: u32 = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let root = env::var("CARGO_MANIFEST_DIR")?;
    let out = env::var("OUT_DIR")?;
    let is_rp2350 = env::var("CARGO_FEATURE_RP2350").is_ok();
    let memory = Path::new(&root).join(if is_rp2350 { "memory.rp2350.x" } else { "memory.x" });
    for input in [&Board::path(), &memory] {
        println!("cargo:rerun-if-changed={}", input.display());
    }
    fs::write(Path::new(&out).join("pins.rs"), pin_table(&Board::read()?)?)?;
    let script = fs::read_to_string(&memory)?;
    fs::write(Path::new(&out).join("flash_map.rs"), flash_map(&script, is_rp2350)?)?;

    // The linker script is copied so that nothing but it is found in the search folder.
    fs::write(Path::new(&out).join("memory.x"), script)?;
    println!("cargo:rustc-link-search={out}");
    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        // Only the RP2040 has a second-stage boot loader, which has a place of its own.
        let boot = (!is_rp2350).then_some("-Tlink-rp.x");
        for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"].into_iter().chain(boot) {
            println!("cargo:rustc-link-arg-bins={argument}");
        }
    }
    Ok(())
}

fn pin_table(board: &Board) -> Result<String, Box<dyn Error>> {
    let mut text = String::from("assign_resources! {\n");
    for (name, group) in &board.group {
        writeln!(text, "    #[doc = \"What the group {name} owns.\"]")?;
        writeln!(text, "    {name}: {}Resources {{", camel(name))?;
        for (role, peripheral) in &group.peripherals {
            writeln!(text, "        {role}: {peripheral},")?;
        }
        for pin in board.pin.iter().filter(|pin| pin.group == *name) {
            writeln!(text, "        {}: PIN_{},", pin.role, pin.gp)?;
        }
        text.push_str("    }\n");
    }
    text.push_str("}\n");
    for pin in &board.pin {
        if board.group.get(&pin.group).is_some_and(|group| group.by_number) {
            writeln!(text, "/// GP{}: {}.", pin.gp, pin.function)?;
            writeln!(text, "pub(crate) const {}: usize = {};", pin.net, pin.gp)?;
        }
    }
    Ok(text)
}

fn camel(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn flash_map(script: &str, is_rp2350: bool) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    // The Pico 2 has no boot loader, and its image lies where the Pico has all that belongs to updates.
    let (mut end_of_last, images): (u32, &[&str]) = if is_rp2350 {
        (FLASH_BASE + 1024 * 1024, &[])
    } else {
        (FLASH_BASE + BOOTLOADER_BYTES, &["PROGRESS", "ACTIVE", "NEW", "OLD"])
    };
    for name in images.iter().chain(&["PLAN", "SETTINGS", "LEDGER", "CLOCK", "LOG"]) {
        let (origin, length) = region(script, name)?;
        if origin < end_of_last {
            return Err(format!("memory.x: {name} overlaps what lies before it").into());
        }
        if origin % ERASE_BYTES != 0 || length % ERASE_BYTES != 0 {
            return Err(format!("memory.x: {name} does not lie on whole erase sectors").into());
        }
        if *name == "ACTIVE"
            && !script.contains(&format!("FLASH    : ORIGIN = {:#x},", origin + HEADER_BYTES))
        {
            return Err("memory.x: FLASH does not begin behind the header of the ACTIVE image".into());
        }
        end_of_last = origin + length;
        let start = origin - FLASH_BASE;
        writeln!(text, "/// Where {name} lies in flash, in bytes from its start.")?;
        writeln!(text, "pub(crate) const {name}: core::ops::Range<u32> = {start}..{};", start + length)?;
    }
    if end_of_last != FLASH_BASE + FLASH_BYTES {
        return Err("memory.x: the records do not end where the flash ends".into());
    }
    writeln!(text, "/// Bytes of the flash.\npub(crate) const FLASH_BYTES: usize = {FLASH_BYTES};")?;
    Ok(text)
}

fn region(script: &str, name: &str) -> Result<(u32, u32), Box<dyn Error>> {
    let line = script
        .lines()
        .find(|line| line.split_whitespace().next() == Some(name))
        .ok_or_else(|| format!("memory.x: no region {name}"))?;
    let value = |key: &str| -> Option<&str> {
        Some(line.split(key).nth(1)?.split(',').next()?.trim_start_matches([' ', '=']).trim())
    };
    let origin = value("ORIGIN").and_then(|text| u32::from_str_radix(text.strip_prefix("0x")?, 16).ok());
    let length =
        value("LENGTH").and_then(|text| text.strip_suffix('K')?.parse::<u32>().ok()).map(|kib| kib * 1024);
    origin
        .zip(length)
        .ok_or_else(|| format!("memory.x: {name} is not 'ORIGIN = 0x..., LENGTH = ...K'").into())
}
