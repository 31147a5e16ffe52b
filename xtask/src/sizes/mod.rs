//! Reports on the image's bytes and its stacks.

mod calls;
mod crates;
mod depth;
mod functions;
mod pointers;
mod stack;
mod text;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

pub use crates::by_crate;
pub use stack::{executor_bytes, main_bytes};

/// Prints the bytes by crate, the largest functions, the kinds of constants, the stacks, or the deepest path
/// from a function.
pub fn report(elf: &Path, what: &str) -> Result<()> {
    let path = || elf.display().to_string();
    let image = fs::read(elf).with_context(path)?;
    let reported = match what {
        "crate" => crates::report(&image),
        "function" => functions::report(&image),
        "text" => text::report(&image),
        "stack" => stack::report(&image),
        function => stack::report_from(&image, function).context("sizes: crate, function, text, stack, or a function"),
    };
    reported.with_context(path)
}
