//! Scenarios: what happens to an exhibit, when, and what must be seen, as files under `tests/scenarios`.
//!
//! ```toml
//! summary = "An open door is dark at once"
//! lasts_s = 8.0
//!
//! [[change]]                     # something happens; every field but at_s may be left out
//! at_s = 5.0
//! loop_a = "open"
//!
//! [[see]]                        # something must hold: at one moment, or all the time from from_s to to_s
//! at_s = 5.02
//! dark = "InterlockOpen"
//! ```
//!
//! `[plan]` and `[ledger]` change what the exhibit starts with, `[room]` what the room is like, `[[body]]` puts people and
//! warm things into it.

mod change;
mod plan;
mod see;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use serde::Deserialize;
use vitrine_exhibit::State;
use vitrine_exhibit::ledger::LedgerRecord;
use vitrine_exhibit::plan::ValidPlan;
use vitrine_exhibit::units::Dose;

pub use self::change::Change;
pub use self::plan::PlanChanges;
pub use self::see::See;
use crate::bench::Bench;
use crate::room::{Body, Climate};

/// One scenario file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// What it shows, in one sentence.
    pub summary: String,
    /// How long it runs.
    pub lasts_s: f64,
    /// Other than the standard plan.
    #[serde(default)]
    plan: PlanChanges,
    /// The plan must be refused for this reason, such as "Ceiling", and the exhibit has none.
    refused: Option<String>,
    /// What is in flash at the start.
    #[serde(default)]
    ledger: LedgerStart,
    /// What the room and its sensors are like.
    #[serde(default)]
    room: Climate,
    /// Everything warm in the room.
    #[serde(default)]
    body: Vec<Body>,
    /// What happens.
    #[serde(default)]
    change: Vec<Change>,
    /// What must be seen.
    see: Vec<See>,
}

/// The ledger in flash at the start.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct LedgerStart {
    day_j_m2: f64,
    life_j_m2: f64,
    full_h: f64,
    quick_resets: u8,
    after_fault: bool,
    /// The ledger's day is today, by UTC.
    today: bool,
}

/// Gives all scenario files, sorted by name.
///
/// # Errors
/// The folder cannot be read.
pub fn files() -> std::io::Result<Vec<PathBuf>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut files = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()?;
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    Ok(files)
}

/// Runs the scenario of a file.
///
/// # Errors
/// What is wrong with the file, or what was not seen.
pub fn run_file(path: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let scenario: Scenario = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    scenario.run()
}

/// Runs the scenario of this name, or all, on all processors, and gives the names of those that fail or panic.
///
/// # Errors
/// The folder cannot be read.
pub fn failing(name: Option<&str>) -> std::io::Result<Vec<String>> {
    let mut files = files()?;
    files.retain(|path| name.is_none_or(|name| path.file_stem().is_some_and(|stem| stem == name)));
    let next = AtomicUsize::new(0);
    let failed = Mutex::new(Vec::new());
    let work = || {
        while let Some(path) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
            if !matches!(std::panic::catch_unwind(|| run_file(path)), Ok(Ok(()))) {
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                failed.lock().unwrap_or_else(PoisonError::into_inner).push(name);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.sort();
    Ok(failed)
}

impl Scenario {
    /// Reads a scenario by its name.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn read(name: &str) -> Result<Self, String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).with_extension("toml");
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Everything warm in its room.
    pub fn bodies(&self) -> &[Body] {
        &self.body
    }

    /// Runs it to its end.
    ///
    /// # Errors
    /// The first thing that was not seen.
    pub fn run(mut self) -> Result<(), String> {
        let mut bench = self.bench()?;
        let steps = (self.lasts_s * 100.0).round() as u64;
        for step in 0..steps {
            let time_s = step as f64 / 100.0;
            for change in self.change.iter().filter(|change| is_now(change.at_s, time_s)) {
                change.apply(&mut bench).map_err(|error| format!("change at {time_s:.2} s: {error}"))?;
            }
            let events = bench.step()?;
            for see in &mut self.see {
                see.look(time_s, &bench, &events)?;
            }
        }
        self.see.iter().try_for_each(See::finish)
    }

    fn bench(&self) -> Result<Bench, String> {
        let mut bench = Bench::new();
        let plan = self.plan.apply(crate::bench::standard_plan())?;
        bench.plan = match (ValidPlan::new(plan), &self.refused) {
            (Ok(plan), None) => Some(plan),
            (Ok(_), Some(wanted)) => return Err(format!("the plan is not refused for {wanted}")),
            (Err(error), Some(wanted)) if format!("{error:?}") == *wanted => None,
            (Err(error), _) => return Err(error.to_string()),
        };
        bench.room.climate = self.room;
        bench.room.bodies.clone_from(&self.body);
        let mut record = LedgerRecord { quick_resets: self.ledger.quick_resets, ..LedgerRecord::default() };
        if self.ledger.today {
            record.day = bench.clock.map_or(0, |clock| (clock.0 / 86_400) as u32);
        }
        for account in [&mut record.lamps.top, &mut record.lamps.bottom] {
            account.day = Dose((self.ledger.day_j_m2 * 1e6) as u64);
            account.life = Dose((self.ledger.life_j_m2 * 1e6) as u64);
            account.full_ms = (self.ledger.full_h * 3_600_000.0) as u64;
        }
        bench.flash = record;
        bench.state = State::new(record, self.ledger.after_fault);
        Ok(bench)
    }
}

/// Tells whether a moment falls into this step.
fn is_now(at_s: f64, time_s: f64) -> bool {
    (at_s - time_s).abs() < 0.005
}
