//! Forms with files (RFC 7578), streamed: nothing is kept but the line that a part begins with.

mod disposition;
mod reader;
#[cfg(test)]
mod tests;

pub use reader::{Error, Item, Multipart};
