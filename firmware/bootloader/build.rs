//! Tells the linker about the memory, and takes the few pins that the boot loader drives from hardware/pins.toml.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use vitrine_pins::Board;

const NETS: [&str; 4] = ["LAMP_TOP_DIM", "LAMP_BOTTOM_DIM", "LAMP_ENABLE", "STATUS_LED"];

fn main() -> Result<(), Box<dyn Error>> {
    let root = env::var("CARGO_MANIFEST_DIR")?;
    let out = env::var("OUT_DIR")?;
    println!("cargo:rerun-if-changed={}", Board::path().display());
    println!("cargo:rerun-if-changed=memory.x");
    let board = Board::read()?;
    let mut text = String::new();
    for net in NETS {
        writeln!(text, "/// GP{0}.\nconst {net}: usize = {0};", board.net(net)?.gp)?;
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
