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
    Lines(Lines),
    /// Nothing is to be told.
    Silent,
}

/// Where a reader of plain lines is.
pub(super) struct Lines {
    last: design::Progress,
    /// When a line was last told, and whether it told of `last`.
    told: Instant,
    is_told: bool,
}

impl Progress {
    pub(super) fn new(silent: bool) -> Self {
        if silent {
            return Self::Silent;
        }
        if !std::io::stderr().is_terminal() {
            let last = design::Progress::at("", 0, 0);
            return Self::Lines(Lines { last, told: Instant::now(), is_told: true });
        }
        let bar = ProgressBar::new(1);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos:>3}/{len} {msg}") {
            bar.set_style(style);
        }
        Self::Bar(bar)
    }

    /// Tells how far the design is.
    pub(super) fn report(&mut self, progress: design::Progress) {
        match self {
            Self::Silent => {}
            Self::Bar(bar) => {
                bar.set_length(progress.total as u64);
                bar.set_position(progress.done as u64);
                bar.set_message(format!("{}{}", progress.stage, quality(&progress)));
            }
            Self::Lines(lines) => lines.report(progress),
        }
    }
}

impl Lines {
    /// Tells where a stage begins and ends, and every few seconds in between.
    fn report(&mut self, progress: design::Progress) {
        let begins = progress.stage != self.last.stage;
        if begins {
            self.finish();
            eprintln!("{}", progress.stage);
        }
        (self.last, self.is_told) = (progress, begins);
        if begins || self.told.elapsed() >= LINE_EVERY {
            self.finish();
            self.told = Instant::now();
        }
    }

    /// Tells where the last stage is, where that is not told yet.
    fn finish(&mut self) {
        if !self.is_told {
            let design::Progress { stage, done, total, .. } = self.last;
            eprintln!("{stage}: {done} of {total}{}", quality(&self.last));
            self.is_told = true;
        }
    }
}

/// The quality so far and what is being gained, where they are known.
fn quality(progress: &design::Progress) -> String {
    let reached = progress.quality_db.map(|quality| format!(", {quality:.2} dB")).unwrap_or_default();
    let gained = progress.gained_db.map(|gained| format!(" ({gained:+.2} dB in ten iterations)"));
    reached + &gained.unwrap_or_default()
}

impl Drop for Progress {
    fn drop(&mut self) {
        match self {
            Self::Bar(bar) => bar.finish_and_clear(),
            Self::Lines(lines) => lines.finish(),
            Self::Silent => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_gained_is_told() {
        let progress = design::Progress::at("solving red", 20, 120);
        assert_eq!(quality(&progress), "");
        let reaching = design::Progress { gained_db: Some(0.034), ..progress.reaching(18.618) };
        assert_eq!(quality(&reaching), ", 18.62 dB (+0.03 dB in ten iterations)");
    }
}
