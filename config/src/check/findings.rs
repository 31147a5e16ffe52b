//! Findings of the checks, and the settings that the checks read.

use crate::diagnostic::Severity;
use crate::ledger::{Ledger, Path};
use crate::machine::MachineConfig;
use crate::report::{At, Reporter};
use core::fmt;

/// Data that the checks read, and the output for their findings.
pub(crate) struct Checks<'a, 'r> {
    pub(crate) config: &'a MachineConfig,
    pub(crate) ledger: &'a Ledger,
    pub(crate) reporter: &'a mut Reporter<'r>,
}

impl Checks<'_, '_> {
    /// An error about a setting: what it belongs to stays off.
    pub(super) fn error(&mut self, setting: Named<'_>, reason: fmt::Arguments<'_>, fix: fmt::Arguments<'_>) {
        report(self.config, self.ledger, self.reporter, Severity::Error, setting, reason, fix);
    }

    /// An error about two instances of a section: nobody can tell which of them is wrong.
    pub(super) fn error_of_both(
        &mut self,
        setting: Named<'_>,
        other: usize,
        reason: fmt::Arguments<'_>,
        fix: fmt::Arguments<'_>,
    ) {
        let (section, place, key) = setting;
        let (Some(path), Some(other)) = (Path::named(section, place, key), Path::named(section, other, key)) else {
            return;
        };
        if self.ledger.is_unreadable(path) || self.ledger.is_unreadable(other) {
            return;
        }
        let span = self.ledger.place(path, self.config);
        let text = path.text(self.config);
        let at = At::new(span, &text, path.module(self.config)).and(other.module(self.config));
        self.reporter.report(Severity::Error, at, reason, fix);
    }

    /// Whether the setting's line could not be understood, which has been said.
    pub(super) fn is_unreadable(&self, (section, place, key): Named<'_>) -> bool {
        Path::named(section, place, key).is_some_and(|path| self.ledger.is_unreadable(path))
    }

    /// A warning about a setting.
    pub(super) fn warn(&mut self, setting: Named<'_>, reason: fmt::Arguments<'_>, fix: fmt::Arguments<'_>) {
        report(self.config, self.ledger, self.reporter, Severity::Warning, setting, reason, fix);
    }
}

/// A setting by section, place of its instance, and key.
pub(crate) type Named<'a> = (&'a str, usize, &'a str);

/// Reports a finding about a setting.
pub(super) fn report(
    config: &MachineConfig,
    ledger: &Ledger,
    reporter: &mut Reporter<'_>,
    severity: Severity,
    (section, place, key): Named<'_>,
    reason: fmt::Arguments<'_>,
    fix: fmt::Arguments<'_>,
) {
    let Some(path) = Path::named(section, place, key) else {
        debug_assert!(false, "the schema has no [{section}] {key}");
        return;
    };
    if ledger.is_unreadable(path) || (severity == Severity::Warning && ledger.is_doubted(path)) {
        return;
    }
    let span = ledger.place(path, config);
    reporter.report(severity, At::new(span, &path.text(config), path.module(config)), reason, fix);
}
