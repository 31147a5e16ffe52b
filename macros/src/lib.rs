//! Klipper's G-code macros: templates in the language of Jinja2 become lines of G-code, on the board.
//!
//! [`compile`] reads a template into memory that the caller lends, [`Program::render`] writes its text.
//! Values, operators, filters and texts of numbers are those of Python and of Jinja2 3.1, so that a macro
//! gives the lines that Klipper would give, byte for byte. docs/macros.md says what is taken and what is
//! refused.
//!
//! No heap and no state: all that a rendering needs is in the caller's two pieces of memory, and what does
//! not fit is refused. The machine is seen through [`Environment`].

#![cfg_attr(not(test), no_std)]

mod arguments;
mod chars;
mod code;
mod digits;
mod environment;
mod fault;
mod filters;
mod format;
mod functions;
mod lexer;
mod literal;
mod memory;
mod methods;
mod names;
mod number;
mod parser;
mod render;
mod run;
mod saved;
mod value;
mod words;

pub use environment::{Action, Environment, Given, Kind, Nothing, Object};
pub use fault::Error;
pub use render::{Program, compile};
pub use saved::rewrite as rewrite_literal;
