//! House rules that are about the text of a source file: where `unsafe` may stand, that pure crates build
//! without the standard library, how long a file may grow.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Folders whose sources may hold `unsafe`: they touch copper.
const MAY_BE_UNSAFE: &[&str] = &["bsp-prime", "boot", "firmware", "controller"];
/// Past this a file holds a second idea.
const MAX_LINES: usize = 500;
/// Last column that a comment may reach.
const COMMENT_COLUMNS: usize = 110;
/// Not ours to judge.
const SKIP: &[&str] = &["target", ".git", "node_modules"];

/// Every broken rule, each with its file.
pub fn faults(root: &Path, pure: &[&str]) -> Result<Vec<String>> {
    let mut faults = Vec::new();
    for path in rust_files(root)? {
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        faults.extend(file_faults(&name, &text));
    }
    for package in pure {
        let library = root.join(package).join("src/lib.rs");
        let text = fs::read_to_string(&library).with_context(|| library.display().to_string())?;
        if !text.contains("no_std") {
            faults.push(format!("{package}/src/lib.rs: a pure crate must be no_std on the board"));
        }
    }
    Ok(faults)
}

/// Files of these crates with a future in them, but for those that begin like one of `futures`.
pub fn waiting(root: &Path, synchronous: &[&str], futures: &[&str]) -> Result<Vec<String>> {
    let mut faults = Vec::new();
    for package in synchronous {
        for path in rust_files(&root.join(package).join("src"))? {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
            if futures.iter().any(|folder| name.starts_with(folder)) {
                continue;
            }
            let waits = |line: &str| words(&code_of(line)).any(|word| word == "async" || word == "await");
            if let Some(number) = text.lines().position(waits) {
                faults.push(format!("{name}:{}: {package} waits by calls, if at all: no async here", number + 1));
            }
        }
    }
    Ok(faults)
}

fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !c.is_alphanumeric() && c != '_')
}

fn file_faults(name: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let lines = text.lines().count();
    if lines > MAX_LINES {
        faults.push(format!("{name}: {lines} lines; split it, one idea per file (limit {MAX_LINES})"));
    }
    for (number, line) in text.lines().enumerate() {
        let Some((mark, words)) = line.trim_start().split_once(' ') else { continue };
        // Rows of tables and hidden lines of examples have no place to be broken, nor has a long word.
        let can_be_broken = words.trim().contains(' ') && !words.starts_with(['|', '#']);
        if mark.starts_with("//") && line.chars().count() > COMMENT_COLUMNS && can_be_broken {
            faults.push(format!("{name}:{}: a comment goes beyond column {COMMENT_COLUMNS}", number + 1));
        }
    }
    let may_be_unsafe = MAY_BE_UNSAFE.iter().any(|folder| name.starts_with(&format!("{folder}/")));
    // The rules' own tests quote the word, the emulator's board suite is an image of its own.
    let exempt = name.starts_with("xtask/") || name.starts_with("virtual-prime/images/");
    if !may_be_unsafe && !exempt {
        for (number, line) in text.lines().enumerate() {
            if words(&code_of(line)).any(|word| word == "unsafe") {
                faults
                    .push(format!("{name}:{}: unsafe belongs in bsp-prime, boot, firmware or controller", number + 1));
            }
        }
    }
    faults
}

/// The line without its `//` comment and without the insides of string literals.
fn code_of(line: &str) -> String {
    let mut code = String::new();
    let mut in_string = false;
    let mut previous = ' ';
    for (index, c) in line.char_indices() {
        if !in_string && line[index..].starts_with("//") {
            break;
        }
        if c == '"' && previous != '\\' {
            in_string = !in_string;
        } else if !in_string {
            code.push(c);
        }
        previous = c;
    }
    code
}

/// Every source below a folder, in order.
pub fn rust_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if path.is_dir() && !SKIP.contains(&name) {
            files.extend(rust_files(&path)?);
        } else if name.ends_with(".rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsafe_is_found_in_code_and_not_in_prose() {
        assert_eq!(file_faults("motion/src/a.rs", "let x = unsafe { y };").len(), 1);
        assert!(file_faults("motion/src/a.rs", "// unsafe is not needed here").is_empty());
        assert!(file_faults("motion/src/a.rs", "let text = \"unsafe\";").is_empty());
        assert!(file_faults("motion/src/a.rs", "#![forbid(unsafe_code)]").is_empty());
        assert!(file_faults("bsp-prime/src/a.rs", "unsafe { y }").is_empty());
    }

    #[test]
    fn a_comment_that_goes_too_far_is_named() {
        let comment = |length: usize| format!("    // {}\n", "word ".repeat(length).trim_end());
        assert_eq!(file_faults("gcode/src/a.rs", &comment(21)).len(), 1);
        assert!(file_faults("gcode/src/a.rs", &comment(20)).is_empty());
    }

    #[test]
    fn a_file_that_grew_too_long_is_named() {
        let text = "//\n".repeat(MAX_LINES + 1);
        assert_eq!(file_faults("gcode/src/a.rs", &text).len(), 1);
        assert!(file_faults("gcode/src/a.rs", &"//\n".repeat(MAX_LINES)).is_empty());
    }
}
