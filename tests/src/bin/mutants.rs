//! Deletes each safety rule and default in turn and shows the scenario that catches it.
//!
//! `cargo run -p vitrine-tests --bin mutants [-- WORD]` patches a copy of the workspace under `target/mutants`, one
//! rule of `tests/mutants.toml` at a time (those whose rule contains WORD), and runs all scenarios against it. It
//! fails where a rule can go without a scenario that fails.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use serde::Deserialize;

/// All mutants.
#[derive(Deserialize)]
struct Mutants {
    mutant: Vec<Mutant>,
}

/// One rule and how it is deleted.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Mutant {
    /// What the rule says.
    rule: String,
    /// The file under `firmware/exhibit/src` that holds it.
    file: String,
    /// Text that stands in it exactly once.
    find: String,
    /// What stands there instead.
    replace: String,
    /// The scenario that must fail, among others.
    scenario: String,
}

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run(std::env::args().nth(1).unwrap_or_default().as_str()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(word: &str) -> Result<bool, Failure> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().ok_or("the tests have no parent")?;
    let copy = copy_workspace(root)?;
    let text = std::fs::read_to_string(root.join("tests/mutants.toml"))?;
    let mutants: Mutants = toml::from_str(&text)?;
    let mut all_caught = true;
    let mut count = 0;
    for mutant in mutants.mutant.iter().filter(|mutant| mutant.rule.contains(word)) {
        let failed = mutant.try_in(&copy).map_err(|error| format!("{}: {error}", mutant.rule))?;
        let caught = failed.contains(&mutant.scenario);
        let verdict = if caught { "caught by" } else { "NOT CAUGHT by" };
        println!("{}: {verdict} {} ({} fail)", mutant.rule, mutant.scenario, failed.len());
        all_caught &= caught;
        count += 1;
    }
    println!("{count} rules deleted in turn; {}", if all_caught { "all caught" } else { "some not caught" });
    Ok(all_caught)
}

/// Copies what the version control knows to `target/mutants/workspace`.
fn copy_workspace(root: &Path) -> Result<PathBuf, Failure> {
    let copy = root.join("target/mutants/workspace");
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root).output()?;
    if !listed.status.success() {
        return Err("git ls-files failed: mutants are made of a checkout".into());
    }
    for name in String::from_utf8(listed.stdout)?.split_terminator('\0') {
        let (from, to) = (root.join(name), copy.join(name));
        let bytes = std::fs::read(&from)?;
        // An unchanged file keeps its time, so that cargo builds only what a mutant changes.
        if std::fs::read(&to).ok().as_ref() != Some(&bytes) {
            std::fs::create_dir_all(to.parent().ok_or("a file has a folder")?)?;
            std::fs::write(&to, bytes)?;
        }
    }
    Ok(copy)
}

impl Mutant {
    /// Gives the names of the scenarios that fail without this rule.
    fn try_in(&self, copy: &Path) -> Result<Vec<String>, Failure> {
        let path = copy.join("firmware/exhibit/src").join(&self.file);
        let original = std::fs::read_to_string(&path)?;
        if original.matches(&self.find).count() != 1 {
            return Err(format!("{:?} does not stand exactly once in {}", self.find, self.file).into());
        }
        std::fs::write(&path, original.replace(&self.find, &self.replace))?;
        let output = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()))
            .args(["test", "-p", "vitrine-tests", "--test", "scenarios"])
            .env("CARGO_TARGET_DIR", copy.join("../target"))
            .env("RUSTFLAGS", "--cap-lints allow")
            .current_dir(copy)
            .output();
        std::fs::write(&path, original)?;
        let output = output?;
        let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
        if !stdout.contains("test result:") {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        let failed = stdout.lines().filter_map(|line| line.strip_prefix("test ")?.strip_suffix("FAILED"));
        Ok(failed.map(|line| line.trim_end_matches([' ', '.']).to_owned()).collect())
    }
}
