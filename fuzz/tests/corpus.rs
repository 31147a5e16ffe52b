//! The kept corpus, every file of it, and generated inputs of a fixed seed: the part of `make fuzz` that
//! `make test` runs.
//!
//! `FUZZ_FILE=path cargo test -p fuzz a_file` runs one input, with what it shows printed.

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use fuzz::dice::Dice;
use fuzz::{TARGETS, Target};

fn target(name: &str) -> &'static Target {
    TARGETS.iter().find(|target| target.name == name).unwrap_or_else(|| panic!("no target {name}"))
}

fn files(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    files
}

/// Runs an input, and prints it when it shows something wrong.
fn run(target: &Target, what: &str, input: &[u8]) {
    let run = target.run;
    assert!(catch_unwind(|| run(input)).is_ok(), "{what} shows something wrong: \"{}\"", input.escape_ascii());
}

fn replay(name: &str) {
    let files = files(name);
    assert!(files.len() >= 30, "the corpus of {name} is gone");
    for file in files {
        let input = fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        run(target(name), &file.display().to_string(), &input);
    }
}

/// Runs inputs out of the grammar, and changed inputs of the corpus.
fn generated(name: &str, seed: u64, count: usize) {
    let target = target(name);
    let mut dice = Dice::new(seed);
    let files = files(name);
    for number in 0..count {
        let mut input =
            if dice.once_in(2) { target.input(&mut dice) } else { fs::read(dice.pick(&files)).unwrap_or_default() };
        for _ in 0..dice.below(6) {
            target.mutate(&mut input, &mut dice, 2_048);
        }
        run(target, &format!("input {number} of seed {seed}"), &input);
    }
}

#[test]
fn corpus_of_the_parser() {
    replay("parser");
}

#[test]
fn corpus_of_the_program() {
    replay("program");
}

#[test]
fn corpus_of_the_console() {
    replay("console");
}

#[test]
fn corpus_of_the_web_server() {
    for name in ["http", "websocket", "form", "json"] {
        replay(name);
    }
}

#[test]
fn generated_for_the_web_server() {
    generated("http", 4, 6_000);
    generated("websocket", 5, 6_000);
    generated("form", 6, 10_000);
    generated("json", 7, 10_000);
}

#[test]
fn corpus_of_a_klipper_host() {
    replay("klipper");
}

#[test]
fn generated_for_a_klipper_host() {
    generated("klipper", 8, 4_000);
}

#[test]
fn generated_for_the_parser() {
    generated("parser", 1, 8_000);
}

#[test]
fn generated_for_the_program() {
    generated("program", 2, 6_000);
}

#[test]
fn generated_for_the_console() {
    generated("console", 3, 400);
}

/// Runs a single input, for a look at a finding.
#[test]
fn a_file() {
    let Some(path) = std::env::var_os("FUZZ_FILE").map(PathBuf::from) else { return };
    let input = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    println!("{}", String::from_utf8_lossy(&input));
    let named = TARGETS.iter().find(|target| path.to_string_lossy().contains(target.name));
    (named.unwrap_or(target("console")).run)(&input);
}
