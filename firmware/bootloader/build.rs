//! Tells the linker about the memory, and takes the few pins that the boot loader drives from hardware/pins.toml.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use serde::Deserialize;

#[derive(Deserialize)]
struct Board {
    pin: Vec<Pin>,
}

#[derive(Deserialize)]
struct Pin {
    gp: u8,
    net: String,
}

const NETS: [&str; 4] = ["LAMP_TOP_DIM", "LAMP_BOTTOM_DIM", "LAMP_ENABLE", "STATUS_LED"];

fn main() -> Result<(), Box<dyn Error>> {
    let root = env::var("CARGO_MANIFEST_DIR")?;
    let out = env::var("OUT_DIR")?;
    let pins = Path::new(&root).join("../../hardware/pins.toml");
    println!("cargo:rerun-if-changed={}", pins.display());
    println!("cargo:rerun-if-changed=memory.x");
    let board: Board = toml::from_str(&fs::read_to_string(&pins)?)?;
    let mut text = String::new();
    for net in NETS {
        let pin = board.pin.iter().find(|pin| pin.net == net);
        let pin = pin.ok_or_else(|| format!("{}: no net {net}", pins.display()))?;
        writeln!(text, "/// GP{0}.\nconst {net}: usize = {0};", pin.gp)?;
    }
    fs::write(Path::new(&out).join("pins.rs"), text)?;

    // The linker script is copied so that nothing but it is found in the search folder.
    fs::copy(Path::new(&root).join("memory.x"), Path::new(&out).join("memory.x"))?;
    println!("cargo:rustc-link-search={out}");
    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        for argument in ["--nmagic", "-Tlink.x", "-Tlink-rp.x"] {
            println!("cargo:rustc-link-arg-bins={argument}");
        }
    }
    Ok(())
}
