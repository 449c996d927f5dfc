//! Deletes each safety rule and default in turn and shows the scenario that catches it.
//!
//! `cargo run -p vitrine-tests --bin mutants [-- WORD]` patches a copy of the workspace under `target/mutants`, one
//! rule of `tests/mutants.toml` at a time (those whose rule or scenario contains WORD), and runs the rule's scenario
//! against it. It fails where a rule can go and its scenario passes. All scenarios must pass against the copy as it is.
//!
//! The copy is built without the tests' own dependencies: this program itself runs its scenarios (`--scenarios`).

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use serde::Deserialize;
use vitrine_tests::scenario;

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
    /// The scenario that must fail.
    scenario: String,
}

type Failure = Box<dyn std::error::Error>;

/// Runs the scenario whose name follows, or all, prints the names of those that fail, and then [`END`].
const SCENARIOS: &str = "--scenarios";
/// Without this last line the scenarios did not come to their end.
const END: &str = "all scenarios have run";

fn main() -> ExitCode {
    let outcome = match std::env::args().nth(1).as_deref() {
        Some(SCENARIOS) => run_scenarios(std::env::args().nth(2).as_deref()),
        word => run(word.unwrap_or_default()),
    };
    match outcome {
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
    let failed = build_and_run(&copy, None)?;
    if !failed.is_empty() {
        return Err(format!("scenarios fail without any change: {failed:?}").into());
    }
    let names = scenario::files()?;
    for mutant in mutants.mutant.iter().filter(|mutant| mutant.is_about(word)) {
        if !names.iter().any(|path| path.file_stem().is_some_and(|stem| *stem == *mutant.scenario)) {
            return Err(format!("{}: there is no scenario {}", mutant.rule, mutant.scenario).into());
        }
        let caught = mutant.is_caught_in(&copy).map_err(|error| format!("{}: {error}", mutant.rule))?;
        let verdict = if caught { "caught by" } else { "NOT CAUGHT by" };
        println!("{}: {verdict} {}", mutant.rule, mutant.scenario);
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
    fn is_about(&self, word: &str) -> bool {
        self.rule.contains(word) || self.scenario.contains(word)
    }

    /// Tells whether its scenario fails without this rule.
    fn is_caught_in(&self, copy: &Path) -> Result<bool, Failure> {
        let path = copy.join("firmware/exhibit/src").join(&self.file);
        let original = std::fs::read_to_string(&path)?;
        if original.matches(&self.find).count() != 1 {
            return Err(format!("{:?} does not stand exactly once in {}", self.find, self.file).into());
        }
        std::fs::write(&path, original.replace(&self.find, &self.replace))?;
        let failed = build_and_run(copy, Some(&self.scenario));
        std::fs::write(&path, original)?;
        Ok(!failed?.is_empty())
    }
}

/// Builds this program from the copy, and gives the names of the scenarios that fail in it, of this one or of all.
fn build_and_run(copy: &Path, scenario: Option<&str>) -> Result<Vec<String>, Failure> {
    let output = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()))
        .args(["run", "--quiet", "-p", "vitrine-tests", "--bin", "mutants", "--", SCENARIOS])
        .args(scenario)
        .env("CARGO_TARGET_DIR", copy.join("../target"))
        .env("CARGO_PROFILE_DEV_DEBUG", "none")
        .env("RUSTFLAGS", "--cap-lints allow")
        .current_dir(copy)
        .output()?;
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    let names = stdout.trim_end().strip_suffix(END);
    let names = names.ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
    Ok(names.lines().map(str::to_owned).collect())
}

fn run_scenarios(name: Option<&str>) -> Result<bool, Failure> {
    let failed = scenario::failing(name)?;
    failed.iter().for_each(|name| println!("{name}"));
    println!("{END}");
    Ok(failed.is_empty())
}
