//! Keeps the documentation true: every file it names exists, every link leads somewhere, and a function named
//! together with its file is in that file.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// Checks `README.md`, `CONTRIBUTING.md` and everything in `docs`.
pub fn check(root: &Path) -> Result<()> {
    let mut pages = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    let listing = fs::read_dir(root.join("docs")).context("docs")?;
    for entry in listing {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "md") {
            pages.push(path);
        }
    }
    pages.sort();
    let mut faults = Vec::new();
    for page in &pages {
        let text = fs::read_to_string(page).with_context(|| page.display().to_string())?;
        let name = page.strip_prefix(root).unwrap_or(page).display().to_string();
        faults.extend(page_faults(root, page, &text).into_iter().map(|fault| format!("{name}: {fault}")));
    }
    for fault in &faults {
        eprintln!("  {fault}");
    }
    if !faults.is_empty() {
        bail!("{} place(s) in the documentation are not true", faults.len());
    }
    println!("docs: {} pages name only what exists", pages.len());
    Ok(())
}

/// Page whose tables end each row with the tests that hold it.
const THREATS: &str = "threats.md";

/// Rows of the tables of threats that name no test, or a function that is none.
fn untested_threats(root: &Path, text: &str) -> Vec<String> {
    let rows = text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| threat |"));
    let mut faults = Vec::new();
    for row in rows {
        let threat = row.split('|').nth(1).unwrap_or_default().trim();
        let tests = quoted_sources(row);
        if !tests.iter().any(|(name, _)| name.is_some()) {
            faults.push(format!("the threat \"{threat}\" names no test"));
        }
        for (name, file) in tests {
            let source = fs::read_to_string(root.join(file)).unwrap_or_default();
            if !name.is_some_and(|name| is_test(&source, name)) {
                faults.push(format!("the threat \"{threat}\": {file} has no test {}", name.unwrap_or_default()));
            }
        }
    }
    faults
}

/// Whether a source has a test of this name.
fn is_test(source: &str, name: &str) -> bool {
    source.split("#[test]").skip(1).any(|behind| behind.trim_start().starts_with(&format!("fn {name}(")))
}

fn page_faults(root: &Path, page: &Path, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    if page.ends_with(THREATS) {
        faults.extend(untested_threats(root, text));
    }
    for target in links(text) {
        let path = page.parent().unwrap_or(root).join(target);
        if !path.exists() {
            faults.push(format!("the link to {target} leads nowhere"));
        }
    }
    for (name, file) in quoted_sources(text) {
        let path: PathBuf = root.join(file);
        match (fs::read_to_string(&path), name) {
            (Err(_), _) => faults.push(format!("there is no {file}")),
            (Ok(source), Some(name)) if !defines(&source, name) => faults.push(format!("{file} has no {name}")),
            _ => {}
        }
    }
    faults
}

/// Relative link targets, without their fragments.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices("](").filter_map(|(at, _)| {
        let rest = &text[at + 2..];
        let target = &rest[..rest.find(')')?];
        let file = target.split('#').next().unwrap_or_default();
        (!file.is_empty() && !target.contains("://")).then_some(file)
    })
}

/// Source files quoted in the text, with the item named just before: "`Motion::stop` in
/// `motion/src/motion.rs`" or "`Motion::stop` (`motion/src/motion.rs`".
fn quoted_sources(text: &str) -> Vec<(Option<&str>, &str)> {
    // Odd pieces lie between backquotes.
    let pieces: Vec<&str> = text.split('`').collect();
    let mut found = Vec::new();
    for index in (1..pieces.len()).step_by(2) {
        let file = pieces[index];
        // `<topic>.rs` stands for any file of its folder.
        if !file.ends_with(".rs") || !file.contains('/') || file.contains('<') {
            continue;
        }
        let joint = pieces[index - 1];
        let named = index >= 3 && (joint == " in " || joint == " (" || joint == ", `" || joint.trim() == "in");
        found.push((named.then(|| pieces[index - 2]).filter(|name| is_item(name)), file));
    }
    found
}

fn is_item(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == ':')
}

/// Does this source define the last part of the path as a function, a type or a constant?
fn defines(source: &str, name: &str) -> bool {
    let last = name.rsplit("::").next().unwrap_or(name);
    ["fn ", "struct ", "enum ", "trait ", "const ", "static "].iter().any(|kind| {
        source.match_indices(&format!("{kind}{last}")).any(|(at, found)| {
            let after = source[at + found.len()..].chars().next().unwrap_or(' ');
            !after.is_alphanumeric() && after != '_'
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_found_with_the_item_named_before_them() {
        let text = "`Motion::stop` in `motion/src/a.rs`, then `b/src/b.rs` and `Queue` (`c/src/c.rs`).";
        let expected = [(Some("Motion::stop"), "motion/src/a.rs"), (None, "b/src/b.rs"), (Some("Queue"), "c/src/c.rs")];
        assert_eq!(quoted_sources(text), expected);
    }

    #[test]
    fn an_item_is_only_found_whole() {
        assert!(defines("pub fn stop(&mut self)", "Motion::stop"));
        assert!(!defines("pub fn stop_now(&mut self)", "Motion::stop"));
        assert!(defines("pub struct Queue<T> {", "Queue"));
    }

    #[test]
    fn a_test_is_a_function_behind_its_mark() {
        let source = "#[test]\nfn holds() {}\nfn helps() {}\n#[test]\n    fn holds_more() {}\n";
        assert!(is_test(source, "holds") && is_test(source, "holds_more"));
        assert!(!is_test(source, "helps") && !is_test(source, "hold") && !is_test("", ""));
        let row =
            |test: &str| untested_threats(Path::new("."), &format!("| threat | what | test |\n| a | b | {test} |\n"));
        assert_eq!(row("nothing"), ["the threat \"a\" names no test"]);
        assert_eq!(row("`no_such` (`src/docs.rs`)"), ["the threat \"a\": src/docs.rs has no test no_such"]);
        assert!(row("`a_test_is_a_function_behind_its_mark` (`src/docs.rs`)").is_empty());
    }

    #[test]
    fn links_into_the_web_and_into_the_page_are_left_alone() {
        let text = "[a](docs/a.md#part) [b](https://example.org) [c](#here)";
        assert_eq!(links(text).collect::<Vec<_>>(), ["docs/a.md"]);
    }
}
