//! Finds the test of each code and command by reading the sources of the tests, for `docs/tested.md`.
//!
//! `WRITE_DOCS=1 cargo test -p program --features docs` writes that page.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::format;
use std::fs;
use std::path::{Path, PathBuf};
use std::string::{String, ToString};
use std::vec::Vec;

use gcode::{Code, Letter};

use super::markdown::escaped;
use super::markdown::tests::settle;
use super::{CodeInfo, Handler, TOPICS, all, find};
use crate::commands::{self, COMMANDS};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
/// Folder of pages that state the meaning of lines as text.
const LANGUAGE: &str = "program/tests/language";
/// Folders with tests of whole machines, on the host and on the virtual board.
const MACHINES: [&str; 4] = ["tests/tests", "machine/tests", FEATURES, "virtual-prime/tests"];
/// Folder of features, of which `scenarios.rs` and `scenarios/` are tests of whole machines.
const FEATURES: &str = "machine/src/features";

/// A test, with everything that its text sends.
#[derive(Debug)]
struct Test {
    name: String,
    /// Codes, and first words of commands.
    types: BTreeSet<String>,
}

/// All tests that send lines, by kind.
#[derive(Debug)]
struct Tests {
    meanings: Vec<Test>,
    machines: Vec<Test>,
}

impl Tests {
    /// Reads the tests of this repository.
    fn read() -> Self {
        let mut meanings = Vec::new();
        for path in files(&[LANGUAGE], "txt") {
            let page = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).unwrap();
            for program in text.split("\n# ").filter(|program| !program.trim().is_empty()) {
                let (title, lines) = program.split_once('\n').unwrap_or((program, ""));
                let title = title.trim_start_matches("# ");
                let lines = lines.lines().filter(|line| !line.starts_with([' ', '@']));
                meanings.push(Test { name: format!("{page}: {title}"), types: lines.flat_map(typed).collect() });
            }
        }
        let mut machines = Vec::new();
        for path in files(&MACHINES, "rs") {
            machines.extend(topic(&path).iter().flat_map(|topic| tests_of(&path, topic)));
        }
        Self { meanings, machines }
    }

    /// Returns the language page and the whole-machine test for a code. Names in the old row are preferred.
    fn of(&self, name: &str, row: &str) -> (Option<&str>, Option<&str>) {
        (narrowest(&self.meanings, name, row), narrowest(&self.machines, name, row))
    }
}

/// Returns the test that the old row names, or else the test with the fewest other codes, so that new tests
/// elsewhere leave the page unchanged.
fn narrowest<'t>(tests: &'t [Test], name: &str, row: &str) -> Option<&'t str> {
    let with = tests.iter().filter(|test| test.types.contains(name));
    let is_named = |test: &Test| row.contains(&format!("| {} |", escaped(&test.name)));
    with.min_by_key(|test| (!is_named(test), test.types.len(), &test.name)).map(|test| test.name.as_str())
}

/// Returns every file below these folders with the ending, in order.
fn files(folders: &[&str], ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut left: Vec<PathBuf> = folders.iter().map(|folder| Path::new(ROOT).join(folder)).collect();
    while let Some(folder) = left.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                left.push(path);
            } else if path.extension().is_some_and(|known| known == ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Returns the topic that the tests of a source file are about, or `None` for a feature's own code.
fn topic(path: &Path) -> Option<String> {
    let file = path.strip_prefix(ROOT).unwrap_or(path).with_extension("");
    let file = file.to_string_lossy();
    let file = file.trim_end_matches("/mod");
    if let Some(feature) = file.strip_prefix(FEATURES) {
        let (feature, rest) = feature.split_once("/scenarios")?;
        return Some(format!("{}{rest}", feature.trim_start_matches('/')));
    }
    let (package, topic) = file.split_once("/tests/").unwrap_or(("", file));
    Some(if package == "virtual-prime" { format!("{package} {topic}") } else { topic.into() })
}

/// Returns the tests of a source file.
fn tests_of(path: &Path, topic: &str) -> Vec<Test> {
    let text = fs::read_to_string(path).unwrap();
    let mut tests = Vec::new();
    for test in text.split("#[test]").skip(1) {
        let Some((_, rest)) = test.split_once("fn ") else { continue };
        let name = rest.split('(').next().unwrap_or_default();
        // A test's body ends with the next closing brace at the margin.
        let body = rest.split("\n}\n").next().unwrap_or(rest);
        let types = literals(body).iter().flat_map(|text| text.lines().flat_map(typed)).collect();
        tests.push(Test { name: format!("{topic} `{name}`"), types });
    }
    tests
}

/// Returns the string literals of a piece of source, with escaped line ends as line ends.
fn literals(source: &str) -> Vec<String> {
    let (mut literals, mut rest) = (Vec::new(), source);
    while let Some((_, from)) = rest.split_once('"') {
        let mut end = 0;
        let bytes = from.as_bytes();
        while end < bytes.len() && bytes[end] != b'"' {
            end += if bytes[end] == b'\\' { 2 } else { 1 };
        }
        literals.push(from.get(..end).unwrap_or(from).replace("\\n", "\n"));
        rest = from.get(end + 1..).unwrap_or("");
    }
    literals
}

/// Returns the codes in a line, and its first word, which may be a command.
fn typed(line: &str) -> Vec<String> {
    let mut all: Vec<String> = line.split_whitespace().next().map(ToString::to_string).into_iter().collect();
    let bytes = line.as_bytes();
    for (at, letter) in line.char_indices().filter(|(_, letter)| matches!(letter, 'G' | 'M')) {
        let before = at.checked_sub(1).and_then(|before| bytes.get(before));
        if before.is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_') {
            continue;
        }
        let number: String = line[at + 1..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
        let number = number.trim_end_matches('.');
        if number.starts_with(|c: char| c.is_ascii_digit()) {
            all.push(format!("{letter}{number}"));
        }
    }
    // Commands such as `$H` and `$J=X1` have no blank behind their name.
    let sign: Option<String> = line.strip_prefix('$').map(|rest| rest.chars().take(1).collect());
    all.extend(sign.map(|letter| format!("${letter}")));
    all
}

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/tested.md");
const HEAD: &str = "# Every code and command, and its test

Generated from the tables in `program/src` and from the tests: of those that type a code, one that types little
else. *Its meaning* is a program on a page of `program/tests/language`; *on a machine* is a test of a whole machine on the
host (`machine`, `tests`) or of the image on the virtual board (`virtual-prime`). The last column says what Smoothieware v2 does
instead, where that differs.

";

/// Returns the new page, given the old page.
fn page(tests: &Tests, before: &str) -> String {
    let row_of = |name: &str| before.lines().find(|line| line.starts_with(&format!("| {name} |"))).unwrap_or("");
    let mut out = String::from(HEAD);
    for (title, rows) in TOPICS {
        out += &format!("## {title}\n\n| code | what it does | its meaning | on a machine | Smoothieware v2 |\n");
        out += "|---|---|---|---|---|\n";
        for row in rows {
            let name = row.code.to_string();
            let (meaning, machine) = tests.of(&name, row_of(&name));
            let cells = [row.help, meaning.unwrap_or(""), machine.unwrap_or(""), row.difference.text()];
            writeln!(out, "| {} | {} |", row.code, cells.map(escaped).join(" | ")).unwrap();
        }
        out.push('\n');
    }
    out += "## Console commands\n\n| command | what it does | on a machine |\n|---|---|---|\n";
    for command in COMMANDS {
        let (_, machine) = tests.of(command.word, row_of(&format!("`{}`", command.word)));
        writeln!(out, "| `{}` | {} | {} |", command.word, escaped(command.help), escaped(machine.unwrap_or("")))
            .unwrap();
    }
    out
}

#[test]
fn the_page_of_tests_is_that_of_the_tables() {
    let before = fs::read_to_string(PAGE).unwrap_or_default();
    settle(PAGE, &before, page(&Tests::read(), &before));
}

#[test]
fn a_row_keeps_its_test_while_that_types_its_code() {
    let test = |name: &str, types: &[&str]| Test {
        name: name.to_string(),
        types: types.iter().map(ToString::to_string).collect(),
    };
    let mut tests = [test("wide", &["M28", "M29"]), test("narrow", &["M28"])];
    assert_eq!(narrowest(&tests, "M28", ""), Some("narrow"));
    assert_eq!(narrowest(&tests, "M28", "| M28 | store | | wide | |"), Some("wide"));
    tests[0].types.remove("M28");
    assert_eq!(narrowest(&tests, "M28", "| M28 | store | | wide | |"), Some("narrow"));
}

/// Every code of the machine has a test on a whole machine, and every code of the program alone a page.
#[test]
fn every_code_and_command_has_a_test() {
    let tests = Tests::read();
    let needs_machine = |row: &CodeInfo| matches!(row.handler, Handler::Function(_) | Handler::Both(..));
    let mut without: Vec<String> = all()
        .filter(|row| {
            let (meaning, machine) = tests.of(&row.code.to_string(), "");
            meaning.is_none() || needs_machine(row) && machine.is_none()
        })
        .map(|row| row.code.to_string())
        .collect();
    without.extend(COMMANDS.iter().map(|info| info.word.to_string()).filter(|word| tests.of(word, "").1.is_none()));
    assert!(without.is_empty(), "no test types {without:?}");
}

/// Every code and command of Smoothieware v2 is known, or the list says why not.
#[test]
fn nothing_of_smoothieware_s_language_is_forgotten() {
    let list = fs::read_to_string(Path::new(ROOT).join("program/tests/v2-language.txt")).unwrap();
    let (mut count, mut forgotten, mut known) = (0, Vec::new(), Vec::new());
    for line in list.lines().filter(|line| !line.is_empty() && !line.starts_with("# ")) {
        let (name, why) = line.split_once(": ").map_or((line, None), |(name, why)| (name, Some(why)));
        let is_known = code(name).map_or_else(|| commands::find(name).is_some(), |code| find(code).is_some());
        match why {
            None if !is_known => forgotten.push(name),
            Some(_) if is_known => known.push(name),
            _ => {}
        }
        count += 1;
    }
    assert!(count > 180, "the list is not there");
    assert!(forgotten.is_empty(), "neither known nor with a reason: {forgotten:?}");
    assert!(known.is_empty(), "known, and still with a reason: {known:?}");
}

/// Parses the name of a code.
fn code(name: &str) -> Option<Code> {
    let letter = match name.chars().next()? {
        'G' => Letter::G,
        'M' => Letter::M,
        _ => return None,
    };
    let (number, subcode) = name.get(1..)?.split_once('.').unwrap_or((name.get(1..)?, "0"));
    Some(Code { letter, number: number.parse().ok()?, subcode: subcode.parse().ok()? })
}
