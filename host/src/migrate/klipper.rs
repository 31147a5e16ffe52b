//! Klipper's printer.cfg becomes a config.ini for the Prime, with a report of what became of every option.

mod account;
mod files;
mod migration;
mod page;
mod pins;
mod reader;
mod rules;
mod sections;
mod source;
mod wiring;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use config::{BoardId, Diagnostic, Severity, Summary};

use super::ini;
use account::Account;
use migration::Migration;
use source::Source;
use wiring::Wire;

/// First line of the new file.
const HEAD: &str =
    "Migrated from Klipper's printer.cfg by velvet migrate. report.html says what became of every option.";

/// Returns whether a file is Klipper's: it is called so, or has a line that begins a section.
pub fn is_klipper(path: &Path) -> Result<bool> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("cfg")) {
        return Ok(true);
    }
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(String::from_utf8_lossy(&bytes).lines().any(|line| line.starts_with('[') && line.contains(']')))
}

/// Writes the folder of the new machine; returns whether it could start with it.
pub fn migrate(path: &Path, out: Option<&Path>) -> Result<bool> {
    let source = files::read(path)?;
    let outcome = Outcome::new(&source);
    match out {
        None => print!("{}", outcome.text),
        Some(folder) if folder.is_file() => {
            bail!("{} is a file: of a printer.cfg --out names a folder", folder.display())
        }
        Some(folder) => outcome.save(&source, folder)?,
    }
    let name = out.map_or_else(|| PathBuf::from("config.ini"), |folder| folder.join("config.ini"));
    eprint!("{}", outcome.told(&name.display().to_string()));
    Ok(outcome.summary.is_complete())
}

/// What a migration came to.
struct Outcome {
    /// The new file.
    text: String,
    account: Account,
    to_do: Vec<String>,
    wires: Vec<Wire>,
    findings: Vec<Diagnostic>,
    summary: Summary,
}

impl Outcome {
    fn new(source: &Source) -> Self {
        let mut migration = Migration::new(source);
        rules::apply(&mut migration);
        let Migration { account, entries, mut to_do, wiring, .. } = migration;
        for (place, remark) in &source.remarks {
            to_do.push(format!("{}: {remark}", source.told(*place)));
        }
        to_do.push("motors: try the direction of each; to turn one, add or take away the ! of its dir_pin".to_owned());
        let text = ini::write(HEAD, &to_do, &entries);
        let mut findings: Vec<Diagnostic> = Vec::new();
        let (_, summary) = config::parse(text.as_bytes(), BoardId::default(), &mut findings);
        Self { text, account, to_do, wires: wiring.wires, findings, summary }
    }

    /// Writes config.ini, the report, and printer.cfg with its includes.
    fn save(&self, source: &Source, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
        };
        write("config.ini", &self.text)?;
        write("report.json", &page::json(self, source))?;
        write("report.html", &page::html(self, source))?;
        for (from, to) in copies(source) {
            let to = folder.join(to);
            if let Some(parent) = to.parent() {
                std::fs::create_dir_all(parent).with_context(|| format!("cannot make {}", parent.display()))?;
            }
            if std::path::absolute(&from)? != std::path::absolute(&to)? {
                std::fs::copy(&from, &to).with_context(|| format!("cannot write {}", to.display()))?;
            }
        }
        Ok(())
    }

    /// Returns what a person reads at the console.
    fn told(&self, name: &str) -> String {
        let mut out = String::new();
        for item in &self.to_do {
            out += &format!("to do: {item}\n");
        }
        let count = self.account.options();
        out += &format!(
            "{} options: {} converted ({} kept in printer.cfg), {} needless, {} refused\n",
            count.all, count.converted, count.kept, count.needless, count.refused
        );
        out + &config::render_all(&self.findings, self.summary, name, &self.text)
    }

    fn errors(&self) -> usize {
        self.findings.iter().filter(|finding| finding.severity != Severity::Warning).count()
    }
}

/// Returns the files to copy and their places in the new folder: as they lie to each other.
fn copies(source: &Source) -> Vec<(PathBuf, PathBuf)> {
    let whole = |path: &PathBuf| files::simplified(&std::path::absolute(path).unwrap_or_else(|_| path.clone()));
    let all: Vec<PathBuf> = source.files.iter().map(whole).collect();
    let mut root = all.first().and_then(|path| path.parent()).map(Path::to_owned).unwrap_or_default();
    while !all.iter().all(|path| path.starts_with(&root)) && root.pop() {}
    let placed = |path: &PathBuf| path.strip_prefix(&root).unwrap_or(path).to_owned();
    source.files.iter().cloned().zip(all.iter().map(placed)).collect()
}
