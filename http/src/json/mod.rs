//! JSON (RFC 8259): tokens out of text in pieces, text made piece by piece.

mod number;
mod parser;
mod parts;
#[cfg(test)]
mod tests;
mod writer;

pub use number::Number;
pub use parser::{Error, Parser, Token};
pub use parts::{Next, Parts};
pub use writer::Writer;
