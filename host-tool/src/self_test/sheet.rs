//! What was found, to be signed and filed.

use std::fmt::Write;

use serde::Serialize;

/// What became of one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It does what it should.
    Passed,
    /// It does not.
    Failed,
    /// It was not tried: nobody was there to help, or it is not fitted.
    NotTried,
}

impl Verdict {
    /// [`Verdict::Passed`] if `sound`, else [`Verdict::Failed`].
    pub(super) fn of(sound: bool) -> Self {
        if sound { Self::Passed } else { Self::Failed }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "FAILED",
            Self::NotTried => "not tried",
        }
    }
}

/// One part of the hardware and what was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The part, in a word or two.
    pub part: &'static str,
    /// What became of it.
    pub verdict: Verdict,
    /// What was measured or seen, in words.
    pub found: String,
}

/// A whole self-test.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Sheet {
    /// The exhibit's name; empty without a plan.
    pub exhibit: String,
    /// The controller's serial number.
    pub serial_number: String,
    /// Its firmware's version.
    pub firmware: String,
    /// When the test began: ISO 8601, in UTC.
    pub began: String,
    /// Every part, in the order in which they were tried.
    pub findings: Vec<Finding>,
}

impl Sheet {
    /// How many parts have this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.findings.iter().filter(|finding| finding.verdict == verdict).count()
    }

    /// The sheet to print and sign.
    pub fn text(&self) -> String {
        let mut text = format!(
            "SELF-TEST of \"{}\"\ncontroller {}, firmware {}\nbegun {}\n\n",
            self.exhibit, self.serial_number, self.firmware, self.began
        );
        for Finding { part, verdict, found } in &self.findings {
            // Writing to a string does not fail.
            let _ = writeln!(text, "[{:^9}]  {part:<18} {found}", verdict.words());
        }
        let count = |verdict| self.count(verdict);
        let _ = write!(
            text,
            "\n{} passed, {} failed, {} not tried\n\n\
             Tested by ______________________  Date ____________  Signature ______________________\n",
            count(Verdict::Passed),
            count(Verdict::Failed),
            count(Verdict::NotTried)
        );
        text
    }
}
