//! The performance ledger: what the release image costs, in instructions counted on the virtual board and in
//! bytes.
//!
//! Small jobs are made up so that each answers one question; `docs/performance.md` says what each number
//! means. Instructions are exact and repeatable. They are not cycles: a Cortex-M7 issues up to two a cycle
//! from TCM, and waits for flash, buses and divisions. Only silicon can tell that factor.

mod board;
mod config;
mod drawing;
mod figures;
mod history;
mod hold;
pub mod image;
mod jobs;
mod laser;
mod machines;
pub mod measure;
pub mod page;
mod table;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::memory;
pub use board::Bench;
pub use figures::{Ledger, SIZE, read};
use figures::{RATES, committed};

/// A number may get worse by this share before it counts as a regression.
const TOLERANCE: f64 = 0.02;

/// Measures, prints, compares with the committed ledger, and writes `bench/ledger.json`, the figures of
/// `docs/performance.md` and the history page.
pub fn run(root: &Path, elf: &Path, virtual_prime: &Path, velvet: &Path) -> Result<()> {
    let bench = Bench { velvet, ..Bench::of(root, elf, virtual_prime) };
    let ledger = measure(root, &bench)?;
    let path = root.join("bench/ledger.json");
    let before = committed(root).or_else(|| read(&path));
    table::print(&ledger, before.as_ref());
    fs::write(&path, serde_json::to_string_pretty(&ledger)? + "\n").with_context(|| path.display().to_string())?;
    page::write(root, &ledger)?;
    drawing::write(root, &ledger)?;
    let page = bench.scratch.join("history.html");
    history::write(root, &ledger, &page)?;
    println!("history: {}", page.strip_prefix(root).unwrap_or(&page).display());
    let worse = regressions(&ledger, before.as_ref());
    ensure!(worse.is_empty(), "worse by more than {:.0} %: {}", TOLERANCE * 100.0, worse.join(", "));
    Ok(())
}

fn measure(root: &Path, bench: &Bench<'_>) -> Result<Ledger> {
    let mut ledger = measure::jobs(root, bench)?;
    let image = fs::read(bench.elf).with_context(|| bench.elf.display().to_string())?;
    let mut ram = 0;
    for (region, bytes) in memory::used(&image)? {
        match region {
            "itcm" | "flash" | "dtcm" => {
                ledger.insert(format!("{region}_bytes"), bytes as f64);
            }
            _ => ram += bytes,
        }
    }
    ledger.insert("ram_bytes".into(), ram as f64);
    ledger.extend(image::sizes(root, &image)?);
    config::measure(root, bench.elf, bench.virtual_prime, &bench.scratch.join("config"), &mut ledger)?;
    Ok(ledger)
}

/// Writes the figures of the ledger that lies there into the page, and draws them.
pub fn write_committed(root: &Path) -> Result<()> {
    let ledger = read(&root.join("bench/ledger.json")).context("bench/ledger.json")?;
    page::write(root, &ledger)?;
    drawing::write(root, &ledger)
}

fn regressions(now: &Ledger, before: Option<&Ledger>) -> Vec<String> {
    let Some(before) = before else { return Vec::new() };
    now.iter()
        .filter(|(name, _)| !name.starts_with(SIZE))
        .filter_map(|(name, &value)| {
            let &old = before.get(name)?;
            let worse = if RATES.contains(&name.as_str()) {
                value < old * (1.0 - TOLERANCE)
            } else {
                value > old * (1.0 + TOLERANCE)
            };
            worse.then(|| format!("{name} {old} -> {value}"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ledger(entries: &[(&str, f64)]) -> Ledger {
        entries.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    #[test]
    fn only_growth_beyond_the_tolerance_is_a_regression() {
        let before = ledger(&[("a", 100.0), ("b", 100.0), ("gone", 1.0), ("flash_of_core", 1.0)]);
        let now = ledger(&[("a", 101.9), ("b", 102.1), ("new", 5.0), ("flash_of_core", 9.0)]);
        assert_eq!(regressions(&now, Some(&before)), ["b 100 -> 102.1"]);
        assert!(regressions(&now, None).is_empty());
        assert!(regressions(&ledger(&[("a", 50.0)]), Some(&before)).is_empty());
    }

    #[test]
    fn a_rate_gets_worse_downwards() {
        let before = ledger(&[("lines_per_s", 100.0)]);
        assert!(regressions(&ledger(&[("lines_per_s", 98.1)]), Some(&before)).is_empty());
        assert!(regressions(&ledger(&[("lines_per_s", 200.0)]), Some(&before)).is_empty());
        assert_eq!(regressions(&ledger(&[("lines_per_s", 97.9)]), Some(&before)), ["lines_per_s 100 -> 97.9"]);
    }
}
