//! The report: as JSON, and as a page with before and after side by side.

use serde::Serialize;

use super::Outcome;
use super::account::{Count, Verdict};
use super::sections::{self, Edition};
use super::source::{Entry, Section, Source};

const TEMPLATE: &str = include_str!("../../../assets/migrate.html");

#[derive(Serialize)]
struct Report<'a> {
    file: String,
    files: Vec<String>,
    /// Whether the machine starts with the new file.
    usable: bool,
    errors: usize,
    warnings: usize,
    options: Count,
    sections: Count,
    to_do: &'a [String],
    wires: Vec<WireRow<'a>>,
    findings: Vec<String>,
    account: Vec<SectionRow<'a>>,
    config: &'a str,
}

#[derive(Serialize)]
struct WireRow<'a> {
    what: &'a str,
    old: &'a str,
    pin: &'a str,
    label: &'a str,
    remark: &'a str,
}

#[derive(Serialize)]
struct SectionRow<'a> {
    section: &'a str,
    /// Edition of Klipper's reference that heads it: both, english or none.
    reference: &'static str,
    at: String,
    #[serde(flatten)]
    verdict: Verdict,
    options: Vec<OptionRow<'a>>,
}

#[derive(Serialize)]
struct OptionRow<'a> {
    option: &'a str,
    value: &'a str,
    at: String,
    #[serde(flatten)]
    verdict: Verdict,
    /// Values that later lines replaced.
    earlier: Vec<String>,
}

fn reference(name: &str) -> &'static str {
    match sections::find(name).map(|row| row.edition) {
        Some(Edition::Both) => "both",
        Some(Edition::English) => "english",
        None => "none",
    }
}

fn report<'a>(outcome: &'a Outcome, source: &'a Source) -> Report<'a> {
    let name = |path: &std::path::PathBuf| path.display().to_string();
    let missing = || Verdict::refused("no rule has judged it", "");
    let option = |(entry, verdict): (&'a Entry, &Option<Verdict>)| OptionRow {
        option: &entry.name,
        value: &entry.value,
        at: source.told(entry.place),
        verdict: verdict.clone().unwrap_or_else(missing),
        earlier: entry.earlier.iter().map(|(at, value)| format!("{}: {value}", source.told(*at))).collect(),
    };
    let section = |(section, of): (&'a Section, &super::account::OfSection)| SectionRow {
        section: &section.name,
        reference: reference(&section.name),
        at: source.told(section.place),
        verdict: of.section.clone().unwrap_or_else(missing),
        options: section.options.iter().zip(&of.options).map(option).collect(),
    };
    let wires = outcome.wires.iter().map(|wire| WireRow {
        what: &wire.what,
        old: &wire.old,
        pin: &wire.pin,
        label: &wire.label,
        remark: &wire.remark,
    });
    Report {
        file: source.files.first().map(name).unwrap_or_default(),
        files: source.files.iter().map(name).collect(),
        usable: outcome.summary.is_usable(),
        errors: outcome.errors(),
        warnings: outcome.findings.len() - outcome.errors(),
        options: outcome.account.options(),
        sections: outcome.account.sections(),
        to_do: &outcome.to_do,
        wires: wires.collect(),
        findings: outcome.findings.iter().map(|finding| config::render(finding, "config.ini", &outcome.text)).collect(),
        account: source.sections.iter().zip(&outcome.account.0).map(section).collect(),
        config: &outcome.text,
    }
}

/// Returns the report for programs.
pub fn json(outcome: &Outcome, source: &Source) -> String {
    serde_json::to_string_pretty(&report(outcome, source)).unwrap_or_default()
}

/// Returns the report for a person.
pub fn html(outcome: &Outcome, source: &Source) -> String {
    let report = report(outcome, source);
    let title = report.file.rsplit('/').next().unwrap_or("printer.cfg").to_owned();
    crate::page::fill(TEMPLATE, &title, &report)
}
