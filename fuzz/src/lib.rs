//! Conditions that the firmware must meet for any input, and inputs to try.
//!
//! Three targets, each a function of bytes that panics when something is wrong: [`parser`] (bytes to
//! words), [`program`] (lines to actions), [`console`] (a whole machine on the native runner, with input at
//! its consoles). Targets run in three ways: on the kept corpus and on generated inputs of a fixed seed in
//! `make test` (`tests/`), and under a coverage-guided engine in `make fuzz` (`engine/`).
//!
//! Inputs are text, so that a finding can be read and typed: text to type, and lines of directions that
//! begin with `@`. The [`grammar`] makes lines out of the tables of codes, commands and settings;
//! [`mutation`] changes inputs line by line and word by word, beside the engine's own changes of bytes.
#![forbid(unsafe_code)]

pub mod console;
pub mod dice;
pub mod grammar;
pub mod mutation;
pub mod parser;
pub mod program;

/// Target: its name, which is also its folder of the corpus, and its function.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the target.
    pub name: &'static str,
    /// Function that panics when the input shows something wrong.
    pub run: fn(&[u8]),
    /// Directions that the target's inputs may hold.
    pub directions: &'static [&'static str],
    /// Greatest number of lines of a generated input.
    pub lines: usize,
}

/// All targets of the crate.
pub const TARGETS: [Target; 3] = [
    Target { name: "parser", run: parser::run, directions: &[], lines: 12 },
    Target { name: "program", run: program::run, directions: program::DIRECTIONS, lines: 30 },
    Target { name: "console", run: console::run, directions: console::DIRECTIONS, lines: 25 },
];
