//! Every file under `tests/scenarios` is a test of its own.

use libtest_mimic::{Arguments, Failed, Trial};
use vitrine_tests::scenario;

fn main() -> std::process::ExitCode {
    let arguments = Arguments::from_args();
    let files = scenario::files().expect("the scenarios can be read");
    let trial = |path: std::path::PathBuf| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Trial::test(name, move || scenario::run_file(&path).map_err(Failed::from))
    };
    libtest_mimic::run(&arguments, files.into_iter().map(trial).collect()).exit_code()
}
