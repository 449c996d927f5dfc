//! How far a design is: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use vitrine::design;

/// The least time between two plain lines of one stage.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// Shows how far a design is, on stderr.
pub(super) enum Progress {
    /// A person watches.
    Bar(ProgressBar),
    /// A file or a program reads along.
    Lines { stage: &'static str, told: Instant },
    /// Nothing is to be told.
    Silent,
}

impl Progress {
    pub(super) fn new(silent: bool) -> Self {
        if silent {
            return Self::Silent;
        }
        if !std::io::stderr().is_terminal() {
            return Self::Lines { stage: "", told: Instant::now() };
        }
        let bar = ProgressBar::new(1);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos:>3}/{len} {msg}") {
            bar.set_style(style);
        }
        Self::Bar(bar)
    }

    /// Tells how far the design is.
    pub(super) fn report(&mut self, progress: design::Progress) {
        let design::Progress { stage, done, total, quality_db } = progress;
        let quality = quality_db.map(|quality| format!(", {quality:.1} dB")).unwrap_or_default();
        match self {
            Self::Silent => {}
            Self::Bar(bar) => {
                bar.set_length(total as u64);
                bar.set_position(done as u64);
                bar.set_message(format!("{stage}{quality}"));
            }
            Self::Lines { stage: last, told } => {
                if *last == stage && told.elapsed() < LINE_EVERY {
                    return;
                }
                let step =
                    if *last == stage { format!(": {done} of {total}{quality}") } else { String::new() };
                eprintln!("{stage}{step}");
                (*last, *told) = (stage, Instant::now());
            }
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
