//! The largest functions and tables of the image.

use anyhow::{Context, Result};
use object::{Object, ObjectSymbol, SymbolKind};

/// So many are listed.
const LISTED: usize = 60;

/// Prints them, largest first.
pub fn report(elf: &[u8]) -> Result<()> {
    let file = object::File::parse(elf).context("not an ELF file")?;
    let is_stored = |kind| matches!(kind, SymbolKind::Text | SymbolKind::Data);
    let mut symbols: Vec<_> = file.symbols().filter(|symbol| is_stored(symbol.kind()) && symbol.size() > 0).collect();
    symbols.sort_by_key(|symbol| std::cmp::Reverse(symbol.size()));
    for symbol in symbols.iter().take(LISTED) {
        let name = symbol.name().unwrap_or_default();
        println!("{:>8}  {:#}", symbol.size(), rustc_demangle::demangle(name));
    }
    Ok(())
}
