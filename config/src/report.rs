//! Findings on their way out: counted, and what they put out of service kept.

use crate::diagnostic::{Diagnostic, Severity, Sink};
use crate::ledger::Span;
use crate::module::Module;
use crate::off::{MAX_OFF, OffModule};
use crate::text::cut;
use core::fmt;
use heapless::Vec;

/// Numbers of findings, by severity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Findings of severity warning.
    pub warnings: u32,
    /// Findings of severity error: something stays off.
    pub errors: u32,
    /// Fatal findings: the machine does not start.
    pub fatals: u32,
}

impl Summary {
    /// Returns whether the machine may be started, with the parts that work.
    #[must_use]
    pub const fn is_usable(self) -> bool {
        self.fatals == 0
    }

    /// Returns whether everything works as the file says.
    #[must_use]
    pub const fn is_complete(self) -> bool {
        self.errors == 0 && self.fatals == 0
    }

    /// Returns the total number of findings.
    #[must_use]
    pub const fn total(self) -> u32 {
        self.warnings + self.errors + self.fatals
    }
}

/// Subject of a finding: span, key and parts of the machine.
#[derive(Clone, Copy)]
pub(crate) struct At<'a> {
    span: Span,
    key: &'a str,
    modules: [Option<Module<'a>>; 2],
}

impl<'a> At<'a> {
    /// A finding about a part of the machine; the key may be empty.
    pub(crate) const fn new(span: Span, key: &'a str, module: Module<'a>) -> Self {
        Self { span, key, modules: [Some(module), None] }
    }

    /// A finding that concerns a second part as well.
    pub(crate) const fn and(self, other: Module<'a>) -> Self {
        let [first, _] = self.modules;
        Self { modules: [first, Some(other)], ..self }
    }

    fn modules(&self) -> impl Iterator<Item = Module<'a>> {
        self.modules.into_iter().flatten()
    }
}

/// Counts findings and passes them on.
pub(crate) struct Reporter<'a> {
    sink: &'a mut dyn Sink,
    pub(crate) summary: Summary,
    off: Vec<OffModule, MAX_OFF>,
}

impl<'a> Reporter<'a> {
    pub(crate) fn new(sink: &'a mut dyn Sink) -> Self {
        Self { sink, summary: Summary::default(), off: Vec::new() }
    }

    /// Reports a finding. An error about what the machine cannot do without is fatal; any other puts its
    /// module out of service.
    pub(crate) fn report(
        &mut self,
        severity: Severity,
        at: At<'_>,
        reason: fmt::Arguments<'_>,
        fix: fmt::Arguments<'_>,
    ) {
        let mut severity = severity;
        let mut off = heapless::String::new();
        if severity == Severity::Error {
            if at.modules().any(Module::is_vital) || !self.put_out_of_service(&at) {
                severity = Severity::Fatal;
            } else {
                off = match at.modules {
                    [Some(one), Some(other)] if one != other => cut(format_args!("{one} and {other}")),
                    [Some(one), _] => cut(format_args!("{one}")),
                    _ => heapless::String::new(),
                };
            }
        }
        match severity {
            Severity::Warning => self.summary.warnings += 1,
            Severity::Error => self.summary.errors += 1,
            Severity::Fatal => self.summary.fatals += 1,
        }
        self.sink.report(&Diagnostic {
            severity,
            line: u32::from(at.span.line),
            column: u16::from(at.span.column),
            length: u16::from(at.span.length).max(1),
            key: cut(format_args!("{}", at.key)),
            reason: cut(reason),
            fix: cut(fix),
            off,
        });
    }

    /// Reports a setting that Velvet cannot act on yet.
    pub(crate) fn not_supported(&mut self, severity: Severity, at: At<'_>, advice: &str) {
        self.report(severity, at, format_args!("not supported yet"), format_args!("{advice}"));
    }

    /// Notes the parts that stay off. Returns false when there are more of them than can be kept: then the
    /// machine must not start.
    fn put_out_of_service(&mut self, at: &At<'_>) -> bool {
        at.modules().all(|module| {
            self.off.iter().any(|known| known.is(module)) || self.off.push(module.off(at.span.line, at.key)).is_ok()
        })
    }

    /// Returns the parts that stay off, in the order found.
    pub(crate) fn into_off(self) -> Vec<OffModule, MAX_OFF> {
        self.off
    }
}
