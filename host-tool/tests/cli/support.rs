//! A folder to work in, and the command.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::LazyLock;

use super::answers;

/// A temporary folder with the bundled photographs.
pub(crate) struct Workshop {
    folder: tempfile::TempDir,
    runtime: tempfile::TempDir,
}

/// A small exhibit of three views, so that tests are quick.
pub(crate) const SMALL: &str = "\
[exhibit]
name = \"Small\"
[stack]
films = 8
pixels = [64, 48]
width_mm = 20.0
[design]
method = \"product\"
optics = \"ideal\"
tone = \"code\"
[[view]]
id = \"astronaut\"
pattern = \"astronaut.jpg\"
horizontal_deg = 30.0
[[view]]
id = \"coffee\"
pattern = \"coffee.jpg\"
[[view]]
id = \"cat\"
pattern = \"cat.jpg\"
horizontal_deg = -30.0
";

impl Workshop {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in vitrine::starter::PHOTOGRAPHS {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        Self { folder, runtime: tempfile::tempdir().unwrap() }
    }

    /// A workshop with [`SMALL`] as exhibit.toml.
    pub(crate) fn small() -> Self {
        let workshop = Self::new();
        workshop.write("exhibit.toml", SMALL);
        workshop
    }

    /// A workshop with [`SMALL`] and its build, designed once for all tests.
    pub(crate) fn built() -> Self {
        static BUILD: LazyLock<Workshop> = LazyLock::new(|| {
            let workshop = Workshop::small();
            workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
            workshop
        });
        let workshop = Self::small();
        copy(&BUILD.path("build"), &workshop.path("build"));
        workshop
    }

    /// Where simulated controllers announce themselves.
    pub(crate) fn runtime(&self) -> &Path {
        self.runtime.path()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path(name), contents).unwrap();
    }

    /// The command, to be run in the folder.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vitrine"));
        // Announcements of simulated controllers stay among the workshop's own.
        command.env("VITRINE_RUNTIME_DIR", self.runtime.path());
        command.current_dir(self.folder.path()).args(arguments);
        command
    }

    /// Runs the command; what it answers in JSON has to be as its schema says.
    pub(crate) fn run(&self, arguments: &[&str]) -> Finished {
        let finished = Finished::from(self.command(arguments).output().unwrap());
        if answers::are_wanted(arguments) {
            answers::check(arguments, &finished);
        }
        finished
    }

    /// Runs the command, which must succeed, and gives its standard output.
    pub(crate) fn succeed(&self, arguments: &[&str]) -> String {
        let finished = self.run(arguments);
        assert_eq!(finished.code, Some(0), "{arguments:?}: {}", finished.stderr);
        finished.stdout
    }

    /// Everything in the folder, folders by their name alone.
    pub(crate) fn names(&self) -> Vec<String> {
        names(self.folder.path())
    }
}

/// `vitrine controller` on a free port; ended when dropped.
pub(crate) struct Simulated {
    pub(crate) child: Child,
    pub(crate) address: String,
}

impl Simulated {
    pub(crate) fn start(workshop: &Workshop, more: &[&str]) -> Self {
        let anywhere: &[&str] = if more.contains(&"--listen") { &[] } else { &["--listen", "tcp:0"] };
        let arguments = [&["controller"], anywhere, more].concat();
        let mut command = workshop.command(&arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        Self { child, address: line.trim().to_owned() }
    }
}

impl Drop for Simulated {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Copies a folder with all that is in it.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let place = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &place);
        } else {
            fs::copy(&path, &place).unwrap();
        }
    }
}

/// The sorted names in a folder.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A command that has ended.
pub(crate) struct Finished {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Finished {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}
