//! The sample with one change, and what the reader says about it.
#![allow(dead_code, reason = "each test file uses a part")]

use config::{BoardId, Diagnostic, MachineConfig, Scope, Severity};

pub type Findings = heapless::Vec<Diagnostic, 64>;

pub const SAMPLE: &str = include_str!("../../samples/cartesian.ini");

pub fn read(text: &str) -> (MachineConfig, Findings) {
    let mut findings = Findings::new();
    let (config, _) = config::parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
    (config, findings)
}

/// The sample with one stretch of text replaced; the stretch must be there once.
pub fn edited(from: &str, to: &str) -> String {
    assert_eq!(SAMPLE.matches(from).count(), 1, "'{from}' must be in the sample once");
    SAMPLE.replace(from, to)
}

pub fn line_of(text: &str, part: &str) -> u32 {
    text.lines().position(|line| line.contains(part)).map_or(0, |index| index as u32 + 1)
}

/// An error in a section that the machine cannot do without is fatal, and so is a pin taken from one.
fn weighed(severity: Severity, text: &str, finding: &Diagnostic) -> Severity {
    let headers = text.lines().take(finding.line as usize).filter_map(|line| line.strip_prefix('[')?.split(']').next());
    let name = headers.last().unwrap_or_default();
    // A misspelt one stands for the section it reminds of.
    let section = if name == "plaeyr" { "player" } else { name };
    let owner = finding.reason.split_once("used by [").and_then(|(_, rest)| rest.split_once(']'));
    let sections = [Some(section), owner.map(|(name, _)| name).filter(|name| *name != "uart console")];
    let is_vital = sections
        .into_iter()
        .flatten()
        .any(|name| config::schema::section(name).is_none_or(|(_, section)| section.scope == Scope::Machine));
    if severity == Severity::Error && is_vital { Severity::Fatal } else { severity }
}

/// Asserts that `to` in place of `from` brings exactly this finding, at the line that holds `at`.
pub fn expect(from: &str, to: &str, severity: Severity, at: &str, key: &str, reason: &str, fix: &str) {
    let text = edited(from, to);
    let (_, findings) = read(&text);
    let [finding] = findings.as_slice() else { panic!("{to}: {findings:#?}") };
    assert_eq!(finding.severity, weighed(severity, &text, finding), "{finding}");
    assert_eq!(finding.line, line_of(&text, at), "{finding}");
    assert_eq!(finding.key, key, "{finding}");
    assert!(finding.reason.contains(reason), "'{reason}' is not in: {finding}");
    assert!(finding.fix.contains(fix), "'{fix}' is not in: {finding}");
}
