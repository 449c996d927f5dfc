//! The man pages as mandoc reads them.

use std::process::Command;

use super::command;

#[test]
fn mandoc_has_no_fault_to_find_with_the_man_pages() {
    let folder = tempfile::tempdir().unwrap();
    let written = Command::new(command()).arg("man").arg(folder.path()).output().unwrap();
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let pages: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(pages.len() > 35, "{pages:?}");
    let lint = Command::new("mandoc").args(["-T", "lint", "-W", "style"]).args(&pages).output().unwrap();
    assert!(lint.status.success(), "{}", String::from_utf8_lossy(&lint.stdout));
    // An example stays a line of its own.
    let page = Command::new("mandoc").arg(folder.path().join("vitrine-hold.1")).output().unwrap();
    let text = String::from_utf8(page.stdout).unwrap();
    let example = text.lines().find(|line| line.contains("hold coffee --for 2h")).unwrap();
    assert_eq!(example.trim(), "vitrine hold coffee --for 2h --to tcp:127.0.0.1:7470");
    assert!(
        text.contains("VITRINE-HOLD(1)") && text.contains(concat!("vitrine ", env!("CARGO_PKG_VERSION"))),
        "{text}"
    );
}
