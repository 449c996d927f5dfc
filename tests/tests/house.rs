//! What holds for the house as a whole.

use std::path::Path;

/// Undefined behaviour needs unsafe code: all that decides, stores, talks and drives is written without it.
#[test]
fn the_firmwares_logic_forbids_unsafe_code() {
    for krate in ["exhibit", "protocol", "storage", "drivers", "boot"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware").join(krate).join("src/lib.rs");
        let text =
            std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert!(text.lines().any(|line| line == "#![forbid(unsafe_code)]"), "{}", file.display());
    }
}
