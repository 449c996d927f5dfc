//! Grows a meadow of flowers and butterflies as a cloud of exactly 51,767 coloured points, as many as the paper's 3D
//! prototype shows, in its 35 x 35 x 12.5 mm:
//!
//! ```text
//! cargo run --release -p vitrine --example flowers -- flowers.ply
//! vitrine slice flowers.ply -o build --pixels 300 --spacer-mm 0.525 --unit-mm 1 --centre origin
//! vitrine turn build -o turn.png
//! ```

mod meadow;

fn main() -> std::io::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "flowers.ply".to_owned());
    std::fs::write(&path, meadow::ply())?;
    println!("{path}: {} points", meadow::POINTS);
    Ok(())
}
