//! Conditions that the firmware must meet for any input, and inputs to try.
//!
//! Targets are functions of bytes that panic when something is wrong: [`parser`] (bytes to words),
//! [`program`] (lines to actions), [`console`] (a whole machine on the native runner, with input at its
//! consoles), four of the web server ([`web`]), and a Klipper
//! host's line ([`klipper`]). Targets run in three ways: on the kept corpus and on
//! generated inputs of a fixed seed in `make test` (`tests/`), and under a coverage-guided engine in
//! `make fuzz` (`engine/`).
//!
//! Inputs of the first three are text, so that a finding can be read and typed: text to type, and lines of
//! directions that begin with `@`. The [`grammar`] makes lines out of the tables of codes, commands and
//! settings; [`mutation`] changes inputs line by line and word by word, beside the engine's own changes of
//! bytes.
#![forbid(unsafe_code)]

pub mod console;
pub mod dice;
pub mod grammar;
pub mod klipper;
pub mod mutation;
pub mod parser;
pub mod program;
pub mod web;

use dice::Dice;

/// Longest input, bytes.
const MOST: usize = 2_048;

/// Target: its name, which is also its folder of the corpus, and its function.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the target.
    pub name: &'static str,
    /// Function that panics when the input shows something wrong.
    pub run: fn(&[u8]),
    /// Language of the inputs.
    pub language: Language,
}

/// Language that inputs are made of.
#[derive(Clone, Copy, Debug)]
pub enum Language {
    /// Lines of programs and commands.
    Lines {
        /// Directions that the inputs may hold.
        directions: &'static [&'static str],
        /// Greatest number of lines of a generated input.
        lines: usize,
    },
    /// Pieces of a protocol.
    Pieces(&'static [&'static [u8]]),
}

impl Target {
    /// Makes an input.
    pub fn input(&self, dice: &mut Dice) -> Vec<u8> {
        match self.language {
            Language::Lines { directions, lines } => grammar::input(dice, directions, lines),
            Language::Pieces(pieces) => web::input(dice, pieces),
        }
    }

    /// Changes an input in a single place, to `most` bytes at most.
    pub fn mutate(&self, input: &mut Vec<u8>, dice: &mut Dice, most: usize) {
        let most = most.min(MOST);
        match self.language {
            Language::Lines { directions, .. } => mutation::mutate(input, dice, directions, most),
            Language::Pieces(pieces) => web::mutate(input, dice, pieces, most),
        }
    }
}

/// All targets of the crate.
pub const TARGETS: [Target; 8] = [
    Target { name: "parser", run: parser::run, language: Language::Lines { directions: &[], lines: 12 } },
    Target {
        name: "program",
        run: program::run,
        language: Language::Lines { directions: program::DIRECTIONS, lines: 30 },
    },
    Target {
        name: "console",
        run: console::run,
        language: Language::Lines { directions: console::DIRECTIONS, lines: 25 },
    },
    Target { name: "http", run: web::http::run, language: Language::Pieces(web::http::PIECES) },
    Target { name: "websocket", run: web::websocket::run, language: Language::Pieces(web::websocket::PIECES) },
    Target { name: "form", run: web::form::run, language: Language::Pieces(web::form::PIECES) },
    Target { name: "json", run: web::json::run, language: Language::Pieces(web::json::PIECES) },
    Target { name: "klipper", run: klipper::run, language: Language::Pieces(klipper::PIECES) },
];
