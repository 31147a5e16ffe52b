//! Sources of a package's test program: a file that no `mod` line leads to is not built, and its tests are
//! not run.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the files that are tests by their place and no part of `tests/main.rs`: those in `tests`, and in
/// `src` each `scenarios.rs` and each file of a folder `scenarios`.
///
/// # Panics
/// When a source cannot be read.
#[must_use]
pub fn left_out(package: &str) -> Vec<PathBuf> {
    let package = Path::new(package);
    let mut named = BTreeSet::new();
    follow(&package.join("tests/main.rs"), &mut named);
    let mut tests = sources(&package.join("tests"));
    let is_scenario = |file: &PathBuf| {
        let below = file.strip_prefix(package).unwrap_or(file);
        below.iter().any(|part| part == "scenarios" || part == "scenarios.rs")
    };
    tests.extend(sources(&package.join("src")).into_iter().filter(is_scenario));
    tests.retain(|file| !named.contains(file));
    tests
}

/// Adds a file, and all to which its `mod` lines lead.
fn follow(file: &Path, named: &mut BTreeSet<PathBuf>) {
    named.insert(file.to_owned());
    let text = read(file);
    let folder = file.parent().unwrap_or(file);
    let stem = file.file_stem().unwrap_or_default();
    let below = if stem == "main" || stem == "mod" { folder.to_owned() } else { folder.join(stem) };
    let mut place = None;
    for line in text.lines() {
        let declaration = line.strip_prefix("pub ").unwrap_or(line).strip_prefix("mod ");
        if let Some(name) = declaration.and_then(|rest| rest.strip_suffix(';')) {
            let beside = below.join(format!("{name}.rs"));
            let inside = below.join(name).join("mod.rs");
            let usual = if beside.exists() { beside } else { inside };
            follow(&place.take().unwrap_or(usual), named);
        }
        place = line.strip_prefix("#[path = \"").and_then(|rest| rest.strip_suffix("\"]")).map(|path| {
            // Paths are compared as written: without `..` in them.
            path.strip_prefix("../").map_or_else(|| folder.join(path), |path| folder.with_file_name(path))
        });
    }
}

/// Returns every source below a folder, in order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("an entry of the folder").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn read(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}
