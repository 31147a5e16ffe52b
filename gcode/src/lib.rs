//! G-code text: bytes to lines ([`LineBuffer`]), lines to blocks ([`Decoder`], [`Blocks`]), blocks to words
//! ([`Block`]).
//!
//! Understood: RepRap (`N` and `*` checksums, resends, several commands on a line, text after the codes of
//! `TEXT_M_CODES` in `scanner.rs`) and NIST RS-274 line syntax (blanks anywhere, lower case, `( )` and `;`
//! comments, block delete, `%`), and Klipper's commands by name ([`Extended`]). Lines of a console command
//! (`ls`, `$H`) are told apart from lower-case G-code (`g1 x10`).
//!
//! The crate knows no positions, modal state or units: a number is a number, with the column it stood in.
#![cfg_attr(not(test), no_std)]

mod block;
mod code_number;
mod decimal;
mod decoder;
mod dialect;
mod error;
pub mod expression;
mod extended;
mod flow;
mod line_buffer;
mod number;
mod plain_words;
pub mod realtime;
mod scanner;
mod stop;
mod text_value;
mod whole_line;

pub use block::{Block, Code, Letter, NO_TOOL, WORD_LETTERS, letter_bit};
pub use decimal::{read_f32, read_f64};
pub use decoder::{Decoder, Line, Refusal, checksum_of};
pub use dialect::{Dialect, Dialects, ExtruderFollows};
pub use error::{Problem, SyntaxError};
pub use expression::{NoParameters, Parameter, Parameters};
pub use extended::{Extended, KeyValues};
pub use flow::{FlowLine, FlowWord};
pub use line_buffer::{Gathered, LineBuffer, MAX_LINE_LENGTH, plain_line};
pub use scanner::Blocks;
pub use whole_line::{MOST_CODES, WholeLine};
