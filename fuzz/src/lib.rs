//! What must hold for any input, and inputs to try it with.
//!
//! Three targets, each a function of bytes that panics when something is wrong: [`parser`] (bytes to words),
//! [`program`] (lines to actions), [`console`] (a whole machine on the native runner, somebody at its
//! consoles). They run in three ways: on the kept corpus and on generated inputs of a fixed seed in `make
//! test` (`tests/`), and under a coverage-guided engine in `make fuzz` (`engine/`).
//!
//! Inputs are text, so that a finding can be read and typed: what is typed, and lines of directions that
//! begin with `@`. The [`grammar`] makes lines out of the tables of codes, commands and settings;
//! [`mutation`] changes inputs line by line and word by word, beside what the engine does to bytes.
#![forbid(unsafe_code)]

pub mod console;
pub mod dice;
pub mod grammar;
pub mod mutation;
pub mod parser;
pub mod program;

/// A target: its name, which is also its folder of the corpus, and what it does with an input.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// Panics when the input shows something wrong.
    pub run: fn(&[u8]),
    /// The directions its inputs may hold.
    pub directions: &'static [&'static str],
    /// Lines of a generated input, at most.
    pub lines: usize,
}

/// Every target.
pub const TARGETS: [Target; 3] = [
    Target { name: "parser", run: parser::run, directions: &[], lines: 12 },
    Target { name: "program", run: program::run, directions: program::DIRECTIONS, lines: 30 },
    Target { name: "console", run: console::run, directions: console::DIRECTIONS, lines: 25 },
];
