//! Limits that the image is held to: `bench/budget.toml` has a row for each figure, with the most or the
//! least it may be, and what that was given for.
//!
//! Sizes come from the linked image, costs from short jobs on the virtual board. Both are exact for a
//! compiler, which the file names: an image of another one is measured and told of, and held to nothing.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection};
use toml_edit::{Document, Item, Table};

use crate::ledger::{self, Bench, Ledger, SIZE, image};

const FILE: &str = "bench/budget.toml";
/// Every figure that was measured, whether or not it has a row.
const FIGURES: &str = "out/bench/held.json";
/// The limit of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Limit {
    AtMost(f64),
    AtLeast(f64),
}

impl Limit {
    fn holds(self, figure: f64) -> bool {
        match self {
            Self::AtMost(limit) => figure <= limit,
            Self::AtLeast(limit) => figure >= limit,
        }
    }
}

/// The file: the compiler, and limits by figure.
#[derive(Debug, PartialEq)]
struct Budget {
    compiler: String,
    limits: BTreeMap<String, Limit>,
}

/// Measures the image, prints each figure beside its limit, and fails when one is past it.
pub fn check(root: &Path, elf: &Path, virtual_prime: &Path) -> Result<()> {
    let budget = Budget::parse(&fs::read_to_string(root.join(FILE)).context(FILE)?).context(FILE)?;
    let linked = fs::read(elf).with_context(|| elf.display().to_string())?;
    let mut figures = image::sizes(root, &linked).with_context(|| elf.display().to_string())?;
    figures.extend(ledger::measure::held(root, &Bench::of(root, elf, virtual_prime))?);
    fs::write(root.join(FIGURES), serde_json::to_string_pretty(&figures)? + "\n").context(FIGURES)?;
    let before = ledger::read(&root.join("bench/ledger.json")).unwrap_or_default();
    let past = budget.past(&figures, &before)?;
    println!("{}", budget.table(&figures, &before));
    let compiler = compiler(&linked)?;
    if compiler != budget.compiler {
        println!("the image is of {compiler}, the limits are those of {}: told, and held to nothing", budget.compiler);
        println!("{past}");
        return Ok(());
    }
    ensure!(past.is_empty(), "past the limits of {FILE}:\n{past}");
    Ok(())
}

/// The compiler that made the image, as it says itself.
fn compiler(image: &[u8]) -> Result<String> {
    let file = object::File::parse(image).context("not an ELF file")?;
    let comment = file.section_by_name(".comment").context("the image does not say who made it")?;
    let text = String::from_utf8_lossy(comment.data()?).into_owned();
    let said = text.split('\0').find(|part| part.starts_with("rustc")).context("no version of rustc in the image")?;
    Ok(said.to_owned())
}

impl Budget {
    fn parse(text: &str) -> Result<Self> {
        let file = text.parse::<Document<String>>()?;
        let compiler = file.get("compiler").and_then(Item::as_str).context("no compiler")?.to_owned();
        let mut limits = BTreeMap::new();
        for (kind, limit) in [("at_most", Limit::AtMost as fn(f64) -> Limit), ("at_least", Limit::AtLeast)] {
            let rows = file.get(kind).and_then(Item::as_table).with_context(|| format!("no [{kind}]"))?;
            for (name, value) in rows_of(rows) {
                let value = value.with_context(|| format!("{name}: write {{ limit = 1, for = \"...\" }}"))?;
                ensure!(limits.insert(name.to_owned(), limit(value)).is_none(), "{name} has two limits");
            }
        }
        Ok(Self { compiler, limits })
    }

    /// A line for each figure that is past its limit, with what it was at the last entry of the ledger, and
    /// for the flash what has grown since.
    fn past(&self, figures: &Ledger, before: &Ledger) -> Result<String> {
        let mut past = String::new();
        let mut is_flash = false;
        for (name, limit) in &self.limits {
            let Some(&figure) = figures.get(name) else { bail!("{name} is no figure that is measured") };
            if limit.holds(figure) {
                continue;
            }
            is_flash |= name.starts_with("flash_");
            let (Limit::AtMost(bound) | Limit::AtLeast(bound)) = *limit;
            let since = before.get(name).map_or("not measured".into(), f64::to_string);
            writeln!(past, "  {name}: {figure}, the limit is {bound}; at the last entry {since}")?;
        }
        if is_flash {
            past += &grown(figures, before);
        }
        Ok(past)
    }

    fn table(&self, figures: &Ledger, before: &Ledger) -> String {
        let mut table = format!("{:<40} {:>12} {:>12} {:>12}\n", "figure", "now", "limit", "last entry");
        for (name, limit) in &self.limits {
            let (sign, bound) = match *limit {
                Limit::AtMost(bound) => ("<=", bound),
                Limit::AtLeast(bound) => (">=", bound),
            };
            let [now, since] = [figures, before].map(|of| of.get(name).map_or("-".into(), f64::to_string));
            // Writing to a string cannot fail.
            let _ = writeln!(table, "{name:<40} {now:>12} {sign} {bound:>9} {since:>12}");
        }
        table
    }
}

/// Name and limit of each row.
fn rows_of(rows: &Table) -> impl Iterator<Item = (&str, Option<f64>)> {
    rows.iter().map(|(name, row)| {
        let limit = row.get("limit").filter(|_| row.get("for").is_some_and(Item::is_str));
        let limit = limit.and_then(|limit| limit.as_float().or_else(|| limit.as_integer().map(|whole| whole as f64)));
        (name, limit)
    })
}

/// The crates whose flash has changed since the last entry, the most first.
fn grown(figures: &Ledger, before: &Ledger) -> String {
    let crates = figures.iter().filter(|(name, _)| name.starts_with(SIZE));
    let mut changes: Vec<(f64, &str)> = crates
        .map(|(name, now)| (now - before.get(name).unwrap_or(&0.0), name.as_str()))
        .filter(|(change, _)| *change != 0.0)
        .collect();
    changes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let lines: Vec<String> = changes.iter().map(|(change, name)| format!("    {name} {change:+}\n")).collect();
    format!("  since the last entry:\n{}", lines.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "compiler = \"rustc version 1\"\n\
        [at_most]\nflash_bytes = { limit = 1000, for = \"all of it\" }\nline_instructions = { limit = 10.5, for = \"x\" }\n\
        [at_least]\ndtcm_free_bytes = { limit = 7, for = \"y\" }\n";

    fn figures(entries: &[(&str, f64)]) -> Ledger {
        entries.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    #[test]
    fn a_figure_past_its_limit_is_named_with_what_grew() {
        let budget = Budget::parse(TEXT).expect("a budget");
        let within = [("flash_bytes", 1000.0), ("line_instructions", 10.5), ("dtcm_free_bytes", 7.0)];
        assert_eq!(budget.past(&figures(&within), &Ledger::new()).expect("figures"), "");
        let past = [
            ("flash_bytes", 1001.0),
            ("line_instructions", 10.0),
            ("dtcm_free_bytes", 6.0),
            ("flash_of_machine", 70.0),
            ("flash_of_core", 5.0),
        ];
        let before = figures(&[("flash_bytes", 990.0), ("flash_of_machine", 60.0), ("flash_of_core", 5.0)]);
        assert_eq!(
            budget.past(&figures(&past), &before).expect("figures"),
            "  dtcm_free_bytes: 6, the limit is 7; at the last entry not measured\n  \
             flash_bytes: 1001, the limit is 1000; at the last entry 990\n  \
             since the last entry:\n    flash_of_machine +10\n"
        );
    }

    #[test]
    fn a_row_needs_a_figure_a_limit_and_a_reason() {
        let budget = Budget::parse(TEXT).expect("a budget");
        assert!(budget.past(&figures(&[("flash_bytes", 1.0)]), &Ledger::new()).is_err());
        assert!(Budget::parse(&TEXT.replace(", for = \"x\"", "")).is_err());
        assert!(Budget::parse(&TEXT.replace("limit = 7", "limit = \"7\"")).is_err());
        assert!(Budget::parse(&TEXT.replace("compiler", "compilers")).is_err());
    }

    #[test]
    fn the_file_of_this_project_can_be_read() {
        let text = include_str!("../../bench/budget.toml");
        let budget = Budget::parse(text).expect("a budget");
        assert!(budget.compiler.starts_with("rustc version ") && budget.limits.len() > 20);
    }
}
