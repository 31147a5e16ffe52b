//! Findings of the reader about a file: place, reason, fix.

use core::fmt;
use heapless::{String, Vec};

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The machine runs, but probably not as meant.
    Warning,
    /// The part of the setting (a heater, a switch, the probe) stays off; the rest of the machine works.
    Error,
    /// Motion or safety depends on the setting: nothing moves or heats until the file is mended. Consoles and
    /// card work.
    Fatal,
}

impl Severity {
    /// Returns the word in messages.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Warning => "warning",
            Self::Error => "error",
            Self::Fatal => "fatal",
        }
    }
}

/// A finding about the file. Texts are cut to fit, never lost whole.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Severity of the finding.
    pub severity: Severity,
    /// Line, from 1; 0 when the finding concerns something the file does not say.
    pub line: u32,
    /// Column in bytes, from 1; 0 with line 0.
    pub column: u16,
    /// Bytes to underline from there, at least 1.
    pub length: u16,
    /// Section and key, as `[actuator] alpha.max_rate`; may be empty.
    pub key: String<72>,
    /// Description of the fault, in a sentence without a full stop.
    pub reason: String<200>,
    /// Advice for the text to write instead; may be empty.
    pub fix: String<200>,
    /// Part that stays off because of an error, as in `switch fan`; else empty.
    pub off: String<96>,
}

impl Diagnostic {
    /// Returns whether a message should begin with the key: the finding has one that the reason does not
    /// name.
    pub(crate) fn names_key(&self) -> bool {
        !self.key.is_empty() && !self.reason.contains(self.key.as_str())
    }
}

/// `line 12, column 3: error: [planner] has no setting 'junction_devation' (did you mean
/// junction_deviation?)`
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(f, "line {}, column {}: ", self.line, self.column)?;
        }
        write!(f, "{}: ", self.severity.word())?;
        if self.names_key() {
            write!(f, "{}: ", self.key)?;
        }
        f.write_str(&self.reason)?;
        if !self.fix.is_empty() {
            write!(f, " ({})", self.fix)?;
        }
        if !self.off.is_empty() {
            write!(f, "; stays off: {}", self.off)?;
        }
        Ok(())
    }
}

/// Receiver of findings: a list, a console, a counter.
pub trait Sink {
    /// Takes one finding, in the order found.
    fn report(&mut self, finding: &Diagnostic);
}

/// Keeps the first `N`, but rather errors than warnings. The [`Summary`](crate::Summary) counts all.
impl<const N: usize> Sink for Vec<Diagnostic, N> {
    fn report(&mut self, finding: &Diagnostic) {
        if self.push(finding.clone()).is_ok() {
            return;
        }
        if let Some(lesser) = self.iter().rposition(|kept| kept.severity < finding.severity) {
            self.remove(lesser);
            let _ = self.push(finding.clone());
        }
    }
}

/// Drops all findings; the summary still counts.
impl Sink for () {
    fn report(&mut self, _: &Diagnostic) {}
}

#[cfg(any(test, feature = "std"))]
impl Sink for std::vec::Vec<Diagnostic> {
    fn report(&mut self, finding: &Diagnostic) {
        self.push(finding.clone());
    }
}
